//! Renderers.

use crate::border::{Failure, Out, borrowed, free, guard};
use crate::{Device, Status, Transfer, Volume};
use layersplat::renderer::{VolumeRenderer, volume_renderer};
use std::sync::{Mutex, TryLockError};
use std::time::Duration;

/// Renders one volume on one device. It may go from thread to thread, but is used by one at a time: a second one is answered
/// LAYERSPLAT_STATUS_BUSY.
pub struct Renderer(Mutex<Box<AnyRenderer>>);

/// A renderer that holds the whole volume, or one that streams it.
pub(crate) type AnyRenderer = dyn VolumeRenderer<'static> + Send;

impl Renderer {
    pub(crate) fn new(renderer: Box<AnyRenderer>) -> Self {
        Self(Mutex::new(renderer))
    }
}

/// Does something with a renderer that nobody else uses.
pub(crate) unsafe fn with<R>(
    renderer: *const Renderer,
    act: impl FnOnce(&mut AnyRenderer) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    let renderer = unsafe { borrowed(renderer, "renderer") }?;
    match renderer.0.try_lock() {
        Ok(mut renderer) => act(&mut **renderer),
        Err(TryLockError::WouldBlock) => Err(Failure::new(Status::Busy, "the renderer is in use by another thread")),
        Err(TryLockError::Poisoned(_)) => Err(Failure::new(
            Status::Panic,
            "layersplat panicked in this renderer before: it cannot be used any more, make another",
        )),
    }
}

/// Makes a renderer of a volume, seen through a transfer function. Device, volume and transfer function may be freed afterwards; the
/// renderer by layersplat_renderer_free().
///
/// The voxels are uploaded at once. A renderer on a device with a memory budget (layersplat_device_with_memory()), and one whose
/// volume is larger than the device's largest buffer, uploads them during frames instead: all of them if they fit, in parts if not.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_new(
    device: *const Device,
    volume: *const Volume,
    transfer: *const Transfer,
    renderer: *mut *mut Renderer,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        out.give(Renderer::new(volume_renderer(&device.0, &volume.0, &transfer.0)?));
        Ok(())
    })
}

/// Calls `act` with a renderer of the whole volume, as [`with`] does. Refuses the call `name` on a renderer that streams.
pub(crate) unsafe fn with_whole<R>(
    renderer: *const Renderer,
    name: &'static str,
    act: impl FnOnce(&mut layersplat::Renderer) -> Result<R, Failure>,
) -> Result<R, Failure> {
    // SAFETY: the caller's promise.
    unsafe { with(renderer, |renderer| act(renderer.require_whole(name)?)) }
}

/// Takes another transfer function from the next frame on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_transfer(renderer: *mut Renderer, transfer: *const Transfer) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let transfer = unsafe { borrowed(transfer, "transfer") }?;
        unsafe {
            with(renderer, |renderer| {
                renderer.set_transfer_function(&transfer.0);
                Ok(())
            })
        }
    })
}

/// Longest time of a frame in seconds, from the next one on; 0: no limit. A longer frame returns LAYERSPLAT_STATUS_TOO_LONG before its next
/// kernel; the one that is running is not stopped. Frames that are enqueued are not limited. Another thread ends a frame by
/// layersplat_cancel_frames().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_limit(renderer: *mut Renderer, seconds: f64) -> Status {
    guard(|| {
        let longest = Duration::try_from_secs_f64(seconds)
            .map_err(|_| Failure::invalid(format!("seconds is {seconds}: expected a finite number, 0 or above")))?;
        // SAFETY: the caller's promise.
        unsafe {
            with(renderer, |renderer| {
                renderer.limit((!longest.is_zero()).then_some(longest));
                Ok(())
            })
        }
    })
}

/// Frees a renderer, which no call may be using, with all that it keeps on the device. What was enqueued is drawn to its end. Null is left
/// alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_free(renderer: *mut Renderer) {
    // SAFETY: the caller's promise.
    unsafe { free(renderer) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;
    use layersplat::{DeviceChoice, OpenOptions, TransferFunction};

    /// A panic in the middle of a frame leaves a renderer that says so, and can be freed.
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
