//! Contexts that share with OpenGL (`cl_khr_gl_sharing`), and textures that are shared.

use super::{Buffer, Device, DeviceChoice, DeviceInfo, DeviceMemory, current_gl, selection};
use crate::error::Error;
use crate::viewport::Viewport;
use opencl3::context::{Context, get_current_device_for_gl_context_khr};
use opencl3::device::Device as ClDevice;
use opencl3::memory::{CL_MEM_WRITE_ONLY, Image};
use std::num::NonZeroU32;

const EXTENSION: &str = "cl_khr_gl_sharing";
const CONTEXT_PLATFORM: isize = 0x1084;
const GL_TEXTURE_2D: u32 = 0x0de1;

impl Device {
    /// Opens the chosen device in a context that shares with the OpenGL context that is current in this thread, where the device offers
    /// `cl_khr_gl_sharing`; else as [`open`](Self::open) does, and pictures go into textures through the host. The default is the device
    /// that draws that OpenGL.
    ///
    /// # Errors
    /// No OpenGL context that is current, and all that [`open`](Self::open) refuses.
    pub fn open_with_gl(choice: &DeviceChoice) -> Result<Self, Error> {
        let current = current_gl::properties()?;
        let (device, info) = match choice {
            DeviceChoice::Default => drawing(&current)?.map_or_else(|| selection::choose(choice), Ok)?,
            DeviceChoice::Named(_) => selection::choose(choice)?,
        };
        if !offers_sharing(&device) {
            return Self::opened(&device, info);
        }
        match Context::from_devices(&[device.id()], &with_platform(&current, &device), None, std::ptr::null_mut()) {
            Ok(context) => Self::in_context(info, context),
            // The OpenGL of another device, most often.
            Err(refusal) => {
                tracing::warn!("{} does not share with the current OpenGL context: clCreateContext answers {refusal}", info.name);
                Self::opened(&device, info)
            }
        }
    }

    /// Whether the context was made to share with one of OpenGL's: by [`open_with_gl`](Self::open_with_gl), or by a caller whose queue this is.
    pub fn shares_gl(&self) -> bool {
        self.shared.programs.context.properties().is_ok_and(|properties| current_gl::names_context(&properties))
    }

    /// A 2D texture as memory that pictures of this device go to; none where they cannot, and the first time it is said why.
    pub(crate) fn share_texture(&self, texture: NonZeroU32) -> Option<SharedTexture> {
        let why = if self.shares_gl() {
            // SAFETY: OpenCL refuses what is no texture of OpenGL's.
            let image = unsafe {
                Image::create_from_gl_texture(&self.shared.programs.context, CL_MEM_WRITE_ONLY, GL_TEXTURE_2D, 0, texture.get())
            };
            match image.map_err(|e| self.error("clCreateFromGLTexture", e)).and_then(|image| DeviceMemory::of_image(&image)) {
                Ok(memory) => return Some(SharedTexture(memory)),
                Err(refusal) => refusal.to_string(),
            }
        } else if offers_sharing(&ClDevice::new(self.id())) {
            "its context does not share with OpenGL's: open it with Device::open_with_gl".into()
        } else {
            format!("it does not offer {EXTENSION}")
        };
        let name = &self.info().name;
        self.shared.through_host.call_once(|| tracing::warn!("pictures of {name} go into textures through the host: {why}"));
        None
    }
}

/// The device that draws the OpenGL context, if it can be shared with.
fn drawing(current: &[isize]) -> Result<Option<(ClDevice, DeviceInfo)>, Error> {
    let draws = |device: &ClDevice| {
        offers_sharing(device)
            && get_current_device_for_gl_context_khr(&with_platform(current, device)).is_ok_and(|id| id == device.id())
    };
    Ok(selection::all()?.into_iter().find(|(device, _)| draws(device)))
}

fn offers_sharing(device: &ClDevice) -> bool {
    device.extensions().unwrap_or_default().split_whitespace().any(|name| name == EXTENSION)
}

/// Properties of a context on a device.
fn with_platform(current: &[isize], device: &ClDevice) -> Vec<isize> {
    let platform = device.platform().map_or(0, |platform| platform as isize);
    [current, &[CONTEXT_PLATFORM, platform, 0]].concat()
}

/// A texture of OpenGL's, which is OpenCL's while a picture is copied into it.
pub(crate) struct SharedTexture(DeviceMemory);

impl SharedTexture {
    /// Enqueues a copy of a picture of the texture's size. OpenGL is done with the texture before, and touches it again when all that was
    /// enqueued is over.
    pub fn receive(&self, device: &Device, picture: &Buffer<[u8; 4]>, size: Viewport) -> Result<(), Error> {
        self.0.check(device, "the texture", true)?;
        let texture = [self.0.raw().cast_const()];
        device.command("clEnqueueAcquireGLObjects", |queue, wait| {
            // SAFETY: the texture is alive, and of the queue's context.
            unsafe { queue.enqueue_acquire_gl_objects(&texture, wait) }
        })?;
        let copied = picture.copy_to_image(device, size.width as usize, size.height as usize, &self.0);
        device.command("clEnqueueReleaseGLObjects", |queue, wait| {
            // SAFETY: as above; it was acquired, and goes back whether the copy was enqueued or not.
            unsafe { queue.enqueue_release_gl_objects(&texture, wait) }
        })?;
        copied
    }
}
