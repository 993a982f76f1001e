//! Surfaces of labels: their definition in f64, closed forms of slabs, balls and thin labels, and silhouettes.

use crate::common::{device, largest_opacity, viewport};
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::reference::Labels;
use layersplat::renderer::{UploadedColors, UploadedVolume};
use layersplat::settings::Algorithm;
use layersplat::volume::{Grid, LabelSurfaces};
use layersplat::{Camera, Frame, Orbit, Quality, Renderer, Settings, Volume};

/// Colours and opacities of the labels 0 to 4; label 4 is hidden.
const ENTRIES: [[f64; 4]; 5] = [[0.0; 4], [0.9, 0.1, 0.2, 0.9], [0.1, 0.8, 0.3, 0.3], [0.2, 0.3, 1.0, 0.6], [1.0, 1.0, 0.0, 0.0]];

fn of_labels(volume: &Volume, entries: &[[f64; 4]], surfaces: LabelSurfaces) -> UploadedColors {
    UploadedColors::from_labels(&[(&UploadedVolume::new(&device(), volume).unwrap(), entries)], surfaces).unwrap()
}

fn camera(grid: &Grid, size: (u32, u32), azimuth: f64, elevation: f64) -> Camera {
    Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport(size.0, size.1), Orbit { azimuth, elevation, roll: 0.0 })
}

fn drawn(colors: &UploadedColors, settings: &Settings, azimuth: f64, elevation: f64) -> Frame {
    let camera = camera(colors.description().grid(), (64, 56), azimuth, elevation);
    Renderer::from_colors(colors).unwrap().render(&camera, viewport(64, 56), settings).unwrap().0
}

fn unlit() -> Settings {
    Settings { shading: None, ..Settings::default() }
}

fn psnr(one: &Frame, other: &Frame) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let squares: f64 = pairs.flat_map(|(a, b)| (0..4).map(|c| f64::from(a[c] - b[c]).powi(2)).collect::<Vec<_>>()).sum();
    -10.0 * (squares / (4 * one.pixels().len()) as f64).log10()
}

/// Labels of voxels by their position from the centre, in world units.
fn by_position(dims: [usize; 3], spacing: DVec3, label: impl Fn(DVec3) -> u8) -> Volume<'static> {
    let [x, y, z] = dims;
    let middle = (DVec3::new(x as f64, y as f64, z as f64) - 1.0) / 2.0;
    let at = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / x / y) as f64);
    let voxels: Vec<u8> = (0..x * y * z).map(|n| label((at(n) - middle) * spacing)).collect();
    Volume::new("labels", Grid::new(dims, spacing).unwrap(), voxels).unwrap()
}

/// Every voxel has one of five labels by chance, so that many meet, and those at the ends of the volume, too.
#[test]
fn smooth_surfaces_have_their_definition() {
    /// PSNR in dB of rays with 16 steps per voxel, where the opacity changes within a third of one.
    const LEAST: f64 = 50.0;
    let casting = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 1.0 / 16.0 }, ..Settings::default() };
    for (dims, spacing) in [([13, 11, 12], DVec3::ONE), ([13, 11, 6], DVec3::new(0.5, 0.6, 1.1)), ([1, 9, 8], DVec3::ONE)] {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        // Half of them in blocks, so that flat surroundings occur.
        let mut labels: Vec<u8> = (0..dims.iter().product())
            .map(|n: usize| if (n / 13).is_multiple_of(2) { next() % 5 } else { 1 + (n / 40 % 3) as u8 })
            .collect();
        labels[0] = 0;
        let volume = Volume::new("labels", Grid::new(dims, spacing).unwrap(), labels).unwrap();
        let camera = camera(volume.grid(), (32, 28), 25.0, 20.0);
        for settings in [casting, Settings { shading: None, ..casting }] {
            let truth = Labels::new(&volume, &ENTRIES, Kernel::Cubic, 1.5).unwrap().with_shading(settings.shading);
            let truth = truth.render(&camera, viewport(32, 28)).unwrap();
            let picture = |surfaces| {
                let mut renderer = Renderer::from_colors(&of_labels(&volume, &ENTRIES, surfaces)).unwrap();
                renderer.render(&camera, viewport(32, 28), &settings).unwrap().0
            };
            let smooth = picture(LabelSurfaces::Smooth);
            let fidelity = psnr(&smooth, &truth);
            println!("{dims:?}, lit {}: {fidelity:.1} dB", settings.shading.is_some());
            assert!(largest_opacity(&smooth) > 0.2, "{dims:?}: something is seen");
            assert!(fidelity >= LEAST, "{dims:?}: {fidelity}");
            // Voxels as they are would be noticed.
            assert!(psnr(&picture(LabelSurfaces::Voxels), &truth) < LEAST - 15.0, "{dims:?}");
        }
    }
}

/// Beer-Lambert through a slab of 8 voxels.
#[test]
fn slabs_have_their_closed_form() {
    /// Of the opacity of a ray: segments meet both surfaces in fifths.
    const TOLERANCE: f64 = 3e-3;
    let (dims, opacity) = ([20; 3], 0.2f64);
    for (axis, azimuth, elevation) in [(0, 90.0, 0.0), (1, 0.0, 90.0), (2, 0.0, 0.0)] {
        let volume = by_position(dims, DVec3::ONE, |p| u8::from(p[axis].abs() < 4.0));
        for surfaces in [LabelSurfaces::Smooth, LabelSurfaces::Voxels] {
            let exact = 1.0 - (1.0f64 - opacity).powi(8);
            let colors = of_labels(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], surfaces);
            let frame = drawn(&colors, &unlit(), azimuth, elevation);
            let pixel = frame.pixels()[28 * 64 + 32].map(f64::from);
            println!("axis {axis}, {surfaces:?}: {pixel:.4?}, {exact:.4}");
            assert!(
                (pixel[3] - exact).abs() <= TOLERANCE && (pixel[0] - exact).abs() <= TOLERANCE,
                "{axis}, {surfaces:?}: {pixel:?}"
            );
        }
    }
}

const SIZE: u32 = 320;

/// Alpha along rays from the middle of a picture, and the distances of the pixels in world units, for angles all around.
fn profiles(frame: &Frame, half_height: f64) -> Vec<Vec<(f64, f64)>> {
    let middle = f64::from(SIZE - 1) / 2.0;
    let per_unit = f64::from(SIZE) / 2.0 / half_height;
    let along = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let place = |k: i32| {
            let r = 0.1 * f64::from(k);
            let [x, y] = [middle + r * c, middle + r * s];
            let at = |x: f64, y: f64| f64::from(frame.pixels()[y as usize * SIZE as usize + x as usize][3]);
            let ([left, top], [u, v]) = ([x.floor(), y.floor()], [x.fract(), y.fract()]);
            let row = |y: f64| (1.0 - u) * at(left, y) + u * at(left + 1.0, y);
            (r / per_unit, (1.0 - v) * row(top) + v * row(top + 1.0))
        };
        (0..1550).map(place).collect()
    };
    (0..360).map(|degree| along(f64::from(degree).to_radians())).collect()
}

/// Where the opacity falls below a level: mean, standard deviation, and the radii themselves, by the angle.
fn silhouette(profiles: &[Vec<(f64, f64)>], level: f64) -> (f64, f64, Vec<f64>) {
    let radius = |profile: &Vec<(f64, f64)>| profile.iter().find(|(_, alpha)| *alpha < level).expect("the picture is larger").0;
    let radii: Vec<f64> = profiles.iter().map(radius).collect();
    let mean = radii.iter().sum::<f64>() / radii.len() as f64;
    let deviation = (radii.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / radii.len() as f64).sqrt();
    (mean, deviation, radii)
}

fn pictured(volume: &Volume, entries: &[[f64; 4]], surfaces: LabelSurfaces, (azimuth, elevation): (f64, f64)) -> Frame {
    let camera = camera(volume.grid(), (SIZE, SIZE), azimuth, elevation);
    let settings = Settings { shading: None, ..Quality::Standard.settings() };
    let colors = of_labels(volume, entries, surfaces);
    Renderer::from_colors(&colors).unwrap().render(&camera, viewport(SIZE, SIZE), &settings).unwrap().0
}

/// The radius of a ball does not depend on its opacity, and is that of the ball.
#[test]
fn balls_have_their_radius_at_any_opacity() {
    /// Largest difference of radii, in voxels.
    const TOLERANCE: f64 = 0.2;
    const RADIUS: f64 = 12.0;
    let volume = by_position([32; 3], DVec3::ONE, |p| u8::from(p.length() < RADIUS));
    let half_height = volume.grid().diagonal() / 2.0;
    let mut radii = Vec::new();
    for opacity in [1.0, 0.1, 0.01] {
        let frame = pictured(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], LabelSurfaces::Smooth, (30.0, 20.0));
        let profiles = profiles(&frame, half_height);
        // A ray at the distance r from the centre passes through 2 √(R² − r²); where this is the share s of 2 R, R is r / √(1 − s²).
        let share = 0.2;
        let level = 1.0 - (1.0f64 - opacity.min(0.99999)).powf(2.0 * RADIUS * share);
        let (level, factor) = if opacity == 1.0 { (0.5, 1.0) } else { (level, 1.0 / (1.0 - share * share).sqrt()) };
        let (mean, deviation, _) = silhouette(&profiles, level);
        println!("opacity {opacity}: radius {:.3}, standard deviation {deviation:.3} voxels", mean * factor);
        radii.push(mean * factor);
    }
    assert!(radii.iter().all(|radius| (radius - RADIUS).abs() <= TOLERANCE), "{radii:?}");
}

/// Balls of thick slices end where those of cubes do.
#[test]
fn balls_of_thick_slices_have_their_radius() {
    /// Largest difference of the radius along any direction in the picture, in world units.
    const TOLERANCE: f64 = 0.5;
    const RADIUS: f64 = 10.0;
    let volume = by_position([56, 56, 14], DVec3::new(0.5, 0.5, 2.0), |p| u8::from(p.length() < RADIUS));
    for opacity in [1.0, 0.1] {
        let frame = pictured(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], LabelSurfaces::Smooth, (0.0, 90.0));
        assert!(largest_opacity(&frame) > 0.9);
        // Along z of the volume: right and left from azimuth 90.
        let frame = pictured(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], LabelSurfaces::Smooth, (90.0, 0.0));
        let level = if opacity == 1.0 { 0.5 } else { 0.2 };
        let (mean, deviation, radii) = silhouette(&profiles(&frame, volume.grid().diagonal() / 2.0), level);
        println!(
            "opacity {opacity}: along z {:.2}, along y {:.2}, mean {mean:.2}, deviation {deviation:.2}",
            radii[0], radii[90]
        );
        assert!([0, 90, 180, 270].iter().all(|&n| (radii[n] - RADIUS).abs() <= TOLERANCE), "{radii:?}");
    }
}

/// The silhouette of a ball is rounder than that of its voxels.
#[test]
fn silhouettes_of_smooth_labels_are_round() {
    /// Largest standard deviation of the silhouette's radius, in voxels.
    const LARGEST: f64 = 0.1;
    let volume = by_position([32; 3], DVec3::ONE, |p| u8::from(p.length() < 12.0));
    let roughness = |surfaces| {
        let frame = pictured(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, 1.0]], surfaces, (30.0, 20.0));
        let (mean, deviation, _) = silhouette(&profiles(&frame, volume.grid().diagonal() / 2.0), 0.5);
        println!("{surfaces:?}: radius {mean:.2}, standard deviation {deviation:.3} voxels");
        deviation
    };
    let [rough, stairs] = [LabelSurfaces::Smooth, LabelSurfaces::Voxels].map(roughness);
    assert!(rough <= LARGEST && stairs > 1.5 * rough, "{rough}, {stairs}");
}

/// Plates keep their thickness: the optical depth through them is that of a voxel. Rods and single voxels are round, and stay.
#[test]
fn labels_of_one_voxel_stay() {
    /// Least and largest thickness of plates, rods and voxels, between pixels of half a voxel.
    const THICKNESSES: [(&str, [f64; 2]); 3] = [("plate", [0.9, 1.1]), ("rod", [0.6, 1.1]), ("voxel", [0.4, 1.1])];
    let opacity = 0.3f64;
    let one_voxel = -(1.0 - opacity).ln();
    for (thin, (name, [least, largest])) in (1..).zip(THICKNESSES) {
        let volume = by_position([15; 3], DVec3::ONE, |p| u8::from((3 - thin..3).all(|axis| p[axis] == 0.0)));
        let frame = drawn(&of_labels(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], LabelSurfaces::Smooth), &unlit(), 0.0, 0.0);
        let thickness = -(1.0 - f64::from(largest_opacity(&frame))).ln() / one_voxel;
        println!("{name}: {thickness:.3} voxels thick");
        assert!((least..=largest).contains(&thickness), "{name}: {thickness}");
    }
}

/// An opaque ball in a translucent one, against the exact integral, and without a dark ring where it is lit.
#[test]
fn opaque_labels_in_translucent_ones_are_exact() {
    /// Mean difference of red, green and blue, unlit, over all pixels of both balls.
    const TOLERANCE: f64 = 0.012;
    /// Least share of the unlit green that is left beside the opaque ball.
    const LEAST_LIT: f64 = 0.85;
    let (outer, inner, opacity) = (18.0f64, 8.0f64, 0.03f64);
    let entries = [[0.0; 4], [0.2, 0.8, 0.4, opacity], [0.8, 0.2, 0.1, 1.0]];
    let volume = by_position([42; 3], DVec3::ONE, |p| u8::from(p.length() < outer) + u8::from(p.length() < inner));
    let colors = of_labels(&volume, &entries, LabelSurfaces::Smooth);
    let camera = camera(volume.grid(), (SIZE, SIZE), 30.0, 20.0);
    let picture = |shading| {
        let settings = Settings { shading, ..Quality::Standard.settings() };
        Renderer::from_colors(&colors).unwrap().render(&camera, viewport(SIZE, SIZE), &settings).unwrap().0
    };
    let (unlit, lit) = (picture(None), picture(Quality::Standard.settings().shading));
    let per_unit = f64::from(SIZE) / volume.grid().diagonal();
    let middle = f64::from(SIZE - 1) / 2.0;
    let (mut differences, mut pixels, mut least) = (0.0, 0.0, 1.0f64);
    for (n, pixel) in unlit.pixels().iter().enumerate() {
        let [x, y] = [n % SIZE as usize, n / SIZE as usize].map(|n| (n as f64 - middle) / per_unit);
        let r = x.hypot(y);
        if r > outer {
            continue;
        }
        let chord = |radius: f64| (radius * radius - r * r).max(0.0).sqrt();
        let passed = if r < inner { chord(outer) - chord(inner) } else { 2.0 * chord(outer) };
        let left = (1.0 - opacity).powf(passed);
        for c in 0..3 {
            let behind = if r < inner { entries[2][c] } else { 0.0 };
            let exact = (1.0 - left) * entries[1][c] + left * behind;
            differences += (f64::from(pixel[c]) - exact).abs() / 3.0;
        }
        pixels += 1.0;
        if (inner + 1.5..inner + 5.0).contains(&r) {
            least = least.min(f64::from(lit.pixels()[n][1]) / f64::from(pixel[1]));
        }
    }
    let difference = differences / pixels;
    println!("mean difference {difference:.4}, lit green beside the opaque ball at least {least:.3} of the unlit");
    assert!(difference <= TOLERANCE, "{difference}");
    assert!(least >= LEAST_LIT, "{least}");
}

/// Where labels of two layers overlap, extinctions add, and the surface of each is where it is alone.
#[test]
fn overlapping_layers_add() {
    /// Of the opacity of a ray.
    const TOLERANCE: f64 = 5e-3;
    let slab = |thickness: f64| by_position([20; 3], DVec3::ONE, |p| u8::from(p.z.abs() < thickness / 2.0));
    let entries = |opacity| vec![[0.0; 4], [1.0, 0.5, 0.0, opacity]];
    let layers = [(slab(10.0), entries(0.1f64)), (slab(4.0), entries(0.3))];
    let uploaded =
        layers.each_ref().map(|(volume, entries)| (UploadedVolume::new(&device(), volume).unwrap(), entries.as_slice()));
    let colors =
        UploadedColors::from_labels(&uploaded.each_ref().map(|(volume, entries)| (volume, *entries)), LabelSurfaces::Smooth)
            .unwrap();
    let pixel = drawn(&colors, &unlit(), 0.0, 0.0).pixels()[28 * 64 + 32];
    let exact = 1.0 - 0.9f64.powi(10) * 0.7f64.powi(4);
    println!("{:.4}, {exact:.4}", pixel[3]);
    assert!((f64::from(pixel[3]) - exact).abs() <= TOLERANCE, "{} {exact}", pixel[3]);
}
