//! OpenCL/OpenGL sharing (`cl_khr_gl_sharing`): contexts and textures.

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
    /// Opens the chosen device in a context that shares objects with the current OpenGL context of this thread, if the device
    /// supports `cl_khr_gl_sharing`. Otherwise works as [`open`](Self::open), and pictures are copied to textures through host
    /// memory. [`DeviceChoice::Default`] selects the device of the OpenGL context.
    ///
    /// # Errors
    /// No current OpenGL context; all errors of [`open`](Self::open).
    pub fn open_with_gl(choice: &DeviceChoice) -> Result<Self, Error> {
        let current = current_gl::properties()?;
        let (device, info) = match choice {
            DeviceChoice::Default => device_of_gl(&current)?.map_or_else(|| selection::choose(choice), Ok)?,
            DeviceChoice::Named(_) => selection::choose(choice)?,
        };
        if !supports_sharing(&device) {
            return Self::with_new_context(&device, info);
        }
        match Context::from_devices(&[device.id()], &with_platform(&current, &device), None, std::ptr::null_mut()) {
            Ok(context) => Self::with_new_queue(info, context),
            // Usually, another device draws the OpenGL context.
            Err(error) => {
                tracing::warn!("{} cannot share with the current OpenGL context: clCreateContext returned {error}", info.name);
                Self::with_new_context(&device, info)
            }
        }
    }

    /// Whether the OpenCL context shares objects with an OpenGL context, created by [`open_with_gl`](Self::open_with_gl) or by
    /// the caller.
    pub fn shares_gl(&self) -> bool {
        self.shared.programs.context.properties().is_ok_and(|properties| current_gl::names_context(&properties))
    }

    /// A 2D texture as destination of pictures of this device. Returns `None` if it cannot be shared, and logs the reason the
    /// first time.
    pub(crate) fn share_texture(&self, texture: NonZeroU32) -> Option<SharedTexture> {
        let reason = if self.shares_gl() {
            // SAFETY: OpenCL rejects names that are not OpenGL textures.
            let image = unsafe {
                Image::create_from_gl_texture(&self.shared.programs.context, CL_MEM_WRITE_ONLY, GL_TEXTURE_2D, 0, texture.get())
            };
            match image.map_err(|e| self.error("clCreateFromGLTexture", e)).and_then(|image| DeviceMemory::from_image(&image)) {
                Ok(memory) => return Some(SharedTexture(memory)),
                Err(error) => error.to_string(),
            }
        } else if supports_sharing(&ClDevice::new(self.id())) {
            "its context does not share with OpenGL: use Device::open_with_gl".into()
        } else {
            format!("it does not support {EXTENSION}")
        };
        let name = &self.info().name;
        self.shared
            .through_host
            .call_once(|| tracing::warn!("pictures of {name} are copied to textures through the host: {reason}"));
        None
    }
}

/// The device of the OpenGL context, if it supports sharing.
fn device_of_gl(current: &[isize]) -> Result<Option<(ClDevice, DeviceInfo)>, Error> {
    let is_current = |device: &ClDevice| {
        supports_sharing(device)
            && get_current_device_for_gl_context_khr(&with_platform(current, device)).is_ok_and(|id| id == device.id())
    };
    Ok(selection::all()?.into_iter().find(|(device, _)| is_current(device)))
}

fn supports_sharing(device: &ClDevice) -> bool {
    device.extensions().unwrap_or_default().split_whitespace().any(|name| name == EXTENSION)
}

/// Context properties for a device: those of the OpenGL context, the device's platform, and the terminating zero.
fn with_platform(current: &[isize], device: &ClDevice) -> Vec<isize> {
    let platform = device.platform().map_or(0, |platform| platform as isize);
    [current, &[CONTEXT_PLATFORM, platform, 0]].concat()
}

/// An OpenGL texture that OpenCL acquires while a picture is copied into it.
pub(crate) struct SharedTexture(DeviceMemory);

impl SharedTexture {
    /// Enqueues a copy of a picture of the texture's size. OpenGL must have finished using the texture, and must not access it
    /// before the enqueued commands have finished.
    pub fn receive(&self, device: &Device, picture: &Buffer<[u8; 4]>, size: Viewport) -> Result<(), Error> {
        self.0.check(device, "the texture", true)?;
        let texture = [self.0.raw().cast_const()];
        device.command("clEnqueueAcquireGLObjects", |queue, wait| {
            // SAFETY: the texture is alive and belongs to the queue's context.
            unsafe { queue.enqueue_acquire_gl_objects(&texture, wait) }
        })?;
        let copied = picture.copy_to_image(device, size.width as usize, size.height as usize, &self.0);
        device.command("clEnqueueReleaseGLObjects", |queue, wait| {
            // SAFETY: as above; the texture was acquired, and must be released even if the copy failed.
            unsafe { queue.enqueue_release_gl_objects(&texture, wait) }
        })?;
        copied
    }
}
