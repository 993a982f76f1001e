//! Pictures in the caller's device memory.

use crate::boundary::{Failure, borrowed};
use crate::opencl::_cl_mem;
use crate::{PixelFormat, render};
use layersplat::Background;
use layersplat::device::DeviceMemory;
use layersplat::renderer::{PictureFormat, PictureMemory};

/// A buffer or a 2D image of the caller that receives pictures: red, green, blue, alpha, row by row from the top.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Picture {
    /// The cl_mem, in the device's context. It is retained as long as it is used.
    pub memory: *mut _cl_mem,
    /// A layersplat_pixel_format.
    pub format: i32,
    /// Alpha of 8-bit pictures. 1: straight alpha. 0: composited over `background`.
    pub transparent: i32,
    /// The opaque background colour of 8-bit pictures, 0 to 1.
    pub background: [f32; 3],
    /// Byte offset of the first pixel in a buffer; 0 for images.
    pub first: usize,
    /// Bytes from row to row in a buffer; 0 if rows are contiguous. 0 for images.
    pub row_pitch: usize,
}

/// The target memory of a picture.
pub(crate) unsafe fn checked(picture: *const Picture) -> Result<PictureMemory, Failure> {
    // SAFETY: upheld by the caller, here and below: the pointer is valid, and its memory object is alive.
    let picture = unsafe { borrowed(picture, "picture") }?;
    let format = match PixelFormat::from_number(picture.format)? {
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
