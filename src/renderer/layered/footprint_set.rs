//! The footprint set of the paper.

use super::super::store::{Inputs, Key, Store, Stored};
use crate::device::launch::Launcher;
use crate::device::launch::layered::{self as kernels, FootprintSetArguments};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, set_direction};
use std::sync::Arc;

const NAME: &str = "the footprint set";

/// Number of texels of all images.
const TEXELS: usize = FOOTPRINT_SET_LEN * FOOTPRINT_SET_SIZE * FOOTPRINT_SET_SIZE;

/// Makes the footprint images on first use.
pub(super) struct FootprintSet {
    kernel: Launcher<kernels::FootprintSet>,
    store: Store,
}

/// Footprint images and their shears.
pub(super) struct FootprintImages {
    pub images: Buffer<u8>,
    pub shears: Buffer<[f32; 2]>,
}

#[derive(PartialEq)]
struct ImagesKey;

impl Key for ImagesKey {
    type Value = FootprintImages;
}

impl Stored for FootprintImages {
    fn bytes(&self) -> usize {
        self.images.bytes() + self.shears.bytes()
    }
}

impl Default for FootprintSet {
    fn default() -> Self {
        Self { kernel: Launcher::default(), store: Store::new(usize::MAX) }
    }
}

impl FootprintSet {
    /// Names and sizes in bytes of the set's buffers.
    pub fn buffers() -> [(&'static str, usize); 2] {
        [(NAME, TEXELS), (NAME, FOOTPRINT_SET_LEN * size_of::<[f32; 2]>())]
    }

    /// The footprint images, which have no inputs.
    pub fn images(&mut self, device: &Device) -> Result<Arc<FootprintImages>, Error> {
        if let Some(kept) = self.store.get(device, &ImagesKey, Inputs::default())? {
            return Ok(kept);
        }
        let shears: Vec<[f32; 2]> = (0..FOOTPRINT_SET_LEN).map(|i| set_direction(i).map(|s| s as f32)).collect();
        let shears = Buffer::from_slice(device, &shears, NAME)?;
        let images = Buffer::new(device, TEXELS, NAME)?;
        let arguments = FootprintSetArguments { shears: &shears, count: TEXELS as i32, images: &images };
        self.kernel.launch(device, (), &arguments)?;
        Ok(self.store.keep(ImagesKey, Inputs::default(), device.produced()?, FootprintImages { images, shears }))
    }
}
