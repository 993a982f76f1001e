//! The caller's memory that receives pictures.

use crate::device::{Buffer, Device, DeviceMemory, ImageFormat, MemoryKind};
use crate::error::Error;
use crate::image::Background;
use crate::viewport::Viewport;

const WHAT: &str = "the picture memory";

/// Pixel format of a picture.
///
/// ```
/// use layersplat::Background;
/// use layersplat::renderer::PictureFormat;
///
/// assert_eq!([PictureFormat::Floats, PictureFormat::Rgba8(Background::Transparent)].map(PictureFormat::bytes), [16, 4]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureFormat {
    /// 8 bits per channel, composited over a background.
    Rgba8(Background),
    /// 32-bit floats, premultiplied, without a background.
    Floats,
}

impl PictureFormat {
    /// Bytes per pixel.
    pub fn bytes(self) -> usize {
        match self {
            PictureFormat::Rgba8(_) => size_of::<[u8; 4]>(),
            PictureFormat::Floats => size_of::<[f32; 4]>(),
        }
    }
}

/// The caller's buffer or 2D image that receives pictures: RGBA, row by row, row 0 on top.
///
/// ```
/// use layersplat::device::DeviceMemory;
/// use layersplat::renderer::{PictureFormat, PictureMemory};
/// use layersplat::{Renderer, Settings};
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # use layersplat::opencl3::{command_queue::CommandQueue, context::Context, memory::{Buffer, CL_MEM_READ_WRITE}};
/// # let context = Context::from_device(&layersplat::Device::open(&layersplat::DeviceChoice::Default)?.id().into()).expect("a context");
/// # let queue = CommandQueue::create_default_with_properties(&context, 0, 0).expect("a queue");
/// # let device = layersplat::Device::from_queue(&queue)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
/// # let pixels = unsafe { Buffer::<f32>::create(&context, CL_MEM_READ_WRITE, 4 * 32 * 24, std::ptr::null_mut()) }.expect("a buffer");
///
/// let onto = PictureMemory::new(&DeviceMemory::from_buffer(&pixels)?, PictureFormat::Floats);
/// let mut renderer = Renderer::new(&device, &volume, &transfer)?;
/// let drawn = renderer.enqueue(&camera, viewport, &Settings::default(), &onto, &[])?;
/// drawn.wait().expect("a picture");
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PictureMemory {
    memory: DeviceMemory,
    format: PictureFormat,
    first: usize,
    row_pitch: Option<usize>,
}

impl PictureMemory {
    /// Pictures in an image, or in a buffer from its beginning, without gaps.
    pub fn new(memory: &DeviceMemory, format: PictureFormat) -> Self {
        Self { memory: memory.clone(), format, first: 0, row_pitch: None }
    }

    /// Sets the byte offset of the first pixel in the buffer.
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// Sets the distance between the beginnings of rows, in bytes.
    pub fn with_row_pitch(self, row_pitch: usize) -> Self {
        Self { row_pitch: Some(row_pitch), ..self }
    }

    /// The pixel format.
    pub fn format(&self) -> PictureFormat {
        self.format
    }

    fn pitch(&self, viewport: Viewport) -> usize {
        self.row_pitch.unwrap_or(viewport.width as usize * self.format.bytes())
    }

    /// Rejects memory that does not fit a picture of this size.
    pub(super) fn check(&self, device: &Device, viewport: Viewport) -> Result<(), Error> {
        self.memory.check(device, WHAT, true)?;
        let refuse = |problem: String| Err(Error::Memory { what: WHAT, problem });
        let [columns, rows] = [viewport.width, viewport.height].map(|n| n as usize);
        match self.memory.kind() {
            MemoryKind::Buffer { bytes } => {
                let (row, pitch) = (columns * self.format.bytes(), self.pitch(viewport));
                let end = self.first as u128 + (rows as u128 - 1) * pitch as u128 + row as u128;
                if pitch < row {
                    return refuse(format!("has rows {pitch} bytes apart, but a row of {columns} pixels takes {row} bytes"));
                }
                if end > bytes as u128 {
                    return refuse(format!("has {bytes} bytes, but a picture of {columns}x{rows} ends at byte {end}"));
                }
                Ok(())
            }
            MemoryKind::Image { width, height, format } => {
                let expected = match self.format {
                    PictureFormat::Rgba8(_) => ImageFormat::Rgba8,
                    PictureFormat::Floats => ImageFormat::Floats,
                };
                if format != expected {
                    return refuse(format!("is an image of {format:?}, but the picture is {expected:?}"));
                }
                if [width, height] != [columns, rows] || self.first != 0 || self.row_pitch.is_some() {
                    return refuse(format!(
                        "is an image of {width}x{height}, but the picture has {columns}x{rows} pixels: it must fill the image"
                    ));
                }
                Ok(())
            }
        }
    }

    /// The caller's buffer, if its layout is the one that kernels write.
    pub(super) fn direct<T: Copy>(&self, device: &Device, viewport: Viewport) -> Result<Option<Buffer<T>>, Error> {
        let tight = self.pitch(viewport) == viewport.width as usize * self.format.bytes();
        match self.memory.kind() {
            MemoryKind::Buffer { .. } if tight && self.first == 0 => {
                Buffer::from_memory(device, &self.memory, viewport.pixels()).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Copies a picture to the memory.
    pub(super) fn copy<T: Copy>(&self, device: &Device, from: &Buffer<T>, viewport: Viewport) -> Result<(), Error> {
        let [columns, rows] = [viewport.width, viewport.height].map(|n| n as usize);
        match self.memory.kind() {
            MemoryKind::Buffer { .. } => from.copy_rows(device, columns, rows, &self.memory, self.first, self.pitch(viewport)),
            MemoryKind::Image { .. } => from.copy_to_image(device, columns, rows, &self.memory),
        }
    }
}
