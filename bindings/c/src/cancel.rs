//! Cancellation of frames from another thread.

use crate::boundary::{Out, borrowed, free, guard};
use crate::{Renderer, Status, renderer};

/// A cancellation flag for frames. Several threads may use it at the same time, also while its renderers are in use. Several
/// renderers may share one.
pub struct Cancel(layersplat::Cancel);

/// Creates a cancellation flag that is not set. To be freed by layersplat_cancel_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_new(cancel: *mut *mut Cancel) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        unsafe { Out::handle(cancel, "cancel") }?.set_handle(Cancel(layersplat::Cancel::new()));
        Ok(())
    })
}

/// Attaches a cancellation flag to a renderer, effective from the next frame. Null detaches it. Enqueued frames cannot be cancelled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_cancel(renderer: *mut Renderer, cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let cancel = unsafe { cancel.as_ref() }.map(|cancel| cancel.0.clone());
        unsafe {
            renderer::with(renderer, |renderer| {
                renderer.set_cancel(cancel);
                Ok(())
            })
        }
    })
}

/// Cancels the current frame and all later ones until layersplat_cancel_reset(). They return LAYERSPLAT_STATUS_CANCELLED and write
/// no pixels. A frame stops before its next kernel; a running kernel is not interrupted. The call does not block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_frames(cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        unsafe { borrowed(cancel, "cancel") }?.0.cancel();
        Ok(())
    })
}

/// Clears the flag. Later frames are rendered again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_reset(cancel: *const Cancel) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller.
        unsafe { borrowed(cancel, "cancel") }?.0.reset();
        Ok(())
    })
}

/// Frees a cancellation flag. Its renderers stay usable without it. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_cancel_free(cancel: *mut Cancel) {
    // SAFETY: upheld by the caller.
    unsafe { free(cancel) }
}
