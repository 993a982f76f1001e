//! Slicing with pre-integrated slabs.

use super::super::classification::{SLAB_VALUES, slicing_table_size};
use super::super::frame::{Declaring, Resources};
use super::super::rays::{AXIS, check_steps, declare_segments, inputs, longest_slab, marched, prepare, slab_params};
use super::super::scene::Scene;
use super::super::tiles::Target;
use crate::device::launch::Launcher;
use crate::device::launch::paper::Slicing;
use crate::device::launch::rays::TableMarchArguments;
use crate::device::launch::structs::MarchParams;
use crate::error::Error;
use crate::layers::Kernel;

/// Renders slices `step` smallest spacings apart.
#[derive(Default)]
pub(super) struct SlicedRays {
    kernel: Launcher<Slicing>,
}

/// Declares the resources of [`SlicedRays`].
pub(super) fn declare(declaring: &Declaring, resources: &mut Resources) {
    declare_segments(declaring, Kernel::Linear, resources);
    resources.kept(("the table of slicing", None, None, 0), [slicing_table_size()]);
}

impl SlicedRays {
    pub fn draw(&mut self, scene: &mut Scene, step: f64, target: &mut Target) -> Result<(), Error> {
        check_steps(scene, step)?;
        let device = scene.device;
        let steps = scene.steps(1);
        let (integrals, slabs) = scene.slicing_table(step * steps.shortest())?;
        let table = scene.table(Kernel::Linear)?;
        let layout = scene.layout(AXIS)?;
        let sample = scene.table_samples(&table, steps, AXIS.frame());
        let field = inputs(scene, Kernel::Linear, layout, sample, longest_slab(scene, step))?;
        let illumination = scene.illumination()?;
        let drawn = prepare(scene, target);
        let p = MarchParams {
            table_first: integrals.scale.first,
            table_per_value: integrals.scale.per_value * (SLAB_VALUES - 1) as f32 / integrals.scale.last as f32,
            table_size: SLAB_VALUES as i32,
            cut: i32::from(integrals.cut),
            ..slab_params(scene, step, integrals.visible_values, field.visible.blocks)
        };
        let march = marched(scene, &field, &illumination, p, &drawn);
        let arguments = TableMarchArguments { march, table: &slabs, tint: None };
        self.kernel.launch(device, (field.layout.voxels.kind(), field.rendering()), &arguments)
    }
}
