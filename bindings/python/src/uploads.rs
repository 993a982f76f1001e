//! Voxels that stay on a device while Python objects are made again with other colours.

use layersplat::renderer::UploadedVolume;
use layersplat::{Device, Error, Volume};
use std::sync::{Arc, Mutex, PoisonError};

/// A volume, and its voxels on the device that drew them last. Clones share them.
#[derive(Clone)]
pub struct Voxels {
    volume: Volume<'static>,
    uploaded: Arc<Mutex<Option<(Device, UploadedVolume)>>>,
}

impl Voxels {
    pub fn new(volume: Volume<'static>) -> Self {
        Self { volume, uploaded: Arc::default() }
    }

    pub fn volume(&self) -> &Volume<'static> {
        &self.volume
    }

    /// The voxels on a device.
    ///
    /// # Errors
    /// If its memory is insufficient.
    pub fn on(&self, device: &Device) -> Result<UploadedVolume, Error> {
        let mut uploaded = self.uploaded.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |other: &Device| other.context() == device.context() && other.memory_budget() == device.memory_budget();
        if let Some((_, voxels)) = uploaded.as_ref().filter(|(other, _)| is_same(other)) {
            return Ok(voxels.clone());
        }
        // The voxels on the other device are released first.
        *uploaded = None;
        let voxels = UploadedVolume::new(device, &self.volume)?;
        *uploaded = Some((device.clone(), voxels.clone()));
        Ok(voxels)
    }
}
