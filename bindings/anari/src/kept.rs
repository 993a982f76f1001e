//! Renderers that stay from frame to frame, with their voxels on the device.

use crate::handle::Handle;
use crate::on_device::{OnDevice, channels, uploaded};
use crate::volume::{DrawnVolume, Place};
use layersplat::renderer::{Channel, VolumeRenderer, volume_renderer};
use layersplat::{Device, DeviceChoice, Error};

pub type Renderer = dyn VolumeRenderer<'static> + Send;

/// Largest number of renderers.
const KEPT: usize = 4;

/// Renderers of the volumes that were drawn last. The device is opened for the first frame.
#[derive(Default)]
pub struct Renderers {
    device: Option<Device>,
    kept: Vec<Kept>,
}

/// A renderer and what it was made for.
pub struct Kept {
    /// Its volumes, at least one.
    places: Vec<Place>,
    /// The same on the device, unless there is one on its own grid.
    uploaded: Vec<OnDevice>,
    pub renderer: Box<Renderer>,
}

/// The volume of a scene with one, if it is drawn on its own grid.
fn on_its_own_grid(shown: &[DrawnVolume]) -> Option<&DrawnVolume> {
    if let [one] = shown { Some(one).filter(|one| !one.is_sheared()) } else { None }
}

impl Kept {
    /// Sets the transfer functions of all its volumes.
    fn show(&mut self, device: &Device, shown: &[DrawnVolume]) -> Result<(), Error> {
        if let Some(one) = on_its_own_grid(shown) {
            if *self.renderer.transfer_function() != one.transfer {
                self.renderer.set_transfer_function(&one.transfer);
            }
            return Ok(());
        }
        self.uploaded = uploaded(device, shown, std::mem::take(&mut self.uploaded))?;
        let channels = channels(&self.uploaded, shown)?;
        self.renderer.require_whole("several volumes")?.set_channels(&channels)
    }

    /// Hides all but one of several volumes, until the next frame.
    pub fn show_only(&mut self, shown: &[DrawnVolume], which: usize) -> Result<(), Error> {
        let channels: Vec<Channel> = channels(&self.uploaded, shown)?
            .into_iter()
            .enumerate()
            .map(|(place, channel)| channel.with_visibility(place == which))
            .collect();
        self.renderer.require_whole("several volumes")?.set_channels(&channels)
    }

    /// Whether it has an older state of a field, or one elsewhere.
    fn is_stale(&self, places: &[Place]) -> bool {
        let is_other = |old: &Place| !places.contains(old) && places.iter().any(|new| new.field.field == old.field.field);
        self.places.iter().any(is_other)
    }
}

impl Renderers {
    /// Forgets what was made from an array, whose memory goes.
    pub fn forget(&mut self, array: Handle) {
        self.kept.retain(|kept| kept.places.iter().all(|place| place.field.array != array));
    }

    /// Forgets what was made from fields that are gone.
    pub fn forget_fields(&mut self, fields: &[Handle]) {
        self.kept.retain(|kept| kept.places.iter().all(|place| !fields.contains(&place.field.field)));
    }

    /// Number of renderers.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.kept.len()
    }

    /// The renderer of at least one volume, with their transfer functions.
    ///
    /// # Errors
    /// Those of the library.
    pub fn get(&mut self, shown: &[DrawnVolume]) -> Result<&mut Kept, Error> {
        let device = match &self.device {
            Some(device) => device.clone(),
            None => self.device.insert(Device::open(&DeviceChoice::Default)?).clone(),
        };
        let places: Vec<Place> = shown.iter().map(DrawnVolume::place).collect();
        let kept = match self.kept.iter().position(|kept| kept.places == places) {
            Some(place) => self.kept.remove(place),
            None => self.make(&device, shown, places)?,
        };
        self.kept.push(kept);
        let kept = self.kept.last_mut().expect("it was pushed");
        kept.show(&device, shown)?;
        Ok(kept)
    }

    /// A renderer of volumes: one whose voxels are out of date, or a new one.
    fn make(&mut self, device: &Device, shown: &[DrawnVolume], places: Vec<Place>) -> Result<Kept, Error> {
        let mut stale: Vec<Kept> = self.kept.extract_if(.., |kept| kept.is_stale(&places)).collect();
        if stale.is_empty() && self.kept.len() == KEPT {
            stale.push(self.kept.remove(0));
        }
        let known: Vec<OnDevice> = stale.iter().chain(&self.kept).flat_map(|kept| kept.uploaded.clone()).collect();
        if let Some(one) = on_its_own_grid(shown) {
            let renderer = self.one(device, one, stale, &known)?;
            return Ok(Kept { places, uploaded: Vec::new(), renderer });
        }
        drop(stale);
        let several = |known| -> Result<_, Error> {
            let uploaded = uploaded(device, shown, known)?;
            let renderer = layersplat::Renderer::from_channels(&channels(&uploaded, shown)?)?;
            Ok((uploaded, renderer))
        };
        let (uploaded, renderer) = match several(known) {
            Err(_) if !self.kept.is_empty() => {
                self.kept.clear();
                several(Vec::new())?
            }
            several => several?,
        };
        Ok(Kept { places, uploaded, renderer: Box::new(renderer) })
    }

    /// A renderer of one volume.
    fn one(
        &mut self,
        device: &Device,
        shown: &DrawnVolume,
        stale: Vec<Kept>,
        known: &[OnDevice],
    ) -> Result<Box<Renderer>, Error> {
        if let Some(volume) = known.iter().find_map(|known| known.alone(shown)) {
            return Ok(Box::new(layersplat::Renderer::from_uploaded(volume, &shown.transfer)?));
        }
        let volume = shown.field.volume(shown.placement)?;
        let reused = stale.into_iter().find(|kept| kept.uploaded.is_empty());
        if let Some(Kept { mut renderer, .. }) = reused
            && renderer.set_volume(&volume).is_ok()
        {
            return Ok(renderer);
        }
        match volume_renderer(device, &volume, &shown.transfer) {
            Err(_) if !self.kept.is_empty() => {
                self.kept.clear();
                volume_renderer(device, &volume, &shown.transfer)
            }
            renderer => renderer,
        }
    }
}
