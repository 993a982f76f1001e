//! From the lattice to the finished picture, and what is reported of a frame.

use super::Renderer;
use super::plan::Plan;
use super::scratch::{Scratch, at_least, read_pixels};
use super::settings::{Classification, Settings};
use crate::camera::Camera;
use crate::device::StageTimes;
use crate::device::launch::WarpArguments;
use crate::device::launch::params::{Float4, WarpParams};
use crate::error::Error;
use crate::image::Background;
use crate::layers::{Ray, Rays, Viewport};
use serde::Serialize;

/// What a frame took.
#[derive(Clone, Debug)]
pub struct FrameReport {
    /// Milliseconds per stage.
    pub stages: StageTimes,
    /// Composited samples whose opacity was above 0.
    pub active_samples: u64,
    /// The lattice, unless the frame was evaluated per pixel.
    pub lattice: Option<LatticeReport>,
}

/// The lattice of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LatticeReport {
    /// Samples per voxel along u and v; in a perspective, in the nearest layer.
    pub m: [f64; 2],
    /// Samples along u.
    pub width: u32,
    /// Samples along v.
    pub height: u32,
}

/// A composited lattice, before the warp.
#[derive(Clone, Debug)]
pub struct LatticePicture {
    plan: Plan,
    /// Samples along u and v.
    pub size: [u32; 2],
    /// Premultiplied RGBA, row by row.
    pub samples: Vec<[f32; 4]>,
}

impl LatticePicture {
    /// The ray of a sample.
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        match &self.plan {
            Plan::Lattice(lattice) => lattice.ray(column, row),
            Plan::Perspective(lattice) => lattice.ray(column, row),
            _ => unreachable!("made for lattices only"),
        }
    }
}

/// Most places per pixel and axis that are averaged where it covers many voxels.
const MOST_FILTERED: f64 = 16.0;

/// A frame that is drawn but for its way onto the screen.
pub(super) struct Drawn {
    pub report: FrameReport,
    warp: Option<WarpParams>,
}

impl FrameReport {
    pub(super) fn new(plan: &Plan) -> Self {
        let lattice = match plan {
            Plan::Lattice(l) => Some((l.samples_per_voxel, l.size)),
            Plan::Perspective(l) => Some((l.samples_per_voxel, l.size)),
            _ => None,
        };
        let lattice = lattice.map(|(m, [width, height])| LatticeReport { m, width, height });
        Self { stages: StageTimes::new(), active_samples: 0, lattice }
    }
}

impl Scratch {
    /// What a warp of the last lattice reads.
    fn warped(&self, params: WarpParams, background: Float4) -> WarpArguments<'_> {
        let rendered = "the lattice was rendered";
        WarpArguments {
            lattice: self.lattice.as_ref().expect(rendered),
            active_samples: self.active_samples.as_ref().expect(rendered),
            params,
            background,
        }
    }
}

impl Renderer {
    /// A frame, up to its lattice.
    pub(super) fn draw(&mut self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Drawn, Error> {
        let rays = Rays::new(camera, viewport, &self.grid)?;
        let plan = Plan::new(&rays, viewport, &self.grid, settings)?;
        tracing::debug!("{plan}");
        if let Plan::Shared(parts) = &plan {
            return self.draw_shared(parts, &rays, viewport, settings);
        }
        let report = self.run(&plan, &rays, viewport, settings)?;
        let warp = self.warp_params(&plan, &rays, viewport, settings.classification);
        Ok(Drawn { report, warp })
    }

    /// A frame that several lattices share, each warped into `scratch.frame` with its share.
    fn draw_shared(
        &mut self,
        parts: &[(Plan, f64)],
        rays: &Rays,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<Drawn, Error> {
        let mut active_samples = 0;
        for (n, (plan, share)) in parts.iter().enumerate() {
            self.run(plan, rays, viewport, settings)?;
            let warp = self.warp_params(plan, rays, viewport, settings.classification);
            let warp = warp.map(|params| WarpParams { share: *share as f32, added: i32::from(n > 0), ..params });
            self.draw_frame(&Drawn { report: FrameReport::new(plan), warp }, viewport)?;
            active_samples += self.count_active()?;
        }
        self.scratch.active_count = 0;
        Ok(Drawn { report: FrameReport { active_samples, ..FrameReport::new(&parts[0].0) }, warp: None })
    }

    /// Samples with opacity in what was drawn last.
    fn count_active(&self) -> Result<u64, Error> {
        let mut counts = vec![0; self.scratch.active_count];
        if let Some(buffer) = &self.scratch.active_samples {
            buffer.read(&self.device, &mut counts)?;
        }
        Ok(counts.iter().map(|&c| u64::from(c)).sum())
    }

    /// How the lattice of a plan comes onto the screen; nothing for a plan that draws there itself.
    fn warp_params(&self, plan: &Plan, rays: &Rays, viewport: Viewport, classification: Classification) -> Option<WarpParams> {
        let (from_screen, size, forward, frame) = match plan {
            Plan::Lattice(l) => (l.from_screen(rays), l.size, 1.0, l.frame),
            Plan::Perspective(l) => (l.from_screen(rays), l.size, l.layer_step as f32, l.frame),
            _ => return None,
        };
        let tuning = self.device.tuning();
        let (tile, counts) = match (plan, classification) {
            // The tiles of all phases lie between each other.
            (Plan::Lattice(l), Classification::Post(_)) => {
                let [m_u, m_v] = l.phases();
                ([tuning.tile_columns() * m_u, tuning.tile_rows * m_v], m_u * m_v)
            }
            (_, Classification::Post(_)) => ([tuning.vector_width, tuning.tile_rows], 1),
            (_, Classification::Preintegrated { .. }) => ([tuning.vector_width, tuning.point_tile_rows], 1),
        };
        Some(WarpParams {
            from_screen: from_screen.transpose().to_cols_array().map(|m| m as f32),
            lattice: size.map(|n| n as i32),
            frame: [viewport.width as i32, viewport.height as i32],
            forward,
            tile: tile.map(|n| n as i32),
            counts: counts as i32,
            share: 1.0,
            added: 0,
            filter: rays.voxels_per_pixel(frame).ceil().clamp(1.0, MOST_FILTERED) as i32,
        })
    }

    /// Completes `scratch.frame`, in floats.
    pub(super) fn draw_frame(&mut self, drawn: &Drawn, viewport: Viewport) -> Result<(), Error> {
        let Self { device, kernels, scratch, .. } = self;
        at_least(&mut scratch.frame, device, viewport.pixels(), "the frame")?;
        let Some(params) = drawn.warp else { return Ok(()) };
        let frame = scratch.frame.as_ref().expect("made above");
        kernels.warp(device)?.launch(device, &scratch.warped(params, Float4([0.0; 4])), frame)
    }

    /// The 8-bit picture, on the host.
    pub(super) fn draw_picture(&mut self, drawn: &Drawn, viewport: Viewport, background: Background) -> Result<Vec<u8>, Error> {
        let Self { device, kernels, scratch, .. } = self;
        let pixels = viewport.pixels();
        at_least(&mut scratch.rgba, device, pixels, "the picture")?;
        let rgba = scratch.rgba.as_ref().expect("made above");
        let background = match background {
            Background::Color([r, g, b]) => Float4([r, g, b, 1.0]),
            Background::Transparent => Float4([0.0; 4]),
        };
        if let Some(params) = drawn.warp {
            kernels.warp_displayed(device)?.launch(device, &scratch.warped(params, background), rgba)?;
        } else {
            let frame = scratch.frame.as_ref().expect("a frame was drawn");
            kernels.present(device)?.launch(device, frame, background, pixels, rgba)?;
        }
        let mut picture = vec![[0u8; 4]; pixels];
        rgba.read(device, &mut picture)?;
        Ok(picture.into_flattened())
    }

    /// Waits for the frame and completes its report.
    pub(super) fn finish(&mut self, mut report: FrameReport) -> Result<FrameReport, Error> {
        report.stages = self.device.finish()?;
        report.active_samples += self.count_active()?;
        Ok(report)
    }

    /// The rendered lattice, on the host.
    pub(super) fn read_lattice(&self, plan: Plan) -> Result<Option<LatticePicture>, Error> {
        let size = match &plan {
            Plan::Lattice(l) => l.size,
            Plan::Perspective(l) => l.size,
            _ => return Ok(None),
        };
        let count = size[0] as usize * size[1] as usize;
        Ok(Some(LatticePicture { plan, size, samples: read_pixels(self.scratch.lattice.as_ref(), &self.device, count)? }))
    }
}
