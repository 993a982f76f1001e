//! The pass of slices: samples the field at the points where the rays of a frame begin.

use super::field::Field;
use super::frame::{Declaring, Resources};
use super::scene::Scene;
use super::screen::screen_params;
use super::tiles::{Drawn, Target, Tiles, declare_target};
use crate::device::launch::Launcher;
use crate::device::launch::slice::{Slice, SliceArguments};
use crate::device::launch::structs::SliceParams;
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use crate::slice::SliceColors;

/// Layer axis of the uploaded layout, in which planes are sampled.
const AXIS: Axis = Axis::Z;
/// Thickness that stands for an infinite one: 1 − e^{−τ·1e30} is 1 for every extinction τ of a table.
const THICKEST: f64 = 1e30;

/// What a slice shows of the field of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlicePlan {
    pub kernel: Kernel,
    pub shows: Shows,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shows {
    /// In the first channel, values with the offset subtracted, as stored numbers.
    Values,
    Colors(SliceColors),
}

/// Draws slices.
#[derive(Default)]
pub(super) struct Slices {
    launcher: Launcher<Slice>,
}

/// Declares the resources of [`Slices::draw`].
pub(super) fn declare_slice(declaring: &Declaring, kernel: Kernel, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::for_screen(declaring.viewport, declaring.tuning), resources);
    declaring.layouts(AXIS, kernel, resources);
    declaring.table(kernel, resources);
}

impl Slices {
    /// Draws the points at which the rays of a scene begin.
    pub fn draw(&mut self, scene: &mut Scene, plan: SlicePlan, target: &mut Target) -> Result<(), Error> {
        let Scene { device, viewport, .. } = *scene;
        let table = scene.table(plan.kernel)?;
        let mut layout = scene.weighted(AXIS, plan.kernel)?;
        // The weights of a Gaussian do not sum to one: values are counted from the smallest.
        layout.view.background = (scene.field.stored().smallest_value - scene.field.offset()) as f32;
        let steps = scene.steps(1);
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let Drawn { samples: frame, .. } = &target.prepare(tiles);
        self.launcher.launch(
            device,
            (layout.voxels.kind(), plan.kernel),
            &SliceArguments {
                voxels: &layout.voxels,
                view: layout.view,
                table: &table.entries,
                s: screen_params(scene, steps, AXIS.frame(), tiles),
                p: slice_params(scene.field, plan.shows),
                sample: scene.table_samples(&table, steps, AXIS.frame()),
                frame,
            },
        )
    }
}

fn slice_params(field: &Field, shows: Shows) -> SliceParams {
    let values = SliceParams { shows: 0, black: 0.0, per_value: 0.0, thickness: 0.0 };
    match shows {
        Shows::Values => values,
        Shows::Colors(SliceColors::Window { level, width }) => SliceParams {
            shows: 1,
            black: field.stored_value(level - width / 2.0) as f32,
            per_value: (field.description().rescale().slope() / width) as f32,
            ..values
        },
        Shows::Colors(SliceColors::Transfer { thickness }) => {
            SliceParams { shows: 2, thickness: thickness.min(THICKEST) as f32, ..values }
        }
    }
}
