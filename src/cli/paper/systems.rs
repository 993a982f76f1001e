//! The compared systems and their ground truth.

use super::super::rotate::{ELEVATION, turn};
use super::Laboratory;
use super::data_sets::DataSet;
use crate::camera::{Camera, Orbit};
use crate::error::Error;
use crate::image::{Background, Frame};
use crate::layers::{Density, Kernel};
use crate::renderer::Renderer;
use crate::settings::{Algorithm, Classification, Evaluation, LayerAxis, Layered, Quality, Settings};
use std::time::Instant;

/// View of pictures and fidelities, as in docs/dev/fidelity.md.
pub(super) const VIEW: Orbit = Orbit { azimuth: 72.0, elevation: ELEVATION, roll: 0.0 };

/// Step of the converged integral, relative to the smallest spacing.
const CONVERGED: f64 = 1.0 / 16.0;

/// The systems of Table 1 in its order, then two more quality presets of layered.
pub(super) const SYSTEMS: [System; 6] = [
    System {
        name: "axis-sheets",
        kernel: Kernel::Gaussian,
        make: Make::Algorithm(Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }),
    },
    System {
        name: "view-sheets",
        kernel: Kernel::Gaussian,
        make: Make::Algorithm(Algorithm::ViewSheets { sheet_distance: 1.0 }),
    },
    System { name: "layered", kernel: Kernel::Cubic, make: Make::Layered(Quality::Standard) },
    System { name: "slicing", kernel: Kernel::Linear, make: Make::Algorithm(Algorithm::Slicing { step: 1.0 }) },
    System { name: "layered draft", kernel: Kernel::Cubic, make: Make::Layered(Quality::Draft) },
    System { name: "layered high", kernel: Kernel::Cubic, make: Make::Layered(Quality::High) },
];

/// Number of [`SYSTEMS`] in the paper.
pub(super) const PAPER_SYSTEMS: usize = 4;
/// Indices in [`SYSTEMS`].
pub(super) const VIEW_SHEETS: usize = 1;
pub(super) const LAYERED: usize = 2;
pub(super) const SLICING: usize = 3;
/// Indices of the quality presets of layered, fastest first.
pub(super) const QUALITIES: [usize; 3] = [4, LAYERED, 5];
/// Indices of the other systems.
pub(super) const OTHERS: [usize; 3] = [0, VIEW_SHEETS, SLICING];

/// A system at its default settings; layered uses the paper's kernel.
#[derive(Clone, Copy)]
pub(super) struct System {
    pub name: &'static str,
    /// Reconstruction kernel.
    pub kernel: Kernel,
    make: Make,
}

#[derive(Clone, Copy)]
enum Make {
    Algorithm(Algorithm),
    Layered(Quality),
}

impl System {
    pub fn settings(self) -> Settings {
        match self.make {
            Make::Algorithm(algorithm) => algorithm.into(),
            Make::Layered(quality) => {
                let own = quality.layered();
                Layered { classification: own.classification.with_kernel(self.kernel), ..own }.into()
            }
        }
    }
}

/// Layered rendering with a lattice density and a number of samples per layer.
pub(super) fn layered(density: Density, samples_per_layer: u32) -> Settings {
    let classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer };
    Layered { evaluation: Evaluation::Lattice(density), classification, ..Layered::default() }.into()
}

/// Renderer of one data set.
pub(super) struct Bench<'a> {
    laboratory: &'a Laboratory<'a>,
    set: &'a DataSet,
    renderer: Renderer,
}

impl<'a> Bench<'a> {
    pub fn new(laboratory: &'a Laboratory, set: &'a DataSet) -> Result<Self, Error> {
        let renderer = Renderer::new(&laboratory.device, &set.volume, &set.transfer)?;
        Ok(Self { laboratory, set, renderer })
    }

    pub fn camera(&self, orbit: Orbit) -> Camera {
        let grid = self.set.volume.grid();
        Camera::fit_parallel(grid.centre(), grid.diagonal(), self.laboratory.size, orbit)
    }

    /// Renders a picture from an orbit.
    pub fn picture(&mut self, orbit: Orbit, settings: &Settings) -> Result<Frame, Error> {
        let camera = self.camera(orbit);
        Ok(self.renderer.render(&camera, self.laboratory.size, settings)?.0)
    }

    /// Renders a picture without shading, for comparison with the ground truth, which is unshaded.
    pub fn unshaded(&mut self, orbit: Orbit, settings: &Settings) -> Result<Frame, Error> {
        self.picture(orbit, &Settings { shading: None, ..*settings })
    }

    /// The converged integral of a kernel's field, unshaded.
    pub fn truth(&mut self, orbit: Orbit, kernel: Kernel) -> Result<Frame, Error> {
        let algorithm = Algorithm::Raycast { kernel, step: CONVERGED };
        self.unshaded(orbit, &Settings { algorithm, early_termination: false, ..Settings::default() })
    }

    /// Times in milliseconds of frames `from..to` of a turn of `frames`, up to the finished 8-bit picture.
    pub fn times(&mut self, settings: &Settings, from: u32, to: u32, frames: u32) -> Result<Vec<f64>, Error> {
        (from..to)
            .map(|n| {
                let camera = self.camera(turn(Orbit { azimuth: 0.0, ..VIEW }, n, frames));
                let started = Instant::now();
                self.renderer.render_rgba8(&camera, self.laboratory.size, settings, Background::BLACK)?;
                Ok(started.elapsed().as_secs_f64() * 1e3)
            })
            .collect()
    }
}
