//! Surfaces: closed forms, and what must not change a picture.

use crate::common::*;
use glam::DVec3;
use layersplat::color::reflectance;
use layersplat::settings::{Blend, Clipping, CropBox, DepthCue, Light, Lights, Look, Shading, Shadows, Sky, Studio};
use layersplat::surface::{Ends, Per, Spheres, Surface, SurfaceShading, Triangles, Tubes};
use layersplat::volume::Voxels;
use layersplat::{Camera, Frame, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport, Volume};

/// Colours of fragments have half precision.
const ROUNDED: f64 = 1e-3;

/// A volume of 20³ voxels that shows nothing.
fn clear() -> (Volume<'static>, TransferFunction) {
    let nothing = TransferFunction::new("nothing", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0)]).unwrap();
    (volume([20; 3], DVec3::ONE, Voxels::Uint8(vec![0; 8000])), nothing)
}

/// The same volume full of matter of this opacity per voxel.
fn fog(opacity: f64) -> (Volume<'static>, TransferFunction) {
    let fog = TransferFunction::new("fog", vec![(0.0, [0.0, 0.0, 1.0])], vec![(0.0, opacity)]).unwrap();
    (volume([20; 3], DVec3::ONE, Voxels::Uint8(vec![0; 8000])), fog)
}

fn drawn((volume, transfer): &(Volume, TransferFunction), surfaces: &[Surface], camera: &Camera, size: Viewport) -> Frame {
    let settings = Settings { shading: None, early_termination: false, ..Settings::default() };
    drawn_with((volume, transfer), surfaces, camera, size, &settings)
}

fn drawn_with(
    (volume, transfer): (&Volume, &TransferFunction),
    surfaces: &[Surface],
    camera: &Camera,
    size: Viewport,
    settings: &Settings,
) -> Frame {
    let mut renderer = Renderer::new(&device(), volume, transfer).unwrap();
    renderer.set_surfaces(surfaces).unwrap();
    renderer.render(camera, size, settings).unwrap().0
}

/// From +z towards the middle of the volume, 8 voxels up and down.
fn along_z(roll: f64) -> Camera {
    Camera::orbit(DVec3::splat(9.5), 100.0, Orbit { roll, ..Orbit::default() }, Projection::Parallel { scale: 8.0 })
}

/// A square across z, of this half edge.
fn square(z: f64, half: f64, opacity: f32) -> Surface {
    let corner = |x: f64, y: f64| DVec3::new(9.5 + x * half, 9.5 + y * half, z);
    let points = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mut surface = Surface::new("square", Triangles::new(points, vec![[0, 1, 2], [0, 2, 3]]).unwrap());
    (surface.color, surface.opacity) = ([1.0, 0.0, 0.0], opacity);
    surface
}

/// A jittered net of triangles around the middle of the volume, with edges in all directions, and waves of this height.
fn net(cells: usize, half: f64, height: f64) -> Triangles {
    let mut random = Random(5);
    let mut point = |n: usize| {
        let mut at = |i: usize| 2.0 * (i as f64 + 0.4 * (random.unit() - 0.5)) / cells as f64 - 1.0;
        let (x, y) = (at(n % (cells + 1)), at(n / (cells + 1)));
        DVec3::new(9.5 + half * x, 9.5 + half * y, 9.5 + height * (4.0 * x).sin() * (3.0 * y).cos())
    };
    let points = (0..(cells + 1) * (cells + 1)).map(&mut point).collect();
    let corner = |i: usize, j: usize| (j * (cells + 1) + i) as u32;
    let halves = |n: usize| {
        let (i, j) = (n % cells, n / cells);
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        if n.is_multiple_of(3) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [d, b, c]] }
    };
    Triangles::new(points, (0..cells * cells).flat_map(halves).collect()).unwrap()
}

#[test]
fn fog_in_front_of_an_opaque_square_absorbs_as_far_as_it() {
    let depth = 6.0_f64;
    for roll in [0.0, 25.0] {
        let scene = fog(0.1);
        // Fog begins a voxel before the outermost ones.
        let frame = drawn(&scene, &[square(20.0 - depth, 30.0, 1.0)], &along_z(roll), viewport(24, 24));
        let left = (0.9_f64).powf(depth);
        for pixel in frame.pixels() {
            let expected = [left, 0.0, 1.0 - left, 1.0];
            let off =
                pixel.iter().zip(expected).map(|(&found, expected)| (f64::from(found) - expected).abs()).fold(0.0, f64::max);
            assert!(off < 5.0 * ROUNDED, "{pixel:?}, expected {expected:?}");
        }
    }
}

#[test]
fn many_translucent_squares_let_the_product_through() {
    let (count, opacity) = (50, 0.1_f64);
    let squares: Vec<_> = (0..count).map(|n| square(-8.0 + 0.7 * n as f64, 30.0, opacity as f32)).collect();
    let frame = drawn(&clear(), &squares, &along_z(0.0), viewport(16, 16));
    let expected = 1.0 - (1.0 - opacity).powi(count);
    for pixel in frame.pixels() {
        assert!((f64::from(pixel[3]) - expected).abs() < ROUNDED, "{pixel:?}, expected {expected}");
    }
}

/// Each pixel within a net has exactly one fragment, whatever edges run through it: also where triangles reach behind the eye.
#[test]
fn shared_edges_lose_no_pixel_and_draw_none_twice() {
    let size = viewport(200, 180);
    let surface = |height| {
        let mut surface = Surface::new("net", net(90, 40.0, height));
        surface.opacity = 0.5;
        surface
    };
    let perspective = |distance, elevation| {
        let orbit = Orbit { azimuth: 20.0, elevation, roll: 10.0 };
        Camera::orbit(DVec3::splat(9.5), distance, orbit, Projection::Perspective { field_of_view: 40.0 })
    };
    // Close to a flat net, half of which is behind the eye.
    let near = Camera { position: DVec3::new(9.5, 9.5, 12.5), focal_point: DVec3::new(12.5, 9.5, 9.5), ..perspective(1.0, 0.0) };
    let far = Camera { projection: Projection::Perspective { field_of_view: 8e-4 }, ..perspective(1e6, 5.0) };
    for (name, camera, height) in [("parallel", along_z(17.0), 12.0), ("far", far, 12.0), ("near", near, 0.0)] {
        let frame = drawn(&clear(), &[surface(height)], &camera, size);
        let other = frame.pixels().iter().filter(|pixel| pixel[3] != 0.5).count();
        assert_eq!(other, 0, "{name}: pixels with other than one fragment");
    }
    // A net with a hole is noticed.
    let whole = net(90, 40.0, 12.0);
    let holed = Triangles::new(whole.points().to_vec(), whole.indices()[..8000].to_vec()).unwrap();
    let mut holed = Surface::new("holed", holed);
    holed.opacity = 0.5;
    let frame = drawn(&clear(), &[holed], &along_z(17.0), size);
    assert!(frame.pixels().iter().any(|pixel| pixel[3] != 0.5));
}

/// Several sets, through each other and the volume.
fn crossing() -> Vec<Surface> {
    let mut random = Random(3);
    let mut place = || DVec3::new(random.unit(), random.unit(), random.unit()) * 19.0;
    let mut net = Surface::new("net", net(12, 9.0, 2.7));
    net.opacity = 0.4;
    let mut spheres = Surface::new("spheres", Spheres::new((0..9).map(|_| place()).collect(), vec![4.0; 9]).unwrap());
    (spheres.opacity, spheres.color) = (0.3, [0.2, 0.9, 0.3]);
    let line: Vec<_> = (0..8).map(|_| place()).collect();
    let mut tube = Surface::new("tube", Tubes::new(line, vec![0.8; 8], &[8], Ends::Flat).unwrap());
    (tube.opacity, tube.color) = (0.6, [0.9, 0.8, 0.2]);
    vec![net, spheres, tube]
}

#[test]
fn the_order_of_triangles_changes_no_bit() {
    let size = viewport(90, 80);
    let scene = (random_volume([20; 3], DVec3::ONE, 4), smooth_transfer());
    let camera = parallel(&scene.0, size, 30.0, 20.0);
    let surfaces = crossing();
    let expected = drawn(&scene, &surfaces, &camera, size);
    let triangles = net(12, 9.0, 2.7);
    let turned = triangles.indices().iter().rev().copied().collect();
    let mut changed = surfaces.clone();
    changed[0] = Surface::new("net", Triangles::new(triangles.points().to_vec(), turned).unwrap());
    changed[0].opacity = 0.4;
    assert!(drawn(&scene, &changed, &camera, size) == expected);
    // And from frame to frame, after another picture.
    let mut renderer = Renderer::new(&device(), &scene.0, &scene.1).unwrap();
    let settings = Settings { shading: None, early_termination: false, ..Settings::default() };
    let alone = renderer.render(&camera, size, &settings).unwrap().0;
    renderer.set_surfaces(&surfaces).unwrap();
    renderer.measure(true);
    let (_, report) = renderer.render(&along_z(0.0), size, &settings).unwrap();
    assert!(report.measured.unwrap().active_samples > 0, "samples of all intervals are counted");
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
    renderer.set_surfaces(&[]).unwrap();
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == alone);
    assert!(alone != expected);
}

#[test]
fn invisible_sets_change_no_bit() {
    let size = viewport(60, 50);
    let scene = (random_volume([20; 3], DVec3::ONE, 4), smooth_transfer());
    let camera = parallel(&scene.0, size, 30.0, 20.0);
    let shown = vec![square(9.0, 4.0, 0.5)];
    let expected = drawn(&scene, &shown, &camera, size);
    let mut more = crossing();
    more[0].opacity = 0.0;
    more[1].is_visible = false;
    // Its fragments cut the volume.
    let colors = Per::Point(vec![[0.9, 0.8, 0.2, 0.0]; 8]);
    more[2] = more[2].clone().with_colors(colors).unwrap();
    more.extend(shown);
    assert!(drawn(&scene, &more, &camera, size) == expected);
    // Alone, they leave the volume to the method that draws it without surfaces.
    let rolled = along_z(20.0);
    more.truncate(2);
    assert!(drawn(&scene, &more, &rolled, size) == drawn(&scene, &[], &rolled, size));
}

#[test]
fn surfaces_on_a_face_of_the_crop_box_are_whole() {
    let size = viewport(60, 50);
    let scene = clear();
    let camera = parallel(&scene.0, size, 30.0, 20.0);
    let everything = CropBox { lowest: DVec3::splat(-100.0), highest: DVec3::splat(100.0) };
    let [mut below, mut above] = [everything; 2];
    (below.highest.z, above.lowest.z) = (12.0, 12.0);
    for crop in [below, above] {
        let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
        let settings = Settings { shading: None, early_termination: false, clipping, ..Settings::default() };
        for (z, is_inside) in [(11.9, crop == below), (12.0, true), (12.1, crop == above)] {
            let square = [square(z, 7.0, 1.0)];
            let expected = drawn(&scene, if is_inside { &square } else { &[] }, &camera, size);
            assert!(drawn_with((&scene.0, &scene.1), &square, &camera, size, &settings) == expected, "{crop:?}, {z}");
        }
    }
}

/// A lit sphere alone: the volume's voxels cast no shadow on it where nothing is visible.
#[test]
fn shadows_of_nothing_change_nothing() {
    let size = viewport(60, 60);
    let sphere = Surface::new("sphere", Spheres::new(vec![DVec3::splat(9.5)], vec![6.0]).unwrap());
    let (volume, transfer) = clear();
    let camera = along_z(0.0);
    let plain = drawn_with((&volume, &transfer), std::slice::from_ref(&sphere), &camera, size, &Settings::default());
    let shadows = Settings { shadows: Some(Shadows::default()), ..Settings::default() };
    let shadowed = drawn_with((&volume, &transfer), &[sphere], &camera, size, &shadows);
    assert_close("shadows of nothing", &plain, &shadowed, 2.0 / 255.0);
    let middle = plain.pixel(30, 30);
    assert!(middle[0] > 0.7 && middle[3] == 1.0, "{middle:?}");
}

#[test]
fn iso_surfaces_and_maxima_have_surfaces_before_and_over_them() {
    let size = viewport(40, 40);
    let bytes = (0..8000).map(|n| if n / 400 >= 10 { 200 } else { 0 }).collect();
    let step = volume([20; 3], DVec3::ONE, Voxels::Uint8(bytes));
    let grey = TransferFunction::new("grey", vec![(0.0, [0.0; 3]), (255.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 1.0)]).unwrap();
    let settings = |blend| Settings { blend, shading: None, ..Settings::default() };
    let picture = |blend, z| {
        let mut square = square(z, 3.0, 1.0);
        square.shading = SurfaceShading::Off;
        drawn_with((&step, &grey), &[square], &along_z(0.0), size, &settings(blend)).pixel(20, 20)
    };
    // The iso-surface lies between layers 19 and 20, towards the eye.
    assert_eq!(picture(Blend::Iso(100.0), 30.0)[..3], [1.0, 0.0, 0.0]);
    assert!(picture(Blend::Iso(100.0), 5.0)[1] > 0.3, "{:?}", picture(Blend::Iso(100.0), 5.0));
    assert_eq!(picture(Blend::Maximum, 5.0)[..3], [1.0, 0.0, 0.0]);
}

/// In the studio, colours are reflectances in linear light, of lights and of an even sky. An iso-surface reflects lights alike; of the light that
/// cells scatter it has a tenth too much.
#[test]
fn squares_reflect_the_light_of_the_studio() {
    /// Of an iso-surface, whose light is interpolated between voxels.
    const AS_ISO: f64 = 2.0 / 255.0;
    let size = viewport(12, 12);
    let bytes = (0..8000).map(|n| if n / 400 < 10 { 200 } else { 0 }).collect();
    let step = volume([20; 3], DVec3::ONE, Voxels::Uint8(bytes));
    for (direction, strength, sky) in
        [(DVec3::Z, 0.8, 0.0), (DVec3::new(3.0_f64.sqrt(), 0.0, 1.0), 0.8, 0.0), (DVec3::Z, 0.0, 1.0), (DVec3::Z, 0.3, 0.4)]
    {
        let lights = Lights::new(&[Light { strength, ..Light::towards(direction) }]).unwrap();
        let sky = Sky { top: [1.0; 3], bottom: [1.0; 3], strength: sky, ..Sky::default() };
        let settings = Settings {
            shading: Some(Shading { lights, specular: 0.0, ..Shading::default() }),
            studio: Some(Studio { sky, ..Studio::default() }),
            ..Settings::default().with_look(Look::Studio)
        };
        let arriving = strength * direction.normalize().z + sky.strength;
        for grey in [1.0, 0.5] {
            let pixel = |opacity: f32| {
                let mut square = square(14.0, 30.0, opacity);
                square.color = [grey as f32; 3];
                let (volume, transfer) = clear();
                drawn_with((&volume, &transfer), &[square], &along_z(0.0), size, &settings).pixel(6, 6)
            };
            let expected = reflectance(grey) * arriving;
            for opacity in [1.0, 0.5] {
                let found = pixel(opacity);
                let off = (f64::from(found[1]) - expected * f64::from(opacity)).abs();
                assert!(off < ROUNDED && found[3] == opacity, "{direction}, {grey}: {found:?}, expected {expected}");
            }
            let solid = TransferFunction::new("solid", vec![(0.0, [grey; 3])], vec![(0.0, 0.0), (200.0, 1.0)]).unwrap();
            let iso = Settings { blend: Blend::Iso(100.0), ..settings };
            let iso = drawn_with((&step, &solid), &[], &along_z(0.0), size, &iso).pixel(6, 6);
            let off = (f64::from(iso[1]) - expected).abs();
            assert!(sky.strength > 0.0 || off < AS_ISO, "{direction}, {grey}: {iso:?} of an iso-surface, expected {expected}");
        }
    }
}

/// Of a tube, the part in the picture is drawn, wherever its ends are: beside the picture, or behind the eye.
#[test]
fn tubes_reach_into_the_picture_from_outside() {
    let (size, scene) = (viewport(32, 32), clear());
    let middle = DVec3::splat(9.5);
    let perspective = Camera { projection: Projection::Perspective { field_of_view: 20.0 }, ..along_z(0.0) };
    let (beside, behind) = (DVec3::new(300.0, 1.0, 20.0), DVec3::new(2.0, -6.0, 130.0));
    for (camera, ends, least) in [
        (along_z(0.0), [-beside, beside], 32 * 7),
        (perspective, [-beside, beside], 32 * 3),
        (along_z(0.0), [DVec3::ZERO, beside], 16 * 7),
        (perspective, [-behind, behind], 40),
    ] {
        let tubes = Tubes::new(ends.map(|end| middle + end).to_vec(), vec![2.0; 2], &[2], Ends::Open).unwrap();
        let frame = drawn(&scene, &[Surface::new("tube", tubes)], &camera, size);
        let covered = frame.pixels().iter().filter(|pixel| pixel[3] == 1.0).count();
        assert!(covered >= least, "{ends:?}: {covered} pixels");
    }
}

#[test]
fn repeated_points_of_lines_change_no_bit() {
    let (size, scene) = (viewport(50, 40), clear());
    let camera = parallel(&scene.0, size, 30.0, 20.0);
    let line = [DVec3::new(2.0, 3.0, 4.0), DVec3::new(12.0, 9.0, 9.0), DVec3::new(16.0, 4.0, 12.0)];
    let picture = |numbers: &[usize]| {
        let points: Vec<_> = numbers.iter().map(|&n| line[n]).collect();
        let values = numbers.iter().map(|&n| n as f32).collect();
        let colors =
            TransferFunction::new("values", vec![(0.0, [1.0, 0.0, 0.0]), (2.0, [0.0, 0.0, 1.0])], vec![(0.0, 1.0)]).unwrap();
        let tubes = Tubes::new(points, vec![1.5; numbers.len()], &[numbers.len()], Ends::Round).unwrap();
        let mut tubes = Surface::new("tube", tubes).with_values(Per::Point(values), colors).unwrap();
        tubes.opacity = 0.5;
        drawn(&scene, &[tubes], &camera, size)
    };
    let expected = picture(&[0, 1, 2]);
    assert!(picture(&[0, 0, 1, 1, 1, 2, 2]) == expected && largest_opacity(&expected) > 0.7);
    assert!(picture(&[0, 1]) != expected);
    // Points that all coincide, with round ends: a ball, with two fragments in each pixel.
    assert!(largest_opacity(&picture(&[1, 1])) == 0.75);
}

#[test]
fn depths_are_those_of_fragments() {
    let (volume, transfer) = clear();
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    renderer.set_surfaces(&[square(14.0, 30.0, 0.5), square(5.0, 30.0, 1.0)]).unwrap();
    let settings = Settings { early_termination: false, ..Settings::default() };
    let depths = renderer.depths(&along_z(0.0), viewport(12, 12), &settings).unwrap();
    // The eye is 100 from the middle, at 9.5.
    for (first, mean) in depths.first().iter().zip(depths.mean()) {
        assert!((first - 95.5).abs() < 1e-3 && (mean - 100.0).abs() < 1e-2, "{first}, {mean}");
    }
}

#[test]
fn cells_found_for_a_view_serve_no_other() {
    let scene = fog(0.05);
    let (near, far) = (square(15.0, 5.0, 0.5), square(5.0, 5.0, 0.5));
    let size = Viewport::new(40, 30).unwrap();
    let cameras = [along_z(0.0), along_z(25.0), along_z(25.0), along_z(0.0)];
    let mut renderer = Renderer::new(&device(), &scene.0, &scene.1).unwrap();
    let settings = Settings { shading: None, early_termination: false, ..Settings::default() };
    for surface in [&near, &far] {
        renderer.set_surfaces(std::slice::from_ref(surface)).unwrap();
        for camera in &cameras {
            let (frame, _) = renderer.render(camera, size, &settings).unwrap();
            let alone = drawn(&scene, std::slice::from_ref(surface), camera, size);
            assert_eq!(frame.pixels(), alone.pixels(), "a frame after another");
        }
    }
    assert_ne!(drawn(&scene, &[near], &cameras[0], size).pixels(), drawn(&scene, &[far], &cameras[0], size).pixels());
}

/// Frames of one view, each with one thing changed: fragments of the frame before are drawn where they are the same.
#[test]
fn fragments_of_a_frame_serve_no_other_light_or_clipping() {
    let (volume, transfer) = fog(0.05);
    let (_, thick) = fog(0.6);
    let own = Settings { unit_distance: Some(1.0), ..Settings::default() };
    let lit = |light: Light| Settings {
        shading: Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() }),
        ..own
    };
    let side = lit(Light::towards(DVec3::new(1.0, 0.3, 0.2)));
    let shadows = Settings { shadows: Some(Shadows::default()), ..side };
    let below = |y: f64| {
        let crop = Some(CropBox { lowest: DVec3::ZERO, highest: DVec3::new(19.0, y, 19.0) });
        Settings { clipping: Clipping { crop, ..Clipping::default() }, ..side }
    };
    let cued = Settings { depth_cue: Some(DepthCue { strength: 0.7, ..DepthCue::default() }), ..own };
    // More translucent ones than are found at first, of which the thick fog hides most.
    let squares: Vec<_> = (0..7).map(|n| square(4.0 + 1.7 * f64::from(n), 6.0 - 0.4 * f64::from(n), 0.3)).collect();
    let (camera, size) = (along_z(12.0), viewport(40, 30));
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    renderer.set_surfaces(&squares).unwrap();
    let frames = [
        (own, &transfer),
        (own, &thick),
        (side, &thick),
        (below(11.0), &thick),
        (below(12.5), &thick),
        (below(12.5), &transfer),
        (side, &thick),
        (shadows, &thick),
        (shadows, &transfer),
        (cued, &thick),
        (own, &thick),
        (own, &transfer),
    ];
    let mut before = None;
    for (n, (settings, transfer)) in frames.into_iter().enumerate() {
        renderer.set_transfer_function(transfer);
        let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
        let alone = drawn_with((&volume, transfer), &squares, &camera, size, &settings);
        assert!(frame.pixels() == alone.pixels(), "frame {n} after another");
        assert!(before.replace(frame) != Some(alone), "frame {n} is that before");
    }
}

#[test]
fn a_line_that_turns_back_leaves_no_hole() {
    let points = [3.2, 15.9, 8.3].map(|x| DVec3::new(x, 9.5, 9.5)).to_vec();
    let tubes = |opacity| {
        let mut tubes = Surface::new("tubes", Tubes::new(points.clone(), vec![2.0; 3], &[3], Ends::Flat).unwrap());
        tubes.opacity = opacity;
        tubes
    };
    // Four pixels per voxel: 11 × 3.5 voxels in the middle of the tube.
    let size = Viewport::new(64, 64).unwrap();
    for (opacity, alpha) in [(1.0, 1.0), (0.5, 0.75)] {
        let frame = drawn(&clear(), &[tubes(opacity)], &along_z(20.0), size);
        let inside = |n: usize| {
            let (x, y) = (n as f64 % 64.0 + 0.5 - 32.0, (n / 64) as f64 + 0.5 - 32.0);
            let (sin, cos) = 20_f64.to_radians().sin_cos();
            [1.0, -1.0].iter().all(|sign| (x * cos + sign * y * sin).abs() < 22.0 && (y * cos - sign * x * sin).abs() < 7.0)
        };
        let seen: Vec<_> = (0..64 * 64).filter(|&n| inside(n)).map(|n| f64::from(frame.pixels()[n][3])).collect();
        assert!(seen.len() > 200 && seen.iter().all(|a| (a - alpha).abs() < ROUNDED), "{opacity}: {seen:?}");
    }
}
