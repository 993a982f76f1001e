//! Triangles, spheres, and the pieces and joints of tubes, each met by rays.

use crate::layers::Ray;
use crate::surface::{Bounds, Ends, Shape, Surface, SurfaceShading, Triangles, Tubes};
use crate::volume::Grid;
use glam::{DAffine3, DMat3, DVec3};

/// Part of a radius: far more than rounding.
const SAME_CONE: f64 = 1e-9;

/// Cosine of the angle between a ray and the normal of a triangle, up to which it is seen edge-on: the rounding of both.
const EDGE_ON: f64 = 1e-12;

/// Where a ray meets an element.
pub(super) struct Hit {
    pub t: f64,
    pub set: u32,
    /// Triangle, sphere or line.
    pub cell: u32,
    /// Of any length and to either side.
    pub normal: DVec3,
    /// Points, and their weights in what is interpolated.
    pub weights: [(u32, f64); 3],
}

/// Elements of several sets, in lengths of the world, in the axes of a grid, from its first voxel.
pub(super) struct Elements {
    all: Vec<Element>,
    /// Pieces of tubes, line by line.
    cones: Vec<Cone>,
}

struct Element {
    set: u32,
    cell: u32,
    geometry: Geometry,
}

enum Geometry {
    Triangle {
        corners: [DVec3; 3],
        points: [u32; 3],
        /// Of the corners, for smooth shading.
        normals: Option<[DVec3; 3]>,
    },
    Ball {
        centre: DVec3,
        radius: f64,
        point: u32,
    },
    /// A piece of a tube, and whether it is the first and the last of its line.
    Piece {
        cone: usize,
        is_end: [bool; 2],
        ends: Ends,
    },
    /// The sphere between the piece before a cone and the cone.
    Joint {
        cone: usize,
        is_smooth: bool,
    },
}

/// A truncated cone.
struct Cone {
    start: DVec3,
    /// Unit vector.
    along: DVec3,
    length: f64,
    /// At its start and its end.
    radii: [f64; 2],
    points: [u32; 2],
    /// What normals follow at its start and its end.
    courses: [Course; 2],
}

/// Direction of a tube, and growth of its radius along it.
#[derive(Clone, Copy)]
struct Course {
    along: DVec3,
    slope: f64,
}

impl Course {
    /// Halfway between two pieces; none if the line turns back.
    fn between(before: &Cone, after: &Cone) -> Option<Self> {
        let along = (before.along + after.along).try_normalize()?;
        Some(Self { along, slope: (before.slope() + after.slope()) / 2.0 })
    }

    /// The normal where a tube of this course has a point off its axis.
    fn normal(&self, off: DVec3) -> DVec3 {
        off.reject_from_normalized(self.along).normalize_or_zero() - self.slope * self.along
    }
}

impl Elements {
    pub fn new(sets: &[Surface], grid: &Grid) -> Self {
        let mut elements = Self { all: Vec::new(), cones: Vec::new() };
        for (index, set) in sets.iter().enumerate().filter(|(_, set)| set.is_visible) {
            let to_grid = DAffine3::from_mat3(grid.world_to_grid_axes()) * DAffine3::from_translation(-grid.origin());
            let placement = to_grid * DAffine3::from_mat4(set.matrix());
            let index = index as u32;
            match set.shape() {
                Shape::Triangles(triangles) => elements.add_triangles(index, triangles, set.shading, placement),
                Shape::Spheres(spheres) => {
                    for (n, (centre, radius)) in spheres.centres().iter().zip(spheres.radii()).enumerate() {
                        let (centre, point) = (placement.transform_point3(*centre), n as u32);
                        let geometry = Geometry::Ball { centre, radius: set.scale() * radius, point };
                        elements.all.push(Element { set: index, cell: point, geometry });
                    }
                }
                Shape::Tubes(tubes) => elements.add_tubes(index, tubes, (set.scale(), set.shading), placement),
            }
        }
        elements
    }

    fn add_triangles(&mut self, set: u32, triangles: &Triangles, shading: SurfaceShading, placement: DAffine3) {
        let places: Vec<DVec3> = triangles.points().iter().map(|point| placement.transform_point3(*point)).collect();
        let normals = triangles.normals().filter(|_| shading == SurfaceShading::Smooth);
        // Keeps normals perpendicular, and on the side of the points' order unless it is mirrored.
        let to_normals = placement.matrix3.inverse().transpose() * placement.matrix3.determinant().signum();
        for (cell, &points) in triangles.indices().iter().enumerate() {
            let corners = points.map(|point| places[point as usize]);
            let own = normal_of(corners).normalize_or_zero();
            let normals = normals.map(|normals| points.map(|point| unit(to_normals, normals[point as usize].as_dvec3(), own)));
            self.all.push(Element { set, cell: cell as u32, geometry: Geometry::Triangle { corners, points, normals } });
        }
    }

    fn add_tubes(&mut self, set: u32, tubes: &Tubes, (scale, shading): (f64, SurfaceShading), placement: DAffine3) {
        let is_smooth = shading == SurfaceShading::Smooth;
        for (line, mut points) in tubes.lines().enumerate() {
            let cell = line as u32;
            let place = |n: usize| placement.transform_point3(tubes.points()[n]);
            let first = self.cones.len();
            let Some(mut last) = points.next() else { continue };
            for next in points {
                let step = place(next) - place(last);
                if step.length() > 0.0 {
                    let radii = [last, next].map(|n| scale * tubes.radii()[n]);
                    let (start, points) = (place(last), [last as u32, next as u32]);
                    let (along, length) = (step.normalize(), step.length());
                    let courses = [Course { along, slope: (radii[1] - radii[0]) / length }; 2];
                    self.cones.push(Cone { start, along, length, radii, points, courses });
                    last = next;
                }
            }
            let end = self.cones.len();
            if first == end && tubes.ends() == Ends::Round {
                let geometry = Geometry::Ball { centre: place(last), radius: scale * tubes.radii()[last], point: last as u32 };
                self.all.push(Element { set, cell, geometry });
            }
            for cone in (first + 1..end).filter(|_| is_smooth) {
                if let Some(course) = Course::between(&self.cones[cone - 1], &self.cones[cone]) {
                    (self.cones[cone - 1].courses[1], self.cones[cone].courses[0]) = (course, course);
                }
            }
            for cone in first..end {
                let is_end = [cone == first, cone + 1 == end];
                self.all.push(Element { set, cell, geometry: Geometry::Piece { cone, is_end, ends: tubes.ends() } });
            }
            self.all.extend((first + 1..end).map(|cone| Element { set, cell, geometry: Geometry::Joint { cone, is_smooth } }));
        }
    }

    /// A box around each element.
    pub fn bounds(&self) -> Vec<Bounds> {
        let ball = |centre: DVec3, radius: f64| Bounds { lowest: centre - radius, highest: centre + radius };
        let of = |element: &Element| match element.geometry {
            Geometry::Triangle { corners: [a, b, c], .. } => Bounds { lowest: a.min(b).min(c), highest: a.max(b).max(c) },
            Geometry::Ball { centre, radius, .. } => ball(centre, radius),
            Geometry::Piece { cone, .. } => {
                let cone = &self.cones[cone];
                ball(cone.start, cone.radii[0]).and(ball(cone.start + cone.along * cone.length, cone.radii[1]))
            }
            Geometry::Joint { cone, .. } => ball(self.cones[cone].start, self.cones[cone].radii[0]),
        };
        self.all.iter().map(of).collect()
    }

    /// Adds all crossings of a line with element `n`.
    pub fn meet(&self, n: usize, ray: &Ray, hits: &mut Vec<Hit>) {
        let Element { set, cell, ref geometry } = self.all[n];
        let at = |t: f64| ray.origin + ray.direction * t;
        let mut add = |t: f64, normal: DVec3, weights| hits.push(Hit { t, set, cell, normal, weights });
        match *geometry {
            Geometry::Triangle { corners, points, normals } => {
                let Some((t, weights)) = crossing(ray, corners) else { return };
                let own = normal_of(corners);
                let smooth = normals.map(|normals| (0..3).map(|i| weights[i] * normals[i]).sum::<DVec3>());
                let normal = smooth.and_then(DVec3::try_normalize).unwrap_or(own);
                add(t, normal, std::array::from_fn(|i| (points[i], weights[i])));
            }
            Geometry::Ball { centre, radius, point } => {
                for t in ball_crossings(ray, centre, radius).into_iter().flatten() {
                    add(t, at(t) - centre, only(point));
                }
            }
            Geometry::Piece { cone: own, is_end, ends } => {
                let beside = [(!is_end[0]).then(|| &self.cones[own - 1]), (!is_end[1]).then(|| &self.cones[own + 1])];
                let cone = &self.cones[own];
                // Where pieces coincide, since the line turns back, the first one is seen.
                let mut add = |t: f64, normal, weights| {
                    let is_within = |end: usize, slack| beside[end].is_some_and(|other| other.contains(at(t), slack));
                    if !is_within(0, SAME_CONE) && !is_within(1, -SAME_CONE) {
                        add(t, normal, weights);
                    }
                };
                for t in cone.side_crossings(ray).into_iter().flatten() {
                    let share = cone.height(at(t)) / cone.length;
                    let weights = [(cone.points[0], 1.0 - share), (cone.points[1], share), (cone.points[1], 0.0)];
                    add(t, cone.normal(at(t)), weights);
                }
                for end in 0..2 {
                    let (centre, radius) = ([cone.start, cone.start + cone.along * cone.length][end], cone.radii[end]);
                    let is_beyond = |p: DVec3| (cone.along.dot(p - centre) < 0.0) == (end == 0);
                    // The joint is on the other side of the plane of the piece beside.
                    let is_shown = |p: DVec3| match beside[end] {
                        Some(other) if end == 0 => other.height(p) < other.length,
                        Some(other) => other.height(p) > 0.0,
                        None => ends == Ends::Flat,
                    };
                    let t = cone.along.dot(centre - ray.origin) / cone.along.dot(ray.direction);
                    if at(t).distance(centre) < radius && is_shown(at(t)) {
                        add(t, cone.along, only(cone.points[end]));
                    }
                    if is_end[end] && ends == Ends::Round {
                        for t in ball_crossings(ray, centre, radius).into_iter().flatten().filter(|&t| is_beyond(at(t))) {
                            add(t, at(t) - centre, only(cone.points[end]));
                        }
                    }
                }
            }
            Geometry::Joint { cone, is_smooth } => {
                let (before, after) = (&self.cones[cone - 1], &self.cones[cone]);
                let is_between = |p: DVec3| before.along.dot(p - after.start) >= 0.0 && after.along.dot(p - after.start) < 0.0;
                let course = Course::between(before, after).filter(|_| is_smooth);
                for t in ball_crossings(ray, after.start, after.radii[0]).into_iter().flatten() {
                    let off = at(t) - after.start;
                    if is_between(at(t)) {
                        add(t, course.map_or(off, |course| course.normal(off)), only(after.points[0]));
                    }
                }
            }
        }
    }
}

fn only(point: u32) -> [(u32, f64); 3] {
    [(point, 1.0), (point, 0.0), (point, 0.0)]
}

fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// A transformed normal, or that of the triangle if it has no direction.
fn unit(transform: DMat3, normal: DVec3, instead: DVec3) -> DVec3 {
    normal.try_normalize().and_then(|normal| (transform * normal).try_normalize()).unwrap_or(instead)
}

/// Parameter at which a line meets a triangle, and the weights of its corners there.
fn crossing(ray: &Ray, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let (normal, direction) = (normal_of(corners), ray.direction);
    let across = normal.dot(direction);
    if across.abs() <= EDGE_ON * normal.length() * direction.length() {
        return None;
    }
    let [a, b, c] = corners.map(|corner| corner - ray.origin);
    let volumes = [(b, c), (c, a), (a, b)].map(|(from, to)| side(direction, from, to));
    let is_left = volumes[0].1;
    if volumes.iter().any(|(_, other)| *other != is_left) {
        return None;
    }
    let sum: f64 = volumes.iter().map(|(volume, _)| volume).sum();
    Some((normal.dot(a) / across, volumes.map(|(volume, _)| volume / sum)))
}

/// Volume between a line through 0 and an edge, and whether it is positive. Both change with the direction of the edge, to the bit. On the
/// edge, the line is moved by less than any number.
fn side(direction: DVec3, from: DVec3, to: DVec3) -> (f64, bool) {
    let volume = direction.dot(from.cross(to));
    let moved = DVec3::AXES.map(|axis| direction.dot((to - from).cross(axis)));
    let sign = [volume, moved[0], moved[1], moved[2]].into_iter().find(|&volume| volume != 0.0);
    (volume, sign.is_some_and(|sign| sign > 0.0))
}

/// Parameters at which a line enters and leaves a ball.
fn ball_crossings(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let squared = ray.direction.length_squared();
    // Half the chord, from the point next to the centre, keeps all digits.
    let nearest = ray.direction.dot(centre - ray.origin) / squared;
    let off = ray.origin + ray.direction * nearest - centre;
    let half = radius * radius - off.length_squared();
    (half > 0.0).then(|| [-1.0, 1.0].map(|sign| nearest + sign * (half / squared).sqrt()))
}

impl Cone {
    /// Distance from the plane of its start.
    fn height(&self, p: DVec3) -> f64 {
        self.along.dot(p - self.start)
    }

    fn radius_at(&self, height: f64) -> f64 {
        self.radii[0] + self.slope() * height
    }

    fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / self.length
    }

    /// From the axis to a point.
    fn off_axis(&self, p: DVec3) -> DVec3 {
        (p - self.start).reject_from_normalized(self.along)
    }

    /// The normal of its side, by the course of the tube between its ends.
    fn normal(&self, p: DVec3) -> DVec3 {
        let (share, [start, end]) = (self.height(p) / self.length, self.courses);
        let along = start.along.lerp(end.along, share).try_normalize().unwrap_or(self.along);
        Course { along, slope: start.slope + share * (end.slope - start.slope) }.normal(self.off_axis(p))
    }

    /// Whether a point is inside, where `slack` is the part of its radius that is added.
    fn contains(&self, p: DVec3, slack: f64) -> bool {
        let height = self.height(p);
        0.0 < height && height < self.length && self.off_axis(p).length() < self.radius_at(height) * (1.0 + slack)
    }

    /// Parameters at which a line meets the side.
    fn side_crossings(&self, ray: &Ray) -> [Option<f64>; 2] {
        // From the point next to the start, so that numbers are small.
        let nearest = ray.direction.dot(self.start - ray.origin) / ray.direction.length_squared();
        let p = ray.origin + ray.direction * nearest;
        let (off, across) = (self.off_axis(p), ray.direction.reject_from_normalized(self.along));
        let (radius, change) = (self.radius_at(self.height(p)), self.slope() * self.along.dot(ray.direction));
        // |off + t across| = radius + t change, squared: a t² + 2 b t + c = 0.
        let a = across.length_squared() - change * change;
        let b = off.dot(across) - radius * change;
        let c = off.length_squared() - radius * radius;
        let discriminant = b * b - a * c;
        if discriminant <= 0.0 {
            return [None; 2];
        }
        let q = -(b + discriminant.sqrt().copysign(b));
        [q / a, c / q].map(|t| {
            let height = self.height(p + ray.direction * t);
            (0.0..self.length).contains(&height).then_some(nearest + t)
        })
    }
}
