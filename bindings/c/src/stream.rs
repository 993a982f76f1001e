//! Streaming plan of a view.

use crate::boundary::{Out, guard};
use crate::render::View;
use crate::renderer::{self, AnyRenderer};
use crate::{Camera, Renderer, Settings, Status};

/// How a frame uploads its volume. See layersplat_renderer_stream_plan().
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StreamPlan {
    /// Number of parts that are uploaded in sequence; 1: all voxels are on the device at once.
    pub parts: usize,
    /// Bytes of voxels that are read and uploaded, including the layers that neighbouring parts share. This and all fields below
    /// are 0 if nothing is streamed.
    pub voxel_bytes: u64,
    /// Bytes of the whole volume's voxels.
    pub volume_bytes: u64,
    /// Peak bytes of buffers on the device.
    pub device_bytes: u64,
    /// Bytes available for these buffers: the memory budget minus the allocations of other renderers.
    pub available_bytes: u64,
}

impl StreamPlan {
    fn new(plan: Option<layersplat::renderer::StreamPlan>) -> Self {
        let Some(plan) = plan else { return Self { parts: 1, ..Self::default() } };
        let in_parts = plan.lattices.iter().any(|lattice| lattice.parts > 1);
        Self {
            // Near 45 degrees, a view has several lattices, each with its own parts.
            parts: if in_parts { plan.lattices.iter().map(|lattice| lattice.parts).sum() } else { 1 },
            voxel_bytes: plan.voxel_bytes,
            volume_bytes: plan.volume_bytes,
            device_bytes: plan.device_bytes,
            available_bytes: plan.memory,
        }
    }
}

/// The streaming plan of a frame, without rendering it. Returns the same out-of-memory errors as rendering would.
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
        // SAFETY: upheld by the caller, here and below.
        let view = unsafe { View::new(camera, width, height, settings) }?;
        let out = unsafe { Out::new(plan, "plan") }?;
        let find = |renderer: &mut AnyRenderer| Ok(renderer.stream_plan(&view.camera, view.viewport, &view.settings)?);
        out.set(StreamPlan::new(unsafe { renderer::with(renderer, find) }?));
        Ok(())
    })
}
