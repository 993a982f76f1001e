//! The renderers of pages: what they draw, and how a page shows it.

use super::drawn::{ColorKey, CurrentLook, Drawn, LastColors, PageField, PageRenderer, Uploaded, UploadedField};
use super::look::Look;
use super::look_fields::PageChannel;
use super::scene::SharedScene;
use crate::annotation::{Legend, LegendEntry};
use crate::error::Error;
use crate::framing::Framing;
use crate::renderer::{Channel, Renderer, UploadedColors, UploadedVolume, volume_renderer};
use crate::settings::{Blend, FieldKind, Settings};
use crate::shown::{Shown, legend_of};
use crate::volume::{LabelTable, Volume};
use std::sync::Arc;

impl SharedScene {
    /// What a renderer of the scene draws.
    pub(super) fn kind(&self) -> FieldKind {
        self.opening.drawn.kind()
    }

    /// Checks the number of a field.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if there is no such field.
    pub(super) fn check_field(&self, field: usize) -> Result<(), Error> {
        if field < self.opening.drawn.fields().len().max(1) {
            return Ok(());
        }
        Err(Error::OutOfRange { name: "field", value: field.to_string(), expected: "a field that the page was told, from 0" })
    }

    /// Fails for looks that do not go with the fields.
    pub(super) fn check_look(&self, look: &Look, settings: &Settings) -> Result<(), Error> {
        self.kind().check(settings)?;
        look.channels_of(self.opening.drawn.fields().len())?;
        self.tables(look).map(drop)
    }

    /// A renderer of its own for a page. `volume`: the step of a sequence.
    ///
    /// # Errors
    /// Insufficient memory of the device, and looks that do not go with the fields.
    pub(super) fn page_renderer(&self, volume: &Volume<'static>, now: CurrentLook) -> Result<Box<PageRenderer>, Error> {
        let device = &self.opening.device;
        let mut renderer: Box<PageRenderer> = match &self.uploaded {
            // The colours of labels need the whole volume.
            Uploaded::Own if self.kind() == FieldKind::LabelColors => Box::new(Renderer::new(device, volume, &now.transfers[0])?),
            Uploaded::Own => volume_renderer(device, volume, &now.transfers[0])?,
            Uploaded::One(uploaded) => Box::new(Renderer::from_uploaded(uploaded, &now.transfers[0])?),
            Uploaded::Several(uploaded) => Box::new(Renderer::from_channels(&self.channels(uploaded, now)?)?),
            Uploaded::Shown(uploaded, made) => Box::new(Renderer::from_colors(&*self.colors(uploaded, made, now)?)?),
        };
        self.set_label_colors(renderer.as_mut(), now)?;
        renderer.limit(self.opening.time_limit);
        Ok(renderer)
    }

    /// Draws the volume in the colours of labels, if there are some.
    fn set_label_colors(&self, renderer: &mut PageRenderer, now: CurrentLook) -> Result<(), Error> {
        let Drawn::LabelColors(all) = &self.opening.drawn else { return Ok(()) };
        let make = || all.over_scan(&self.opening.device, &self.tables(now.look)?);
        let colors = self.label_colors.get(ColorKey::Labels(now.look.labels.clone()), make)?;
        renderer.require_whole("the colours of labels")?.set_label_colors(Some(&colors))
    }

    /// Shows the fields as a page wants them from now on. Voxels are uploaded and programs built by none of it.
    ///
    /// # Errors
    /// Insufficient memory of the device, and looks that do not go with the fields: the renderer stays as it was.
    pub(super) fn update(&self, renderer: &mut PageRenderer, now: CurrentLook) -> Result<(), Error> {
        match &self.uploaded {
            Uploaded::Own | Uploaded::One(_) => {
                renderer.set_transfer_function(&now.transfers[0]);
                self.set_label_colors(renderer, now)?;
            }
            Uploaded::Several(uploaded) => {
                let channels = self.channels(uploaded, now)?;
                renderer.require_whole("channels")?.set_channels(&channels)?;
            }
            Uploaded::Shown(uploaded, made) => {
                let colors = self.colors(uploaded, made, now)?;
                renderer.require_whole("colours")?.set_colors(&colors)?;
            }
        }
        Ok(())
    }

    fn channels(&self, uploaded: &[UploadedField], now: CurrentLook) -> Result<Vec<Channel>, Error> {
        let shown = now.look.channels_of(uploaded.len())?;
        let fields = self.opening.drawn.fields().iter().zip(uploaded);
        let mut channels = Vec::new();
        for (((field, uploaded), transfer), shown) in fields.zip(now.transfers).zip(shown) {
            channels.extend(field.channels(&self.opening.device, uploaded, transfer, shown)?);
        }
        Ok(channels)
    }

    fn colors(
        &self,
        uploaded: &[UploadedVolume],
        made: &LastColors<UploadedColors>,
        now: CurrentLook,
    ) -> Result<Arc<UploadedColors>, Error> {
        let Drawn::Shown(shown) = &self.opening.drawn else {
            unreachable!("colours are made of what is shown instead of values")
        };
        let transfer = &now.transfers[0];
        let key = match shown {
            Shown::Components(..) | Shown::Vectors { .. } => ColorKey::Opacities(transfer.opacities().to_vec()),
            Shown::Labels(..) => ColorKey::Labels(now.look.labels.clone()),
        };
        made.get(key, || shown.colors(&self.opening.device, uploaded, transfer, &self.tables(now.look)?))
    }

    /// Names and looks of the labels of each layer, as a page shows them.
    ///
    /// # Errors
    /// For labels that there are not.
    pub(super) fn tables(&self, look: &Look) -> Result<Vec<LabelTable>, Error> {
        match self.opening.drawn.labels() {
            Some(labels) => labels.changed_tables(&look.labels.changes()?),
            None => Ok(Vec::new()),
        }
    }

    /// Names and colours of what a page shows, in place of a colour bar; `None` for one field.
    pub(super) fn legend(&self, look: &Look) -> Result<Option<Legend>, Error> {
        match &self.opening.drawn {
            Drawn::One => Ok(None),
            // A field alone has a colour bar.
            Drawn::Several(fields) if fields.len() < 2 => Ok(None),
            Drawn::Several(fields) => {
                let shown = fields.iter().zip(look.channels_of(fields.len())?).filter(|(_, shown)| shown.visible);
                let entries_of = |(field, look): (&PageField, &PageChannel)| {
                    Ok(match &field.shown {
                        None => vec![LegendEntry::new(&field.name, look.color()?)],
                        // Colours have none.
                        Some(shown) => shown.legend(&field.tables()?).map_or_else(Vec::new, |legend| legend.entries),
                    })
                };
                let entries = shown.map(entries_of).collect::<Result<Vec<_>, Error>>()?;
                Ok(Some(Legend { entries: entries.into_iter().flatten().collect() }))
            }
            Drawn::Shown(shown) => Ok(shown.legend(&self.tables(look)?)),
            Drawn::LabelColors(all) => Ok(Some(legend_of(all.labels(), &self.tables(look)?))),
        }
    }

    /// Bounds of what a page shows of what is no single volume; `None` for one field.
    ///
    /// # Errors
    /// Looks that do not go with the fields.
    pub(super) fn framing_of_fields(&self, settings: &Settings, now: CurrentLook) -> Result<Option<Framing>, Error> {
        let fields = match &self.opening.drawn {
            Drawn::One | Drawn::LabelColors(_) => return Ok(None),
            Drawn::Shown(shown) => return Ok(Some(shown.framing(&now.transfers[0], &self.tables(now.look)?))),
            Drawn::Several(fields) => fields,
        };
        let shown = now.look.channels_of(fields.len())?;
        let visible = fields.iter().zip(now.transfers).zip(shown).filter(|(_, shown)| shown.visible);
        let framing = |((field, transfer), _): ((&PageField, _), _)| {
            Ok(match (&field.shown, settings.blend) {
                (Some(shown), _) => shown.framing(transfer, &field.tables()?),
                (None, Blend::Composite) => Framing::visible(&field.volume, transfer, settings.unit_distance),
                (None, Blend::Iso(value)) => Framing::iso(&field.volume, field.iso.unwrap_or(value)),
                (None, _) => Framing::whole(&field.volume),
            })
        };
        let framings = visible.map(framing).collect::<Result<Vec<_>, Error>>()?.into_iter();
        Ok(Some(framings.reduce(Framing::joined).unwrap_or_else(|| Framing::whole(&self.opening.volume))))
    }
}
