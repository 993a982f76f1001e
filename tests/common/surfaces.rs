//! Scenes of surfaces in volumes, of data sets and of volumes that every machine has.

use super::*;
use layersplat::glam::Vec3;
use layersplat::surface::{Ends, Per, Spheres, Surface, Triangles, Tubes};
use std::collections::HashMap;

/// Where the volumes of scenes are from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Data {
    /// Data sets: tests carry `cfg_attr(not(real_volumes), ignore)`.
    Real,
    /// Generated and built-in volumes.
    BuiltIn,
}

pub struct Scene {
    pub name: &'static str,
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
    pub surfaces: Vec<Surface>,
    pub camera: Camera,
}

/// All scenes, each made when it is asked for.
pub fn scenes(data: Data, size: Viewport) -> impl Iterator<Item = Scene> {
    [own_surface, crossing_spheres, tubes_in_a_skull, magnified, rolled].into_iter().map(move |scene| scene(data, size))
}

/// The engine, with its own iso-surface at half opacity: 207 000 triangles, whose normals are the gradients of the voxels.
pub fn own_surface(data: Data, size: Viewport) -> Scene {
    let (volume, transfer, iso, step) = match data {
        Data::Real => {
            let (volume, transfer) = data_set("engine");
            (volume, transfer, 90.0, 3)
        }
        Data::BuiltIn => {
            let (_, volume, transfer) = generated::walnut();
            (volume, transfer, 100.0, 1)
        }
    };
    let mut own = Surface::new("own surface", iso_surface(&volume, iso, step));
    (own.color, own.opacity) = ([0.4, 0.7, 0.9], 0.5);
    let camera = parallel(&volume, size, 72.0, 20.0);
    Scene { name: "own surface", volume, transfer, surfaces: vec![own], camera }
}

/// Neghip, and 40 spheres through each other of opacity 0.3.
pub fn crossing_spheres(data: Data, size: Viewport) -> Scene {
    let (volume, transfer) = match data {
        Data::Real => data_set("neghip"),
        Data::BuiltIn => {
            let (_, volume, transfer) = generated::noise();
            (volume, transfer)
        }
    };
    let camera = parallel(&volume, size, 30.0, 25.0);
    let surfaces = vec![spheres_in(&volume)];
    Scene { name: "crossing spheres", volume, transfer, surfaces, camera }
}

/// The same, four times as large.
pub fn magnified(data: Data, size: Viewport) -> Scene {
    let scene = crossing_spheres(data, size);
    let Projection::Parallel { scale } = scene.camera.projection else { unreachable!("it is parallel") };
    Scene { name: "magnified", camera: scaled(scene.camera, scale / 4.0), ..scene }
}

/// The same in a perspective that is rolled by 20°.
pub fn rolled(data: Data, size: Viewport) -> Scene {
    let scene = crossing_spheres(data, size);
    let (grid, orbit) = (scene.volume.grid(), Orbit { azimuth: 30.0, elevation: 25.0, roll: 20.0 });
    let camera = Camera::fit_perspective(grid.centre(), grid.diagonal(), 30.0, size, orbit);
    Scene { name: "rolled", camera, ..scene }
}

/// A skull with translucent tubes through it, coloured by values, and an opaque one that is cut off flat.
pub fn tubes_in_a_skull(data: Data, size: Viewport) -> Scene {
    let (volume, transfer) = match data {
        Data::Real => skull(),
        Data::BuiltIn => {
            let (_, volume, transfer) = generated::mr();
            (volume, transfer)
        }
    };
    let (azimuth, elevation) = if data == Data::Real { (30.0, 20.0) } else { (40.0, 25.0) };
    let camera = parallel(&volume, size, azimuth, elevation);
    let surfaces = tubes_in(&volume);
    Scene { name: "tubes", volume, transfer, surfaces, camera }
}

/// Spheres of random places, sizes and colours.
fn spheres_in(volume: &Volume) -> Surface {
    const COUNT: usize = 40;
    let (grid, mut random) = (volume.grid(), Random(7));
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    let side = (last * grid.spacing()).min_element();
    let mut three = || DVec3::new(random.unit(), random.unit(), random.unit());
    let centres = (0..COUNT).map(|_| grid.index_to_world().transform_point3(last * (0.1 + 0.8 * three()))).collect();
    let radii = (0..COUNT).map(|_| side * (0.05 + 0.12 * three().x)).collect();
    let colors = (0..COUNT).map(|_| (0.2 + 0.8 * three()).as_vec3().extend(1.0).to_array()).collect();
    let spheres = Surface::new("spheres", Spheres::new(centres, radii).unwrap());
    let mut spheres = spheres.with_colors(Per::Cell(colors)).unwrap();
    spheres.opacity = 0.3;
    spheres
}

/// Twelve tubes that wind upwards, and a straight one across.
fn tubes_in(volume: &Volume) -> Vec<Surface> {
    const LINES: usize = 12;
    const POINTS: usize = 50;
    let grid = volume.grid();
    let half = DVec3::from_array(grid.dims().map(|n| (n as f64 - 1.0) / 2.0));
    // From −1 to 1 along each axis of the grid.
    let place = |p: DVec3| grid.index_to_world().transform_point3(half + half * p);
    let side = (half * grid.spacing()).min_element();
    let along = |n: usize| (n % POINTS) as f64 / (POINTS - 1) as f64;
    let point = |n: usize| {
        let (angle, height) = ((n / POINTS) as f64 * std::f64::consts::TAU / LINES as f64, along(n));
        let (sin, cos) = (angle + 3.0 * height).sin_cos();
        let radius = 0.65 + 0.3 * (2.0 * angle + 5.0 * height).sin();
        place(DVec3::new(radius * cos, radius * sin, 1.8 * height - 0.9))
    };
    let points = (0..LINES * POINTS).map(point).collect();
    let radii = (0..LINES * POINTS).map(|n| side * (0.03 + 0.02 * (12.0 * along(n)).sin())).collect();
    let values = (0..LINES * POINTS).map(|n| along(n) as f32).collect();
    let colors = vec![(0.0, [0.1, 0.3, 0.9]), (0.5, [0.2, 0.8, 0.4]), (1.0, [0.95, 0.8, 0.2])];
    let colors = TransferFunction::new("along lines", colors, vec![(0.0, 1.0)]).unwrap();
    let winding = Tubes::new(points, radii, &[POINTS; LINES], Ends::Round).unwrap();
    let mut winding = Surface::new("winding", winding).with_values(Per::Point(values), colors).unwrap();
    winding.opacity = 0.5;
    let across = vec![place(DVec3::new(-1.1, 0.1, -0.2)), place(DVec3::new(0.6, -0.2, 0.3))];
    let mut across = Surface::new("across", Tubes::new(across, vec![0.12 * side; 2], &[2], Ends::Flat).unwrap());
    across.color = [0.8, 0.8, 0.85];
    vec![winding, across]
}

/// The iso-surface of every `step`th voxel, by tetrahedra, with the gradients there as normals. It is open where it meets the outermost voxels.
pub fn iso_surface(volume: &Volume, iso: f64, step: usize) -> Triangles {
    /// Corners of a cell, x, y, z as bits, on the six ways from the first to the last.
    const WAYS: [[usize; 2]; 6] = [[1, 3], [1, 5], [2, 3], [2, 6], [4, 5], [4, 6]];
    let (grid, [nx, ny, nz]) = (volume.grid(), volume.grid().dims());
    let [dx, dy, dz] = [nx, ny, nz].map(|n| (n - 1) / step + 1);
    let value = |[x, y, z]: [usize; 3]| volume.value(x + nx * (y + ny * z));
    let place = |n: usize| [n % dx, n / dx % dy, n / (dx * dy)].map(|i| i * step);
    let values: Vec<f64> = (0..dx * dy * dz).map(|n| value(place(n))).collect();
    let world = |n: usize| grid.index_to_world().transform_point3(DVec3::from_array(place(n).map(|i| i as f64)));
    let gradient = |n: usize| {
        let along = |axis: usize| {
            let (mut before, mut after) = (place(n), place(n));
            before[axis] = before[axis].saturating_sub(1);
            after[axis] = (after[axis] + 1).min([nx, ny, nz][axis] - 1);
            (value(after) - value(before)) / (after[axis] - before[axis]).max(1) as f64
        };
        grid.direction() * (DVec3::new(along(0), along(1), along(2)) / grid.spacing())
    };
    let (mut points, mut normals, mut indices) = (Vec::new(), Vec::<Vec3>::new(), Vec::new());
    let mut made = HashMap::new();
    for n in 0..dx * dy * (dz - 1) {
        if n % dx + 1 == dx || n / dx % dy + 1 == dy {
            continue;
        }
        let corners: [usize; 8] = std::array::from_fn(|c| n + (c & 1) + dx * (c >> 1 & 1) + dx * dy * (c >> 2));
        if corners.iter().all(|&c| (values[c] < iso) == (values[n] < iso)) {
            continue;
        }
        for [second, third] in WAYS {
            let (low, high): (Vec<usize>, Vec<usize>) =
                [0, second, third, 7].iter().map(|&c| corners[c]).partition(|&c| values[c] < iso);
            let mut between = |i: usize, j: usize| {
                let (from, to) = (low[i], high[j]);
                *made.entry((from, to)).or_insert_with(|| {
                    let share = (iso - values[from]) / (values[to] - values[from]);
                    points.push(world(from).lerp(world(to), share));
                    normals.push(-gradient(from).lerp(gradient(to), share).as_vec3());
                    points.len() as u32 - 1
                })
            };
            let faces = match (low.len(), high.len()) {
                (1, 3) => vec![[between(0, 0), between(0, 1), between(0, 2)]],
                (3, 1) => vec![[between(0, 0), between(1, 0), between(2, 0)]],
                (2, 2) => {
                    let [a, b, c, d] = [between(0, 0), between(0, 1), between(1, 1), between(1, 0)];
                    vec![[a, b, c], [a, c, d]]
                }
                _ => continue,
            };
            // Seen from lower values, counter-clockwise: of a tetrahedron, the sides of low and high corners are known exactly.
            let mean = |of: &[usize]| of.iter().map(|&n| world(n)).sum::<DVec3>() / of.len() as f64;
            let outwards = mean(&low) - mean(&high);
            let [a, b, c] = faces[0].map(|n| points[n as usize]);
            let is_turned = (b - a).cross(c - a).dot(outwards) < 0.0;
            indices.extend(faces.into_iter().map(|[a, b, c]| if is_turned { [a, c, b] } else { [a, b, c] }));
        }
    }
    Triangles::new(points, indices).unwrap().with_normals(normals).unwrap()
}
