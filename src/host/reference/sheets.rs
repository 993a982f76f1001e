//! Both kinds of sheet-buffer splatting, evaluated from their definitions.

use super::compositing::{Gathered, opacity_of_depth, opacity_over, picture};
use super::depth_cue::{Fade, faded};
use super::field::Field;
use super::interval::Region;
use super::shading::{Lighting, ShadingInputs};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Axis, GAUSSIAN_RADIUS, Kernel, Ray, Rays, SplatProjection, SplatSlabs, gaussian_footprint};
use crate::settings::{Algorithm, LayerAxis, Settings};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Extinction of an opaque splatted voxel.
const OPAQUE: f64 = 16.0;

/// Sheet-buffer splatting in `f64`: every voxel is tested against every pixel, without lists, tables and early ray termination.
pub struct Sheets<'a> {
    field: Field,
    volume: &'a Volume<'a>,
    transfer: &'a TransferFunction,
    settings: &'a Settings,
}

/// A projected voxel.
struct Splat {
    /// In voxels.
    place: DVec3,
    pixel: DVec2,
    w: f64,
    depth: f64,
    /// Index along the layer axis, front to back.
    layer: i64,
    value: f64,
    gradient: DVec3,
}

impl<'a> Sheets<'a> {
    /// Creates a renderer for the sheet-buffer algorithm of the settings.
    pub fn new(volume: &'a Volume<'a>, transfer: &'a TransferFunction, settings: &'a Settings) -> Self {
        Self { field: Field::new(volume, transfer, settings.blend, Kernel::Gaussian), volume, transfer, settings }
    }

    /// Renders the picture of a camera.
    ///
    /// # Panics
    /// If the algorithm is not a sheet-buffer algorithm.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?.with_pixel_aspect(self.settings.pixel_aspect, viewport);
        let projection = SplatProjection::new(&rays, viewport, self.volume.grid());
        let splats = self.splats(&projection, rays.central_direction());
        Ok(picture(viewport, |x, y| {
            let weight = |s: &Splat| gaussian_footprint(projection.squared_distance(DVec2::new(x, y) - s.pixel, s.w));
            let seen: Vec<(&Splat, f64)> = splats.iter().map(|s| (s, weight(s))).filter(|(_, weight)| *weight > 0.0).collect();
            let ray = rays.at(x, y);
            match self.settings.algorithm {
                Algorithm::AxisSheets { .. } => self.by_layer(&ray, &projection, &seen, rays.central_direction(), rays.to_eye),
                Algorithm::ViewSheets { sheet_distance } => self.by_sheet(&ray, &projection, &seen, sheet_distance, rays.to_eye),
                other => panic!("{} has no sheets", other.name()),
            }
        }))
    }

    fn splats(&self, projection: &SplatProjection, direction: DVec3) -> Vec<Splat> {
        let a = self.layer_axis(direction).index();
        let forward = direction[a] >= 0.0;
        let [nx, ny, nz] = self.field.dims();
        let missing = match self.settings.algorithm {
            Algorithm::ViewSheets { .. } => self.field.missing(),
            _ => self.field.background(),
        };
        let mut splats = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let p = DVec3::new(i as f64, j as f64, k as f64);
                    let depth = projection.depth(p);
                    if depth < projection.nearest {
                        continue;
                    }
                    let (pixel, w) = projection.project(p);
                    if w <= projection.least_w {
                        continue;
                    }
                    let voxel = |d: [i64; 3], s: i64| self.field.voxel_or([i + s * d[0], j + s * d[1], k + s * d[2]], missing);
                    let difference = |d: [i64; 3]| (voxel(d, 1) - voxel(d, -1)) / 2.0;
                    let gradient = DVec3::new(difference([1, 0, 0]), difference([0, 1, 0]), difference([0, 0, 1]));
                    let layer = if forward { [i, j, k][a] } else { -[i, j, k][a] };
                    splats.push(Splat { place: p, pixel, w, depth, layer, value: self.field.voxel([i, j, k]), gradient });
                }
            }
        }
        splats
    }

    /// Axis perpendicular to axis-aligned sheets, for a central view direction.
    fn layer_axis(&self, direction: DVec3) -> Axis {
        match self.settings.algorithm {
            Algorithm::AxisSheets { layer_axis: LayerAxis::Forced(axis) } => axis,
            _ => Axis::most_parallel(direction),
        }
    }

    /// Length of a ray in unit distances per voxel of depth.
    fn length_per_depth(&self, ray: &Ray, projection: &SplatProjection) -> f64 {
        let spacing = self.volume.grid().spacing();
        let unit = self.settings.unit_distance.unwrap_or(self.volume.grid().unit());
        (ray.direction * spacing).length() / unit / projection.along.dot(ray.direction)
    }

    fn by_layer(
        &self,
        ray: &Ray,
        projection: &SplatProjection,
        seen: &[(&Splat, f64)],
        central: DVec3,
        to_eye: DVec3,
    ) -> [f64; 4] {
        let fade = Fade::new(self.volume, self.settings, ray, to_eye);
        // Sums of extinction times colour, and of extinction.
        let mut layers: BTreeMap<i64, [f64; 4]> = BTreeMap::new();
        for (splat, weight) in seen {
            let extinction = match self.settings.extinction {
                Extinction::Exponential => self.transfer.extinction(splat.value).min(OPAQUE),
                Extinction::Linear => self.transfer.opacity(splat.value),
            };
            let lighting = Lighting::new(self.volume, ShadingInputs::from_settings(self.settings), splat.gradient, to_eye);
            let extinction = extinction * lighting.left();
            if extinction > 0.0 {
                let [r, g, b] = faded(fade, splat.place, lighting.on(self.transfer.color(splat.value)));
                let sums = layers.entry(splat.layer).or_default();
                for (sum, c) in sums.iter_mut().zip([r, g, b, 1.0]) {
                    *sum += weight * extinction * c;
                }
            }
        }
        let length = self.length_per_depth(ray, projection);
        let interval = Region::from_clipping(self.volume, &self.settings.clipping).line_intersection(ray);
        let a = self.layer_axis(central).index();
        let parameter = |k: f64| (k - ray.origin[a]) / ray.direction[a];
        let mut gathered = Gathered::new();
        for (layer, [r, g, b, extinction]) in layers {
            // A sheet represents the space half-way to its neighbours.
            let k = layer as f64 * central[a].signum();
            let [front, back] = [-0.5, 0.5].map(|half| parameter(k + half * ray.direction[a].signum()));
            let Some(part) = interval.and_then(|interval| interval.part_of(front, back)) else { continue };
            let opacity = opacity_of_depth(extinction * length * part.length(), self.settings.extinction);
            gathered.add([r, g, b].map(|c| c / extinction), opacity);
        }
        gathered.rgba()
    }

    fn by_sheet(
        &self,
        ray: &Ray,
        projection: &SplatProjection,
        seen: &[(&Splat, f64)],
        distance: f64,
        to_eye: DVec3,
    ) -> [f64; 4] {
        let slabs = SplatSlabs { distance };
        // Sums of differences from the background, and of gradients.
        let mut sheets: BTreeMap<i64, (f64, DVec3)> = BTreeMap::new();
        let background = self.field.missing();
        let visible = self.transfer.opacity(background) > 0.0;
        if visible {
            let size = DVec3::from_array(self.field.dims().map(|n| n as f64));
            let deepest = ((projection.along.abs().dot(size) + 2.0 * GAUSSIAN_RADIUS) / distance).ceil() as i64;
            sheets.extend((-deepest..=deepest).map(|s| (s, Default::default())));
        }
        for (splat, footprint) in seen {
            let (first, fraction) = slabs.first(splat.depth);
            for n in 0..slabs.count() {
                let weight = footprint * slabs.weight(n, fraction);
                let sums = sheets.entry(first + n as i64).or_default();
                sums.0 += weight * (splat.value - background);
                sums.1 += weight * splat.gradient;
            }
        }
        let dt = self.length_per_depth(ray, projection) * distance;
        let parameter = |depth: f64| (depth - projection.depth(ray.origin)) / projection.along.dot(ray.direction);
        let (blend, clipping) = (self.settings.blend, &self.settings.clipping);
        let interval = Region::new(self.volume, self.transfer, blend, clipping, GAUSSIAN_RADIUS).line_intersection(ray);
        let fade = Fade::new(self.volume, self.settings, ray, to_eye);
        let mut gathered = Gathered::new();
        for (sheet, (difference, gradient)) in sheets {
            let depth = sheet as f64 * distance;
            // A sheet represents the space half-way to its neighbours.
            let [front, back] = [-0.5, 0.5].map(|half| parameter(depth + half * distance));
            let part = interval.and_then(|interval| interval.part_of(front, back));
            let Some(part) = part.filter(|_| depth >= projection.nearest_sheet()) else { continue };
            let value = self.field.within_range(background + difference);
            let share = part.length();
            let opacity = match self.settings.extinction {
                Extinction::Exponential => opacity_over(self.transfer, value, dt * share, Extinction::Exponential),
                Extinction::Linear => opacity_over(self.transfer, value, dt, Extinction::Linear) * share,
            };
            if opacity > 0.0 {
                let color = self.transfer.color(value);
                let (color, opacity) =
                    ShadingInputs::from_settings(self.settings).at(self.volume, || gradient, to_eye, color, opacity);
                let place = ray.origin + ray.direction * parameter(depth);
                gathered.add(faded(fade, place, color), opacity);
            }
        }
        gathered.rgba()
    }
}
