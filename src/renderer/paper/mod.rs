//! The systems that the paper compares with: axis-aligned sheets, image-aligned sheets, and slicing.

mod order;
mod sheets;
mod slicing;

use super::classification::{EntryKind, Integrals, SplatList, Splatted};
use super::field::Layout;
use super::frame::{Declaring, Resources};
use super::plan::{MAX_FORCED_SHEAR, Plan, axis_error, choose_axis};
use super::scene::Scene;
use super::tiles::Target;
use crate::device::Buffer;
use crate::device::launch::structs::Float4;
use crate::error::Error;
use crate::layers::{Axis, Kernel, Rays};
use crate::settings::{Algorithm, Blend, Method};
use sheets::{AxisAlignedSheets, ImageAlignedSheets};
use slicing::SlicedRays;
use std::fmt;
use std::sync::Arc;

/// Render path of a system that the paper compares with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PaperPlan {
    /// Axis-aligned sheets.
    AxisSheets(Axis),
    /// Image-aligned sheets, with their distance in voxels.
    ViewSheets(f64),
    /// Slicing, with the slice distance in smallest spacings.
    Slicing(f64),
}

impl fmt::Display for PaperPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AxisSheets(axis) => write!(f, "sheets along axis {axis:?}"),
            Self::ViewSheets(distance) => write!(f, "sheets across the view, {distance} voxels apart"),
            Self::Slicing(step) => write!(f, "slices {step} spacings apart"),
        }
    }
}

impl PaperPlan {
    /// The plan of one of these algorithms.
    ///
    /// # Panics
    /// For layers and ray casting.
    pub(super) fn of(algorithm: Algorithm, rays: &Rays, blend: Blend) -> Result<Plan, Error> {
        match algorithm {
            Algorithm::AxisSheets { layer_axis } => {
                let axis = choose_axis(layer_axis, rays);
                let shear = axis.frame().shear(rays.central_direction());
                let reached = shear.iter().all(|s| s.abs() <= MAX_FORCED_SHEAR);
                if reached { Ok(Plan::Paper(Self::AxisSheets(axis))) } else { Err(axis_error(axis)) }
            }
            Algorithm::ViewSheets { sheet_distance } => Ok(Plan::Paper(Self::ViewSheets(sheet_distance))),
            Algorithm::Slicing { step } if blend == Blend::Composite => Ok(Plan::Paper(Self::Slicing(step))),
            Algorithm::Slicing { step } => Ok(Plan::CastValues(Kernel::Linear, step)),
            Algorithm::Layered(_) | Algorithm::Raycast { .. } => unreachable!("planned without the paper's systems"),
        }
    }

    /// The method that draws it.
    pub(super) fn method(self) -> Method {
        match self {
            Self::AxisSheets(_) => Method::AxisSheets,
            Self::ViewSheets(_) => Method::ViewSheets,
            Self::Slicing(_) => Method::Slicing,
        }
    }

    /// Declares the resources of a frame.
    pub(super) fn declare(self, declaring: &Declaring, resources: &mut Resources) {
        match self {
            Self::AxisSheets(axis) => sheets::declare_axis_sheets(declaring, axis, resources),
            Self::ViewSheets(distance) => sheets::declare_view_sheets(declaring, distance, resources),
            Self::Slicing(_) => slicing::declare(declaring, resources),
        }
    }
}

/// The passes of these systems.
#[derive(Default)]
pub(super) struct PaperPasses {
    axis_sheets: AxisAlignedSheets,
    view_sheets: ImageAlignedSheets,
    slicing: SlicedRays,
}

impl PaperPasses {
    pub fn draw(&mut self, scene: &mut Scene, plan: PaperPlan, target: &mut Target) -> Result<(), Error> {
        match plan {
            PaperPlan::AxisSheets(axis) => self.axis_sheets.draw(scene, axis, target),
            PaperPlan::ViewSheets(distance) => self.view_sheets.draw(scene, distance, target),
            PaperPlan::Slicing(step) => self.slicing.draw(scene, step, target),
        }
    }
}

/// Data that these passes need on the device; made on first use, then cached.
impl Scene<'_> {
    /// The integrals and the slicing table for slabs of this thickness in unit distances.
    pub fn slicing_table(&mut self, thickness: f64) -> Result<(Arc<Integrals>, Arc<Buffer<Float4>>), Error> {
        self.classification.slicing_table(self.kernels, self.device, self.field, EntryKind::new(self.settings), thickness)
    }

    /// The splats of axis-aligned sheets.
    pub fn axis_splats(&mut self, axis: Axis) -> Result<Arc<SplatList>, Error> {
        self.classification.axis_splats(self.kernels, self.device, self.field, axis, EntryKind::new(self.settings))
    }

    /// The splats of image-aligned sheets, and the layout that they refer to.
    pub fn view_splats(&mut self, splatted: Splatted) -> Result<(Arc<SplatList>, Layout), Error> {
        self.classification.view_splats(self.kernels, self.device, self.field, EntryKind::new(self.settings), splatted)
    }
}
