//! How a view is streamed.

use crate::border::{Out, guard};
use crate::render::View;
use crate::renderer::{self, AnyRenderer};
use crate::{Camera, Renderer, Settings, Status};

/// How a frame uploads its volume, of layersplat_renderer_stream_plan().
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StreamPlan {
    /// Parts that are uploaded one after the other; 1: all voxels are on the device at once.
    pub parts: usize,
    /// Bytes of voxels that are read and uploaded, with the layers that neighbouring parts share. This and all below are 0 where nothing
    /// is streamed.
    pub voxel_bytes: u64,
    /// Bytes of the whole volume's voxels.
    pub volume_bytes: u64,
    /// Most bytes of buffers on the device at a time.
    pub device_bytes: u64,
    /// Bytes that these may take: the memory budget less what other renderers take of it.
    pub available_bytes: u64,
}

impl StreamPlan {
    fn new(plan: Option<layersplat::renderer::StreamPlan>) -> Self {
        let Some(plan) = plan else { return Self { parts: 1, ..Self::default() } };
        let in_parts = plan.lattices.iter().any(|lattice| lattice.parts > 1);
        Self {
            // Near 45 degrees, each lattice of the view has its own parts.
            parts: if in_parts { plan.lattices.iter().map(|lattice| lattice.parts).sum() } else { 1 },
            voxel_bytes: plan.voxel_bytes,
            volume_bytes: plan.volume_bytes,
            device_bytes: plan.device_bytes,
            available_bytes: plan.memory,
        }
    }
}

/// How a frame would upload its volume, without drawing it. The errors are those that drawing it would return for want of memory.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_stream_plan(
    renderer: *mut Renderer,
    camera: *const Camera,
    width: u32,
    height: u32,
    settings: *const Settings,
    plan: *mut StreamPlan,
) -> Status {
    guard(|| {
        // SAFETY: the caller's promise, and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let out = unsafe { Out::new(plan, "plan") }?;
        let find = |renderer: &mut AnyRenderer| Ok(renderer.stream_plan(&view.camera, view.viewport, &view.settings)?);
        out.set(StreamPlan::new(unsafe { renderer::with(renderer, find) }?));
        Ok(())
    })
}
