//! Rays of screen pixels, for kernels that render in screen tiles.

use super::sampling::Steps;
use super::scene::Scene;
use super::tiles::Tiles;
use crate::device::launch::structs::ScreenParams;
use crate::layers::AxisFrame;
use glam::DVec3;

/// Kernel argument with the rays in the axes of `frame`.
pub(super) fn screen_params(scene: &Scene, steps: Steps, frame: AxisFrame, tiles: Tiles) -> ScreenParams {
    let Scene { rays, viewport, .. } = *scene;
    let affine = |p: &[DVec3; 3]| p.map(|v| frame.local(v).as_vec3().extend(0.0).to_array());
    ScreenParams {
        origin: affine(&rays.origin),
        direction: affine(&rays.direction),
        step: frame.local(steps.0).as_vec3().to_array(),
        size: [viewport.width as i32, viewport.height as i32],
        tiles: tiles.for_kernels(),
    }
}
