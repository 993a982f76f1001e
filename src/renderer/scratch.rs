//! What frames write and the next frame writes again.

use crate::device::launch::Splat;
use crate::device::launch::params::{Float4, LayerOffset};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{SplatSlabs, Viewport};

/// Buffers that frames write and the next frame writes again. They only grow.
#[derive(Default)]
pub(super) struct Scratch {
    pub offsets: [Option<Buffer<LayerOffset>>; 2],
    pub crossings: [Option<Buffer<[f32; 2]>>; 2],
    pub nodes: Option<Buffer<[f32; 2]>>,
    pub weights: Option<Buffer<f32>>,
    pub table: Option<Buffer<Float4>>,
    pub slabs: Option<Buffer<Float4>>,
    pub lattice: Option<Buffer<Float4>>,
    pub frame: Option<Buffer<Float4>>,
    pub rgba: Option<Buffer<[u8; 4]>>,
    pub active_samples: Option<Buffer<u32>>,
    /// With the slabs that they are for.
    pub slab_weights: Option<(SplatSlabs, Buffer<f32>)>,
    pub sheet_counts: Option<Buffer<u32>>,
    pub sorted: Option<Buffer<Splat>>,
    pub tile_ends: Option<Buffer<u32>>,
    pub lists: Option<Buffer<u32>>,
    pub total: Option<Buffer<u64>>,
    /// How many of `active_samples` the last frame wrote.
    pub active_count: usize,
}

/// The buffer in `slot`, made anew if it is shorter than `len`.
pub(super) fn at_least<'a, T: Copy>(
    slot: &'a mut Option<Buffer<T>>,
    device: &Device,
    len: usize,
    what: &str,
) -> Result<&'a mut Buffer<T>, Error> {
    if slot.as_ref().is_some_and(|b| b.len() < len) {
        *slot = None;
    }
    match slot {
        Some(buffer) => Ok(buffer),
        None => Ok(slot.insert(Buffer::new(device, len, what)?)),
    }
}

/// The buffer in `slot` with `values` in it.
pub(super) fn filled<'a, T: Copy>(
    slot: &'a mut Option<Buffer<T>>,
    device: &Device,
    values: &[T],
    what: &str,
) -> Result<&'a Buffer<T>, Error> {
    let buffer = at_least(slot, device, values.len(), what)?;
    buffer.write(device, values)?;
    Ok(buffer)
}

impl Scratch {
    /// The finished frame, copied to the host.
    pub fn read_frame(&self, device: &Device, viewport: Viewport) -> Result<Frame, Error> {
        Ok(Frame::new(viewport, read_pixels(self.frame.as_ref(), device, viewport.pixels())?))
    }
}

/// The first `count` pixels of a buffer that a frame has written.
pub(super) fn read_pixels(buffer: Option<&Buffer<Float4>>, device: &Device, count: usize) -> Result<Vec<[f32; 4]>, Error> {
    let mut pixels = vec![Float4([0.0; 4]); count];
    buffer.expect("a frame was drawn").read(device, &mut pixels)?;
    Ok(pixels.into_iter().map(|p| p.0).collect())
}
