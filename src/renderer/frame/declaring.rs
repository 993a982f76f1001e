//! Input of resource declarations: sizes only, no device memory.

use super::super::classification::TableSizes;
use super::super::field::FieldShape;
use super::super::light::ScatterGrids;
use super::super::surfaces::SurfaceSizes;
use super::resources::Resources;
use crate::device::Tuning;
use crate::layers::{Axis, GradientEstimator, Kernel};
use crate::settings::{LightGrid, Settings};
use crate::viewport::Viewport;
use crate::volume::Grid;

/// Sizes from which passes declare the resources of a frame.
pub(in crate::renderer) struct Declaring<'a> {
    /// Shape of the voxels that are, or would be, on the device.
    pub shape: FieldShape,
    pub tables: &'a TableSizes<'a>,
    /// The same of the fields that are drawn together with this one.
    pub others: &'a [(FieldShape, TableSizes<'a>)],
    /// Number of this field.
    pub channel: usize,
    /// Whether frames may be of several fields or of colours, whose layers have a work-item per tile on every device.
    pub is_tiled: bool,
    pub tuning: &'a Tuning,
    pub viewport: Viewport,
    /// Estimation of gradients, if the frame needs them.
    pub gradient: Option<GradientEstimator>,
    /// Light volumes, if the frame needs them.
    pub light: Option<DeclaredLight>,
    /// The surfaces, if there are any.
    pub surfaces: Option<SurfaceSizes>,
}

/// The light volumes of a frame.
#[derive(Clone, Copy)]
pub(in crate::renderer) struct DeclaredLight {
    /// Most volumes of lights.
    pub volumes: usize,
    /// Whether there is one of the ambient light.
    pub sky: bool,
    /// The cells of the studio.
    pub studio: Option<ScatterGrids>,
    /// Whether they are those of colours or labels alone.
    pub of_colors: bool,
    pub grid: LightGrid,
    /// Of a part of a volume, light is uploaded and not swept.
    pub part: Option<PartOfLight>,
}

/// The light of a part of a volume.
#[derive(Clone, Copy)]
pub(in crate::renderer) struct PartOfLight {
    /// Voxels of the whole volume along x, y, z.
    pub whole: [usize; 3],
    /// Axis of the layers that are held, and their number.
    pub axis: Axis,
    pub layers: usize,
}

impl DeclaredLight {
    /// Those of these settings. Lights may turn out to be at the camera or equal, and need fewer then.
    pub fn new(settings: &Settings, grid: &Grid) -> Option<Self> {
        let lights = settings.shading.map_or(0, |shading| shading.lights.as_slice().len());
        let volumes = if settings.shadows.is_some() || settings.studio.is_some() { lights } else { 0 };
        let sky = settings.ambient_occlusion.is_some();
        let studio = settings.studio.map(|_| ScatterGrids::new(grid, settings.light_grid));
        (volumes > 0 || sky || studio.is_some()).then_some(Self {
            volumes,
            sky,
            studio,
            of_colors: false,
            grid: settings.swept_grid(),
            part: None,
        })
    }
}

impl<'a> Declaring<'a> {
    /// Of a frame of one field that needs neither gradients nor light.
    pub fn new(shape: FieldShape, tables: &'a TableSizes<'a>, tuning: &'a Tuning, viewport: Viewport) -> Self {
        Self {
            shape,
            tables,
            others: &[],
            channel: 0,
            is_tiled: false,
            tuning,
            viewport,
            gradient: None,
            light: None,
            surfaces: None,
        }
    }

    /// Declares the resources of each field.
    pub fn for_each_channel(&self, mut declare: impl FnMut(&Declaring)) {
        declare(self);
        for ((shape, tables), channel) in self.others.iter().zip(1..) {
            declare(&Declaring { shape: *shape, tables, channel, others: &[], ..*self });
        }
    }

    /// The layouts of a layer axis for a kernel, the visibility of its min-max blocks, and the transfer table.
    pub fn visibility(&self, axis: Axis, kernel: Kernel, resources: &mut Resources) {
        self.layouts(axis, kernel, resources);
        resources.kept(("visibility", Some(axis), Some(kernel), self.channel), self.shape.visibility(axis, kernel));
        self.table(kernel, resources);
    }

    /// The layouts that a kernel needs for a layer axis.
    pub fn layouts(&self, axis: Axis, kernel: Kernel, resources: &mut Resources) {
        resources.kept(("layouts", Some(axis), Some(kernel), self.channel), self.shape.layouts(axis, kernel));
    }

    /// The voxels from which the gradients of a kernel's field are estimated, for a layer axis.
    pub fn gradients(&self, axis: Axis, kernel: Kernel, resources: &mut Resources) {
        let buffers = self.gradient.map_or(Vec::new(), |estimator| self.shape.gradient_layouts(axis, kernel, estimator));
        resources.kept(("gradients", Some(axis), Some(kernel), self.channel), buffers);
    }

    /// The transfer table of a kernel's field.
    pub fn table(&self, kernel: Kernel, resources: &mut Resources) {
        resources.kept(("table", None, Some(kernel), self.channel), TableSizes::table(self.tables.entries(kernel)));
    }

    /// The segment integrals of a kernel's field, and its transfer table. `axis`: the layer axis that they are for, unless they serve all.
    pub fn integrals(&self, axis: Option<Axis>, kernel: Kernel, resources: &mut Resources) {
        self.table(kernel, resources);
        resources.kept(("integrals", axis, Some(kernel), self.channel), [TableSizes::integrals(self.tables.entries(kernel))]);
    }
}
