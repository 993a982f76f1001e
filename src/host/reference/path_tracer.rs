//! The studio by path tracing: the light that scattering on grids approximates.

use super::interval::Region;
use crate::camera::Camera;
use crate::color::{albedo, reflectance};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Rays;
use crate::settings::{LightSpace, Settings, Studio};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::Volume;
use glam::DVec3;
use std::f64::consts::TAU;

/// Step along paths in smallest spacings.
const STEP: f64 = 0.25;
/// Entries of the table of the transfer function.
const ENTRIES: usize = 8192;
/// Voxels along the edge of a block that is skipped where it is clear.
const BLOCK: i64 = 8;

/// The studio by path tracing, in linear light, for the field of the linear kernel with central differences.
pub struct PathTracer<'a> {
    volume: &'a Volume<'a>,
    studio: Studio,
    lights: Vec<(DVec3, DVec3)>,
    up: DVec3,
    specular: f64,
    power: f64,
    background: f64,
    /// Lowest value and range.
    lowest: f64,
    range: f64,
    /// Extinction per smallest spacing, reflectances and albedos, by value.
    table: Vec<Matter>,
    clear_blocks: Vec<bool>,
    region: Region,
}

#[derive(Clone, Copy, Default)]
struct Matter {
    extinction: f64,
    reflectance: DVec3,
    albedo: DVec3,
}

/// Where light meets matter.
struct Event {
    point: DVec3,
    matter: Matter,
}

/// Knuth's generator; its upper bits are good.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.unit() - 1.0, TAU * self.unit());
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    }
}

impl<'a> PathTracer<'a> {
    /// A path tracer for settings with a studio whose lights and sky are those of the world.
    ///
    /// # Panics
    /// For other settings.
    pub fn new(volume: &'a Volume<'a>, transfer: &TransferFunction, settings: &Settings) -> Self {
        let (studio, shading) = (settings.studio.expect("a studio"), settings.shading.expect("lights"));
        assert!(studio.sky.space == LightSpace::World, "the reference knows a sky of the world only");
        let grid = volume.grid();
        let to_grid = grid.world_to_grid_axes();
        let light = |light: &crate::settings::Light| {
            assert!(light.space == LightSpace::World, "the reference knows lights of the world only");
            (to_grid * light.direction.expect("a direction").normalize(), light.strength * DVec3::from_array(light.color))
        };
        let (lo, hi) = volume.description().field_range();
        let unit = grid.spacing().min_element() / settings.unit_distance.unwrap_or(grid.unit());
        let matter = |n: usize| {
            let value = lo + (hi - lo) * n as f64 / (ENTRIES - 1) as f64;
            let reflectance = DVec3::from_array(transfer.color(value).map(reflectance));
            let albedo = DVec3::from_array(reflectance.to_array().map(albedo));
            Matter { extinction: transfer.extinction(value).min(1e3) * unit, reflectance, albedo }
        };
        let table: Vec<_> = (0..ENTRIES).map(matter).collect();
        let mut tracer = Self {
            volume,
            studio,
            lights: shading.lights.as_slice().iter().map(light).collect(),
            up: to_grid * studio.sky.up.normalize(),
            specular: shading.specular,
            power: shading.power,
            background: volume.background(),
            lowest: lo,
            range: hi - lo,
            table,
            clear_blocks: Vec::new(),
            region: Region::new(volume, transfer, settings.blend, &settings.clipping, 1.0),
        };
        tracer.clear_blocks = tracer.find_clear_blocks();
        tracer
    }

    /// Two independent halves of every `stride`th pixel of the picture along x and y, premultiplied. Each of them has `samples` paths in each
    /// half.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn halves(&self, camera: &Camera, viewport: Viewport, stride: u32, samples: usize) -> Result<[Frame; 2], Error> {
        let rays = Rays::new(camera, viewport, self.volume.grid())?;
        let strided = strided(viewport, stride)?;
        let half = |seed: u64| {
            super::compositing::picture(strided, |x, y| {
                let [x, y] = [x, y].map(|centre| (centre - 0.5) * f64::from(stride) + 0.5);
                let mut random = Random(seed ^ ((x as u64) << 32 | y as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
                let ray = rays.at(x, y);
                let direction = (ray.direction * rays.spacing).normalize();
                let (mut sum, mut hits) = (DVec3::ZERO, 0.0);
                for _ in 0..samples {
                    random.unit();
                    if let Some(event) = self.next(ray.origin, direction, Some(ray.start), &mut random) {
                        (sum, hits) = (sum + self.seen(&event, -direction, &mut random), hits + 1.0);
                    }
                }
                let [r, g, b] = (sum / samples as f64).to_array();
                [r, g, b, hits / samples as f64]
            })
        };
        Ok([half(1), half(2)])
    }

    /// What leaves a first event towards the viewer.
    fn seen(&self, event: &Event, to_eye: DVec3, random: &mut Random) -> DVec3 {
        let gradient = self.gradient(event.point);
        let length = gradient.length();
        let faded = ((length - 1e-3) * 1e3).clamp(0.0, 1.0);
        let lit = faded * faded * (3.0 - 2.0 * faded);
        let Matter { reflectance, albedo, .. } = event.matter;
        if random.unit() >= lit {
            return albedo * (self.direct(event.point) + self.arriving(event.point, random.direction(), random));
        }
        let normal = gradient / length * if gradient.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        // Cosines of directions on a sphere that touches the surface are distributed as reflection is.
        let around = (normal + random.direction()).normalize_or(normal);
        let mut leaving = reflectance * self.arriving(event.point, around, random);
        for (to_light, strength) in &self.lights {
            let facing = normal.dot(*to_light);
            if facing > 0.0 {
                let arriving = *strength * self.transmittance(event.point, *to_light);
                let half_way = (*to_light + to_eye).normalize_or(to_eye);
                let mirrored = self.specular * normal.dot(half_way).max(0.0).powf(self.power);
                leaving += arriving * (reflectance * facing + mirrored);
            }
        }
        leaving
    }

    /// What lights scatter at a point, per albedo.
    fn direct(&self, point: DVec3) -> DVec3 {
        self.lights.iter().map(|(to_light, strength)| *strength / 4.0 * self.transmittance(point, *to_light)).sum()
    }

    /// The radiance that arrives from a direction, without that of the lights themselves.
    fn arriving(&self, point: DVec3, from: DVec3, random: &mut Random) -> DVec3 {
        let (mut place, mut direction, mut weight, mut sum) = (point, from, DVec3::ONE, DVec3::ZERO);
        loop {
            let Some(event) = self.next(place, direction, None, random) else {
                return sum + weight * self.studio.sky.radiance(direction.dot(self.up));
            };
            weight *= event.matter.albedo * self.studio.scattering;
            let survival = weight.max_element().min(0.98);
            if random.unit() >= survival {
                return sum;
            }
            weight /= survival;
            sum += weight * self.direct(event.point);
            (place, direction) = (event.point, random.direction());
        }
    }

    /// The next event from a point on. `start`: depth of the first point on the ray.
    fn next(&self, from: DVec3, direction: DVec3, start: Option<f64>, random: &mut Random) -> Option<Event> {
        let wanted = -(1.0 - random.unit()).ln();
        let mut depth = 0.0;
        let offset = random.unit();
        self.march(from, direction, start, offset, |point, matter, length| {
            depth += matter.extinction * length;
            (depth >= wanted).then_some(Event { point, matter })
        })
    }

    fn transmittance(&self, from: DVec3, direction: DVec3) -> f64 {
        let mut depth = 0.0;
        self.march(from, direction, None, 0.5, |_, matter, length| {
            depth += matter.extinction * length;
            (depth > 12.0).then_some(())
        });
        (-depth).exp()
    }

    /// Calls `visit` with the matter in the middle of each step, and its length in smallest spacings, until that has a result.
    fn march<T>(
        &self,
        from: DVec3,
        direction: DVec3,
        start: Option<f64>,
        offset: f64,
        mut visit: impl FnMut(DVec3, Matter, f64) -> Option<T>,
    ) -> Option<T> {
        let spacing = self.volume.grid().spacing();
        let smallest = spacing.min_element();
        let per_length = direction * smallest / spacing;
        let dims = DVec3::from_array(self.volume.grid().dims().map(|n| n as f64));
        let [mut near, mut far] = [if start.is_some() { f64::NEG_INFINITY } else { 0.0 }, f64::INFINITY];
        for i in 0..3 {
            let at = |bound: f64| (bound - from[i]) / per_length[i];
            let ends = [at(-1.0), at(dims[i])];
            if per_length[i] != 0.0 {
                (near, far) = (near.max(ends[0].min(ends[1])), far.min(ends[0].max(ends[1])));
            } else if from[i] < -1.0 || from[i] > dims[i] {
                return None;
            }
        }
        let mut t = near;
        while t < far {
            let point = from + per_length * (t + STEP * offset);
            let block = (point / BLOCK as f64).floor();
            if self.is_clear(block) {
                // To the end of the block.
                let to_end = |i: usize| {
                    let bound = (block[i] + f64::from(u8::from(per_length[i] > 0.0))) * BLOCK as f64;
                    if per_length[i] == 0.0 { f64::INFINITY } else { (bound - from[i]) / per_length[i] }
                };
                t = to_end(0).min(to_end(1)).min(to_end(2)).max(t) + 1e-3;
                continue;
            }
            let value = self.value(point);
            let matter = self.matter(value);
            if matter.extinction > 0.0
                && self.region.contains(point)
                && let Some(result) = visit(point, matter, STEP)
            {
                return Some(result);
            }
            t += STEP;
        }
        None
    }

    fn matter(&self, value: f64) -> Matter {
        let place = (value - self.lowest) / self.range.max(f64::MIN_POSITIVE) * (ENTRIES - 1) as f64;
        self.table[(place + 0.5).clamp(0.0, (ENTRIES - 1) as f64) as usize]
    }

    fn voxel(&self, [x, y, z]: [i64; 3]) -> f64 {
        let [nx, ny, nz] = self.volume.grid().dims().map(|n| n as i64);
        if x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz {
            return self.background;
        }
        self.volume.value(((z * ny + y) * nx + x) as usize)
    }

    fn value(&self, point: DVec3) -> f64 {
        let base = point.floor();
        let ([x, y, z], part) = (base.to_array().map(|n| n as i64), point - base);
        let row = |j: i64, k: i64| {
            let low = self.voxel([x, y + j, z + k]);
            low + part.x * (self.voxel([x + 1, y + j, z + k]) - low)
        };
        let plane = |k: i64| {
            let low = row(0, k);
            low + part.y * (row(1, k) - low)
        };
        let low = plane(0);
        low + part.z * (plane(1) - low)
    }

    /// Gradient in ranges of values per smallest spacing, along grid axes.
    fn gradient(&self, point: DVec3) -> DVec3 {
        let spacing = self.volume.grid().spacing();
        let of_axis = |axis: DVec3| 0.5 * (self.value(point + axis) - self.value(point - axis));
        let differences = DVec3::new(of_axis(DVec3::X), of_axis(DVec3::Y), of_axis(DVec3::Z));
        differences / spacing / self.volume.description().steepness()
    }

    fn blocks(&self) -> [i64; 3] {
        self.volume.grid().dims().map(|n| n as i64 / BLOCK + 2)
    }

    /// Whether nothing absorbs in a block; they count from -1.
    fn is_clear(&self, block: DVec3) -> bool {
        let [x, y, z] = block.to_array().map(|n| n as i64 + 1);
        let [nx, ny, nz] = self.blocks();
        if x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz {
            return true;
        }
        self.clear_blocks[((z * ny + y) * nx + x) as usize]
    }

    fn find_clear_blocks(&self) -> Vec<bool> {
        let [nx, ny, nz] = self.blocks();
        let mut visible_before = vec![0u32];
        for matter in &self.table {
            visible_before.push(visible_before.last().unwrap_or(&0) + u32::from(matter.extinction > 0.0));
        }
        let entry =
            |value: f64| ((value - self.lowest) / self.range.max(f64::MIN_POSITIVE) * (ENTRIES - 1) as f64 + 0.5) as usize;
        let is_clear = |n: i64| {
            let first = [n % nx, n / nx % ny, n / nx / ny].map(|block| (block - 1) * BLOCK);
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..(BLOCK + 1).pow(3) {
                let offset = [i % (BLOCK + 1), i / (BLOCK + 1) % (BLOCK + 1), i / (BLOCK + 1).pow(2)];
                let value = self.voxel([0, 1, 2].map(|axis| first[axis] + offset[axis]));
                (lo, hi) = (lo.min(value), hi.max(value));
            }
            let [lo, hi] = [lo, hi].map(|value| entry(value).min(ENTRIES - 1));
            visible_before[hi + 1] == visible_before[lo]
        };
        (0..nx * ny * nz).map(is_clear).collect()
    }
}

/// The size of every `stride`th pixel of a picture.
fn strided(viewport: Viewport, stride: u32) -> Result<Viewport, Error> {
    Viewport::new(viewport.width.div_ceil(stride), viewport.height.div_ceil(stride))
}

/// Mean square of the differences of red, green and blue from two halves of the truth whose noise is independent, and the brightness relative to
/// it. The halves have every `stride`th pixel of the picture.
pub fn against_halves(found: &Frame, [one, other]: &[Frame; 2], stride: u32) -> (f64, f64) {
    let (mut squares, mut sums) = (0.0, [0.0; 2]);
    let width = one.width();
    for n in 0..one.pixels().len() as u32 {
        let (x, y) = (n % width, n / width);
        let [found, one, other] =
            [(found, stride), (one, 1), (other, 1)].map(|(frame, stride)| frame.pixel(x * stride, y * stride));
        for c in 0..3 {
            let [found, one, other] = [found[c], one[c], other[c]].map(f64::from);
            squares += (found - one) * (found - other);
            sums = [sums[0] + found, sums[1] + 0.5 * (one + other)];
        }
    }
    (squares / (3.0 * one.pixels().len() as f64), sums[0] / sums[1].max(f64::MIN_POSITIVE))
}
