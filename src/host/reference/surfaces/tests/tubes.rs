//! Tubes and spheres against other definitions of them.

use super::*;
use crate::surface::{Ends, Tubes};

/// A bent line whose pieces have this length.
fn line(pieces: u32, length: f64, bend: f64) -> Vec<DVec3> {
    let mut direction = DVec3::new(0.8, 0.5, 0.3).normalize();
    let mut place = grid().centre() - direction * (length * f64::from(pieces) / 2.0);
    let mut points = vec![place];
    for n in 0..pieces {
        let axis = direction.cross(DVec3::new((f64::from(n) * 1.3).cos(), (f64::from(n) * 1.7).sin(), 0.4)).normalize();
        direction = (DMat3::from_axis_angle(axis, bend) * direction).normalize();
        place += direction * length;
        points.push(place);
    }
    points
}

fn tube(points: &[DVec3], radius: impl Fn(usize) -> f64, ends: Ends) -> Surface {
    let radii = (0..points.len()).map(radius).collect();
    let tubes = Tubes::new(points.into(), radii, &[points.len()], ends).unwrap();
    shown(Surface::new("tube", tubes), [1.0; 3], 0.5)
}

/// Rays near the line, in all directions.
fn rays(points: &[DVec3], count: u32, off: f64) -> Vec<(DVec3, DVec3)> {
    let number = |n: u32, by: f64| (f64::from(n + 1) * by).fract() - 0.5;
    let direction = |n: u32| DVec3::new(number(n, 0.618_034), number(n, 0.414_214), number(n, 0.732_051)).normalize();
    let off = |n: u32| off * DVec3::new(number(n, 0.236_068), number(n, 0.645_751), number(n, 0.316_625));
    (0..count).map(|n| (points[n as usize % points.len()] + off(n), direction(n))).collect()
}

fn depths(sets: &[Surface], (place, direction): (DVec3, DVec3)) -> Vec<f64> {
    fragments(sets, &ray(place, direction, f64::NEG_INFINITY)).into_iter().map(|fragment| fragment.t).collect()
}

/// Changes of the sign of a function along a ray, found in steps and refined by bisection.
fn changes(function: impl Fn(f64) -> f64, reach: f64) -> Vec<f64> {
    const STEPS: u32 = 4000;
    let at = |n: u32| (f64::from(n) / f64::from(STEPS) * 2.0 - 1.0) * reach;
    let steps = (0..STEPS).map(|n| [at(n), at(n + 1)]).filter(|ends| (function(ends[0]) < 0.0) != (function(ends[1]) < 0.0));
    steps
        .map(|[mut near, mut far]| {
            let begins_inside = function(near) < 0.0;
            for _ in 0..60 {
                let middle = (near + far) / 2.0;
                if (function(middle) < 0.0) == begins_inside { near = middle } else { far = middle }
            }
            near
        })
        .collect()
}

/// Round tubes of one radius are where the distance from the line is less than it.
#[test]
fn round_tubes_are_all_that_is_near_a_line() {
    let cases = [(1, 6.0, 0.0), (3, 4.0, 0.0), (4, 5.0, 0.6), (3, 5.0, 1.8), (40, 0.4, 0.08)];
    for (pieces, length, bend) in cases {
        const RADIUS: f64 = 1.2;
        let points = line(pieces, length, bend);
        let sets = [tube(&points, |_| RADIUS, Ends::Round)];
        let (mut differ, count) = (0, 300);
        for (place, direction) in rays(&points, count, 4.0) {
            let distance = |t: f64| {
                let p = place + direction * t;
                let to_piece = |ends: &[DVec3]| {
                    let along = ends[1] - ends[0];
                    let share = ((p - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    p.distance(ends[0] + along * share)
                };
                points.windows(2).map(to_piece).fold(f64::INFINITY, f64::min) - RADIUS
            };
            let (expected, found) = (changes(distance, 40.0), depths(&sets, (place, direction)));
            // A chord shorter than a step is not found in steps.
            let is_short = found.windows(2).any(|pair| pair[1] - pair[0] < 0.05);
            let same = found.len() == expected.len() && found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6);
            differ += u32::from(!same && !is_short);
        }
        assert_eq!(differ, 0, "{pieces} pieces of {length} that bend by {bend}: {differ} of {count} rays differ");
    }
}

/// A straight tube of one radius is a cylinder.
#[test]
fn straight_tubes_are_cylinders() {
    const RADIUS: f64 = 1.5;
    let points = line(3, 3.0, 0.0);
    let (start, end) = (points[0], points[3]);
    let along = (end - start).normalize();
    // To the axis of the tube along z.
    let (u, v) = along.any_orthonormal_pair();
    let local = |p: DVec3| DVec3::new(u.dot(p), v.dot(p), along.dot(p));
    let [mut sides, mut caps] = [0; 2];
    for (place, direction) in rays(&points, 2000, 4.0) {
        let (o, d) = (local(place - start), local(direction));
        let [a, b, c] = [d.x * d.x + d.y * d.y, o.x * d.x + o.y * d.y, o.x * o.x + o.y * o.y - RADIUS * RADIUS];
        let root = (b * b - a * c).sqrt();
        let height = |t: f64| o.z + t * d.z;
        let side: Vec<f64> =
            [-1.0, 1.0].map(|sign| (-b + sign * root) / a).into_iter().filter(|&t| (0.0..9.0).contains(&height(t))).collect();
        let is_within = |t: &f64| (o + d * *t).truncate().length() < RADIUS;
        let cap: Vec<f64> = [0.0, 9.0].map(|z| (z - o.z) / d.z).into_iter().filter(is_within).collect();
        let assert_depths = |ends: Ends, mut expected: Vec<f64>| {
            expected.sort_by(f64::total_cmp);
            let found = depths(&[tube(&points, |_| RADIUS, ends)], (place, direction));
            let same = found.len() == expected.len() && found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(same, "{ends:?}: {found:?} for {expected:?}");
        };
        assert_depths(Ends::Open, side.clone());
        assert_depths(Ends::Flat, [side.clone(), cap.clone()].concat());
        (sides, caps) = (sides + side.len(), caps + cap.len());
    }
    assert!(sides > 500 && caps > 300, "{sides} and {caps}");
}

/// Flat and round tubes of any radii are closed: rays enter them as often as they leave them. Open ones are not.
#[test]
fn tubes_are_closed() {
    for (pieces, length, bend) in [(5, 4.0, 0.5), (4, 5.0, 2.0), (30, 0.6, 0.1)] {
        let points = line(pieces, length, bend);
        let radius = |n: usize| 0.8 + 0.4 * (n as f64 * 4.0 / f64::from(pieces)).sin();
        let odd = |ends| {
            let sets = [tube(&points, radius, ends)];
            let rays = rays(&points, 3000, 3.0);
            rays.iter().filter(|&&ray| depths(&sets, ray).len() % 2 == 1).count()
        };
        assert_eq!([odd(Ends::Flat), odd(Ends::Round)], [0, 0], "{pieces} pieces of {length} that bend by {bend}");
        assert!(odd(Ends::Open) > 10);
    }
}

/// The side of a cone: its radius changes linearly, and turns its normal from the axis.
#[test]
fn cones_have_the_radii_of_their_points() {
    let points = line(1, 8.0, 0.0);
    let along = (points[1] - points[0]).normalize();
    let sets = [changed(tube(&points, |n| [2.0, 0.5][n], Ends::Open), |set| set.shading = SurfaceShading::Smooth)];
    let mut count = 0;
    for (place, direction) in rays(&points, 500, 4.0) {
        let shading = Some(Shading { ambient: 0.0, specular: 0.0, diffuse: 0.5, ..Shading::default() });
        let look = Look { shading, to_eye: grid().world_to_grid_axes() * -direction, ..plain() };
        let ray = ray(place, direction, f64::NEG_INFINITY);
        for Fragment { t, color, .. } in Surfaces::new(&sets, &volume()).fragments(&ray, &look) {
            let off = place + direction * t - points[0];
            let height = along.dot(off);
            let radius = (off - along * height).length();
            assert!((radius - (2.0 - 1.5 * height / 8.0)).abs() < 1e-9 && (0.0..8.0).contains(&height), "{radius} at {height}");
            let normal = ((off - along * height) / radius + along * (1.5 / 8.0)).normalize();
            assert!((color[0] - 0.5 * normal.dot(direction).abs()).abs() < 1e-9, "{color:?} at {height}");
            count += 1;
        }
    }
    assert!(count > 100);
}

#[test]
fn repeated_points_are_nothing_and_single_ones_balls() {
    let points = line(3, 3.0, 0.4);
    let repeated = [points[0], points[0], points[1], points[1], points[1], points[2], points[3], points[3]];
    for ends in [Ends::Flat, Ends::Open, Ends::Round] {
        let [once, twice] = [&points[..], &repeated].map(|points| [tube(points, |_| 1.0, ends)]);
        let single = [tube(&[points[0]; 2], |_| 1.0, ends)];
        for ray in rays(&points, 200, 2.0) {
            assert_eq!(depths(&once, ray), depths(&twice, ray));
            let is_met = ray.1.cross(points[0] - ray.0).length() < ray.1.length();
            let expected = if ends == Ends::Round && is_met { 2 } else { 0 };
            assert_eq!(depths(&single, ray).len(), expected);
        }
    }
}

/// Triangles on a sphere. They are at most this far inside it, relative to the radius, for an angle of `step` between points: along both.
fn sagitta(step: f64) -> f64 {
    2.0 * (1.0 - (step / 2.0).cos())
}

/// A sphere of triangles between circles of latitude, with its normals.
fn globe(centre: DVec3, radius: f64, rows: u32) -> Triangles {
    let step = std::f64::consts::PI / f64::from(rows);
    let normal = |i: u32, j: u32| {
        let (latitude, longitude) = (step * f64::from(j), step * f64::from(i % (2 * rows)));
        DVec3::new(latitude.sin() * longitude.cos(), latitude.sin() * longitude.sin(), latitude.cos())
    };
    let columns = 2 * rows;
    let normals: Vec<DVec3> = (0..=rows).flat_map(|j| (0..columns).map(move |i| normal(i, j))).collect();
    let index = |i: u32, j: u32| j * columns + i % columns;
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let faces =
        |(i, j)| [[index(i, j), index(i + 1, j), index(i + 1, j + 1)], [index(i, j), index(i + 1, j + 1), index(i, j + 1)]];
    let points = normals.iter().map(|normal| centre + radius * *normal).collect();
    Triangles::new(points, cells.flat_map(faces).collect())
        .unwrap()
        .with_normals(normals.iter().map(|n| n.as_vec3()).collect())
        .unwrap()
}

/// A sphere of 200 000 triangles is the quadric, up to their distance from it.
#[test]
fn many_triangles_are_a_sphere() {
    const ROWS: u32 = 224;
    let (centre, radius) = (grid().centre(), 7.0);
    let triangles = globe(centre, radius, ROWS);
    assert!(triangles.indices().len() > 200_000);
    let set = |surface: Surface| [changed(surface, |set| (set.color, set.opacity) = ([0.9, 0.5, 0.2], 0.4))];
    let [round, flat] =
        [set(Surface::new("sphere", Spheres::new(vec![centre], vec![radius]).unwrap())), set(Surface::new("globe", triangles))];
    let volume = volume();
    let [round, flat] = [&round, &flat].map(|sets| Surfaces::new(sets, &volume));
    let most = radius * sagitta(std::f64::consts::PI / f64::from(ROWS));
    let (mut compared, direction) = (0, DVec3::new(0.3, -0.5, 0.8).normalize());
    let (u, v) = direction.any_orthonormal_pair();
    let (shading, to_eye) = (Shading::default(), grid().world_to_grid_axes() * -direction);
    for n in 0..2500u32 {
        let off = [n % 50, n / 50].map(|i| (f64::from(i) + 0.5) / 25.0 - 1.0);
        let place = centre + (u * off[0] + v * off[1]) * (1.05 * radius);
        let ray = ray(place, direction, f64::NEG_INFINITY);
        let [a, b] =
            [&round, &flat].map(|surfaces| surfaces.fragments(&ray, &Look { shading: Some(shading), to_eye, ..plain() }));
        let facing = 1.0 - (place.distance(centre) / radius).powi(2);
        if facing <= 0.0 {
            assert!(a.is_empty() && b.is_empty(), "{n}");
            continue;
        }
        // At the silhouette, depths and normals change without bounds.
        if facing.sqrt() > 0.2 {
            assert_eq!([a.len(), b.len()], [2, 2]);
            let off = 1.1 * most / facing.sqrt();
            // Interpolated normals are those of their places, so the distance turns them, and with them the light.
            let turned = (shading.diffuse + shading.specular * shading.power) * off / radius;
            assert!(turned < 2.5e-3);
            for (a, b) in a.iter().zip(&b) {
                assert!((a.t - b.t).abs() <= off, "{n}: {a:?} and {b:?}");
                let apart = a.color.iter().zip(b.color).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart <= turned && a.opacity == b.opacity, "{n}: {a:?} and {b:?}");
            }
            compared += 1;
        }
    }
    assert!(compared > 1500, "{compared}");
}
