//! What a page draws if it is not one volume of values: several fields, colours or labels, or a volume in the colours of labels. All pages
//! share the voxels on the device. Each page chooses how it shows them.

use super::look::Look;
use super::look_fields::{PageChannel, PageLabels};
use crate::device::Device;
use crate::error::Error;
use crate::renderer::{Channel, UploadedColors, UploadedVolume, VolumeRenderer};
use crate::settings::{FieldKind, GradientOpacity};
use crate::shown::{IndexedLabels, Shown};
use crate::transfer::TransferFunction;
use crate::volume::{LabelTable, Labels, Volume};
use std::sync::{Arc, Mutex, PoisonError};

/// What a page draws.
#[derive(Default)]
pub enum Drawn {
    /// The values of the volume.
    #[default]
    One,
    /// Several fields. The first is the volume.
    Several(Vec<PageField>),
    /// Colours or labels instead of values.
    Shown(Shown),
    /// The values of the volume in the colours of labels, which lie where they colour it ([`Labels::over`]).
    LabelColors(IndexedLabels),
}

/// One of several fields. Whether it is visible, its factor and its colour are part of the look ([`PageChannel`]).
pub struct PageField {
    /// Name.
    pub name: String,
    /// Its volume; of colours and labels, the one that stands for them.
    pub volume: Volume<'static>,
    /// Colours or labels instead of values.
    pub shown: Option<Shown>,
    /// Its first transfer function.
    pub transfer: TransferFunction,
    /// Value of its iso-surface, if it has one of its own.
    pub iso: Option<f64>,
    /// Opacity by gradient magnitude, if it has one of its own.
    pub gradient_opacity: Option<GradientOpacity>,
}

/// Voxels that all pages share.
pub(super) enum Uploaded {
    /// None: the volume is streamed, or a step of a sequence, which each page has on its own.
    Own,
    One(Box<UploadedVolume>),
    Several(Vec<UploadedField>),
    /// Components or indices of labels, and the colours that pages have made of them.
    Shown(Vec<UploadedVolume>, LastColors<UploadedColors>),
}

/// A field that all pages share.
pub(super) enum UploadedField {
    Values(Box<UploadedVolume>),
    /// As [`Uploaded::Shown`], and the channels that pages have made.
    Shown(Vec<UploadedVolume>, LastColors<Vec<Channel>>),
}

/// The colours that a page made last, and what of: pages that show the same ones, and pictures that are saved, share them.
pub(super) struct LastColors<T>(Mutex<Option<(ColorKey, Arc<T>)>>);

/// What colours depend on besides the voxels.
#[derive(PartialEq)]
pub(super) enum ColorKey {
    Opacities(Vec<(f64, f64)>),
    Labels(PageLabels),
}

/// How a page shows its fields.
#[derive(Clone, Copy)]
pub(super) struct CurrentLook<'a> {
    pub look: &'a Look,
    /// Those of all fields.
    pub transfers: &'a [TransferFunction],
}

/// A renderer of a page.
pub(super) type PageRenderer = dyn VolumeRenderer<'static> + Send;

impl<T> Default for LastColors<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> LastColors<T> {
    /// The colours for a key: those at hand, or new ones.
    pub fn get(&self, key: ColorKey, make: impl FnOnce() -> Result<T, Error>) -> Result<Arc<T>, Error> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, colors)) = last.as_ref().filter(|(known, _)| *known == key) {
            return Ok(colors.clone());
        }
        let colors = Arc::new(make()?);
        *last = Some((key, colors.clone()));
        Ok(colors)
    }
}

impl Drawn {
    /// What a renderer draws of it.
    pub fn kind(&self) -> FieldKind {
        match self {
            Self::One => FieldKind::One,
            Self::Several(fields) if fields.iter().any(|field| field.shown.is_some()) => FieldKind::Mixed,
            Self::Several(_) => FieldKind::Several,
            Self::Shown(shown) => shown.kind(),
            Self::LabelColors(_) => FieldKind::LabelColors,
        }
    }

    /// The labels, if it has some.
    pub(super) fn labels(&self) -> Option<&Labels> {
        match self {
            Self::One | Self::Several(_) => None,
            Self::Shown(shown) => shown.labels(),
            Self::LabelColors(all) => Some(all.labels()),
        }
    }

    /// Uploads the voxels of what is no single volume.
    pub(super) fn upload(&self, device: &Device) -> Result<Option<Uploaded>, Error> {
        Ok(match self {
            Self::One | Self::LabelColors(_) => None,
            Self::Several(fields) => {
                let uploaded = fields.iter().map(|field| field.upload(device));
                Some(Uploaded::Several(uploaded.collect::<Result<_, _>>()?))
            }
            Self::Shown(shown) => Some(Uploaded::Shown(shown.upload(device)?, LastColors::default())),
        })
    }

    /// The fields, if there are several.
    pub(super) fn fields(&self) -> &[PageField] {
        if let Self::Several(fields) = self { fields } else { &[] }
    }
}

impl PageField {
    fn upload(&self, device: &Device) -> Result<UploadedField, Error> {
        Ok(match &self.shown {
            None => UploadedField::Values(Box::new(UploadedVolume::new(device, &self.volume)?)),
            Some(shown) => UploadedField::Shown(shown.upload(device)?, LastColors::default()),
        })
    }

    /// Names and looks of its labels.
    ///
    /// # Errors
    /// As [`Shown::tables`].
    pub(super) fn tables(&self) -> Result<Vec<LabelTable>, Error> {
        self.shown.as_ref().map_or_else(|| Ok(Vec::new()), |shown| shown.tables(&[]))
    }

    /// Its channels: one, and of labels one for each layer and opacity.
    pub(super) fn channels(
        &self,
        device: &Device,
        uploaded: &UploadedField,
        transfer: &TransferFunction,
        look: &PageChannel,
    ) -> Result<Vec<Channel>, Error> {
        let channels = match (uploaded, &self.shown) {
            (UploadedField::Shown(uploaded, made), Some(shown)) => {
                let key = ColorKey::Opacities(transfer.opacities().to_vec());
                made.get(key, || shown.channels(device, uploaded, transfer, &self.tables()?))?.to_vec()
            }
            (UploadedField::Values(volume), _) => {
                vec![Channel::new(volume, transfer).with_gradient_opacity(self.gradient_opacity).with_iso(self.iso)]
            }
            (UploadedField::Shown(..), None) => unreachable!("a field is uploaded as it is shown"),
        };
        channels.into_iter().map(|channel| channel.with_visibility(look.visible).with_factor(look.factor)).collect()
    }
}
