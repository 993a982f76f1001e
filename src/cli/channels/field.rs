//! A field and how it is shown.

use crate::device::Device;
use crate::error::Error;
use crate::renderer::{Channel, UploadedVolume};
use crate::settings::GradientOpacity;
use crate::shown::Shown;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// A field beside the first one.
pub(in crate::cli) struct Field {
    /// Of colours and labels, the volume that stands for them.
    pub volume: Volume<'static>,
    /// Colours or labels instead of values.
    pub shown: Option<Shown>,
    pub transfer: TransferFunction,
    pub look: FieldLook,
}

/// How a field is shown.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::cli) struct FieldLook {
    pub factor: f64,
    pub visible: bool,
    pub iso: Option<f64>,
    pub gradient_opacity: Option<GradientOpacity>,
}

impl Default for FieldLook {
    fn default() -> Self {
        Self { factor: 1.0, visible: true, iso: None, gradient_opacity: None }
    }
}

impl FieldLook {
    /// The channels of a renderer: of colours or labels, or of the values of a volume.
    pub fn channels(
        &self,
        device: &Device,
        volume: &Volume,
        shown: Option<&Shown>,
        transfer: &TransferFunction,
    ) -> Result<Vec<Channel>, Error> {
        let channels = match shown {
            Some(shown) => shown.channels(device, &shown.upload(device)?, transfer, &shown.tables(&[])?)?,
            None => return Ok(vec![self.channel(device, volume, transfer)?]),
        };
        channels.into_iter().map(|channel| self.applied_to(channel)).collect()
    }

    /// A channel of the values of a volume.
    pub fn channel(&self, device: &Device, volume: &Volume, transfer: &TransferFunction) -> Result<Channel, Error> {
        self.applied_to(Channel::new(&UploadedVolume::new(device, volume)?, transfer))
    }

    fn applied_to(&self, channel: Channel) -> Result<Channel, Error> {
        let channel = channel.with_visibility(self.visible).with_factor(self.factor)?;
        Ok(channel.with_gradient_opacity(self.gradient_opacity).with_iso(self.iso))
    }
}

impl Field {
    pub fn is_visible(&self) -> bool {
        self.look.visible
    }

    /// Value of its iso-surface, if it has one of its own.
    pub fn iso(&self) -> Option<f64> {
        self.look.iso
    }
}
