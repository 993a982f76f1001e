//! Memory of the caller's own that pictures go to.

use crate::border::{Failure, borrowed};
use crate::opencl::_cl_mem;
use crate::{PixelFormat, render};
use layersplat::Background;
use layersplat::device::DeviceMemory;
use layersplat::renderer::{PictureFormat, PictureMemory};

/// A buffer or a 2D image of the caller's that pictures go to: red, green, blue, alpha, row by row from the top.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Picture {
    /// The cl_mem, in the device's context. It is retained as long as it is used.
    pub memory: *mut _cl_mem,
    /// A layersplat_pixel_format.
    pub format: i32,
    /// Whether 8-bit pictures keep their alpha: 1; 0 puts them over `background`.
    pub transparent: i32,
    /// The opaque colour below 8-bit pictures, 0 to 1.
    pub background: [f32; 3],
    /// Byte of a buffer where the first pixel goes. Of images 0.
    pub first: usize,
    /// Bytes from row to row of a buffer; 0 is without gaps. Of images 0.
    pub row_pitch: usize,
}

/// Where a picture goes.
pub(crate) unsafe fn checked(picture: *const Picture) -> Result<PictureMemory, Failure> {
    // SAFETY: the caller's promise, and below: it points to one, whose memory is alive.
    let picture = unsafe { borrowed(picture, "picture") }?;
    let format = match PixelFormat::chosen(picture.format)? {
        PixelFormat::Floats => PictureFormat::Floats,
        PixelFormat::Rgba8 if picture.transparent == 1 => PictureFormat::Rgba8(Background::Transparent),
        PixelFormat::Rgba8 if picture.transparent == 0 => {
            PictureFormat::Rgba8(unsafe { render::background(picture.background.as_ptr()) }?)
        }
        PixelFormat::Rgba8 => {
            return Err(Failure::invalid(format!("transparent is {}: expected 0 or 1", picture.transparent)));
        }
    };
    let memory = unsafe { DeviceMemory::from_raw(picture.memory.cast()) }?;
    let onto = PictureMemory::new(&memory, format).with_first(picture.first);
    Ok(if picture.row_pitch == 0 { onto } else { onto.with_row_pitch(picture.row_pitch) })
}
