//! Volumes on the OpenCL device, to be drawn together.
//!
//! A volume alone ends with its grid. The common grid of volumes with other grids is larger, as is one that covers a sheared volume. Around a
//! volume it has its background, by default the smallest value. Where that is visible, a background below it, which the transfer function
//! hides, keeps the volume in its grid.

use crate::volume::{DrawnVolume, Place};
use layersplat::renderer::{Channel, UploadedVolume};
use layersplat::{Device, Error, TransferFunction};

/// How far below the smallest value the background is, and from where on values are hidden, in shares of the range of values. Resampling
/// reaches as far below the smallest value as the latter, at most.
const BACKGROUND: f64 = 0.25;
const HIDDEN: f64 = 0.2;

/// A volume on the device.
#[derive(Clone)]
pub struct OnDevice {
    place: Place,
    volume: UploadedVolume,
    /// Whether its background is below its smallest value.
    is_enclosed: bool,
}

/// Whether volumes have other grids than the first, or are sheared.
fn grids_differ(shown: &[DrawnVolume]) -> bool {
    let grid = |volume: &DrawnVolume| volume.field.grid(volume.placement).ok();
    shown.iter().any(|volume| volume.is_sheared() || grid(volume) != grid(&shown[0]))
}

/// Length of a range of values. Constants have one, too.
fn length((lowest, highest): (f64, f64)) -> f64 {
    match highest - lowest {
        0.0 if lowest == 0.0 => 1.0,
        0.0 => lowest.abs(),
        length => length,
    }
}

impl OnDevice {
    /// Uploads a volume, and resamples it if it is sheared.
    fn new(device: &Device, shown: &DrawnVolume, grids_differ: bool) -> Result<Self, Error> {
        let mut volume = shown.field.volume(shown.placement)?;
        let range = volume.range();
        let is_enclosed = grids_differ && shown.transfer.opacity(range.0) > 0.0;
        if is_enclosed {
            volume = volume.with_background(range.0 - BACKGROUND * length(range))?;
        }
        let mut volume = UploadedVolume::new(device, &volume)?;
        if shown.is_sheared() {
            volume = volume.with_placement(shown.field.index_to_world(shown.placement))?;
        }
        Ok(Self { place: shown.place(), volume, is_enclosed })
    }

    /// Whether it can be drawn as this volume.
    fn fits(&self, shown: &DrawnVolume, grids_differ: bool) -> bool {
        let is_visible_around = || shown.transfer.opacity(self.volume.description().range().0) > 0.0;
        self.place == shown.place() && if self.is_enclosed { grids_differ } else { !grids_differ || !is_visible_around() }
    }

    /// The volume, if one that is not sheared can be drawn alone as this one.
    pub fn alone(&self, shown: &DrawnVolume) -> Option<&UploadedVolume> {
        self.fits(shown, false).then_some(&self.volume)
    }

    /// The transfer function, which hides the background.
    fn transfer(&self, transfer: &TransferFunction) -> Result<TransferFunction, Error> {
        if !self.is_enclosed {
            return Ok(transfer.clone());
        }
        let range = self.volume.description().range();
        let (lowest, length) = (range.0, length(range));
        let opacity = transfer.opacity(lowest);
        let around = [(lowest - BACKGROUND * length, 0.0), (lowest - HIDDEN * length, opacity), (lowest, opacity)];
        let within = transfer.opacities().iter().copied().filter(|&(value, _)| value > lowest);
        transfer.with_opacities(around.into_iter().chain(within).collect())
    }
}

/// The volumes on the device: those of `known` that fit, and new ones.
///
/// # Errors
/// If device memory is insufficient.
pub fn uploaded(device: &Device, shown: &[DrawnVolume], mut known: Vec<OnDevice>) -> Result<Vec<OnDevice>, Error> {
    let grids_differ = grids_differ(shown);
    let mut all = Vec::new();
    for volume in shown {
        let found = match known.iter().find(|known| known.fits(volume, grids_differ)) {
            Some(found) => found.clone(),
            None => {
                known.push(OnDevice::new(device, volume, grids_differ)?);
                known.last().expect("it was pushed").clone()
            }
        };
        all.push(found);
    }
    Ok(all)
}

/// The channels of volumes. Settings have the unit distance of the first: extinctions are inverse to it.
///
/// # Errors
/// For numbers that the library does not take.
pub fn channels(uploaded: &[OnDevice], shown: &[DrawnVolume]) -> Result<Vec<Channel>, Error> {
    let channel = |(uploaded, volume): (&OnDevice, &DrawnVolume)| {
        let factor = shown[0].unit_distance / volume.unit_distance;
        Channel::new(&uploaded.volume, &uploaded.transfer(&volume.transfer)?).with_factor(factor)
    };
    uploaded.iter().zip(shown).map(channel).collect()
}
