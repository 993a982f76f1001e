//! Kernel families: the units of a device check.

use crate::layers::Kernel;
#[cfg(feature = "paper")]
use crate::renderer::PaperPlan;
use crate::renderer::Plan;
use crate::settings::{Blend, Classification, Layered, Settings};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A family of kernels that render a picture together, including preparation.
///
/// The check covers each program once, with uint8 voxels. Of programs that are specialised for a kernel or a blend mode, it covers the
/// variants named here.
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
    /// Point-sampled layers on a lattice: the default.
    PointLattice,
    /// Point-sampled layers on a lattice with the B-spline and its prefilter.
    Spline,
    /// Point-sampled layers on a lattice with maximum, minimum or average.
    PointValues,
    /// Point-sampled layers on a lattice with an iso-surface.
    PointSurface,
    /// Point-sampled layers, per pixel.
    PointPixels,
    /// Splatted layers on a lattice, parallel projection.
    SplatLattice,
    /// Splatted layers on a lattice, perspective projection.
    SplatPerspective,
    /// Splatted layers per pixel, with exact footprints.
    SplatPixels,
    /// Splatted layers per pixel, with the paper's footprint set.
    FootprintSet,
    /// Ray casting.
    Raycast,
    /// Ray casting with pre-integrated segments, which replaces lattices that cannot cover a view.
    CastSegments,
    /// Ray casting with maximum, minimum or average.
    CastValues,
    /// Ray casting with an iso-surface.
    CastSurface,
    /// Pre-integrated slicing.
    Slicing,
    /// Axis-aligned sheets.
    AxisSheets,
    /// Image-aligned sheets.
    ViewSheets,
    /// Point-sampled layers on a lattice with shadows or ambient occlusion.
    Light,
    /// Point-sampled layers on a lattice in the studio.
    Studio,
    /// Triangles, spheres and tubes, and point-sampled layers on a lattice between them.
    Surfaces,
}

impl Family {
    /// All families that are built.
    pub const ALL: [Family; if cfg!(feature = "paper") { 19 } else { 16 }] = [
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
        #[cfg(feature = "paper")]
        Family::Slicing,
        #[cfg(feature = "paper")]
        Family::AxisSheets,
        #[cfg(feature = "paper")]
        Family::ViewSheets,
        Family::Light,
        Family::Studio,
        Family::Surfaces,
    ];

    /// Name in reports.
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
            Family::Light => "light",
            Family::Studio => "studio",
            Family::Surfaces => "surfaces",
        }
    }

    /// The family that renders a plan; `parallel`: whether the projection is parallel.
    pub fn from_plan(plan: &Plan, settings: &Settings, parallel: bool) -> Self {
        match plan {
            Plan::Lattice(_, layered) | Plan::Shared(_, layered) => {
                let family = Self::on_lattice(layered, settings.blend, parallel);
                match family {
                    Family::PointLattice if settings.studio.is_some() => Family::Studio,
                    Family::PointLattice if settings.sweeps_light() => Family::Light,
                    _ => family,
                }
            }
            Plan::Direct(_, Layered { classification: Classification::Preintegrated { .. }, .. }) => Family::PointPixels,
            Plan::Direct(_, Layered { footprints: crate::settings::Footprints::Set, .. }) => Family::FootprintSet,
            Plan::Direct(..) => Family::SplatPixels,
            #[cfg(feature = "paper")]
            Plan::Paper(plan) => match plan {
                PaperPlan::AxisSheets(_) => Family::AxisSheets,
                PaperPlan::ViewSheets(_) => Family::ViewSheets,
                PaperPlan::Slicing(_) => Family::Slicing,
            },
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
        assert!(Family::ALL.is_sorted(), "figures.png has a row for each family, in this order");
    }
}
