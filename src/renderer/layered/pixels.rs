//! A field that is drawn per pixel, in layers of any axis.

use super::super::classification::VisibleBlocks;
use super::super::field::Layout;
use super::super::light::Illumination;
use super::super::region::Region;
use super::super::scene::{GradientVoxels, Scene};
use crate::device::launch::layered::PixelField;
use crate::device::launch::structs::{DirectParams, SampleParams};
use crate::device::launch::{Output, Rendering, VoxelKind};
use crate::error::Error;
use crate::layers::{Axis, Kernel};
use glam::DVec3;
use std::sync::Arc;

/// Layer axes whose blocks are passed to kernels for x, y, z. If all rays share one axis, the blocks of the others are not read.
pub(super) fn layer_axes(axis: Option<Axis>) -> [Axis; 3] {
    axis.map_or(Axis::ALL, |axis| [axis; 3])
}

/// What both renderings of layers per pixel read. Layout and parameters are those of layer axis z.
pub(super) struct PixelInputs {
    /// That of all rays, or `None`.
    axis: Option<Axis>,
    layout: Layout,
    gradients: GradientVoxels,
    /// For layer axes x, y, z.
    pub visible: Vec<Arc<VisibleBlocks>>,
    sample: SampleParams,
    region: Region,
    illumination: Illumination,
}

impl PixelInputs {
    pub fn new(
        scene: &mut Scene,
        (axis, kernel): (Option<Axis>, Kernel),
        layout: Layout,
        sample: SampleParams,
        region: Region,
    ) -> Result<Self, Error> {
        let visible = layer_axes(axis).into_iter().map(|axis| scene.visible_blocks(axis, kernel)).collect::<Result<_, _>>()?;
        let gradients = scene.gradient_voxels(Axis::Z, kernel, &layout)?;
        let illumination = scene.illumination()?;
        Ok(Self { axis, layout, gradients, visible, sample, region, illumination })
    }

    /// Program permutation of kernels that read the voxels.
    pub fn kind(&self) -> VoxelKind {
        self.layout.voxels.kind()
    }

    /// Kernel permutation flags.
    pub fn rendering(&self) -> Rendering {
        self.region.rendering_from(&self.gradients)
    }

    /// Kernel arguments.
    pub fn arguments<'a>(&'a self, scene: &Scene, output: Output<'a>) -> PixelField<'a> {
        let [visible_x, visible_y, visible_z] = [0, 1, 2].map(|i| &self.visible[i].flags);
        PixelField {
            voxels: &self.layout.voxels,
            view_of_z: self.layout.view,
            gradient_voxels: &self.gradients.layout.voxels,
            gradient_view_of_z: self.gradients.layout.view,
            light: self.illumination.arguments(visible_x),
            visible_x,
            visible_y,
            visible_z,
            p: self.params(scene),
            sample_of_z: self.sample,
            ray_ends: self.region.for_screen(Axis::Z.frame(), scene.rays),
            output,
        }
    }

    fn params(&self, scene: &Scene) -> DirectParams {
        let affine = |p: &[DVec3; 3]| p.map(|v| v.as_vec3().extend(0.0).to_array());
        let Scene { rays, settings, viewport, .. } = *scene;
        DirectParams {
            origin: affine(&rays.origin),
            direction: affine(&rays.direction),
            blocks: [0, 1, 2].map(|i| self.visible[i].blocks),
            axis: self.axis.map_or(-1, |a| a.index() as i32),
            culling: i32::from(settings.culling),
            size: [viewport.width as i32, viewport.height as i32],
        }
    }
}
