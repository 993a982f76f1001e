//! Surfaces on a device.

use crate::device::launch::structs::{Float4, SurfaceSet};
use crate::device::launch::surfaces::SURFACE_COLORS;
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::surface::{Ends, Per, Shape, Surface, SurfaceShading, Triangles, Tubes};
use crate::volume::Grid;
use glam::{DMat3, DMat4, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// Kinds of cells, and flags of cones: kernels/surfaces/cells.cl.
const TRIANGLE: i32 = 0;
const SPHERE: i32 = 1;
const CONE: i32 = 2;
const DISC: i32 = 3;
const CONE_BEFORE: i32 = 1;
const CONE_BEHIND: i32 = 2;
/// No point.
const NONE: i32 = -1;

/// Attributes of points and cells: kernels/surfaces/surface_colors.cl.
const NO_ATTRIBUTE: i32 = 0;
const COLORS: i32 = 1;
const VALUES: i32 = 3;
/// Kinds of shading there.
const FLAT: i32 = 1;
const SMOOTH: i32 = 2;

/// The sets that a renderer draws. Their places are those in files; each frame places them.
pub(in crate::renderer) struct UploadedSurfaces {
    sets: Vec<PlacedSet>,
    /// Points, less the median of their set, and radii.
    pub own: Buffer<Float4>,
    pub cells: Buffer<[i32; 4]>,
    pub attributes: Buffer<f32>,
    pub normals: Buffer<Float4>,
    pub tables: Buffer<Float4>,
    pub cell_count: usize,
}

/// Numbers of points and cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) struct SurfaceSizes {
    pub points: usize,
    pub cells: usize,
}

/// A set, and its points.
struct PlacedSet {
    set: SurfaceSet,
    points: Range<usize>,
    centre: DVec3,
    matrix: DMat4,
}

/// What the sets have, on the host.
#[derive(Default)]
struct Gathered {
    points: Vec<Float4>,
    cells: Vec<[i32; 4]>,
    attributes: Vec<f32>,
    normals: Vec<Float4>,
    tables: Vec<Float4>,
}

impl UploadedSurfaces {
    /// Replaces surfaces by others.
    pub fn replace(held: &mut Option<Arc<Self>>, device: &Device, surfaces: &[Surface]) -> Result<(), Error> {
        // Before the new ones: there may not be enough memory for both.
        *held = None;
        *held = Self::new(device, surfaces)?.map(Arc::new);
        Ok(())
    }

    /// Uploads the sets that are drawn, if there are any.
    fn new(device: &Device, surfaces: &[Surface]) -> Result<Option<Self>, Error> {
        let mut gathered = Gathered::default();
        let drawn = surfaces.iter().filter(|surface| surface.is_drawn());
        let sets: Vec<_> = drawn.enumerate().map(|(n, surface)| gathered.add(n, surface)).collect();
        if sets.is_empty() {
            return Ok(None);
        }
        device.begin(&[])?;
        Ok(Some(Self {
            sets,
            own: Buffer::from_slice(device, &gathered.points, "the points of surfaces")?,
            cells: Buffer::from_slice(device, &gathered.cells, "the cells of surfaces")?,
            attributes: Buffer::from_slice(device, &gathered.attributes, "the attributes of surfaces")?,
            normals: Buffer::from_slice(device, &gathered.normals, "the normals of surfaces")?,
            tables: Buffer::from_slice(device, &gathered.tables, "the colours of values on surfaces")?,
            cell_count: gathered.cells.len(),
        }))
    }

    /// Their sizes.
    pub fn sizes(&self) -> SurfaceSizes {
        SurfaceSizes { points: self.sets.last().map_or(0, |set| set.points.end), cells: self.cell_count }
    }

    /// The points of each set.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.sets.iter().map(|set| set.points.clone())
    }

    /// The sets as kernels take them, placed around the centre of a grid whose world has units of `unit`.
    pub fn placed(&self, grid: &Grid, unit: f64) -> Vec<SurfaceSet> {
        self.sets.iter().map(|set| set.placed(grid, unit)).collect()
    }
}

impl PlacedSet {
    fn placed(&self, grid: &Grid, unit: f64) -> SurfaceSet {
        let to_axes = grid.world_to_grid_axes();
        let linear = to_axes * DMat3::from_mat4(self.matrix) * (1.0 / unit);
        let origin = to_axes * (self.matrix.transform_point3(self.centre) / unit - grid.centre());
        let normals = linear.inverse().transpose();
        // Their length does not matter, and floats can hold them.
        let normals = normals * (1.0 / normals.to_cols_array().iter().fold(f64::MIN_POSITIVE, |most, n| most.max(n.abs())));
        let row = |matrix: &DMat3, i: usize| matrix.row(i).as_vec3().to_array();
        SurfaceSet {
            to_view: std::array::from_fn(|i| linear.row(i).extend(origin[i]).as_vec4().to_array()),
            normal_to_view: std::array::from_fn(|i| row(&normals, i)),
            scale: self.set.scale / unit as f32,
            ..self.set
        }
    }
}

impl Gathered {
    /// Adds set number `n`.
    fn add(&mut self, n: usize, surface: &Surface) -> PlacedSet {
        let (first_point, first_cell) = (self.points.len(), self.cells.len());
        let centre = median(surface.shape().places());
        let mut first_normal = NONE;
        let add = |points: &mut Vec<Float4>, all: &[DVec3], radius: &dyn Fn(usize) -> f64| {
            points.extend(all.iter().enumerate().map(|(n, p)| Float4((*p - centre).extend(radius(n)).as_vec4().to_array())));
        };
        match surface.shape() {
            Shape::Triangles(triangles) => {
                add(&mut self.points, triangles.points(), &|_| 0.0);
                self.add_triangles(triangles, first_point, n);
                if let Some(normals) = triangles.normals().filter(|_| surface.shading == SurfaceShading::Smooth) {
                    first_normal = self.normals.len() as i32;
                    self.normals.extend(normals.iter().map(|normal| Float4(normal.extend(0.0).to_array())));
                }
            }
            Shape::Spheres(spheres) => {
                add(&mut self.points, spheres.centres(), &|n| spheres.radii()[n]);
                let cell = |i: usize| [(first_point + i) as i32, NONE, NONE, kind(SPHERE, n)];
                self.cells.extend((0..spheres.centres().len()).map(cell));
            }
            Shape::Tubes(tubes) => {
                let lines = distinct_points(tubes);
                let (all, radii): (Vec<_>, Vec<_>) =
                    lines.concat().into_iter().map(|n| (tubes.points()[n], tubes.radii()[n])).unzip();
                add(&mut self.points, &all, &|n| radii[n]);
                self.add_tubes(&lines, tubes.ends(), first_point, n);
            }
        }
        let (attribute, first_attribute) = self.add_attributes(surface);
        let (first_color, table_from, table_per_value) = self.add_table(surface);
        let set = SurfaceSet {
            to_view: [[0.0; 4]; 3],
            normal_to_view: [[0.0; 3]; 3],
            scale: surface.scale() as f32,
            color: [surface.color[0], surface.color[1], surface.color[2], surface.opacity],
            table_from,
            table_per_value,
            attribute,
            first_attribute,
            first_color,
            first_point: first_point as i32,
            first_cell: first_cell as i32,
            first_normal,
            opaque: i32::from(!surface.is_translucent()),
            shaded: match surface.shading {
                SurfaceShading::Off => 0,
                SurfaceShading::Flat => FLAT,
                SurfaceShading::Smooth => SMOOTH,
            },
            clipped: i32::from(surface.is_clipped),
        };
        PlacedSet { set, points: first_point..self.points.len(), centre, matrix: surface.matrix() }
    }

    fn add_triangles(&mut self, triangles: &Triangles, first: usize, n: usize) {
        let place = |index: u32| first as i32 + index as i32;
        self.cells.extend(triangles.indices().iter().map(|&[a, b, c]| [place(a), place(b), place(c), kind(TRIANGLE, n)]));
    }

    /// Adds tubes around lines of points, the first of which is number `first`.
    fn add_tubes(&mut self, lines: &[Vec<usize>], ends: Ends, first: usize, n: usize) {
        let round = ends == Ends::Round;
        let mut start = first;
        for line in lines {
            let (begin, last) = (start, line.len().saturating_sub(1));
            start += line.len();
            let place = |i: usize| (begin + i) as i32;
            if last == 0 {
                // Its points coincide.
                self.cells.extend(round.then(|| [place(0), NONE, NONE, kind(SPHERE, n)]));
                continue;
            }
            for i in 0..last {
                let flags = if i > 0 { CONE_BEFORE } else { 0 } | if i + 1 < last { CONE_BEHIND } else { 0 };
                self.cells.push([place(i), place(i + 1), flags, kind(CONE, n)]);
            }
            let joints = if round { 0..=last } else { 1..=last - 1 };
            for i in joints {
                let before = if i > 0 { place(i - 1) } else { NONE };
                let behind = if i < last { place(i + 1) } else { NONE };
                self.cells.push([place(i), before, behind, kind(SPHERE, n)]);
            }
            if ends == Ends::Flat {
                self.cells.push([place(0), place(1), 0, kind(DISC, n)]);
                self.cells.push([place(last), place(last - 1), 0, kind(DISC, n)]);
            }
        }
    }

    /// Kind and first of the attributes.
    fn add_attributes(&mut self, surface: &Surface) -> (i32, i32) {
        let first = self.attributes.len() as i32;
        if let Some(colors) = surface.colors() {
            self.extend(surface.shape(), colors, |color| color.to_vec());
            return (COLORS + i32::from(is_of_cells(surface.shape(), colors)), first);
        }
        let Some((values, _)) = surface.values() else { return (NO_ATTRIBUTE, 0) };
        self.extend(surface.shape(), values, |value| vec![*value]);
        (VALUES + i32::from(is_of_cells(surface.shape(), values)), first)
    }

    /// Adds attributes. Those of lines become those of their points.
    fn extend<T>(&mut self, shape: &Shape, entries: &Per<T>, floats: impl Fn(&T) -> Vec<f32>) {
        match (shape, entries) {
            (Shape::Tubes(tubes), entries) => {
                for (number, line) in distinct_points(tubes).into_iter().enumerate() {
                    for point in line {
                        self.attributes.extend(floats(match entries {
                            Per::Point(entries) => &entries[point],
                            Per::Cell(entries) => &entries[number],
                        }));
                    }
                }
            }
            (_, entries) => entries.entries().iter().for_each(|entry| self.attributes.extend(floats(entry))),
        }
    }

    /// The place of the colours of values, the first value, and colours per value.
    fn add_table(&mut self, surface: &Surface) -> (i32, f32, f32) {
        let Some((_, transfer)) = surface.values() else { return (0, 0.0, 0.0) };
        let first = self.tables.len() as i32;
        let colors = transfer.colors();
        let (from, to) = (colors.first().map_or(0.0, |c| c.0), colors.last().map_or(1.0, |c| c.0));
        let step = (to - from) / (SURFACE_COLORS - 1) as f64;
        let entry = |n: usize| {
            let [r, g, b] = transfer.color(from + n as f64 * step).map(|c| c as f32);
            Float4([r, g, b, 1.0])
        };
        self.tables.extend((0..SURFACE_COLORS).map(entry));
        (first, from as f32, if step > 0.0 { (1.0 / step) as f32 } else { 0.0 })
    }
}

/// The points of each line, without those that repeat the one before: there is no piece between equal points.
fn distinct_points(tubes: &Tubes) -> Vec<Vec<usize>> {
    let points = tubes.points();
    tubes.lines().map(|line| line.clone().filter(|&n| n == line.start || points[n] != points[n - 1]).collect()).collect()
}

/// The median of each coordinate: floats are precise around most points, however far a few others are.
fn median(points: &[DVec3]) -> DVec3 {
    let middle = |i: usize| {
        let mut all: Vec<f64> = points.iter().map(|point| point[i]).collect();
        let half = all.len() / 2;
        if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(half, f64::total_cmp).1 }
    };
    DVec3::from_array([0, 1, 2].map(middle))
}

/// Last number of a cell of set `n`.
fn kind(kind: i32, n: usize) -> i32 {
    (n as i32) << 3 | kind
}

/// Whether kernels look attributes up by cell: only triangles have them so.
fn is_of_cells<T>(shape: &Shape, entries: &Per<T>) -> bool {
    matches!((shape, entries), (Shape::Triangles(_), Per::Cell(_)))
}
