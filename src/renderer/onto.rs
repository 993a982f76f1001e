//! Memory of the caller's own that pictures go to.

use crate::device::{Buffer, Device, DeviceMemory, ImageFormat, MemoryKind};
use crate::error::Error;
use crate::image::Background;
use crate::viewport::Viewport;

const WHAT: &str = "the memory of the picture";

/// Pixels of a picture.
///
/// ```
/// use layersplat::Background;
/// use layersplat::renderer::PictureFormat;
///
/// assert_eq!([PictureFormat::Floats, PictureFormat::Rgba8(Background::Transparent)].map(PictureFormat::bytes), [16, 4]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureFormat {
    /// A byte per channel, over a background.
    Rgba8(Background),
    /// A float per channel, premultiplied, without a background.
    Floats,
}

impl PictureFormat {
    /// Bytes of a pixel.
    pub fn bytes(self) -> usize {
        match self {
            PictureFormat::Rgba8(_) => size_of::<[u8; 4]>(),
            PictureFormat::Floats => size_of::<[f32; 4]>(),
        }
    }
}

/// A buffer or a 2D image of the caller's that pictures go to: RGBA, row by row, row 0 on top.
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
    /// Pictures from the beginning of a buffer on, without gaps, or in an image.
    pub fn new(memory: &DeviceMemory, format: PictureFormat) -> Self {
        Self { memory: memory.clone(), format, first: 0, row_pitch: None }
    }

    /// The same with the first pixel `first` bytes into the buffer.
    pub fn with_first(self, first: usize) -> Self {
        Self { first, ..self }
    }

    /// The same with rows that begin so many bytes apart.
    pub fn with_row_pitch(self, row_pitch: usize) -> Self {
        Self { row_pitch: Some(row_pitch), ..self }
    }

    /// What pixels are.
    pub fn format(&self) -> PictureFormat {
        self.format
    }

    fn pitch(&self, viewport: Viewport) -> usize {
        self.row_pitch.unwrap_or(viewport.width as usize * self.format.bytes())
    }

    /// Refuses memory that a picture of this size cannot go to.
    pub(super) fn check(&self, device: &Device, viewport: Viewport) -> Result<(), Error> {
        self.memory.check(device, WHAT, true)?;
        let refuse = |problem: String| Err(Error::Memory { what: WHAT, problem });
        let [columns, rows] = [viewport.width, viewport.height].map(|n| n as usize);
        match self.memory.kind() {
            MemoryKind::Buffer { bytes } => {
                let (row, pitch) = (columns * self.format.bytes(), self.pitch(viewport));
                let end = self.first as u128 + (rows as u128 - 1) * pitch as u128 + row as u128;
                if pitch < row {
                    return refuse(format!("has rows {pitch} bytes apart, and one of {columns} pixels has {row}"));
                }
                if end > bytes as u128 {
                    return refuse(format!("has {bytes} bytes, and a picture of {columns}x{rows} ends at {end}"));
                }
                Ok(())
            }
            MemoryKind::Image { width, height, format } => {
                let expected = match self.format {
                    PictureFormat::Rgba8(_) => ImageFormat::Rgba8,
                    PictureFormat::Floats => ImageFormat::Floats,
                };
                if format != expected {
                    return refuse(format!("is an image of {format:?}, and the picture is of {expected:?}"));
                }
                if [width, height] != [columns, rows] || self.first != 0 || self.row_pitch.is_some() {
                    return refuse(format!(
                        "is an image of {width}x{height}: pictures fill images, and this is one of {columns}x{rows}"
                    ));
                }
                Ok(())
            }
        }
    }

    /// The caller's buffer as one that kernels can draw into, where pixels lie in it as kernels write them.
    pub(super) fn direct<T: Copy>(&self, device: &Device, viewport: Viewport) -> Result<Option<Buffer<T>>, Error> {
        let tight = self.pitch(viewport) == viewport.width as usize * self.format.bytes();
        match self.memory.kind() {
            MemoryKind::Buffer { .. } if tight && self.first == 0 => {
                Buffer::from_memory(device, &self.memory, viewport.pixels()).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Copies a picture there.
    pub(super) fn copy<T: Copy>(&self, device: &Device, from: &Buffer<T>, viewport: Viewport) -> Result<(), Error> {
        let [columns, rows] = [viewport.width, viewport.height].map(|n| n as usize);
        match self.memory.kind() {
            MemoryKind::Buffer { .. } => from.copy_rows(device, columns, rows, &self.memory, self.first, self.pitch(viewport)),
            MemoryKind::Image { .. } => from.copy_to_image(device, columns, rows, &self.memory),
        }
    }
}
