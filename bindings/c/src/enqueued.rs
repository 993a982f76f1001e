//! Frames that are enqueued and not waited for, into memory of the caller's own.

use crate::border::{Out, copy, guard, values};
use crate::opencl::{_cl_event, _cl_mem, WaitList, give};
use crate::render::View;
use crate::{Camera, Picture, Renderer, Settings, Status, picture, renderer};
use layersplat::device::DeviceMemory;

/// Enqueues a frame into memory of the caller's own, after `wait_count` events, and returns at once. `event`, unless it is null, gets the
/// cl_event that is complete when the picture is there; the caller releases it with clReleaseEvent. Nothing is read back, and no queue is
/// waited for. What the arguments point to may change as soon as this returns.
///
/// Kernels that were not built yet are built first, which takes seconds: layersplat_renderer_prepare() does that beforehand. Sheets
/// cannot be enqueued. An error leaves the queue usable, the picture undefined, and no event.
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
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let onto = unsafe { picture::checked(picture) }?;
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let enqueue = |renderer: &mut layersplat::Renderer| {
            Ok(renderer.enqueue(&view.camera, view.viewport, &view.settings, &onto, &wait.events())?)
        };
        unsafe { give(renderer::with_whole(renderer, "layersplat_renderer_enqueue", enqueue)?, event) };
        Ok(())
    })
}

/// Makes what frames like this one need, from any side: kernels are built, tables made. It waits until all of it is there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_prepare(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        unsafe { renderer::with(renderer, |renderer| Ok(renderer.prepare(&view.camera, view.viewport, &view.settings)?)) }
    })
}

/// The voxels of layersplat_renderer_in_place() change, or have changed: frames from here on are of what is there after `wait_count`
/// events. `event`, unless it is null, gets the cl_event that is complete when those are, for the caller to release; frames wait for it by
/// themselves.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_volume_changed(
    renderer: *mut Renderer,
    wait_count: u32,
    wait_list: *const *mut _cl_event,
    event: *mut *mut _cl_event,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let wait = unsafe { WaitList::new(wait_count, wait_list) }?;
        let changed = |renderer: &mut layersplat::Renderer| Ok(renderer.volume_changed(&wait.events())?);
        unsafe { give(renderer::with_whole(renderer, "layersplat_renderer_volume_changed", changed)?, event) };
        Ok(())
    })
}

/// Bytes of each buffer of scratch that a frame needs, into `sizes`, which has room for `room` of them; `count` is how many there are.
/// With `room` 0, only that is told. Besides, a renderer keeps tables of its own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_scratch_sizes(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    picture: *const Picture,
    sizes: *mut usize,
    room: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let onto = unsafe { picture::checked(picture) }?;
        let count = unsafe { Out::new(count, "count") }?;
        let needed = |renderer: &mut layersplat::Renderer| {
            Ok(renderer.scratch_bytes(&view.camera, view.viewport, &view.settings, &onto)?)
        };
        let needed = unsafe { renderer::with_whole(renderer, "layersplat_renderer_scratch_sizes", needed) }?;
        count.set(needed.len());
        if room == 0 { Ok(()) } else { unsafe { copy(&needed, sizes, room, "sizes") } }
    })
}

/// Gives cl_mem buffers for what enqueued frames write besides the picture: one for each of layersplat_renderer_scratch_sizes(), in any
/// order. They are retained. No buffers, and the renderer makes its own again. Another renderer whose frames may be drawn at the same time
/// must not be given them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_scratch(
    renderer: *mut Renderer,
    buffers: *const *mut _cl_mem,
    count: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let buffers = unsafe { values(buffers, count, "buffers") }?;
        let retained = buffers.iter().map(|buffer| unsafe { DeviceMemory::from_raw(buffer.cast()) });
        let retained = retained.collect::<Result<Vec<_>, _>>()?;
        let set = |renderer: &mut layersplat::Renderer| Ok(renderer.set_scratch(&retained)?);
        unsafe { renderer::with_whole(renderer, "layersplat_renderer_set_scratch", set) }
    })
}
