//! Splatting onto axis-aligned and image-aligned sheets.

use super::super::classification::Splatted;
use super::super::frame::{Declaring, Resources, Slot};
use super::super::region::Region;
use super::super::scene::Scene;
use super::super::screen::screen_params;
use super::super::tiles::{Target, Tiles, declare_target};
use super::order::{SplatOrder, Unsorted};
use crate::device::launch::Launcher;
use crate::device::launch::paper::{AxisSheets, AxisSheetsArguments, ViewSheets, ViewSheetsArguments};
use crate::device::launch::structs::SplatParams;
use crate::error::Error;
use crate::layers::{Axis, AxisFrame, GAUSSIAN_RADIUS, Kernel, SplatProjection, SplatSlabs};
use crate::volume::Grid;
use glam::DVec3;

/// Splats onto one sheet per layer.
#[derive(Default)]
pub(super) struct AxisAlignedSheets {
    kernel: Launcher<AxisSheets>,
    order: SplatOrder,
}

/// Splats slabs onto sheets perpendicular to the view direction.
#[derive(Default)]
pub(super) struct ImageAlignedSheets {
    kernel: Launcher<ViewSheets>,
    order: SplatOrder,
}

const SLAB_WEIGHTS: Slot<f32> = Slot::new("the slabs of a splat");

/// Declares the resources of [`AxisAlignedSheets`], except buffers whose sizes the device counts.
pub(super) fn declare_axis_sheets(declaring: &Declaring, axis: Axis, resources: &mut Resources) {
    declare_sheets(declaring, axis, resources);
}

/// Declares the resources of [`ImageAlignedSheets`], except buffers whose sizes the device counts.
pub(super) fn declare_view_sheets(declaring: &Declaring, distance: f64, resources: &mut Resources) {
    declare_sheets(declaring, Axis::Z, resources);
    resources.host(&SLAB_WEIGHTS, slab_weights(SplatSlabs { distance }).len());
}

fn declare_sheets(declaring: &Declaring, axis: Axis, resources: &mut Resources) {
    declare_target(declaring.viewport.pixels(), Tiles::for_screen(declaring.viewport, declaring.tuning), resources);
    declaring.layouts(axis, Kernel::Gaussian, resources);
    declaring.table(Kernel::Gaussian, resources);
}

impl AxisAlignedSheets {
    pub fn draw(&mut self, scene: &mut Scene, axis: Axis, target: &mut Target) -> Result<(), Error> {
        let Scene { device, rays, viewport, .. } = *scene;
        let splats = scene.axis_splats(axis)?;
        let table = scene.table(Kernel::Gaussian)?;
        let frame = axis.frame();
        let steps = scene.steps(1);
        let sample = scene.table_samples(&table, steps, frame);
        let projection = SplatProjection::new(rays, viewport, scene.field.grid());
        let (background, _) = scene.field.background();
        let backwards = i32::from(rays.central_direction()[axis.index()] < 0.0);
        let params = SplatParams { backwards, ..splat_params(&projection, frame, background) };
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let splatted = Splatted::Visible;
        let order = self.order.sort(
            device,
            &mut target.arena,
            &Unsorted { splats: &splats, splatted, table: &table, params, sample, viewport },
        )?;
        let region = Region::of_clipping(scene);
        let drawn = target.prepare(tiles);
        let arguments = AxisSheetsArguments {
            sorted: &order.sorted,
            ends: &order.ends,
            lists: &order.lists,
            chunks: device.tuning().splat_chunks as i32,
            s: screen_params(scene, steps, frame, tiles),
            p: params,
            sample,
            ray_ends: region.for_kernels(frame),
            output: drawn.output(),
        };
        self.kernel.launch(device, region.rendering, &arguments)
    }
}

impl ImageAlignedSheets {
    /// Renders sheets `distance` voxels apart.
    pub fn draw(&mut self, scene: &mut Scene, distance: f64, target: &mut Target) -> Result<(), Error> {
        const AXIS: Axis = Axis::Z;
        let Scene { device, rays, viewport, settings, .. } = *scene;
        let splatted = if settings.culling { Splatted::InReach } else { Splatted::All };
        let (splats, layout) = scene.view_splats(splatted)?;
        let table = scene.table(Kernel::Gaussian)?;
        let slabs = SplatSlabs { distance };
        let slab_weights = target.arena.fill(device, &SLAB_WEIGHTS, &slab_weights(slabs))?;
        let steps = scene.steps(1);
        let sample = scene.table_samples(&table, steps, AXIS.frame());
        let projection = SplatProjection::new(rays, viewport, scene.field.grid());
        let params = SplatParams {
            sheet_distance: distance as f32,
            sheets: sheets(scene.field.grid(), &projection, distance),
            ..splat_params(&projection, AXIS.frame(), layout.view.background)
        };
        let tiles = Tiles::for_screen(viewport, device.tuning());
        let order = self.order.sort(
            device,
            &mut target.arena,
            &Unsorted { splats: &splats, splatted, table: &table, params, sample, viewport },
        )?;
        let region = Region::new(scene, Kernel::Gaussian, 1);
        let drawn = target.prepare(tiles);
        let arguments = ViewSheetsArguments {
            sorted: &order.sorted,
            ends: &order.ends,
            lists: &order.lists,
            chunks: device.tuning().splat_chunks as i32,
            slabs: &slab_weights,
            table: &table.entries,
            s: screen_params(scene, steps, AXIS.frame(), tiles),
            p: params,
            sample,
            ray_ends: region.for_kernels(AXIS.frame()),
            output: drawn.output(),
        };
        self.kernel.launch(device, (slabs.count(), settings.looks_at_gradients(), region.rendering), &arguments)
    }
}

/// Kernel argument with the projection in the axes of `frame`; the range of sheets is not set.
fn splat_params(projection: &SplatProjection, frame: AxisFrame, background: f32) -> SplatParams {
    let row = |coefficients: DVec3, constant: f64| frame.local(coefficients).extend(constant).as_vec4().to_array();
    let half_size = projection.half_size().as_vec2();
    SplatParams {
        to_screen: [0, 1, 2].map(|r| row(projection.to_screen.row(r), projection.offset[r])),
        along: row(projection.along, -projection.along.dot(projection.centre)),
        footprint: projection.footprint.map(|f| f as f32),
        half_size: half_size.to_array(),
        nearest: projection.nearest as f32,
        least_w: projection.least_w as f32,
        nearest_sheet: projection.nearest_sheet() as f32,
        sheet_distance: 1.0,
        sheets: [0; 2],
        backwards: 0,
        background,
    }
}

/// First and last sheet that the splat of any voxel can reach.
fn sheets(grid: &Grid, projection: &SplatProjection, distance: f64) -> [i32; 2] {
    let size = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    let deepest = (projection.along.abs().dot(size) / 2.0 + GAUSSIAN_RADIUS) / distance;
    [(-deepest - 1.5).floor() as i32, (deepest + 1.5).ceil() as i32]
}

/// Weights of a splat on all sheets that it reaches, for evenly spaced fractional positions.
fn slab_weights(slabs: SplatSlabs) -> Vec<f32> {
    let steps = ViewSheets::SLAB_STEPS;
    let at = |i: usize| (0..slabs.count()).map(move |n| slabs.weight(n, i as f64 / steps as f64) as f32);
    (0..=steps).flat_map(at).collect()
}
