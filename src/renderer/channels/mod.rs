//! Several fields that are drawn together: extinctions add, and colours are weighted by them (docs/guide/channels.md).

mod classified;
mod common_grid;
mod fields;
mod inputs;
mod on_frame;
mod packed_colors;
mod scenes;
#[cfg(test)]
mod tests;

pub(super) use fields::Fields;
pub(super) use inputs::{FieldInputs, MergedInputs, VoxelColors};
pub(super) use packed_colors::{PackedColors, VOXEL_COLORS};

use super::field::UploadedVolume;
use super::frame::{Declaring, Resources, Slot};
use super::world::World;
use crate::device::launch::MAX_CHANNELS;
use crate::device::launch::structs::ChannelParams;
use crate::error::Error;
use crate::settings::{Blend, GradientOpacity, Settings};
use crate::transfer::TransferFunction;

/// A field that is drawn together with others, and how it is shown.
///
/// In every segment of a ray the optical depths of all fields add, τ = Σ τ_c, and the colour is Σ τ_c C_c / τ: the order of the fields does
/// not matter. The blend modes maximum, minimum and average are taken of each field, and their colours add, at most to 1. Of iso-surfaces the
/// nearest is seen.
#[derive(Clone)]
pub struct Channel {
    pub(super) volume: UploadedVolume,
    pub(super) transfer: TransferFunction,
    pub(super) look: ChannelLook,
    /// Colours of its voxels, instead of those of the transfer function.
    colors: Option<PackedColors>,
}

/// Their kernel arguments.
pub(super) const CHANNELS: Slot<ChannelParams> = Slot::new("the parameters of channels");

/// Declares what several fields need besides the resources of each.
pub(super) fn declare_channels(declaring: &Declaring, resources: &mut Resources) {
    if !declaring.others.is_empty() {
        resources.host(&CHANNELS, 1 + declaring.others.len());
    }
}

/// How a field is shown, besides its transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChannelLook {
    /// Factor of the extinction, and of the colours of reduced values.
    pub factor: f64,
    pub visible: bool,
    /// In the caller's world units; replaces that of the settings.
    pub gradient_opacity: Option<GradientOpacity>,
    /// Value of the iso-surface; replaces that of the settings.
    pub iso: Option<f64>,
}

impl Default for ChannelLook {
    fn default() -> Self {
        Self { factor: 1.0, visible: true, gradient_opacity: None, iso: None }
    }
}

impl Channel {
    /// Most channels of a renderer.
    pub const MOST: usize = MAX_CHANNELS;

    /// A visible channel.
    pub fn new(volume: &UploadedVolume, transfer: &TransferFunction) -> Self {
        Self { volume: volume.clone(), transfer: transfer.clone(), look: ChannelLook::default(), colors: None }
    }

    /// Multiplies the extinction by a factor. Opacity α becomes 1 − (1−α)^factor; with
    /// [`Extinction::Linear`](crate::transfer::Extinction::Linear), α times the factor. Maximum, minimum and average, which have no extinction,
    /// multiply the colour, at most to 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the factor is finite and at least 0.
    pub fn with_factor(mut self, factor: f64) -> Result<Self, Error> {
        if !(0.0..=f64::MAX).contains(&factor) {
            let expected = "a finite number that is at least 0";
            return Err(Error::OutOfRange { name: "factor", value: factor.to_string(), expected });
        }
        self.look.factor = factor;
        Ok(self)
    }

    /// Shows or hides the channel. A hidden channel costs nothing.
    pub fn with_visibility(mut self, visible: bool) -> Self {
        self.look.visible = visible;
        self
    }

    /// Sets the opacity by gradient magnitude, instead of that of the settings. `None` changes nothing.
    pub fn with_gradient_opacity(mut self, opacity: impl Into<Option<GradientOpacity>>) -> Self {
        self.look.gradient_opacity = opacity.into().or(self.look.gradient_opacity);
        self
    }

    /// Sets the value of the iso-surface, instead of that of the settings. Its colour is that of the transfer function. `None` changes nothing:
    /// labels have a value of their own.
    pub fn with_iso(mut self, value: impl Into<Option<f64>>) -> Self {
        self.look.iso = value.into().or(self.look.iso);
        self
    }
}

impl ChannelLook {
    /// The settings of a frame, in normalised units, for a field with this look.
    pub fn settings(&self, settings: &Settings, world: World) -> Settings {
        let opacity = self.gradient_opacity.map(|opacity| opacity.times(world.unit()));
        let blend = match (settings.blend, self.iso) {
            (Blend::Iso(_), Some(value)) => Blend::Iso(value),
            (blend, _) => blend,
        };
        let gradient_opacity = if blend == Blend::Composite { opacity.or(settings.gradient_opacity) } else { None };
        Settings { gradient_opacity, blend, ..*settings }
    }
}
