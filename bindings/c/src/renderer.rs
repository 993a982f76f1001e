//! Renderers.

use crate::boundary::{Failure, Out, borrowed, free, guard};
use crate::{Device, Status, Transfer, Volume};
use layersplat::renderer::{VolumeRenderer, volume_renderer};
use std::sync::{Mutex, TryLockError};
use std::time::Duration;

/// A renderer of one volume on one device. It may move between threads, but only one thread may use it at a time: concurrent calls
/// return LAYERSPLAT_STATUS_BUSY.
pub struct Renderer(Mutex<Box<AnyRenderer>>);

/// A renderer that holds the whole volume, or one that streams it.
pub(crate) type AnyRenderer = dyn VolumeRenderer<'static> + Send;

impl Renderer {
    pub(crate) fn new(renderer: Box<AnyRenderer>) -> Self {
        Self(Mutex::new(renderer))
    }
}

/// Calls `act` with exclusive access to a renderer.
///
/// # Errors
/// `Busy` if another thread uses the renderer, `Panic` after a panic in it, and the errors of `act`.
pub(crate) unsafe fn with<R>(
    renderer: *const Renderer,
    act: impl FnOnce(&mut AnyRenderer) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: upheld by the caller.
    let renderer = unsafe { borrowed(renderer, "renderer") }?;
    match renderer.0.try_lock() {
        Ok(mut renderer) => act(&mut **renderer),
        Err(TryLockError::WouldBlock) => Err(Failure::new(Status::Busy, "the renderer is in use by another thread")),
        Err(TryLockError::Poisoned(_)) => {
            Err(Failure::new(Status::Panic, "layersplat panicked in this renderer before: free it and make another"))
        }
    }
}

/// Creates a renderer of a volume with a transfer function. Device, volume and transfer function may be freed afterwards. To be freed
/// by layersplat_renderer_free().
///
/// The voxels are uploaded immediately. They are uploaded during frames instead if the device has a memory budget
/// (layersplat_device_with_memory()) or the volume exceeds the largest buffer of the device: completely if they fit, otherwise in
/// parts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_new(
    device: *const Device,
    volume: *const Volume,
    transfer: *const Transfer,
    renderer: *mut *mut Renderer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        out.set_handle(Renderer::new(volume_renderer(&device.0, &volume.0, &transfer.0)?));
        Ok(())
    })
}

/// Like [`with`], for a renderer that holds the whole volume. Rejects the call `name` on a renderer that streams.
pub(crate) unsafe fn with_whole<R>(
    renderer: *const Renderer,
    name: &'static str,
    act: impl FnOnce(&mut layersplat::Renderer) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: upheld by the caller.
    unsafe { with(renderer, |renderer| act(renderer.require_whole(name)?)) }
}

/// Sets the transfer function, effective from the next frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_transfer(renderer: *mut Renderer, transfer: *const Transfer) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        unsafe {
            with(renderer, |renderer| {
                renderer.set_transfer_function(&transfer.0);
                Ok(())
            })
        }
    })
}

/// Replaces the volume, effective from the next frame. Size, type and range may differ. The volume may be freed afterwards. If memory
/// is insufficient, the renderer may have no volume: frames then return an error until a volume is set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_volume(renderer: *mut Renderer, volume: *const Volume) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let volume = unsafe { borrowed(volume, "volume") }?;
        unsafe { with(renderer, |renderer| Ok(renderer.set_volume(&volume.0)?)) }
    })
}

/// Sets the time limit per frame in seconds, effective from the next frame; 0: no limit. A frame that exceeds it returns
/// LAYERSPLAT_STATUS_TOO_LONG before its next kernel; a running kernel is not interrupted. Enqueued frames are not limited. To end a
/// frame from another thread, use layersplat_cancel_frames().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_limit(renderer: *mut Renderer, seconds: f64) -> Status {
    guard(|| {
        let longest = Duration::try_from_secs_f64(seconds)
            .map_err(|_| Failure::invalid(format!("seconds is {seconds}: expected a finite number, 0 or above")))?;
        // SAFETY: upheld by the caller.
        unsafe {
            with(renderer, |renderer| {
                renderer.limit((!longest.is_zero()).then_some(longest));
                Ok(())
            })
        }
    })
}

/// Frees a renderer and its device memory. No call may be using it. Enqueued frames still complete. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_free(renderer: *mut Renderer) {
    // SAFETY: upheld by the caller.
    unsafe { free(renderer) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;
    use layersplat::{DeviceChoice, OpenOptions, TransferFunction};

    /// After a panic, every call on the renderer reports it, and the renderer can be freed.
    #[test]
    fn a_renderer_is_used_once_at_a_time_and_not_after_a_panic() {
        let volume = layersplat::Volume::open("builtin:hydrogen@8", &OpenOptions::default()).unwrap();
        let transfer = TransferFunction::automatic(&volume);
        let device = layersplat::Device::open(&DeviceChoice::Default).unwrap();
        let made = Renderer::new(volume_renderer(&device, &volume, &transfer).unwrap());
        let renderer = Box::into_raw(Box::new(made));
        // SAFETY: it is alive until it is freed.
        unsafe {
            let within = with(renderer, |_| Ok(layersplat_renderer_limit(renderer, 0.0)));
            assert_eq!(within.unwrap(), Status::Busy);
            assert_eq!(layersplat_renderer_limit(renderer, 1.0), Status::Ok);
            assert_eq!(layersplat_renderer_limit(renderer, f64::NAN), Status::InvalidArgument);
            assert_eq!(guard(|| with(renderer, |_| panic!("in the middle"))), Status::Panic);
            assert_eq!(layersplat_renderer_limit(renderer, 0.0), Status::Panic);
            layersplat_renderer_free(renderer);
        }
    }
}
