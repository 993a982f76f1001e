//! Lattice views of a volume, and the combination of their raw samples.

use super::super::accumulation::Jitter;
use super::super::plan::Plan;
use super::super::world::World;
use crate::camera::Camera;
use crate::error::Error;
use crate::layers::{Axis, Lattice, Rays};
use crate::settings::{Blend, Layered, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::Description;
use std::ops::Range;

/// What views show: a whole volume through a transfer function.
#[derive(Clone, Copy)]
pub(crate) struct SeenVolume<'a> {
    pub description: &'a Description,
    pub transfer: &'a TransferFunction,
}

/// A view of a volume with one lattice.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LatticeView {
    pub(super) lattice: Lattice,
    pub(super) rays: Rays,
    pub(super) viewport: Viewport,
    pub(super) layered: Layered,
    pub(super) settings: Settings,
    /// Blend mode of stored numbers.
    pub(super) blend: Blend,
}

impl LatticeView {
    /// The lattices of a view with their shares of the picture: one, or near 45° those of two or three layer axes.
    ///
    /// # Errors
    /// If the view has no lattice.
    pub fn all(seen: SeenVolume, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Vec<(Self, f64)>, Error> {
        Self::all_jittered(seen, camera, viewport, settings, None)
    }

    /// The lattices of a view whose rays are moved within their pixels.
    ///
    /// # Errors
    /// If the view has no lattice.
    pub fn all_jittered(
        SeenVolume { description, transfer }: SeenVolume,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
        jitter: Option<Jitter>,
    ) -> Result<Vec<(Self, f64)>, Error> {
        let world = World::new(description.grid());
        let grid = world.grid(description.grid());
        let (rays, settings) = world.normalised_view(&grid, camera, viewport, settings)?;
        let rays = jitter.map_or(rays, |jitter| jitter.apply(rays));
        let reversed = description.rescale().slope() < 0.0;
        let blend = if reversed { settings.blend.reversed() } else { settings.blend };
        let (lattices, layered) =
            match Plan::with_steepness(&rays, viewport, &grid, &settings, transfer.steepness(description.field_range()))? {
                Plan::Lattice(lattice, layered) => (vec![(lattice, 1.0)], layered),
                Plan::Shared(parts, layered) => (parts, layered),
                other => {
                    let problem = format!("only layers on a lattice can be rendered in parts, not {other}: use the whole volume");
                    return Err(view_error(problem));
                }
            };
        let view = |lattice| Self { lattice, rays, viewport, layered, settings, blend };
        Ok(lattices.into_iter().map(|(lattice, share)| (view(lattice), share)).collect())
    }

    pub fn axis(&self) -> Axis {
        self.lattice.frame.layer_axis()
    }

    /// Whether rays cross layers in ascending order.
    pub fn ascending(&self) -> bool {
        self.lattice.layer_step > 0
    }

    /// Whether `behind` begins where `front` ends.
    fn joins(&self, front: &Range<usize>, behind: &Range<usize>) -> bool {
        if self.ascending() { front.end == behind.start } else { behind.end == front.start }
    }

    pub(super) fn check_joined(&self, front: &Range<usize>, behind: &Range<usize>) -> Result<(), Error> {
        if self.joins(front, behind) {
            return Ok(());
        }
        let order = if self.ascending() { "from the first layer to the last" } else { "from the last layer to the first" };
        Err(view_error(format!("layers {behind:?} are not right behind layers {front:?}: the view order is {order}")))
    }
}

/// Error about the layers of a view.
pub(super) fn view_error(problem: String) -> Error {
    Error::Settings { field: "layer_axis", problem }
}

/// Combines two raw samples, one behind the other, as kernels/shared/accumulator.cl does.
pub(crate) fn combined(blend: Blend, front: [f32; 4], behind: [f32; 4]) -> [f32; 4] {
    let value = |value| [value, 0.0, 0.0, 0.0];
    match blend {
        Blend::Maximum => value(front[0].max(behind[0])),
        Blend::Minimum => value(front[0].min(behind[0])),
        Blend::Average => value(front[0] + behind[0]),
        Blend::Composite | Blend::Iso(_) => {
            let passes = front[3];
            let [r, g, b] = [0, 1, 2].map(|c| front[c] + passes * behind[c]);
            [r, g, b, passes * behind[3]]
        }
    }
}
