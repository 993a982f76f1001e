//! Which evaluation a view gets.

use super::algorithm::Algorithm;
use super::settings::{Classification, Evaluation, Footprints, LayerAxis, Settings};
use crate::error::Error;
use crate::layers::{Axis, Density, Interpolation, Lattice, PerspectiveLattice, Rays, Viewport};
use crate::volume::Grid;
use std::fmt;

/// Largest |s| of a forced layer axis: kernels/direct.cl culls up to here.
const MAX_FORCED_SHEAR: f64 = 3.0;

/// How a frame is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// On the sheared lattice of a parallel view.
    Lattice(Lattice),
    /// On the lattice of a perspective.
    Perspective(PerspectiveLattice),
    /// On the lattices of two or three layer axes between which the view lies, each with its share of the picture, the most parallel
    /// first.
    Shared(Vec<(Plan, f64)>),
    /// Per pixel: with one layer axis, or with each ray's own.
    Direct(Option<Axis>),
    /// By axis-aligned sheets.
    AxisSheets(Axis),
    /// By sheets across the view, of a distance in voxels.
    ViewSheets(f64),
    /// By slices, of a distance in smallest spacings.
    Slicing(f64),
    /// By ray casting, with a step in smallest spacings.
    Raycast(Interpolation, f64),
    /// By ray casting with pre-integrated stretches of a length in smallest spacings: layers where no lattice reaches.
    Stretches(f64),
}

impl Plan {
    /// Chooses layer axis and evaluation for a view.
    ///
    /// All rays share the central ray's axis as long as none leans too far from it; otherwise (wide angles, an eye
    /// inside the volume) rays are cast, or, per pixel, each takes its own.
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, settings: &Settings) -> Result<Self, Error> {
        settings.check()?;
        let axis = match settings.layer_axis {
            LayerAxis::Auto => Axis::most_parallel(rays.central_direction()),
            LayerAxis::Forced(axis) => axis,
        };
        match settings.algorithm {
            Algorithm::Layered => {}
            Algorithm::AxisSheets => {
                let shear = axis.frame().shear(rays.central_direction());
                let reached = shear.iter().all(|s| s.abs() <= MAX_FORCED_SHEAR);
                return if reached { Ok(Plan::AxisSheets(axis)) } else { Err(too_far(axis)) };
            }
            Algorithm::ViewSheets { sheet_distance } => return Ok(Plan::ViewSheets(sheet_distance)),
            Algorithm::Slicing { step } => return Ok(Plan::Slicing(step)),
            Algorithm::Raycast { interpolation, step } => return Ok(Plan::Raycast(interpolation, step)),
        }
        let direct = Self::direct(rays, grid, axis, settings)?;
        let Evaluation::Lattice(density) = settings.evaluation else {
            return Ok(direct);
        };
        if let Some(shared) = Self::shared(rays, viewport, grid, density, settings) {
            return Ok(shared);
        }
        let lattice = Self::lattice(rays, viewport, grid, axis, density, settings.classification);
        Ok(lattice.unwrap_or_else(|| {
            // A forced axis is kept to.
            let plan = if settings.layer_axis == LayerAxis::Auto { Self::cast(density, settings.classification) } else { direct };
            tracing::info!("no lattice reaches this view: {plan}");
            plan
        }))
    }

    /// The lattice of a layer axis, if it reaches all rays.
    fn lattice(
        rays: &Rays,
        viewport: Viewport,
        grid: &Grid,
        axis: Axis,
        density: Density,
        classification: Classification,
    ) -> Option<Self> {
        match (rays.is_parallel(), classification) {
            (true, Classification::Post(_)) => Lattice::in_phases(rays, viewport, grid, axis, density).map(Plan::Lattice),
            (true, Classification::Preintegrated { .. }) => Lattice::new(rays, viewport, grid, axis, density).map(Plan::Lattice),
            (false, Classification::Post(_)) => {
                PerspectiveLattice::new(rays, viewport, grid, axis, density).map(Plan::Perspective)
            }
            (false, Classification::Preintegrated { .. }) => {
                PerspectiveLattice::of_points(rays, viewport, grid, axis, density).map(Plan::Perspective)
            }
        }
    }

    /// Lattices of all axes that have a share in the view, if these are several and all reach. Splatted layers switch from one
    /// axis to the next, as in the paper.
    fn shared(rays: &Rays, viewport: Viewport, grid: &Grid, density: Density, settings: &Settings) -> Option<Self> {
        let Classification::Preintegrated { .. } = settings.classification else { return None };
        let shares = match settings.layer_axis {
            LayerAxis::Auto => Axis::shares(rays.central_direction()),
            LayerAxis::Forced(_) => return None,
        };
        let lattice = |axis| Self::lattice(rays, viewport, grid, axis, density, settings.classification);
        let parts: Option<Vec<_>> = shares.iter().map(|&(axis, share)| Some((lattice(axis)?, share))).collect();
        parts.filter(|parts| parts.len() > 1).map(Plan::Shared)
    }

    /// Ray casting of at least the fidelity that a lattice would have: 44 to 70 dB with four steps per layer where one sample per layer
    /// has 28 to 47 per pixel, in a fifth of the time (engine and tooth, from inside and at wide angles, lit).
    fn cast(density: Density, classification: Classification) -> Self {
        let per_layer = if matches!(density, Density::Fixed(_)) { 2.0 } else { 4.0 };
        let step = 1.0 / (per_layer * f64::from(classification.samples_per_layer()));
        match classification {
            Classification::Post(_) => Plan::Raycast(Interpolation::Tricubic, step),
            Classification::Preintegrated { .. } => Plan::Stretches(step),
        }
    }

    fn direct(rays: &Rays, grid: &Grid, axis: Axis, settings: &Settings) -> Result<Self, Error> {
        // The footprint set ends at 45°, where the axis rule does.
        let set = settings.footprints == Footprints::Set;
        let limit = if set { 1.0 + 1e-6 } else { MAX_FORCED_SHEAR };
        let reached = if rays.is_parallel() {
            axis.frame().shear(rays.central_direction()).iter().all(|s| s.abs() <= limit)
        } else {
            !set && PerspectiveLattice::reaches(rays, grid, axis)
        };
        match (reached, settings.layer_axis) {
            (true, _) => Ok(Plan::Direct(Some(axis))),
            (false, LayerAxis::Auto) => Ok(Plan::Direct(None)),
            (false, LayerAxis::Forced(_)) => Err(too_far(axis)),
        }
    }
}

fn too_far(axis: Axis) -> Error {
    let problem = format!("some rays lean too far from layer axis {axis:?}: choose another --layer-axis, or auto");
    Error::Settings { problem }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Plan::Lattice(l) => write!(f, "lattice of {}x{} samples, {:?} per voxel", l.size[0], l.size[1], l.samples_per_voxel),
            Plan::Perspective(l) => write!(f, "perspective lattice of {}x{} samples", l.size[0], l.size[1]),
            Plan::Shared(parts) => parts.iter().try_for_each(|(plan, share)| write!(f, "{share:.3} of a {plan}; ")),
            Plan::Direct(Some(axis)) => write!(f, "direct, layer axis {axis:?}"),
            Plan::Direct(None) => write!(f, "direct, each ray with its own layer axis"),
            Plan::AxisSheets(axis) => write!(f, "sheets along axis {axis:?}"),
            Plan::ViewSheets(distance) => write!(f, "sheets across the view, {distance} voxels apart"),
            Plan::Slicing(step) => write!(f, "slices {step} spacings apart"),
            Plan::Stretches(step) => write!(f, "rays, pre-integrated in steps of {step} spacings"),
            Plan::Raycast(interpolation, step) => write!(f, "rays, {interpolation:?}, in steps of {step} spacings"),
        }
    }
}
