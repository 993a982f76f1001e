//! Frames that are drawn without a lattice, in tiles of screen pixels.

use super::Renderer;
use super::sample::SampleAxes;
use super::scratch::at_least;
use crate::device::launch::params::ScreenParams;
use crate::error::Error;
use crate::layers::{AxisFrame, Rays, Viewport};
use glam::DVec3;

impl Renderer {
    /// Makes the frame for kernels that draw tiles of the screen, with the rays in the axes of `frame`.
    pub(super) fn begin_screen(
        &mut self,
        rays: &Rays,
        viewport: Viewport,
        axes: &SampleAxes,
        frame: AxisFrame,
    ) -> Result<ScreenParams, Error> {
        let Self { device, scratch, .. } = self;
        let tuning = *device.tuning();
        let tiles = [viewport.width.div_ceil(tuning.vector_width), viewport.height.div_ceil(tuning.screen_tile_rows)];
        scratch.active_count = tiles[0] as usize * tiles[1] as usize;
        at_least(&mut scratch.frame, device, viewport.pixels(), "the frame")?;
        at_least(&mut scratch.active_samples, device, scratch.active_count, "the sample counts")?;
        let affine = |p: &[DVec3; 3]| p.map(|v| frame.local(v).as_vec3().extend(0.0).to_array());
        Ok(ScreenParams {
            origin: affine(&rays.origin),
            direction: affine(&rays.direction),
            start: rays.start as f32,
            step: frame.local(axes.step).as_vec3().to_array(),
            size: [viewport.width as i32, viewport.height as i32],
            tiles: tiles.map(|t| t as i32),
        })
    }
}
