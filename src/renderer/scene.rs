//! Inputs shared by all passes: a view of a field through a transfer function.

use super::channels::{PackedColors, VoxelColors};
use super::classification::{Classification, EntryKind, Integrals, PreparationKernels, Table, VisibleBlocks};
use super::colors::ColorFields;
use super::field::{Field, Layout};
use super::label_colors::LabelColors;
use super::light::{LightSources, LightVolumes};
use super::lighting::Lighting;
use super::region::Region;
use super::sampling::Steps;
use super::store::Inputs;
use crate::device::Device;
use crate::device::launch::Tint;
use crate::device::launch::structs::{ClassificationParams, FieldPlacement, SampleParams, SegmentParams};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, GradientEstimator, Kernel, Rays};
use crate::settings::{FieldKind, Settings};
use crate::viewport::Viewport;
use std::sync::Arc;

/// A view to render.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub device: &'a Device,
    pub rays: &'a Rays,
    pub viewport: Viewport,
    pub settings: &'a Settings,
    /// Whether parts of rays are drawn.
    pub is_cut: bool,
}

/// The voxels that gradients are estimated from.
pub(super) struct GradientVoxels {
    pub layout: Layout,
    /// Whether they are not the input of the kernel.
    pub are_separate: bool,
}

/// A view of a field through a transfer function.
pub(super) struct Scene<'a> {
    pub device: &'a Device,
    pub field: &'a Field,
    pub classification: &'a mut Classification,
    pub kernels: &'a mut PreparationKernels,
    pub light: &'a mut LightVolumes,
    pub rays: &'a Rays,
    pub viewport: Viewport,
    pub settings: &'a Settings,
    /// Whether parts of rays are drawn.
    pub is_cut: bool,
    /// Fields that are drawn together with this one.
    others: Vec<OtherField<'a>>,
    /// All fields at the voxels of the frame, if those of the scene have others and light is swept.
    absorbers: Vec<OtherField<'a>>,
    /// The other fields of colours, if the scene's field is one.
    colors: Option<&'a ColorFields>,
    /// Colours of the field's voxels, among several.
    voxel_colors: Option<&'a PackedColors>,
    /// Colours of labels over the scene's field.
    label_colors: Option<&'a LabelColors>,
}

/// A field that a scene draws together with its own.
pub(super) struct OtherField<'a> {
    pub field: &'a Field,
    pub classification: &'a mut Classification,
    /// In normalised world units.
    pub settings: Settings,
    pub voxel_colors: Option<&'a PackedColors>,
}

impl<'a> Scene<'a> {
    pub fn new(
        View { device, rays, viewport, settings, is_cut }: View<'a>,
        field: &'a Field,
        classification: &'a mut Classification,
        kernels: &'a mut PreparationKernels,
        light: &'a mut LightVolumes,
    ) -> Self {
        let (others, absorbers) = (Vec::new(), Vec::new());
        let (colors, voxel_colors, label_colors) = (None, None, None);
        Self {
            device,
            field,
            classification,
            kernels,
            light,
            rays,
            viewport,
            settings,
            is_cut,
            others,
            absorbers,
            colors,
            voxel_colors,
            label_colors,
        }
    }

    /// Adds fields that are drawn together with this one.
    pub fn with_others(self, others: Vec<OtherField<'a>>) -> Self {
        Self { others, ..self }
    }

    /// Sweeps light through these fields.
    pub fn with_absorbers(self, absorbers: Vec<OtherField<'a>>) -> Self {
        Self { absorbers, ..self }
    }

    /// Draws the scene's field, among others, in the colours of its voxels.
    pub fn with_voxel_colors(self, voxel_colors: Option<&'a PackedColors>) -> Self {
        Self { voxel_colors, ..self }
    }

    /// Makes the scene's field one of colours.
    pub fn with_colors(self, colors: Option<&'a ColorFields>) -> Self {
        Self { colors, ..self }
    }

    /// Draws the scene's field in the colours of labels.
    pub fn with_label_colors(self, label_colors: Option<&'a LabelColors>) -> Self {
        Self { label_colors, ..self }
    }

    /// The colours of labels at points along the axes of `frame`.
    pub fn tint(&self, frame: AxisFrame) -> Result<Option<Tint<'a>>, Error> {
        self.label_colors.map(|labels| labels.tint(self.field.description(), frame)).transpose()
    }

    /// Whether layers are drawn by kernels that have a work-item per tile on every device.
    pub fn is_tiled(&self) -> bool {
        self.colors.is_some() || self.draws_fields_together()
    }

    /// Whether kernels of several fields draw the scene: also one field whose voxels are not those of the frame, or have colours.
    pub fn draws_fields_together(&self) -> bool {
        self.channels() > 1 || self.field.is_framed() || self.voxel_colors.is_some()
    }

    /// The colours of the field's voxels, in the layout for a layer axis.
    pub fn voxel_colors(&self, axis: Axis) -> Option<VoxelColors> {
        Some(self.voxel_colors?.along(self.field.own_axis(axis).frame()))
    }

    /// Whether the field is one of labels.
    fn has_labels(&self) -> bool {
        self.voxel_colors.is_some_and(|colors| colors.of_labels)
            || self.colors.is_some_and(|colors| colors.kind == FieldKind::Labels)
    }

    /// The colours of voxels that absorb light: also those of a field of colours alone.
    pub fn absorbed_colors(&self) -> Result<Option<PackedColors>, Error> {
        match (self.voxel_colors, self.colors) {
            (None, Some(colors)) => PackedColors::new(self.device, self.field, colors).map(Some),
            (colors, _) => Ok(colors.cloned()),
        }
    }

    /// The fields of colours beside the scene's, if it shows colours.
    pub fn colors(&self) -> Option<&'a ColorFields> {
        self.colors
    }

    /// The fields of colours beside the scene's, as input of a kernel.
    pub fn color_layouts(&mut self, axis: Axis, kernel: Kernel) -> Result<Vec<Layout>, Error> {
        let fields = self.colors.iter().flat_map(|colors| colors.all());
        fields.map(|field| field.weighted(&mut self.kernels.field, self.device, axis, kernel)).collect()
    }

    /// Number of fields.
    pub fn channels(&self) -> usize {
        1 + self.others.len()
    }

    /// Versions of all fields and their classifications.
    pub fn inputs(&self) -> Inputs {
        let mut inputs = self.classification.inputs_with(self.field);
        for (versions, other) in inputs.others.iter_mut().zip(&self.others) {
            *versions = Some(other.classification.versions(other.field));
        }
        inputs
    }

    /// Results of `work` for the scene of each field alone, beginning with this one.
    pub fn for_each_channel<T>(&mut self, mut work: impl FnMut(&mut Scene) -> Result<T, Error>) -> Result<Vec<T>, Error> {
        let mut results = vec![work(self)?];
        let Self { device, kernels, light, rays, viewport, is_cut, .. } = self;
        for OtherField { field, classification, settings, voxel_colors } in &mut self.others {
            let view = View { device, rays, viewport: *viewport, settings, is_cut: *is_cut };
            let mut scene = Scene::new(view, field, classification, kernels, light).with_voxel_colors(*voxel_colors);
            results.push(work(&mut scene)?);
        }
        Ok(results)
    }

    /// The same for the fields that absorb light. Their voxels are those of the frame.
    pub fn for_each_absorber<T>(&mut self, mut work: impl FnMut(&mut Scene) -> Result<T, Error>) -> Result<Vec<T>, Error> {
        if !self.field.is_framed() {
            return self.for_each_channel(work);
        }
        let Self { device, kernels, light, rays, viewport, is_cut, .. } = self;
        let each = self.absorbers.iter_mut().map(|OtherField { field, classification, settings, voxel_colors }| {
            let view = View { device, rays, viewport: *viewport, settings, is_cut: *is_cut };
            work(&mut Scene::new(view, field, classification, kernels, light).with_voxel_colors(*voxel_colors))
        });
        each.collect()
    }

    /// Where the voxels of the field lie among those of the frame, for kernels that read them along the axes of `frame`.
    pub fn placement(&self, frame: AxisFrame, kernel: Kernel, region: &Region, visible: &VisibleBlocks) -> FieldPlacement {
        self.field.placement(frame, region.own_ends, visible.blocks, kernel.radius())
    }
}

/// Data that passes need on the device; made on first use, then cached.
impl Scene<'_> {
    /// The voxels for a layer axis. If they are not those of the frame, their layout may have an axis of its own, as all data below.
    pub fn layout(&mut self, axis: Axis) -> Result<Layout, Error> {
        self.field.layout(&mut self.kernels.field, self.device, self.field.own_axis(axis))
    }

    /// Kernel input, voxels or B-spline coefficients, for a layer axis.
    pub fn weighted(&mut self, axis: Axis, kernel: Kernel) -> Result<Layout, Error> {
        self.field.weighted(&mut self.kernels.field, self.device, self.field.own_axis(axis), kernel)
    }

    /// The voxels that gradients of a kernel's field are estimated from, for a layer axis. `input`: that of the kernel.
    pub fn gradient_voxels(&mut self, axis: Axis, kernel: Kernel, input: &Layout) -> Result<GradientVoxels, Error> {
        self.estimated_voxels(axis, (kernel, self.settings.needed_gradient()), input)
    }

    /// The voxels that this estimator needs, if gradients are needed.
    pub fn estimated_voxels(
        &mut self,
        axis: Axis,
        (kernel, estimator): (Kernel, Option<GradientEstimator>),
        input: &Layout,
    ) -> Result<GradientVoxels, Error> {
        let separate = match estimator {
            Some(estimator) => {
                let axis = self.field.own_axis(axis);
                self.field.gradient_layout(&mut self.kernels.field, self.device, axis, (kernel, estimator))?
            }
            None => None,
        };
        let are_separate = separate.is_some();
        Ok(GradientVoxels { layout: separate.unwrap_or_else(|| input.clone()), are_separate })
    }

    /// The voxels as input of the Gaussian kernel, for layer axis z.
    pub fn gaussian_layout(&mut self) -> Result<Layout, Error> {
        self.classification.gaussian_layout(self.kernels, self.device, self.field, EntryKind::new(self.settings))
    }

    /// Visibility of the min-max blocks of a layer axis, for a kernel's field.
    pub fn visible_blocks(&mut self, axis: Axis, kernel: Kernel) -> Result<Arc<VisibleBlocks>, Error> {
        let (kind, blend) = (EntryKind::new(self.settings), self.settings.blend);
        let axis = self.field.own_axis(axis);
        self.classification.visible_blocks(self.kernels, self.device, self.field, (axis, kernel), kind, blend)
    }

    /// The transfer table for the values of a kernel's field.
    pub fn table(&mut self, kernel: Kernel) -> Result<Arc<Table>, Error> {
        self.classification.table(self.device, self.field, EntryKind::new(self.settings), kernel)
    }

    /// Segment integrals of a kernel's field, for segments of at least `thinnest` unit distances and `per_layer` segments per
    /// layer.
    pub fn integrals(&mut self, kernel: Kernel, thinnest: f64, per_layer: u32) -> Result<Arc<Integrals>, Error> {
        self.classification.integrals(self.device, self.field, EntryKind::new(self.settings), kernel, (thinnest, per_layer))
    }

    /// Whether the background has opacity.
    pub fn background_shows(&self) -> bool {
        self.classification.shows_background(self.field)
    }
}

impl Scene<'_> {
    /// Step lengths with this number of samples per layer.
    pub fn steps(&self, samples_per_layer: u32) -> Steps {
        let spacing = self.field.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(self.field.unit_distance()) * f64::from(samples_per_layer);
        Steps(spacing / unit)
    }

    /// The light volumes that samples look up, if any.
    pub fn light_sources(&self) -> Option<LightSources> {
        Lighting::new(self.settings, self.field, self.rays).sources().cloned()
    }

    /// Sample parameters along the axes of `frame`. Kernels in which each ray may have its own layer axis permute them from axis
    /// z themselves.
    pub fn sample(&self, frame: AxisFrame, classification: ClassificationParams, segments: SegmentParams) -> SampleParams {
        let mut lighting = Lighting::new(self.settings, self.field, self.rays);
        if self.has_labels() {
            lighting.set_surfaces();
        }
        self.sample_lit_by(lighting, frame, classification, segments)
    }

    fn sample_lit_by(
        &self,
        mut lighting: Lighting,
        frame: AxisFrame,
        classification: ClassificationParams,
        segments: SegmentParams,
    ) -> SampleParams {
        self.light.given_grids().into_iter().for_each(|grids| lighting.set_light_grids(grids));
        let light = lighting.params(frame);
        SampleParams { field: self.field.params(self.settings.needed_gradient(), frame), classification, light, segments }
    }

    /// The parameters of points on surfaces.
    pub fn surface_samples(&self, table: &Table, frame: AxisFrame) -> SampleParams {
        let mut lighting = Lighting::new(self.settings, self.field, self.rays);
        lighting.set_solid();
        let segments = SegmentParams::single(self.settings, self.steps(1), frame);
        self.sample_lit_by(lighting, frame, ClassificationParams::from_table(self, table), segments)
    }

    /// The parameters of single samples that are looked up in a table.
    pub fn table_samples(&self, table: &Table, steps: Steps, frame: AxisFrame) -> SampleParams {
        self.sample(frame, ClassificationParams::from_table(self, table), SegmentParams::single(self.settings, steps, frame))
    }
}
