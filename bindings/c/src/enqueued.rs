//! Asynchronous frames into the caller's device memory.

use crate::boundary::{Out, copy, guard, values};
use crate::opencl::{_cl_event, _cl_mem, WaitList, set_event};
use crate::render::View;
use crate::{Camera, Picture, Renderer, Settings, Status, picture, renderer};
use layersplat::device::DeviceMemory;

/// Enqueues a frame into device memory of the caller, after `wait_count` events, and returns without waiting. If `event` is not
/// null, it receives a cl_event that completes when the picture is written; the caller releases it with clReleaseEvent. Nothing is
/// read back to the host. The arguments may change as soon as the call returns.
///
/// Missing kernels are built first, which takes seconds: layersplat_renderer_prepare() builds them in advance. Sheet-buffer
/// splatting cannot be enqueued. After an error the queue is usable, the picture is undefined, and there is no event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_enqueue(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    picture: *const Picture,
    wait_count: u32,
    wait_list: *const *mut _cl_event,
    event: *mut *mut _cl_event,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let onto = unsafe { picture::checked(picture) }?;
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let enqueue = |renderer: &mut layersplat::Renderer| {
            Ok(renderer.enqueue(&view.camera, view.viewport, &view.settings, &onto, &wait.events())?)
        };
        unsafe { set_event(renderer::with_whole(renderer, "layersplat_renderer_enqueue", enqueue)?, event) };
        Ok(())
    })
}

/// Builds the kernels and tables that frames with these settings need, for every view direction. The call blocks until they are
/// ready.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_prepare(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        unsafe { renderer::with(renderer, |renderer| Ok(renderer.prepare(&view.camera, view.viewport, &view.settings)?)) }
    })
}

/// Notifies a renderer of layersplat_renderer_in_place() that its voxels have changed, or will have changed after `wait_count`
/// events. Later frames use the new voxels. If `event` is not null, it receives a cl_event that completes when those events have;
/// the caller releases it. Frames wait for it automatically.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_volume_changed(
    renderer: *mut Renderer,
    wait_count: u32,
    wait_list: *const *mut _cl_event,
    event: *mut *mut _cl_event,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let changed = |renderer: &mut layersplat::Renderer| Ok(renderer.volume_changed(&wait.events())?);
        unsafe { set_event(renderer::with_whole(renderer, "layersplat_renderer_volume_changed", changed)?, event) };
        Ok(())
    })
}

/// Sizes in bytes of the scratch buffers that a frame needs. `sizes` is an array of `capacity` elements; `count` is set to the number
/// of buffers. If `capacity` is 0, only `count` is set. The renderer's own tables are not included.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_scratch_sizes(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    picture: *const Picture,
    sizes: *mut usize,
    capacity: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let onto = unsafe { picture::checked(picture) }?;
        let count = unsafe { Out::new(count, "count") }?;
        let needed = |renderer: &mut layersplat::Renderer| {
            Ok(renderer.scratch_bytes(&view.camera, view.viewport, &view.settings, &onto)?)
        };
        let needed = unsafe { renderer::with_whole(renderer, "layersplat_renderer_scratch_sizes", needed) }?;
        count.set(needed.len());
        if capacity == 0 { Ok(()) } else { unsafe { copy(&needed, sizes, capacity, "sizes") } }
    })
}

/// Sets the cl_mem scratch buffers of enqueued frames: one for each size of layersplat_renderer_scratch_sizes(), in any order. They
/// are retained. If `count` is 0, the renderer allocates its own again. Renderers whose frames may run concurrently must not share
/// scratch buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_scratch(
    renderer: *mut Renderer,
    buffers: *const *mut _cl_mem,
    count: usize,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let buffers = unsafe { values(buffers, count, "buffers") }?;
        let retained = buffers.iter().map(|buffer| unsafe { DeviceMemory::from_raw(buffer.cast()) });
        let retained = retained.collect::<Result<Vec<_>, _>>()?;
        let set = |renderer: &mut layersplat::Renderer| Ok(renderer.set_scratch(&retained)?);
        unsafe { renderer::with_whole(renderer, "layersplat_renderer_set_scratch", set) }
    })
}
