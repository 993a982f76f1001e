//! Point-sampled layers of colours.

use super::super::colors::ColorFields;
use super::super::scene::Scene;
use super::point_inputs::{LatticeView, PointInputs};
use crate::device::launch::colors::{ColorArguments, ColorLattice, ColorLatticeArguments};
use crate::device::launch::layered::Segments;
use crate::device::launch::{Launcher, Output};
use crate::error::Error;

/// Renders point-sampled layers of colours.
#[derive(Default)]
pub(super) struct ColorLayers {
    lattice: Launcher<ColorLattice>,
}

impl ColorLayers {
    pub fn draw(&mut self, scene: &mut Scene, fields: &ColorFields, view: &LatticeView, output: Output) -> Result<(), Error> {
        let layouts = scene.color_layouts(view.axis, view.kernel)?;
        let PointInputs { field, segments, .. } = PointInputs::new(scene, view)?;
        let illumination = scene.illumination()?;
        let arguments = ColorLatticeArguments {
            colors: ColorArguments {
                others: fields.arguments(&layouts),
                shaded: field.shaded(illumination.arguments(&field.visible.flags)),
                visible: &field.visible.flags,
                sample: field.sample,
                ray_ends: field.region.for_layers(view.frame()),
                output,
            },
            shown_slabs: &field.visible.shown,
            p: view.params(field.visible.blocks, scene.settings.culling),
        };
        // Deep segments are always composited in parts: their colours may differ.
        let segments = Segments { dimmed: true, ..segments };
        let variant = (field.layout.voxels.kind(), view.kernel, segments, view.rendering(field.rendering()));
        self.lattice.launch(scene.device, (variant, fields.of()), &arguments)
    }
}
