//! Pictures, colours, light, clipping and blend modes.

use super::*;
use crate::camera::{Camera, Projection};
use crate::layers::Rays;
use crate::settings::{Blend, ClipPlane, CropBox, DepthCue, Light, Lights};
use crate::surface::{Ends, Tubes};
use crate::viewport::Viewport;

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// A camera at a distance along z from the centre, with this view-up.
fn camera(distance: f64, view_up: DVec3, projection: Projection) -> Camera {
    let focal_point = grid().centre();
    Camera { position: focal_point + DVec3::Z * distance, focal_point, view_up, projection }
}

#[test]
fn planes_change_order_at_their_line() {
    let (volume, clear, size) = (volume(), transfer(0.0), Viewport::new(96, 96).unwrap());
    let up = DVec3::new(0.3, 1.0, 0.0).normalize();
    let across = up.cross(DVec3::Z);
    let projections = [Projection::Parallel { scale: 8.0 }, Projection::Perspective { field_of_view: 40.0 }];
    for camera in projections.map(|projection| camera(25.0, DVec3::Y, projection)) {
        let plane = |side: f64, color| square("plane", grid().centre(), DVec3::Z + across * side, 20.0, color, 0.5);
        let sets = [plane(0.7, RED), plane(-0.7, BLUE)];
        let picture = Integral::new(&volume, &clear, None).with_surfaces(&sets).render(&camera, size).unwrap();
        let rays = Rays::new(&camera, size, volume.grid()).unwrap();
        for (x, y) in (0..96).flat_map(|y| (0..96).map(move |x| (x, y))) {
            let ray = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let on_screen = volume.grid().index_to_world().transform_point3(ray.origin) - grid().centre();
            // The first plane falls off towards `across`, so the second is nearer to the eye there.
            let expected = if across.dot(on_screen) < 0.0 { [0.5, 0.0, 0.25, 0.75] } else { [0.25, 0.0, 0.5, 0.75] };
            assert_eq!(picture.pixel(x, y), expected, "{x}, {y}");
        }
    }
}

#[test]
fn near_planes_keep_their_order_from_afar() {
    const APART: f64 = 1e-3;
    let (volume, clear, size) = (volume(), transfer(0.0), Viewport::new(40, 40).unwrap());
    let distance = 1e6f64;
    let field_of_view = 2.0 * (10.0 / distance).atan().to_degrees();
    let camera = camera(distance, DVec3::Y, Projection::Perspective { field_of_view });
    for normal in [DVec3::Z, DVec3::new(0.5, -0.3, 0.6)] {
        let plane = |height: f64, color| square("plane", grid().centre() + DVec3::Z * height, normal, 100.0, color, 0.5);
        // The order of sets does not help.
        let sets = [plane(-APART, BLUE), plane(0.0, [0.0, 1.0, 0.0]), plane(APART, RED)];
        let picture = Integral::new(&volume, &clear, None).with_surfaces(&sets).render(&camera, size).unwrap();
        assert!(picture.pixels().iter().all(|pixel| pixel == &[0.5, 0.25, 0.125, 0.875]), "{normal}");
    }
}

#[test]
fn colours_are_interpolated_straight_and_values_before_they_are_looked_up() {
    let corners = vec![DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
    let triangle = shown(Surface::new("t", Triangles::new(corners, vec![[0, 1, 2]]).unwrap()), [0.1, 0.2, 0.3], 0.5);
    // Weights of the corners: 1/2, 1/4, 1/4.
    let ray = ray(DVec3::new(1.0, 1.0, 5.0), DVec3::NEG_Z, 0.0);
    let look = |set: Surface| {
        let Fragment { color, opacity, t } = fragments(&[set], &ray)[0];
        assert!((t - 5.0).abs() < ROUNDING);
        [color[0], color[1], color[2], opacity]
    };
    let [r, g, b] = triangle.color.map(f64::from);
    assert_same("own", look(triangle.clone()), [r, g, b, 0.5], ROUNDING);
    let points = vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.5], [0.0, 1.0, 1.0, 0.0]];
    let of_points = triangle.clone().with_colors(Per::Point(points)).unwrap();
    assert_same("points", look(of_points.clone()), [0.5, 0.5, 0.25, 0.3125], ROUNDING);
    let of_cell = triangle.clone().with_colors(Per::Cell(vec![[0.5, 0.25, 1.0, 0.5]])).unwrap();
    assert_same("cell", look(of_cell), [0.5, 0.25, 1.0, 0.25], ROUNDING);
    let ramp =
        TransferFunction::new("ramp", vec![(0.0, [0.0; 3]), (4.0, [1.0, 0.0, 0.0]), (8.0, [0.0, 1.0, 0.0])], vec![(0.0, 0.0)])
            .unwrap();
    let valued = |numbers: Per<f32>| triangle.clone().with_values(numbers, ramp.clone()).unwrap();
    assert_same("values", look(valued(Per::Point(vec![0.0, 8.0, 16.0]))), [0.5, 0.5, 0.0, 0.5], ROUNDING);
    assert_same("value", look(valued(Per::Cell(vec![2.0]))), [0.5, 0.0, 0.0, 0.5], ROUNDING);
    for unknown in [f32::NAN, f32::INFINITY] {
        assert_same("unknown", look(valued(Per::Point(vec![0.0, unknown, 16.0]))), [r, g, b, 0.5], ROUNDING);
    }
    let both = of_points.with_values(Per::Cell(vec![2.0]), ramp).unwrap();
    assert_same("colours before values", look(both), [0.5, 0.5, 0.25, 0.3125], ROUNDING);
    // A quarter of the way from the first to the second point of a tube.
    let line = Tubes::new(vec![DVec3::new(0.0, 1.0, 0.0), DVec3::new(4.0, 1.0, 0.0)], vec![0.5; 2], &[2], Ends::Flat).unwrap();
    let tube = shown(Surface::new("tube", line), [0.0; 3], 1.0);
    let colored = tube.with_colors(Per::Point(vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.2]])).unwrap();
    let Fragment { color, opacity, .. } = fragments(&[colored], &ray)[0];
    assert_same("tube", [color[0], color[1], color[2], opacity], [0.75, 0.25, 0.0, 0.8], 1e-7);
}

/// Blinn–Phong with a certain normal, from both sides; the world is turned against the grid, whose spacing differs along its axes.
#[test]
fn spheres_and_their_triangles_are_lit_by_their_normals() {
    let (volume, centre, radius) = (volume(), grid().centre(), 5.0);
    let to_light = DVec3::new(0.3, 0.4, 0.87).normalize();
    let shading = Shading { lights: Lights::new(&[Light::towards(to_light)]).unwrap(), ..Shading::default() };
    let direction = DVec3::new(-0.2, 0.3, -1.0).normalize();
    let look = Look { shading: Some(shading), to_eye: grid().world_to_grid_axes() * -direction, ..plain() };
    let half_way = (to_light - direction).normalize();
    let expected = |normal: DVec3| {
        let factor = shading.ambient + shading.diffuse * normal.dot(to_light).abs();
        (0.5 * factor + shading.specular * normal.dot(half_way).abs().powf(shading.power)).min(1.0)
    };
    let set = |surface: Surface| changed(surface, |set| set.color = [0.5; 3]);
    let sphere = set(Surface::new("sphere", Spheres::new(vec![centre], vec![radius]).unwrap()));
    let across = direction.any_orthonormal_vector();
    for off in [0.0, 0.3, 0.6, 0.9] {
        let ray = ray(centre + across * (off * radius) - direction * 20.0, direction, 0.0);
        for (n, fragment) in Surfaces::new(std::slice::from_ref(&sphere), &volume).fragments(&ray, &look).iter().enumerate() {
            let height = (1.0 - off * off).sqrt() * [-1.0, 1.0][n];
            let normal = across * off + direction * height;
            assert!((fragment.color[0] - expected(normal)).abs() < ROUNDING, "{off}: {fragment:?}");
        }
    }
    // Triangles with normals of any length; one has none, so that of the triangle stands for it.
    let corners = vec![centre, centre + DVec3::X, centre + DVec3::Y];
    let triangles = Triangles::new(corners, vec![[0, 1, 2]]).unwrap();
    let normals = vec![glam::Vec3::new(0.0, 3.0, 4.0), glam::Vec3::ZERO, glam::Vec3::new(0.0, 0.0, -1e-3)];
    let smooth = set(Surface::new("t", triangles.with_normals(normals).unwrap()));
    let ray = ray(centre + DVec3::new(0.25, 0.25, 0.0) - direction * 9.0, direction, 0.0);
    let mean = (0.5 * DVec3::new(0.0, 0.6, 0.8) + 0.25 * DVec3::Z - 0.25 * DVec3::Z).normalize();
    for (shading, normal) in [(SurfaceShading::Smooth, mean), (SurfaceShading::Flat, DVec3::Z)] {
        // A mirrored set is the set that it mirrors, also in the side that the order of points means.
        let mirrored = glam::DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let twice = changed(smooth.clone(), |set| set.shading = shading);
        let Shape::Triangles(own) = smooth.shape() else { panic!() };
        let points = own.points().iter().map(|p| mirrored.transform_point3(*p)).collect();
        let other = Triangles::new(points, vec![[0, 2, 1]]).unwrap().with_normals(own.normals().unwrap().into()).unwrap();
        let other = changed(set(Surface::new("m", other).with_matrix(mirrored).unwrap()), |set| set.shading = shading);
        for set in [twice, other] {
            let found = Surfaces::new(&[set], &volume).fragments(&ray, &look)[0].color[0];
            assert!((found - expected(normal)).abs() < 1e-6, "{shading:?}: {found} for {}", expected(normal));
        }
    }
}

/// Behind an opaque slab no light of the volume's shadows is left; outside the volume all of it is.
#[test]
fn fragments_are_in_the_shadow_of_the_volume_and_fade_with_depth() {
    let (volume, dense) = (volume(), transfer(1.0 - 1e-9));
    let lights = Lights::new(&[Light::towards(DVec3::Z)]).unwrap();
    let shading = Some(Shading { lights, ambient: 0.0, specular: 0.0, diffuse: 1.0, ..Shading::default() });
    let shadows = Some(crate::settings::Shadows { strength: 1.0, ..Default::default() });
    let depth_cue = Some(DepthCue { strength: 1.0, color: [0.0, 0.0, 1.0] });
    let settings = Settings { shading, shadows, depth_cue, ..Settings::default() };
    let shadow_rays = ShadowRays::new(&volume, &dense, &settings).unwrap();
    let to_eye = grid().world_to_grid_axes() * DVec3::Z;
    let ray = ray(grid().centre() + DVec3::Z * 40.0, DVec3::NEG_Z, 0.0);
    let fade = Fade::new(&volume, &settings, &ray, to_eye);
    let plane = |height: f64| square("plane", grid().centre() + DVec3::Z * (height - 1.0), DVec3::Z, 3.0, [1.0; 3], 0.5);
    let sets = [40.0, 0.0, -40.0].map(|height| changed(plane(height), |set| set.shading = SurfaceShading::Flat));
    let look = Look { clipping: &Clipping::default(), shading, shadow_rays: Some(&shadow_rays), fade: None, to_eye };
    let lit = Surfaces::new(&sets, &volume).fragments(&ray, &look);
    assert_eq!(lit.iter().map(|f| (f.color[0] * 1e6).round() / 1e6).collect::<Vec<_>>(), [1.0, 0.0, 1.0]);
    let faded = Surfaces::new(&sets, &volume).fragments(&ray, &Look { fade, shadow_rays: None, ..look });
    assert_eq!([faded[0].color, faded[2].color], [[1.0; 3], [0.0, 0.0, 1.0]]);
    assert!((0.3..0.7).contains(&faded[1].color[0]));
}

#[test]
fn clipping_cuts_sets_that_are_clipped() {
    let centre = grid().centre();
    let ray = ray(centre + DVec3::X * 30.0, DVec3::NEG_X, 0.0);
    let heights = [12.0, 3.0, 0.5, -3.0];
    let sets = heights.map(|x| square("plane", centre + DVec3::X * x, DVec3::X, 5.0, [1.0; 3], 0.5));
    let free = sets.clone().map(|set| changed(set, |set| set.is_clipped = false));
    let plane = ClipPlane { point: centre + DVec3::X, normal: DVec3::NEG_X };
    let middle = grid().centre_in_voxels();
    let crop = CropBox { lowest: middle - 4.0, highest: middle + 4.0 };
    let seen = |sets: &[Surface], clipping: &Clipping| {
        let found = Surfaces::new(sets, &volume()).fragments(&ray, &Look { clipping, ..plain() });
        found.iter().map(|fragment| 30.0 - fragment.t).map(|x| (x * 1e6).round() / 1e6).collect::<Vec<_>>()
    };
    let of_plane = Clipping::default().with_planes([plane]);
    let of_crop = Clipping { crop: Some(crop), ..Clipping::default() };
    assert_eq!(seen(&sets, &of_plane), [0.5, -3.0]);
    assert_eq!(seen(&sets, &of_crop), [3.0, 0.5, -3.0]);
    assert_eq!(seen(&free, &of_crop), heights);
    // The volume is cut all the same.
    let (volume, dense) = (volume(), transfer(1.0));
    let settings = Settings {
        clipping: of_plane,
        algorithm: Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 },
        ..Settings::default()
    };
    let [r, .., alpha] = Marched::new(&volume, &dense, &settings).with_surfaces(&free[1..2]).composite(&ray, DVec3::Z);
    assert_same("dense fog behind a plane", [r, 0.0, 0.0, alpha], [0.5 + 0.5 * FOG[0], 0.0, 0.0, 1.0], 0.3);
}

/// Iso-surfaces are met by depth; other values are seen through what is in front of anything.
#[test]
fn blend_modes_draw_fragments_by_depth_or_over_their_values() {
    let own = Grid::new([16, 16, 16], DVec3::new(1.0, 0.8, 1.2)).unwrap();
    let ramp = (0..own.voxel_count()).map(|n| 10 * (n % 16) as u8).collect();
    let volume = Volume::new("ramp", own.clone(), Voxels::Uint8(ramp)).unwrap();
    let transfer = TransferFunction::new("ramp", vec![(0.0, [0.0; 3]), (200.0, [0.0, 1.0, 0.0])], vec![(0.0, 0.5)]).unwrap();
    let ray = Ray { origin: DVec3::new(-5.0, 7.3, 8.4), direction: DVec3::X, start: 0.0 };
    // The iso-value 75 is at x = 7.5.
    let plane = |x: f64, color, opacity| square("plane", DVec3::new(x, 6.0, 9.0), DVec3::X, 20.0, color, opacity);
    let linear = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 };
    let layers = {
        let classification = Classification::Preintegrated { kernel: Kernel::Linear, samples_per_layer: 1 };
        Algorithm::from(crate::settings::Layered { classification, ..Default::default() })
    };
    let look = |algorithm: Algorithm, blend, sets: &[Surface]| {
        let gradient = Some(GradientEstimator::for_kernel(Kernel::Linear));
        let settings = Settings { blend, shading: None, algorithm, gradient, ..Settings::default() };
        match algorithm {
            Algorithm::Raycast { .. } => {
                Marched::new(&volume, &transfer, &settings).with_surfaces(sets).composite(&ray, DVec3::NEG_X)
            }
            _ => Layered::new(&volume, &transfer, &settings).with_surfaces(sets).composite(&ray, None, DVec3::NEG_X),
        }
    };
    for algorithm in [linear, layers] {
        let what = format!("{algorithm:?}");
        let iso = |sets: &[Surface]| look(algorithm, Blend::Iso(75.0), sets);
        assert_same(&what, iso(&[plane(7.4, RED, 0.5)]), [0.5, 0.1875, 0.0, 1.0], ROUNDING);
        assert_same(&what, iso(&[plane(7.6, RED, 0.5)]), [0.0, 0.375, 0.0, 1.0], ROUNDING);
        assert_same(&what, iso(&[plane(7.4, RED, 1.0), plane(-4.0, BLUE, 0.5)]), [0.5, 0.0, 0.5, 1.0], ROUNDING);
        for (blend, value) in [(Blend::Maximum, 150.0), (Blend::Minimum, 0.0), (Blend::Average, 75.0)] {
            let green = value / 200.0;
            let found = |sets: &[Surface]| look(algorithm, blend, sets);
            assert_same(&what, found(&[plane(3.0, RED, 0.5)]), [0.5, 0.5 * green, 0.0, 1.0], ROUNDING);
            assert_same(&what, found(&[plane(3.0, RED, 1.0), plane(18.0, BLUE, 0.5)]), [1.0, 0.0, 0.0, 1.0], ROUNDING);
        }
    }
}
