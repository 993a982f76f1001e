//! Fragments in fog, whose pictures have closed forms.

mod looks;
mod tubes;

use super::super::{Integral, Layered, Marched};
use super::*;
use crate::layers::{GradientEstimator, Kernel};
use crate::settings::{Algorithm, Classification, Settings};
use crate::surface::{Shape, Spheres, Triangles};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Voxels};
use glam::DMat3;

/// Sums of hundreds of steps in `f64`, and roots where a ray grazes a sphere.
const ROUNDING: f64 = 1e-10;
const FOG: [f64; 3] = [0.2, 0.5, 0.8];
/// Extinction of the fog per world unit.
const EXTINCTION: f64 = 0.05;

fn grid() -> Grid {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
    Grid::oriented([21, 17, 19], DVec3::new(1.0, 0.7, 1.4), DVec3::new(3.0, -2.0, 5.0), turned).unwrap()
}

fn volume() -> Volume<'static> {
    let numbers = vec![100; grid().voxel_count()];
    Volume::new("fog", grid(), Voxels::Uint8(numbers)).unwrap().with_background(100.0).unwrap()
}

fn transfer(opacity: f64) -> TransferFunction {
    TransferFunction::new("fog", vec![(0.0, FOG)], vec![(0.0, opacity)]).unwrap()
}

/// A ray from a place in the world; its parameter is the length in the world.
fn ray(from: DVec3, direction: DVec3, start: f64) -> Ray {
    let grid = grid();
    Ray { origin: grid.world_to_voxel(from), direction: grid.world_to_voxel_linear() * direction.normalize(), start }
}

/// A ray through the volume, from outside unless it starts later.
fn through(n: u32, start: f64) -> Ray {
    let angle = f64::from(n) * 2.4;
    let direction = DVec3::new(angle.cos(), angle.sin(), 0.3 + (f64::from(n) * 0.37).sin());
    ray(grid().centre() + DVec3::new(0.3, -0.4, 0.2) * f64::from(n % 5) - 30.0 * direction.normalize(), direction, start)
}

/// A square of two triangles.
fn square(name: &str, centre: DVec3, normal: DVec3, half_side: f64, color: [f32; 3], opacity: f32) -> Surface {
    let (u, v) = normal.normalize().any_orthonormal_pair();
    let corner = |x: f64, y: f64| centre + (u * x + v * y) * half_side;
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    shown(Surface::new(name, Triangles::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap()), color, opacity)
}

/// A set of this colour, without light.
fn shown(surface: Surface, color: [f32; 3], opacity: f32) -> Surface {
    changed(surface, |set| (set.color, set.opacity, set.shading) = (color, opacity, SurfaceShading::Off))
}

fn changed(mut surface: Surface, change: impl FnOnce(&mut Surface)) -> Surface {
    change(&mut surface);
    surface
}

fn plain() -> Look<'static> {
    static NONE: Clipping = Clipping { crop: None, planes: [None; Clipping::MAX_PLANES] };
    Look { clipping: &NONE, shading: None, shadow_rays: None, fade: None, to_eye: DVec3::Z }
}

fn fragments(sets: &[Surface], ray: &Ray) -> Vec<Fragment> {
    Surfaces::new(sets, &volume()).fragments(ray, &plain())
}

/// Where a ray is at most `reach` voxels beyond the outermost ones.
fn fog_along(ray: &Ray, reach: f64) -> Option<[f64; 2]> {
    let ends = (0..3).map(|i| {
        let last = grid().dims()[i] as f64 - 1.0;
        let [a, b] = [-reach, last + reach].map(|face| (face - ray.origin[i]) / ray.direction[i]);
        [a.min(b), a.max(b)]
    });
    let [from, to] = ends.reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])]).unwrap();
    (from.max(ray.start) < to).then_some([from.max(ray.start), to])
}

/// Colour of fragments, each a depth with straight RGBA, in fog between two depths.
fn in_fog(mut fragments: Vec<(f64, [f64; 4])>, fog: Option<[f64; 2]>, extinction: f64) -> [f64; 4] {
    fragments.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [from, to] = fog.unwrap_or_default();
    let (mut color, mut left, mut depth) = ([0.0; 3], 1.0, from);
    let mut over = |rgb: [f64; 3], transmittance: f64| {
        (0..3).for_each(|i| color[i] += left * (1.0 - transmittance) * rgb[i]);
        left *= transmittance;
    };
    for (t, [r, g, b, a]) in fragments {
        let end = t.clamp(depth, to);
        over(FOG, (-extinction * (end - depth)).exp());
        over([r, g, b], 1.0 - a);
        depth = end;
    }
    over(FOG, (-extinction * (to - depth)).exp());
    [color[0], color[1], color[2], 1.0 - left]
}

#[track_caller]
fn assert_same(what: &str, found: [f64; 4], expected: [f64; 4], tolerance: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{what}: {found:?} for {expected:?}");
}

/// Compares all references with the closed form, given the fragments of each ray.
#[track_caller]
fn assert_in_fog(sets: &[Surface], rays: &[Ray], expected: impl Fn(&Ray) -> Vec<(f64, [f64; 4])>) {
    let (volume, transfer) = (volume(), transfer(1.0 - (-EXTINCTION).exp()));
    let settings = |algorithm: Algorithm| Settings { unit_distance: Some(1.0), shading: None, algorithm, ..Settings::default() };
    let cast = settings(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.7 });
    let layered = settings(Settings::default().algorithm);
    let Some(Classification::Preintegrated { kernel, .. }) = layered.layered().map(|own| own.classification) else { panic!() };
    let integral = Integral::new(&volume, &transfer, Some(1.0)).with_known(|_| (100.0, DVec3::ZERO)).with_surfaces(sets);
    let marched = Marched::new(&volume, &transfer, &cast).with_surfaces(sets);
    let layers = Layered::new(&volume, &transfer, &layered).with_surfaces(sets);
    for (n, ray) in rays.iter().enumerate() {
        let [at_voxels, around, of_layers] =
            [0.0, 1.0, f64::from(kernel.radius())].map(|reach| in_fog(expected(ray), fog_along(ray, reach), EXTINCTION));
        assert_same(&format!("integral, ray {n}"), integral.composite(ray, DVec3::Z), at_voxels, ROUNDING);
        assert_same(&format!("marched, ray {n}"), marched.composite(ray, DVec3::Z), around, ROUNDING);
        assert_same(&format!("layered, ray {n}"), layers.composite(ray, None, DVec3::Z), of_layers, ROUNDING);
    }
}

/// Depth and straight colour where a ray meets a plane, in front of its start.
fn on_plane(ray: &Ray, point: DVec3, normal: DVec3, [r, g, b]: [f32; 3], opacity: f32) -> Option<(f64, [f64; 4])> {
    let to_world = grid().index_to_world();
    let (from, direction) = (to_world.transform_point3(ray.origin), to_world.transform_vector3(ray.direction));
    let t = normal.dot(point - from) / normal.dot(direction);
    (t > ray.start).then_some((t, [r, g, b, opacity].map(f64::from)))
}

#[test]
fn planes_in_fog_are_products_of_transmittances() {
    let centre = grid().centre();
    let planes = [
        (centre + DVec3::X * 2.0, DVec3::new(1.0, 0.2, 0.1), [0.9, 0.1, 0.3], 0.25),
        (centre - DVec3::Y * 2.0, DVec3::new(-0.3, 1.0, 0.1), [0.1, 0.7, 0.2], 0.5),
        // In front of the volume for some rays, behind it for others.
        (centre + DVec3::Z * 15.0, DVec3::new(0.2, 0.2, 1.0), [0.3, 0.3, 1.0], 0.75),
    ];
    let rays: Vec<Ray> = (0..40).flat_map(|n| [through(n, f64::NEG_INFINITY), through(n, 0.0), through(n, 32.0)]).collect();
    for opaque in 0..=planes.len() {
        let opacity = |n: usize, own: f32| if n == opaque { 1.0 } else { own };
        let each = || planes.iter().enumerate().map(|(n, &(p, normal, color, own))| (p, normal, color, opacity(n, own)));
        let sets: Vec<Surface> = each().map(|(p, normal, color, a)| square("plane", p, normal, 1e4, color, a)).collect();
        assert_in_fog(&sets, &rays, |ray| {
            each().filter_map(|(p, normal, color, a)| on_plane(ray, p, normal, color, a)).collect()
        });
    }
}

#[test]
fn fog_before_an_opaque_plane_is_that_of_its_depth() {
    let ray = through(3, 0.0);
    let [from, _] = fog_along(&ray, 0.0).unwrap();
    let direction = grid().index_to_world().transform_vector3(ray.direction);
    let depth = 6.0;
    let place = grid().index_to_world().transform_point3(ray.origin + ray.direction * (from + depth));
    let (volume, transfer) = (volume(), transfer(1.0 - (-EXTINCTION).exp()));
    let sets = [square("plane", place, direction, 3.0, [0.0; 3], 1.0)];
    let integral = Integral::new(&volume, &transfer, Some(1.0)).with_known(|_| (100.0, DVec3::ZERO)).with_surfaces(&sets);
    let before = 1.0 - (-EXTINCTION * depth).exp();
    let [r, g, b] = FOG.map(|c| c * before);
    assert_same("black plane", integral.composite(&ray, DVec3::Z), [r, g, b, 1.0], ROUNDING);
}

#[test]
fn spheres_are_their_chords() {
    let centre = grid().centre() + DVec3::new(1.0, -1.0, 0.5);
    for (radius, opacity) in [(4.0, 0.3), (4.0, 1.0), (40.0, 0.3), (1e-3, 0.5)] {
        let sphere = Spheres::new(vec![DVec3::ZERO], vec![radius / 2.0]).unwrap();
        let placed = glam::DMat4::from_translation(centre) * glam::DMat4::from_scale(DVec3::splat(2.0));
        let sets = [shown(Surface::new("sphere", sphere), [0.9, 0.6, 0.1], opacity).with_matrix(placed).unwrap()];
        // Rays from outside, from the centre, and past the sphere.
        let direction = DVec3::new(0.4, 0.5, -0.8).normalize();
        let across = direction.any_orthonormal_vector();
        let offs = [0.0, 0.3, 0.99, 1.01, 5.0];
        let outside = offs.map(|off| ray(centre + across * (off * radius) - direction * 50.0, direction, f64::NEG_INFINITY));
        let inside = [ray(centre, direction, 0.0), ray(centre + across * (0.5 * radius), direction, 0.0)];
        assert_in_fog(&sets, &[outside.as_slice(), inside.as_slice()].concat(), |ray| {
            let to_world = grid().index_to_world();
            let from = to_world.transform_point3(ray.origin) - centre;
            let nearest = -from.dot(to_world.transform_vector3(ray.direction));
            let half = (radius * radius - (from.length_squared() - nearest * nearest)).max(0.0).sqrt();
            let color = [0.9f32, 0.6, 0.1, opacity].map(f64::from);
            let depths = [nearest - half, nearest + half].into_iter().filter(|&t| half > 0.0 && t > ray.start);
            depths.map(|t| (t, color)).collect()
        });
    }
}

/// A line of sight that misses all sets, a hidden set, and one without opacity leave the picture as it is.
#[test]
fn what_is_not_seen_changes_no_bit() {
    let (volume, transfer) = (volume(), transfer(0.1));
    let settings = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..Settings::default() };
    let without = Marched::new(&volume, &transfer, &settings);
    let centre = grid().centre();
    let plane = |place, opacity| square("plane", place, DVec3::ONE, 10.0, [1.0; 3], opacity);
    let hidden = changed(plane(centre, 1.0), |set| set.is_visible = false);
    let point = Surface::new("point", Spheres::new(vec![centre], vec![0.0]).unwrap());
    let flat = Triangles::new(vec![centre; 3], vec![[0, 1, 2], [0, 0, 1]]).unwrap();
    let sets = [plane(centre, 0.0), plane(centre + DVec3::splat(200.0), 1.0), hidden, point, Surface::new("flat", flat)];
    let with = Marched::new(&volume, &transfer, &settings).with_surfaces(&sets);
    for n in 0..20 {
        let ray = through(n, 0.0);
        let turned = Ray { start: f64::NEG_INFINITY, ..ray };
        assert!(fragments(&sets[..1], &turned).is_empty() && fragments(&sets[2..], &turned).is_empty());
        assert_eq!(with.composite(&ray, DVec3::Z), without.composite(&ray, DVec3::Z), "ray {n}");
    }
}

/// Hundreds of nearly transparent cuts through an unlit field change it by no more than their opacity.
#[test]
fn cuts_change_nothing() {
    const OPACITY: f32 = 1e-12;
    let bumps = |n: usize| (((n as f64 * 0.31).sin() + (n as f64 * 0.011).cos()) * 50.0 + 100.0) as u8;
    let volume = Volume::new("bumps", grid(), Voxels::Uint8((0..grid().voxel_count()).map(bumps).collect())).unwrap();
    let colors = vec![(0.0, FOG), (200.0, [0.9, 0.2, 0.1])];
    let transfer = TransferFunction::new("bumps", colors, vec![(40.0, 0.0), (200.0, 0.3)]).unwrap();
    let settings = |algorithm| Settings { shading: None, algorithm, ..Settings::default() };
    let cast = settings(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 });
    let many = (0..300).map(|n| grid().centre() + DVec3::splat(f64::from(n) / 11.0 - 14.0)).collect::<Vec<_>>();
    let sets: Vec<Surface> = many.iter().map(|&p| square("cut", p, DVec3::new(1.0, 0.7, 0.5), 1e3, [0.0; 3], OPACITY)).collect();
    let [with, without] = [&sets[..], &[]].map(|sets| Marched::new(&volume, &transfer, &cast).with_surfaces(sets));
    for n in 0..20 {
        let ray = through(n, f64::NEG_INFINITY);
        assert_same("marched", with.composite(&ray, DVec3::Z), without.composite(&ray, DVec3::Z), 1e3 * f64::from(OPACITY));
    }
}

/// A ray meets one of the triangles at an edge or a point, wherever it meets it, and enters a closed surface as often as it leaves it.
#[test]
fn edges_are_met_once() {
    const SIDE: u32 = 8;
    let place = |n: u32| DVec3::new(f64::from(n % (SIDE + 1)), f64::from(n / (SIDE + 1)), 0.0);
    let points: Vec<DVec3> = (0..(SIDE + 1).pow(2)).map(place).collect();
    let cells = (0..SIDE * SIDE).map(|n| n / SIDE * (SIDE + 1) + n % SIDE);
    let halves = |a: u32| [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]];
    let lattice = Triangles::new(points, cells.flat_map(halves).collect()).unwrap();
    let unit = Volume::new("unit", Grid::new([2; 3], DVec3::ONE).unwrap(), Voxels::Uint8(vec![0; 8])).unwrap();
    let sets = [Surface::new("lattice", lattice)];
    let surfaces = Surfaces::new(&sets, &unit);
    for n in 0..(2 * SIDE - 1).pow(2) {
        let at = DVec3::new(f64::from(1 + n % (2 * SIDE - 1)), f64::from(1 + n / (2 * SIDE - 1)), 0.0) / 2.0;
        for direction in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.5, 0.25, 1.0), DVec3::new(-1.0, 1.0, -0.5)] {
            let ray = Ray { origin: at - direction * 4.0, direction, start: 0.0 };
            let met = surfaces.fragments(&ray, &plain());
            assert!(met.len() == 1 && (met[0].t - 4.0).abs() < ROUNDING, "{at} along {direction}: {met:?}");
        }
    }
    let octahedron = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let faces = (0..4).flat_map(|n| [[n, (n + 1) % 4, 4], [(n + 1) % 4, n, 5]]).collect();
    let closed = Triangles::new(octahedron.clone(), faces).unwrap();
    assert!(closed.is_closed());
    let sets = [Surface::new("octahedron", closed)];
    let surfaces = Surfaces::new(&sets, &unit);
    for (n, corner) in octahedron.iter().enumerate() {
        for other in octahedron.iter().skip(n) {
            for direction in [DVec3::Z, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.25, 0.5, -0.75)] {
                let ray = Ray { origin: (corner + other) / 2.0 - direction * 4.0, direction, start: f64::NEG_INFINITY };
                let met = surfaces.fragments(&ray, &plain());
                assert!(met.len().is_multiple_of(2), "{corner} and {other} along {direction}: {met:?}");
            }
        }
    }
}

/// Random triangles of random colours in several translucent sets.
fn shreds(count: u32) -> Vec<Triangles> {
    let number = |n: u32, by: f64| (f64::from(n) * by).fract() - 0.5;
    let place = |n: u32| grid().centre() + 20.0 * DVec3::new(number(n, 0.618_034), number(n, 0.414_214), number(n, 0.732_051));
    let set = |first: u32| {
        let points = (first..first + 3 * count).map(place).collect();
        Triangles::new(points, (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect()).unwrap()
    };
    (0..4).map(|n| set(1000 * n + 1)).collect()
}

fn translucent(sets: &[Triangles]) -> Vec<Surface> {
    let color = |n: usize| [0.2 * n as f32, 0.5, 1.0 - 0.2 * n as f32];
    sets.iter().enumerate().map(|(n, set)| shown(Surface::new("set", set.clone()), color(n), 0.1 + 0.1 * n as f32)).collect()
}

#[test]
fn the_order_of_triangles_and_sets_does_not_matter() {
    let sets = shreds(200);
    let (volume, transfer) = (volume(), transfer(0.02));
    let turned = |set: &Triangles| Triangles::new(set.points().into(), set.indices().iter().rev().copied().collect()).unwrap();
    let mut others = translucent(&sets.iter().map(turned).collect::<Vec<_>>());
    others.reverse();
    let own = translucent(&sets);
    let [one, other] = [&own, &others].map(|sets| Integral::new(&volume, &transfer, None).with_surfaces(sets));
    let mut most = 0;
    for n in 0..100 {
        let ray = through(n, f64::NEG_INFINITY);
        let [a, b] = [&one, &other].map(|integral| integral.composite(&ray, DVec3::Z).map(f64::to_bits));
        assert_eq!(a, b, "ray {n}");
        most = most.max(fragments(&own, &ray).len());
    }
    assert!(most > 20, "at most {most} triangles follow each other");
}

#[test]
fn coincident_fragments_follow_the_order_of_sets_and_then_colours() {
    let plane = |color, opacity| square("plane", grid().centre(), DVec3::X, 50.0, color, opacity);
    let [red, green] = [plane([1.0, 0.0, 0.0], 0.5), plane([0.0, 1.0, 0.0], 0.5)];
    let ray = ray(grid().centre() - DVec3::X * 20.0 + DVec3::Y, DVec3::X, 0.0);
    let first = |sets: &[Surface]| fragments(sets, &ray)[0].color;
    assert_eq!(first(&[red.clone(), green.clone()]), [1.0, 0.0, 0.0]);
    assert_eq!(first(&[green, red.clone()]), [0.0, 1.0, 0.0]);
    let Shape::Triangles(own) = red.shape() else { panic!() };
    let twice = |colors: [[f32; 4]; 2]| {
        let indices = [own.indices(), own.indices()].concat();
        let colors = [colors[0], colors[0], colors[1], colors[1]].to_vec();
        let both = Surface::new("both", Triangles::new(own.points().into(), indices).unwrap());
        [shown(both, [0.0; 3], 1.0).with_colors(Per::Cell(colors)).unwrap()]
    };
    let colors = [[0.3, 0.1, 0.9, 0.5], [0.3, 0.2, 0.1, 0.5]];
    assert_eq!(fragments(&twice(colors), &ray), fragments(&twice([colors[1], colors[0]]), &ray));
    assert!(first(&twice(colors))[1] < 0.15);
}

#[test]
fn split_triangles_look_as_whole_ones() {
    let sets = shreds(100);
    let split = |set: &Triangles| {
        let (mut points, mut indices) = (set.points().to_vec(), Vec::new());
        for &[a, b, c] in set.indices() {
            let middle = points.len() as u32;
            points.push([a, b, c].into_iter().zip([0.2, 0.5, 0.3]).map(|(n, share)| share * points[n as usize]).sum());
            indices.extend([[a, b, middle], [b, c, middle], [c, a, middle]]);
        }
        Triangles::new(points, indices).unwrap()
    };
    let (own, others) = (translucent(&sets), translucent(&sets.iter().map(split).collect::<Vec<_>>()));
    for n in 0..100 {
        let ray = through(n, f64::NEG_INFINITY);
        let [a, b] = [&own, &others].map(|sets| fragments(sets, &ray));
        assert_eq!(a.len(), b.len(), "ray {n}");
        // The depth of a triangle that is seen nearly edge-on depends on the rounding of its corners.
        let apart = a.iter().zip(&b).map(|(a, b)| (a.t - b.t).abs()).fold(0.0, f64::max);
        assert!(apart < ROUNDING, "ray {n}: {apart}");
        let [a, b] = [a, b].map(|all| over(&all, f64::INFINITY, [0.0; 4]));
        assert_same("split", a, b, 1e-12);
    }
}
