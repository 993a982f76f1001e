//! Parameters shared by both per-pixel renderings of layers.

use super::super::scene::Scene;
use crate::device::launch::structs::{DirectParams, VolumeView};
use crate::layers::Axis;
use glam::DVec3;

/// Layer axes whose blocks are passed to kernels for x, y, z. If all rays share one axis, the blocks of the others are not read.
pub(super) fn layer_axes(axis: Option<Axis>) -> [Axis; 3] {
    axis.map_or(Axis::ALL, |axis| [axis; 3])
}

/// Kernel argument with the rays. `view` is that of layer axis z; `blocks` are those of layer axes x, y, z.
pub(super) fn direct_params(scene: &Scene, axis: Option<Axis>, view: &VolumeView, blocks: [[i32; 2]; 3]) -> DirectParams {
    let affine = |p: &[DVec3; 3]| p.map(|v| v.as_vec3().extend(0.0).to_array());
    let Scene { rays, settings, .. } = *scene;
    let [x, y, z] = view.stride;
    DirectParams {
        stride: [x, y, z, view.first],
        origin: affine(&rays.origin),
        direction: affine(&rays.direction),
        start: rays.start as f32,
        dims: view.dims,
        blocks,
        axis: axis.map_or(-1, |a| a.index() as i32),
        culling: i32::from(settings.culling),
        background: view.background,
        offset: view.offset,
    }
}
