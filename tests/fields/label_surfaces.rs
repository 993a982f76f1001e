//! Surfaces of labels: the definition of smooth ones in f64, the extinction through a plane, and silhouettes.

use crate::common::{device, largest_opacity, parallel, viewport};
use glam::DVec3;
use layersplat::renderer::{ColorOpacity, UploadedColors, UploadedVolume};
use layersplat::volume::{Grid, LabelSurfaces};
use layersplat::{Frame, GradientEstimator, Quality, Renderer, Settings, TransferFunction, Volume};
use std::collections::BTreeMap;

/// Colours and opacities of the labels 0 to 4; label 4 is hidden.
const ENTRIES: [[f64; 4]; 5] = [[0.0; 4], [0.9, 0.1, 0.2, 0.9], [0.1, 0.8, 0.3, 0.3], [0.2, 0.3, 1.0, 0.6], [1.0, 1.0, 0.0, 0.0]];

/// Smooth labels by their definition: red, green, blue and opacity of each voxel.
fn smoothed(dims: [usize; 3], labels: &[u8]) -> Vec<[f64; 4]> {
    let at = |p: [i64; 3]| {
        let [x, y, z] = std::array::from_fn(|a| p[a].clamp(0, dims[a] as i64 - 1) as usize);
        labels[(z * dims[1] + y) * dims[0] + x]
    };
    let entry = |label: u8| ENTRIES[usize::from(label)];
    let of_voxel = |n: usize| {
        let centre = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|c| c as i64);
        let mut weights = BTreeMap::<u8, f64>::new();
        for d in (0..27).map(|n: i64| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]) {
            let weight: i64 = d.iter().map(|d| 2 - d.abs()).product();
            *weights.entry(at(std::array::from_fn(|a| centre[a] + d[a]))).or_default() += weight as f64 / 64.0;
        }
        let share = |label: u8, weight: f64| {
            let share = ((weight - 10.0 / 64.0) / (44.0 / 64.0)).clamp(0.0, 1.0);
            if label == at(centre) && entry(label)[3] > 0.0 { share.max(0.9) } else { share }
        };
        let shares: f64 = weights.iter().map(|(&label, &weight)| share(label, weight)).sum();
        if shares == 0.0 {
            return entry(at(centre));
        }
        let mean = |of: &dyn Fn([f64; 4]) -> f64| {
            weights.iter().map(|(&label, &weight)| share(label, weight) * of(entry(label))).sum::<f64>() / shares
        };
        let opacity = mean(&|entry| entry[3]);
        let color = |c: usize| if opacity > 0.0 { mean(&|entry| entry[c] * entry[3]) / opacity } else { 0.0 };
        [color(0), color(1), color(2), opacity]
    };
    (0..labels.len()).map(of_voxel).collect()
}

/// Colours of these components.
fn of_components(dims: [usize; 3], voxels: &[[f64; 4]]) -> UploadedColors {
    let component = |c: usize| {
        let values: Vec<f32> = voxels.iter().map(|voxel| voxel[c] as f32).collect();
        Volume::new("component", Grid::new(dims, DVec3::ONE).unwrap(), values).unwrap()
    };
    let unused = TransferFunction::new("unused", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (1.0, 1.0)]).unwrap();
    UploadedColors::new(&device(), &[0, 1, 2, 3].map(component), ColorOpacity::Alpha, &unused).unwrap()
}

fn of_labels(volume: &Volume, entries: &[[f64; 4]], surfaces: LabelSurfaces) -> UploadedColors {
    UploadedColors::from_labels(&[(&UploadedVolume::new(&device(), volume).unwrap(), entries)], surfaces).unwrap()
}

fn drawn(colors: &UploadedColors, settings: &Settings, azimuth: f64, elevation: f64) -> Frame {
    let size = viewport(64, 56);
    let grid = colors.description().grid();
    let orbit = layersplat::Orbit { azimuth, elevation, roll: 0.0 };
    let camera = layersplat::Camera::fit_parallel(grid.centre(), grid.diagonal(), size, orbit);
    Renderer::from_colors(colors).unwrap().render(&camera, size, settings).unwrap().0
}

fn apart(one: &Frame, other: &Frame) -> f32 {
    let pairs = one.pixels().iter().zip(other.pixels());
    pairs.flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max)
}

/// Every voxel has one of five labels by chance, so that many meet, and those at the ends of the volume, too.
#[test]
fn smooth_surfaces_have_their_definition() {
    /// Opacities of 4 bytes have extinctions to 1e-6, and a ray crosses some ten voxels.
    const TOLERANCE: f32 = 2e-5;
    for dims in [[13, 11, 12], [1, 9, 8], [9, 1, 1], [1, 1, 1]] {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        // Half of them in blocks, so that flat surroundings occur.
        let mut labels: Vec<u8> = (0..dims.iter().product())
            .map(|n: usize| if (n / 13).is_multiple_of(2) { next() % 5 } else { 1 + (n / 40 % 3) as u8 })
            .collect();
        labels[0] = 1;
        let volume = Volume::new("labels", Grid::new(dims, DVec3::ONE).unwrap(), labels.clone()).unwrap();
        let lit = Settings { gradient: Some(GradientEstimator::Gaussian(1.5)), ..Settings::default() };
        let defined = drawn(&of_components(dims, &smoothed(dims, &labels)), &lit, 25.0, 20.0);
        let smooth = drawn(&of_labels(&volume, &ENTRIES, LabelSurfaces::Smooth), &Settings::default(), 25.0, 20.0);
        println!("{dims:?}: {:.1e} apart", apart(&smooth, &defined));
        assert!(largest_opacity(&smooth) > 0.2, "{dims:?}: something is seen");
        assert!(apart(&smooth, &defined) <= TOLERANCE, "{dims:?}: {}", apart(&smooth, &defined));
        // Voxels as they are would be noticed where labels meet.
        let voxels = drawn(&of_labels(&volume, &ENTRIES, LabelSurfaces::Voxels), &lit, 25.0, 20.0);
        assert!(dims == [1; 3] || apart(&voxels, &defined) > 0.02, "{dims:?}");
    }
}

/// Beer-Lambert through a slab: voxels have its opacity, the first within a smooth one 38 shares beside 6 of the background, raised to 0.9 of
/// all, and the last without 6 beside 38.
#[test]
fn slabs_have_their_closed_form() {
    /// Of the colour of a ray with 8 voxels, pre-integrated in segments.
    const TOLERANCE: f64 = 1e-3;
    let (dims, opacity) = ([20; 3], 0.2f64);
    let smooth_surface = (1.0 - 6.0 / 44.0 * opacity) * (1.0 - 0.9 / (0.9 + 6.0 / 44.0) * opacity);
    let transmittances = [(LabelSurfaces::Smooth, smooth_surface.powi(2)), (LabelSurfaces::Voxels, (1.0 - opacity).powi(2))];
    for (axis, azimuth, elevation) in [(0, 90.0, 0.0), (1, 0.0, 90.0), (2, 0.0, 0.0)] {
        let within = |n: usize| (6..14).contains(&([n % 20, n / 20 % 20, n / 400][axis]));
        let labels: Vec<u8> = (0..8000).map(|n| u8::from(within(n))).collect();
        let volume = Volume::new("slab", Grid::new(dims, DVec3::ONE).unwrap(), labels).unwrap();
        let unlit = Settings { shading: None, ..Settings::default() };
        for (surfaces, transmittance) in transmittances {
            let exact = 1.0 - transmittance * (1.0f64 - opacity).powi(6);
            let colors = of_labels(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, opacity]], surfaces);
            let frame = drawn(&colors, &unlit, azimuth, elevation);
            let pixel = frame.pixels()[28 * 64 + 32].map(f64::from);
            println!("axis {axis}, {surfaces:?}: {pixel:.4?}, {exact:.4}");
            assert!(
                (pixel[3] - exact).abs() <= TOLERANCE && (pixel[0] - exact).abs() <= TOLERANCE,
                "{axis}, {surfaces:?}: {pixel:?}"
            );
            assert!((pixel[3] - (1.0 - (1.0f64 - opacity).powi(7))).abs() > TOLERANCE, "another thickness would be noticed");
        }
    }
}

/// The silhouette of a ball is rounder than that of its voxels.
#[test]
fn silhouettes_of_smooth_labels_are_round() {
    /// Largest standard deviation of the silhouette's radius, in voxels.
    const LARGEST: f64 = 0.1;
    const SIZE: u32 = 320;
    let n = 32;
    let centre = DVec3::splat(15.5);
    let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
    let labels: Vec<u8> = (0..n * n * n).map(|i| u8::from(at(i).distance(centre) < 12.0)).collect();
    let volume = Volume::new("ball", Grid::new([n; 3], DVec3::ONE).unwrap(), labels).unwrap();
    let size = viewport(SIZE, SIZE);
    let camera = parallel(&volume, size, 30.0, 20.0);
    let roughness = |surfaces| {
        let colors = of_labels(&volume, &[[0.0; 4], [1.0, 0.5, 0.0, 1.0]], surfaces);
        let settings = Settings { shading: None, ..Quality::Standard.settings() };
        let frame = Renderer::from_colors(&colors).unwrap().render(&camera, size, &settings).unwrap().0;
        let middle = f64::from(SIZE - 1) / 2.0;
        let per_voxel = f64::from(SIZE) / volume.grid().diagonal();
        let radius = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let opaque = |r: f64| {
                frame.pixels()[((middle + r * s).round() * f64::from(SIZE) + (middle + r * c).round()) as usize][3] > 0.5
            };
            (0..).map(|k| f64::from(k) * 0.1).find(|&r| !opaque(r)).unwrap() / per_voxel
        };
        let radii: Vec<f64> = (0..720).map(|k| radius(f64::from(k).to_radians() / 2.0)).collect();
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        let deviation = (radii.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / radii.len() as f64).sqrt();
        println!("{surfaces:?}: radius {mean:.2}, standard deviation {deviation:.3} voxels");
        (mean, deviation)
    };
    let [(smooth, rough), (voxels, stairs)] = [LabelSurfaces::Smooth, LabelSurfaces::Voxels].map(roughness);
    assert!(rough <= LARGEST && stairs > 1.5 * rough, "{rough}, {stairs}");
    // Not larger than the voxels.
    assert!(smooth <= voxels + 0.5 && smooth >= 11.5, "{smooth}, {voxels}");
}
