//! The scene that every pass draws: a view of a field through a transfer function.

use super::classification::{Classification, Integrals, PreparationKernels, SplatList, Splatted, Table, VisibleBlocks};
use super::field::{Field, Layout};
use crate::device::launch::structs::{Float4, SampleParams};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, Kernel, Rays};
use crate::settings::Blend;
use crate::settings::{self, GradientOpacity, Light, Lights, Settings, Shading};
use crate::transfer::Extinction;
use crate::viewport::Viewport;
use glam::DVec3;
use std::sync::Arc;

/// Colours as they are, where gradients are looked at for opacity alone.
const UNLIT: Shading = Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, power: 1.0, lights: Lights::AT_CAMERA };

/// A view, to be drawn.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub device: &'a Device,
    pub rays: &'a Rays,
    pub viewport: Viewport,
    pub settings: &'a Settings,
}

/// A view of a field through a transfer function, to be drawn.
pub(super) struct Scene<'a> {
    pub device: &'a Device,
    pub field: &'a Field,
    pub classification: &'a mut Classification,
    pub kernels: &'a mut PreparationKernels,
    pub rays: &'a Rays,
    pub viewport: Viewport,
    pub settings: &'a Settings,
}

/// What a sample needs along the grid's axes x, y, z.
pub(super) struct SampleAxes {
    /// Voxel differences to gradients in value ranges per voxel of the smallest spacing.
    pub gradient: DVec3,
    /// World size of a voxel step, in unit distances times samples per layer.
    pub step: DVec3,
}

impl SampleAxes {
    /// Length of a sample along rays of one direction, in unit distances.
    pub fn sample_length(&self, frame: AxisFrame, shear: [f64; 2]) -> f64 {
        (DVec3::new(shear[0], shear[1], 1.0) * frame.local(self.step)).length()
    }
}

impl<'a> Scene<'a> {
    /// A view of a field through a classification.
    pub fn new(
        View { device, rays, viewport, settings }: View<'a>,
        field: &'a Field,
        classification: &'a mut Classification,
        kernels: &'a mut PreparationKernels,
    ) -> Self {
        Self { device, field, classification, kernels, rays, viewport, settings }
    }
}

/// What passes find prepared on the device.
impl Scene<'_> {
    /// The voxels for a layer axis.
    pub fn layout(&mut self, axis: Axis) -> Result<Layout, Error> {
        self.field.layout(&mut self.kernels.field, self.device, axis)
    }

    /// The numbers that a kernel weights, for a layer axis.
    pub fn weighted(&mut self, axis: Axis, kernel: Kernel) -> Result<Layout, Error> {
        self.field.weighted(&mut self.kernels.field, self.device, axis, kernel)
    }

    /// The voxels as a Gaussian weights them, for layer axis z.
    pub fn gaussian_layout(&mut self) -> Result<Layout, Error> {
        self.classification.gaussian_layout(self.kernels, self.device, self.field, self.settings.extinction)
    }

    /// The blocks of a layer axis in which a kernel's field can show anything.
    pub fn visible_blocks(&mut self, axis: Axis, kernel: Kernel) -> Result<Arc<VisibleBlocks>, Error> {
        let Settings { extinction, blend, .. } = *self.settings;
        self.classification.visible_blocks(self.kernels, self.device, self.field, (axis, kernel), extinction, blend)
    }

    /// The transfer table for the values of a kernel's field.
    pub fn table(&mut self, kernel: Kernel) -> Result<Arc<Table>, Error> {
        self.classification.table(self.device, self.field, self.settings.extinction, kernel)
    }

    /// The integrals for segments of at least `thinnest` unit distances, so many per layer, of a kernel's field.
    pub fn integrals(&mut self, kernel: Kernel, thinnest: f64, per_layer: u32) -> Result<Arc<Integrals>, Error> {
        self.classification.integrals(self.device, self.field, self.settings.extinction, kernel, (thinnest, per_layer))
    }

    /// The integrals and the table of slicing for slabs of a thickness in unit distances.
    pub fn slicing_table(&mut self, thickness: f64) -> Result<(Arc<Integrals>, Arc<Buffer<Float4>>), Error> {
        self.classification.slicing_table(self.kernels, self.device, self.field, self.settings.extinction, thickness)
    }

    /// The splats of sheets along an axis.
    pub fn axis_splats(&mut self, axis: Axis) -> Result<Arc<SplatList>, Error> {
        self.classification.axis_splats(self.kernels, self.device, self.field, axis, self.settings.extinction)
    }

    /// The splats of sheets across the view, and the layout that they are from.
    pub fn view_splats(&mut self, splatted: Splatted) -> Result<(Arc<SplatList>, Layout), Error> {
        self.classification.view_splats(self.kernels, self.device, self.field, self.settings.extinction, splatted)
    }

    /// Whether the background has opacity.
    pub fn background_shows(&self) -> bool {
        self.classification.shows_background(self.field)
    }
}

impl Scene<'_> {
    /// The axes of a sample, of which there are so many per layer.
    pub fn axes(&self, samples_per_layer: u32) -> SampleAxes {
        let grid = self.field.grid();
        let spacing = grid.spacing();
        let smallest = spacing.min_element();
        let range = self.gradient_range();
        let unit = self.settings.unit_distance.unwrap_or(smallest) * f64::from(samples_per_layer);
        SampleAxes { gradient: smallest / spacing / range, step: spacing / unit }
    }

    /// A light as samples have it: the direction to it and one half-way between it and the eye, along the grid's axes.
    fn light(&self, light: &Light) -> [DVec3; 2] {
        let to_eye = self.rays.to_eye;
        let to_light = light.direction.map_or(to_eye, |l| self.field.grid().world_to_grid_axes() * l.normalize());
        [to_light, (to_light + to_eye).normalize_or(to_eye)]
    }

    /// The stored numbers that gradients are measured by.
    fn gradient_range(&self) -> f64 {
        let (lo, hi) = self.field.stored().range;
        if hi > lo { hi - lo } else { 1.0 }
    }

    /// By lengths as samples have them, in value ranges per voxel of the smallest spacing.
    fn gradient_opacity(&self) -> Option<GradientOpacity> {
        let stored_per_value = (self.field.stored_value(1.0) - self.field.stored_value(0.0)).abs();
        let per_length = stored_per_value * self.field.grid().spacing().min_element() / self.gradient_range();
        self.settings.gradient_opacity.map(|opacity| opacity.times(per_length))
    }

    /// Parameters of samples for a layer axis, without those of a table and of layers. Kernels whose rays may differ in their axis set
    /// the axes themselves.
    pub fn sample(&self, axes: &SampleAxes, frame: AxisFrame) -> SampleParams {
        let settings = self.settings;
        let shading = settings.shading.unwrap_or(UNLIT);
        let local = |v: DVec3| frame.local(v).as_vec3().to_array();
        let (first, more) = shading.lights.as_slice().split_first().expect("there is a light");
        let [light, half_way] = self.light(first).map(local);
        let lights = std::array::from_fn(|i| {
            more.get(i).map_or([0.0; 8], |other| {
                let [[u, v, a], [half_u, half_v, half_a]] = self.light(other).map(local);
                let [diffuse, specular] = [shading.diffuse, shading.specular].map(|share| (share * other.strength) as f32);
                [u, v, a, half_u, half_v, half_a, diffuse, specular]
            })
        });
        let (least_thinned, rises) = self.gradient_opacity().map(|opacity| opacity.rises()).unwrap_or_default();
        let iso = if let Blend::Iso(value) = settings.blend { Some(value) } else { None };
        SampleParams {
            table_first: 0.0,
            table_per_value: 0.0,
            table_last: 0,
            visible: [0; 2],
            shown: [f32::NEG_INFINITY, f32::INFINITY],
            linear: i32::from(settings.extinction == Extinction::Linear),
            samples_per_layer: [1, 0, 0],
            background_visible: i32::from(self.background_shows()),
            opaque: if settings.early_termination { Settings::OPAQUE as f32 } else { 0.0 },
            shading: i32::from(settings.looks_at_gradients()),
            gradient: local(axes.gradient),
            light,
            half_way,
            ambient: shading.ambient as f32,
            diffuse: (shading.diffuse * first.strength) as f32,
            specular: (shading.specular * first.strength) as f32,
            power: shading.power as f32,
            more_lights: more.len() as i32,
            lights,
            thinned: i32::from(settings.gradient_opacity.is_some()),
            least_thinned: least_thinned as f32,
            rises: rises.map(|rise| rise.map(|number| number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)),
            step: local(axes.step),
            table_unit: 0.0,
            ends: [[0.0; 2]; settings::Classification::MAX_POINTS as usize],
            curve: 0.0,
            range: self.field.voxel_values(),
            iso: iso.map_or(0.0, |value| self.field.stored_value(value) as f32),
            iso_color: iso.map_or([0.0; 3], |value| self.classification.transfer_function().color(value).map(|c| c as f32)),
        }
    }
}
