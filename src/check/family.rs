//! What there is to check: the kernels that draw a view, by the way they are chosen.

use crate::layers::Kernel;
use crate::renderer::Plan;
use crate::settings::{Blend, Classification, Layered, Settings};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Kernels that draw a picture together, all that prepare it included.
///
/// One of each program is checked: with bytes as voxels, and of the programs that are built anew for a kernel or a blend mode, those named
/// here.
///
/// ```
/// use layersplat::check::Family;
///
/// for family in Family::ALL {
///     println!("{}", family.name());
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Family {
    /// Layers sampled at points, on a lattice: the default.
    PointLattice,
    /// The same through the B-spline, with its prefilter.
    Spline,
    /// The same where values are gathered.
    PointValues,
    /// The same where an iso-surface is found.
    PointSurface,
    /// Layers sampled at points, per pixel.
    PointPixels,
    /// Splatted layers on a lattice, in parallel views.
    SplatLattice,
    /// The same in perspectives.
    SplatPerspective,
    /// Splatted layers per pixel, with the footprints of the view.
    SplatPixels,
    /// The same with the paper's footprint set.
    FootprintSet,
    /// Ray casting.
    Raycast,
    /// Ray casting with pre-integrated segments: layers where no lattice reaches.
    CastSegments,
    /// Ray casting where values are gathered.
    CastValues,
    /// Ray casting where an iso-surface is found.
    CastSurface,
    /// Pre-integrated slicing.
    Slicing,
    /// Axis-aligned sheets.
    AxisSheets,
    /// Image-aligned sheets.
    ViewSheets,
}

impl Family {
    /// All of them.
    pub const ALL: [Family; 16] = [
        Family::PointLattice,
        Family::Spline,
        Family::PointValues,
        Family::PointSurface,
        Family::PointPixels,
        Family::SplatLattice,
        Family::SplatPerspective,
        Family::SplatPixels,
        Family::FootprintSet,
        Family::Raycast,
        Family::CastSegments,
        Family::CastValues,
        Family::CastSurface,
        Family::Slicing,
        Family::AxisSheets,
        Family::ViewSheets,
    ];

    /// Its name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Family::PointLattice => "point-lattice",
            Family::Spline => "spline",
            Family::PointValues => "point-values",
            Family::PointSurface => "point-surface",
            Family::PointPixels => "point-pixels",
            Family::SplatLattice => "splat-lattice",
            Family::SplatPerspective => "splat-perspective",
            Family::SplatPixels => "splat-pixels",
            Family::FootprintSet => "footprint-set",
            Family::Raycast => "raycast",
            Family::CastSegments => "cast-segments",
            Family::CastValues => "cast-values",
            Family::CastSurface => "cast-surface",
            Family::Slicing => "slicing",
            Family::AxisSheets => "axis-sheets",
            Family::ViewSheets => "view-sheets",
        }
    }

    /// What draws a view that is planned so; `parallel` if its rays are.
    pub fn of(plan: &Plan, settings: &Settings, parallel: bool) -> Self {
        match plan {
            Plan::Lattice(_, layered) | Plan::Shared(_, layered) => Self::on_lattice(layered, settings.blend, parallel),
            Plan::Direct(_, Layered { classification: Classification::Preintegrated { .. }, .. }) => Family::PointPixels,
            Plan::Direct(_, Layered { footprints: crate::settings::Footprints::Set, .. }) => Family::FootprintSet,
            Plan::Direct(..) => Family::SplatPixels,
            Plan::AxisSheets(_) => Family::AxisSheets,
            Plan::ViewSheets(_) => Family::ViewSheets,
            Plan::Slicing(_) => Family::Slicing,
            Plan::Raycast(..) => Family::Raycast,
            Plan::CastValues(..) if matches!(settings.blend, Blend::Iso(_)) => Family::CastSurface,
            Plan::CastValues(..) => Family::CastValues,
            Plan::CastSegments(..) => Family::CastSegments,
        }
    }

    fn on_lattice(layered: &Layered, blend: Blend, parallel: bool) -> Self {
        match (layered.classification, blend) {
            (Classification::Post(_), _) if parallel => Family::SplatLattice,
            (Classification::Post(_), _) => Family::SplatPerspective,
            (Classification::Preintegrated { .. }, Blend::Iso(_)) => Family::PointSurface,
            (Classification::Preintegrated { .. }, Blend::Maximum | Blend::Minimum | Blend::Average) => Family::PointValues,
            (Classification::Preintegrated { kernel: Kernel::BSpline, .. }, Blend::Composite) => Family::Spline,
            (Classification::Preintegrated { .. }, Blend::Composite) => Family::PointLattice,
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_reports() {
        for family in Family::ALL {
            assert_eq!(serde_json::to_value(family).unwrap(), family.name());
        }
        assert!(Family::ALL.is_sorted(), "figures.png has a row for each, in this order");
    }
}
