//! Point-sampled layers of colours.

use super::super::channels::FieldInputs;
use super::super::scene::Scene;
use super::points::{LatticeView, PointInputs};
use crate::device::Buffer;
use crate::device::launch::Launcher;
use crate::device::launch::colors::{ColorLattice, ColorLatticeArguments};
use crate::device::launch::layered::Segments;
use crate::device::launch::structs::Float4;
use crate::error::Error;

/// Renders point-sampled layers of colours.
#[derive(Default)]
pub(super) struct ColorLayers {
    lattice: Launcher<ColorLattice>,
}

impl ColorLayers {
    pub fn draw(
        &mut self,
        scene: &mut Scene,
        view: &LatticeView,
        samples: &Buffer<Float4>,
        active_samples: &Buffer<u32>,
    ) -> Result<(), Error> {
        let colors = scene.color_layouts(view.axis, view.kernel)?;
        let PointInputs { field: inputs, segments, .. } = PointInputs::new(scene, view)?;
        let FieldInputs { layout, gradients, visible, sample, region, .. } = &inputs;
        let illumination = scene.illumination()?;
        let [light, sky] = illumination.arguments(&visible.flags);
        let arguments = ColorLatticeArguments {
            red: &colors[0].voxels,
            green: &colors[1].voxels,
            blue: &colors[2].voxels,
            extinction: &layout.voxels,
            view: layout.view,
            gradient_voxels: &gradients.layout.voxels,
            gradient_view: gradients.layout.view,
            light,
            sky,
            visible: &visible.flags,
            shown_slabs: &visible.shown,
            p: view.params(visible.blocks, scene.settings.culling),
            sample: *sample,
            clip: region.for_layers(view.frame()),
            lattice: samples,
            active_samples,
        };
        // Deep segments are always composited in parts: their colours may differ.
        let segments = Segments { dimmed: true, ..segments };
        let variant = (layout.voxels.kind(), view.kernel, segments, view.rendering(region.rendering_from(gradients)));
        self.lattice.launch(scene.device, variant, &arguments)
    }
}
