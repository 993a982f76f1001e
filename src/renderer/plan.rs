//! Render-path selection.

#[cfg(feature = "paper")]
use super::paper::PaperPlan;
use crate::error::Error;
use crate::layers::{Axis, Density, Kernel, Lattice, Rays, Sampling};
use crate::settings::{Algorithm, Blend, Classification, Evaluation, Footprints, LayerAxis, Layered, Method, Settings};
use crate::viewport::Viewport;
use crate::volume::Grid;
use std::fmt;

/// Largest |s| of a forced layer axis; kernels/layered/splat_direct.cl supports culling up to this shear.
pub(super) const MAX_FORCED_SHEAR: f64 = 3.0;

/// [Steepness](crate::TransferFunction::steepness) of a transfer function from which `high` has more samples along rays, and from which
/// lattices follow the screen. Below the first, `high` has 48 dB and more without; below the second, `standard` has 39 dB and more
/// (docs/dev/fidelity.md).
const STEEP: f64 = 0.25;
const HARD_EDGED: f64 = 0.5;

/// Additional samples per layer of [`Density::Fine`] for steep transfer functions.
const MORE_FOR_STEEP: u32 = 3;

/// Render path of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// Layers on a lattice.
    Lattice(Lattice, Layered),
    /// Layers on the lattices of the two or three layer axes near the view direction. Each has its share of the picture; the most
    /// parallel axis comes first.
    Shared(Vec<(Lattice, f64)>, Layered),
    /// Layers per pixel, with one layer axis for all rays or, with `None`, one per ray.
    Direct(Option<Axis>, Layered),
    /// One of the systems that the paper compares with.
    #[cfg(feature = "paper")]
    Paper(PaperPlan),
    /// Ray casting, with the step in smallest spacings.
    Raycast(Kernel, f64),
    /// Ray casting that reduces values or finds an iso-surface, with the distance of planes in smallest spacings.
    CastValues(Kernel, f64),
    /// Ray casting with pre-integrated segments, with their length in smallest spacings. It replaces layers where no lattice
    /// covers the view.
    CastSegments(Kernel, f64),
}

impl Plan {
    /// Selects layer axis and render path of a view.
    ///
    /// All rays share the layer axis of the central ray if none leans too far from it. Otherwise (wide angles, an eye inside the
    /// volume) rays are cast or, with per-pixel evaluation, each ray has its own layer axis. The plan is that of a transfer function that is
    /// not steep; others have denser samples ([`with_steepness`](Self::with_steepness)).
    pub fn new(rays: &Rays, viewport: Viewport, grid: &Grid, settings: &Settings) -> Result<Self, Error> {
        Self::with_steepness(rays, viewport, grid, settings, 0.0)
    }

    /// As [`new`](Self::new), for a transfer function of this [steepness](crate::TransferFunction::steepness) over the values of the whole
    /// volume.
    pub fn with_steepness(
        rays: &Rays,
        viewport: Viewport,
        grid: &Grid,
        settings: &Settings,
        steepness: f64,
    ) -> Result<Self, Error> {
        match settings.algorithm {
            Algorithm::Layered(layered) => Self::layered(rays, viewport, grid, layered, settings.blend, steepness),
            Algorithm::Raycast { kernel, step } => Ok(Self::raycast(kernel, step, settings.blend)),
            #[cfg(feature = "paper")]
            algorithm => PaperPlan::of(algorithm, rays, settings.blend),
            #[cfg(not(feature = "paper"))]
            algorithm => {
                let problem = format!("this build has no {}: choose another, or enable the feature `paper`", algorithm.name());
                Err(Error::Settings { field: "algorithm", problem })
            }
        }
    }

    fn layered(
        rays: &Rays,
        viewport: Viewport,
        grid: &Grid,
        layered: Layered,
        blend: Blend,
        steepness: f64,
    ) -> Result<Self, Error> {
        let axis = choose_axis(layered.layer_axis, rays);
        let direct = Self::direct(rays, grid, axis, layered)?;
        let Evaluation::Lattice(density) = layered.evaluation else {
            return Ok(direct);
        };
        let lattices = |layered| Self::lattices(rays, viewport, grid, axis, layered);
        // Very large voxels in a perspective have no lattice that follows the screen.
        let planned = adapted(layered, blend, steepness).into_iter().chain([layered]).find_map(lattices);
        Ok(planned.unwrap_or_else(|| {
            // A forced layer axis is kept.
            let plan = if layered.layer_axis == LayerAxis::Auto { Self::cast(density, layered, blend) } else { direct };
            tracing::info!("no lattice covers this view: {plan}");
            plan
        }))
    }

    /// The lattices of a view, if it has any.
    fn lattices(rays: &Rays, viewport: Viewport, grid: &Grid, axis: Axis, layered: Layered) -> Option<Self> {
        let Evaluation::Lattice(density) = layered.evaluation else { return None };
        Self::shared(rays, viewport, grid, density, layered).or_else(|| {
            let lattice = Lattice::new(rays, viewport, grid, axis, density, sampling(layered.classification))?;
            Some(Plan::Lattice(lattice, layered))
        })
    }

    /// The lattices of all layer axes with a share in the view, if there are several and each covers the view. Splatted layers
    /// switch between axes instead, as in the paper.
    fn shared(rays: &Rays, viewport: Viewport, grid: &Grid, density: Density, layered: Layered) -> Option<Self> {
        let Classification::Preintegrated { kernel, .. } = layered.classification else { return None };
        let shares = match layered.layer_axis {
            LayerAxis::Auto => Axis::shares(rays.central_direction()),
            LayerAxis::Forced(_) => return None,
        };
        let lattice = |axis| Lattice::new(rays, viewport, grid, axis, density, Sampling::Points(kernel));
        let parts: Option<Vec<_>> = shares.iter().map(|&(axis, share)| Some((lattice(axis)?, share))).collect();
        parts.filter(|parts| parts.len() > 1).map(|parts| Plan::Shared(parts, layered))
    }

    /// Ray casting of at least the fidelity of a lattice. With four steps per layer it reaches 44 to 70 dB. One sample per layer,
    /// evaluated per pixel, reaches 28 to 47 dB and takes five times as long (engine and tooth, from inside and at wide angles,
    /// lit).
    fn cast(density: Density, Layered { classification, .. }: Layered, blend: Blend) -> Self {
        let per_layer = if matches!(density, Density::Fixed(_)) { 2.0 } else { 4.0 };
        let step = 1.0 / (per_layer * f64::from(classification.samples_per_layer()));
        match classification {
            Classification::Preintegrated { kernel, .. } if blend == Blend::Composite => Plan::CastSegments(kernel, step),
            Classification::Preintegrated { kernel, .. } => Self::raycast(kernel, step, blend),
            Classification::Post(_) => Self::raycast(Kernel::Cubic, step, blend),
        }
    }

    /// The same view, sampled at pixels, for frames with surfaces.
    ///
    /// # Errors
    /// Those of [`Settings::check_surfaces`].
    pub(crate) fn with_surfaces(self, rays: &Rays, viewport: Viewport, grid: &Grid, settings: &Settings) -> Result<Self, Error> {
        settings.check_surfaces()?;
        let (Self::Lattice(_, layered) | Self::Shared(_, layered) | Self::Direct(_, layered)) = self else { return Ok(self) };
        let Evaluation::Lattice(density) = layered.evaluation else {
            return Ok(Self::cast(Density::Fine, layered, settings.blend));
        };
        let axis = choose_axis(layered.layer_axis, rays);
        let lattice = Lattice::new(rays, viewport, grid, axis, Density::Screen, sampling(layered.classification));
        Ok(match lattice.filter(Lattice::has_pixels_samples) {
            Some(lattice) => Self::Lattice(lattice, Layered { evaluation: Evaluation::Lattice(Density::Screen), ..layered }),
            None => Self::cast(density, layered, settings.blend),
        })
    }

    fn raycast(kernel: Kernel, step: f64, blend: Blend) -> Self {
        match blend {
            Blend::Composite => Plan::Raycast(kernel, step),
            _ => Plan::CastValues(kernel, step),
        }
    }

    /// The method that draws it. Where no lattice covers a view, it is not that of the algorithm.
    pub(super) fn method(&self) -> Method {
        match *self {
            Plan::Lattice(_, layered) | Plan::Shared(_, layered) => Method::of(layered.into()),
            Plan::Direct(_, layered) => Method::of(Layered { evaluation: Evaluation::Direct, ..layered }.into()),
            #[cfg(feature = "paper")]
            Plan::Paper(plan) => plan.method(),
            Plan::Raycast(..) | Plan::CastValues(..) | Plan::CastSegments(..) => Method::Rays,
        }
    }

    /// Whether the device counts splats, so that the size of their lists is not known before.
    pub(super) fn counts_splats(&self) -> bool {
        #[cfg(feature = "paper")]
        return matches!(self, Plan::Paper(PaperPlan::AxisSheets(_) | PaperPlan::ViewSheets(_)));
        #[cfg(not(feature = "paper"))]
        false
    }

    fn direct(rays: &Rays, grid: &Grid, axis: Axis, layered: Layered) -> Result<Self, Error> {
        // The footprint set ends at 45°, where the axis rule does.
        let set = layered.footprints == Footprints::Set;
        let limit = if set { 1.0 + 1e-6 } else { MAX_FORCED_SHEAR };
        let reached = if rays.is_parallel() {
            axis.frame().shear(rays.central_direction()).iter().all(|s| s.abs() <= limit)
        } else {
            !set && Lattice::reaches_perspective(rays, grid, axis, sampling(layered.classification))
        };
        match (reached, layered.layer_axis) {
            (true, _) => Ok(Plan::Direct(Some(axis), layered)),
            (false, LayerAxis::Auto) => Ok(Plan::Direct(None, layered)),
            (false, LayerAxis::Forced(_)) => Err(axis_error(axis)),
        }
    }
}

/// The settings that a transfer function of this steepness needs instead of these, in the order of preference; none if these suffice, or are
/// explicit.
fn adapted(layered: Layered, blend: Blend, steepness: f64) -> Vec<Layered> {
    let Evaluation::Lattice(density @ (Density::Relaxed | Density::Fine)) = layered.evaluation else { return Vec::new() };
    let Classification::Preintegrated { kernel, samples_per_layer } = layered.classification else { return Vec::new() };
    if !layered.adapts_to_opacity || blend != Blend::Composite || steepness < STEEP {
        return Vec::new();
    }
    let more = if density == Density::Fine { MORE_FOR_STEEP } else { 0 };
    let samples_per_layer = (samples_per_layer + more).min(Classification::MAX_POINTS);
    let denser = Layered { classification: Classification::Preintegrated { kernel, samples_per_layer }, ..layered };
    let on_screen = Layered { evaluation: Evaluation::Lattice(Density::Screen), ..denser };
    if steepness < HARD_EDGED { vec![denser] } else { vec![on_screen, denser] }
}

/// The forced layer axis, or the most parallel one.
pub(super) fn choose_axis(layer_axis: LayerAxis, rays: &Rays) -> Axis {
    match layer_axis {
        LayerAxis::Auto => Axis::most_parallel(rays.central_direction()),
        LayerAxis::Forced(axis) => axis,
    }
}

pub(super) fn axis_error(axis: Axis) -> Error {
    let problem = format!("some rays lean too far from layer axis {axis:?}: choose another axis, or automatic selection");
    Error::Settings { field: "layer_axis", problem }
}

/// Lattice sampling of a kind of classification.
fn sampling(classification: Classification) -> Sampling {
    match classification {
        Classification::Post(_) => Sampling::Splats,
        Classification::Preintegrated { kernel, .. } => Sampling::Points(kernel),
    }
}

fn write_lattice(f: &mut fmt::Formatter<'_>, lattice: &Lattice) -> fmt::Result {
    let Lattice { size: [width, height], samples_per_voxel: [u, v], .. } = lattice;
    write!(f, "lattice of {width}x{height} samples, {u:.2} x {v:.2} per voxel")
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Plan::Lattice(lattice, _) => write_lattice(f, lattice),
            Plan::Shared(parts, _) => parts.iter().try_for_each(|(lattice, share)| {
                write!(f, "{share:.3} of a ")?;
                write_lattice(f, lattice)?;
                write!(f, "; ")
            }),
            Plan::Direct(Some(axis), _) => write!(f, "layers per pixel along axis {axis:?}"),
            Plan::Direct(None, _) => write!(f, "layers per pixel, each ray with its own axis"),
            #[cfg(feature = "paper")]
            Plan::Paper(plan) => plan.fmt(f),
            Plan::CastSegments(kernel, step) => write!(f, "rays, {kernel:?}, pre-integrated in steps of {step} spacings"),
            Plan::CastValues(kernel, step) => {
                write!(f, "rays through values, {kernel:?}, in steps of {step} spacings")
            }
            Plan::Raycast(kernel, step) => write!(f, "rays, {kernel:?}, in steps of {step} spacings"),
        }
    }
}
