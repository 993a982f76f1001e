//! Clipped part of a ray: a single interval, since all clip regions are convex.

use crate::layers::Ray;
use crate::settings::{Blend, Clipping};
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use glam::DVec3;

/// A range of ray parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub from: f64,
    pub to: f64,
}

/// The unclipped part of a segment, as fractions from its front to its back: 0 ≤ from < to ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    pub from: f64,
    pub to: f64,
}

impl Interval {
    /// Intersection of a ray with a box; `None` if the ray misses it or runs along a face.
    pub fn in_box(ray: &Ray, lowest: DVec3, highest: DVec3) -> Option<Self> {
        let (mut from, mut to) = (ray.start, f64::INFINITY);
        for i in 0..3 {
            let (o, d) = (ray.origin[i], ray.direction[i]);
            if d == 0.0 {
                if o <= lowest[i] || o >= highest[i] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lowest[i] - o) / d, (highest[i] - o) / d);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from < to).then_some(Self { from, to })
    }

    /// Intersection of two intervals.
    pub fn and(self, other: Self) -> Option<Self> {
        let both = Self { from: self.from.max(other.from), to: self.to.min(other.to) };
        (both.from < both.to).then_some(both)
    }

    /// Intersection with the segment between two parameters, as a part of the segment.
    pub fn part_of(self, front: f64, back: f64) -> Option<Part> {
        let (from, to) = (self.from.max(front), self.to.min(back));
        let share = |t: f64| (t - front) / (back - front);
        (from < to).then(|| Part { from: share(from), to: share(to) })
    }
}

impl Part {
    /// Fraction of the segment.
    pub fn length(self) -> f64 {
        self.to - self.from
    }

    /// Intersection with a range of the segment, as a part of that range.
    pub fn within(self, from: f64, to: f64) -> Option<Self> {
        let share = |t: f64| (t.clamp(from, to) - from) / (to - from);
        let part = Self { from: share(self.from), to: share(self.to) };
        (part.from < part.to).then_some(part)
    }

    /// Converts a position in the part, 0 … 1, to a position in the segment.
    pub fn at(self, t: f64) -> f64 {
        self.from + t * (self.to - self.from)
    }

    /// Values at both ends of the part, for a linear ramp over the segment.
    pub fn ends_of(self, [front, back]: [f64; 2]) -> [f64; 2] {
        [self.from, self.to].map(|t| front + t * (back - front))
    }
}

/// Intersection of closed half-spaces. (n, d) contains the point p, in voxels, if n·p + d ≥ 0.
pub(super) struct Region {
    half_spaces: Vec<(DVec3, f64)>,
}

impl Region {
    /// Clip region of a field that ends `radius` beyond the outermost voxels. Blend modes that reduce values are limited to the voxel
    /// region. A visible background is limited to the support of the field, because it would otherwise be infinite. Clipping applies in any
    /// case.
    pub fn new(volume: &Volume, transfer: &TransferFunction, blend: Blend, clipping: &Clipping, radius: f64) -> Self {
        let mut region = Self::from_clipping(volume, clipping);
        let last = DVec3::from_array(volume.grid().dims().map(|n| n as f64 - 1.0));
        if blend.gathers_values() {
            // An axis with a single voxel has no length between voxels; use the extent of its layer.
            let around = DVec3::from_array(last.to_array().map(|n| if n == 0.0 { 0.5 } else { 0.0 }));
            region.cut_to_box(-around, last + around);
        } else if blend == Blend::Composite && transfer.opacity(volume.background()) > 0.0 {
            region.cut_to_box(DVec3::splat(-radius), last + radius);
        }
        region
    }

    /// Clip region of the crop box and the clip planes only.
    pub fn from_clipping(volume: &Volume, clipping: &Clipping) -> Self {
        let mut region = Self { half_spaces: Vec::new() };
        if let Some(crop) = clipping.crop {
            region.cut_to_box(crop.lowest, crop.highest);
        }
        let to_world = volume.grid().index_to_world();
        for plane in clipping.planes.iter().flatten() {
            let height = |p: DVec3| plane.normal.dot(to_world.transform_point3(p) - plane.point);
            let at_origin = height(DVec3::ZERO);
            let normal = DVec3::new(height(DVec3::X), height(DVec3::Y), height(DVec3::Z)) - at_origin;
            region.half_spaces.push((normal, at_origin));
        }
        region
    }

    fn cut_to_box(&mut self, lowest: DVec3, highest: DVec3) {
        for axis in DVec3::AXES {
            self.half_spaces.push((axis, -lowest.dot(axis)));
            self.half_spaces.push((-axis, highest.dot(axis)));
        }
    }

    /// Whether a point, in voxels, is inside.
    pub fn contains(&self, point: DVec3) -> bool {
        self.half_spaces.iter().all(|&(normal, d)| normal.dot(point) + d >= 0.0)
    }

    /// Intersection with a ray, in front of its eye.
    pub fn intersection(&self, ray: &Ray) -> Option<Interval> {
        self.line_intersection(&Ray { start: f64::NEG_INFINITY, ..*ray }).and_then(|line| {
            let from = line.from.max(ray.start);
            (from < line.to).then_some(Interval { from, to: line.to })
        })
    }

    /// Intersection with the whole line of a ray, also behind its eye.
    pub fn line_intersection(&self, ray: &Ray) -> Option<Interval> {
        let mut interval = Interval { from: f64::NEG_INFINITY, to: f64::INFINITY };
        for &(normal, d) in &self.half_spaces {
            let (height, climb) = (normal.dot(ray.origin) + d, normal.dot(ray.direction));
            if climb > 0.0 {
                interval.from = interval.from.max(-height / climb);
            } else if climb < 0.0 {
                interval.to = interval.to.min(-height / climb);
            } else if height < 0.0 {
                return None;
            }
        }
        (interval.from < interval.to).then_some(interval)
    }
}
