//! Frames that another thread cancels.

use crate::border::{Out, borrowed, free, guard};
use crate::{Renderer, Status, renderer};

/// Cancels frames from another thread. Any thread may use it, several at a time, also while a renderer that it was given to is in use; one
/// may serve several renderers.
pub struct Cancel(layersplat::Cancel);

/// Not cancelled. To be freed by layersplat_cancel_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_new(cancel: *mut *mut Cancel) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        unsafe { Out::handle(cancel, "cancel") }?.give(Cancel(layersplat::Cancel::new()));
        Ok(())
    })
}

/// Lets `cancel` end frames of a renderer, from the next one on; null: nothing does any more. Frames that are enqueued are not cancelled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_cancel(renderer: *mut Renderer, cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let cancel = unsafe { cancel.as_ref() }.map(|cancel| cancel.0.clone());
        unsafe {
            renderer::with(renderer, |renderer| {
                renderer.set_cancel(cancel);
                Ok(())
            })
        }
    })
}

/// Ends the frame in progress and all later ones, until layersplat_cancel_reset(): they return LAYERSPLAT_STATUS_CANCELLED and write no
/// pixels. A frame ends before its next kernel; the one that is running is not stopped. It returns at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_frames(cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        unsafe { borrowed(cancel, "cancel") }?.0.cancel();
        Ok(())
    })
}

/// Lets later frames be drawn again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_reset(cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: the caller's promise.
        unsafe { borrowed(cancel, "cancel") }?.0.reset();
        Ok(())
    })
}

/// Frees it. Renderers that it was given to go on, and nothing cancels them any more. Null is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_free(cancel: *mut Cancel) {
    // SAFETY: the caller's promise.
    unsafe { free(cancel) }
}
