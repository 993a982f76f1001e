//! Lattices whose samples are pixels, where columns of pixels lean: perspectives, and slightly rolled parallel views.

use crate::common::blends::{composited, crop};
use crate::common::*;
use glam::DVec3;
use layersplat::device::{DeviceKind, LatticeSchedule, Tuning};
use layersplat::layers::{Density, Kernel, Rays};
use layersplat::renderer::Plan;
use layersplat::settings::{Blend, Classification, Clipping, Evaluation, Layered};
use layersplat::volume::Voxels;
use layersplat::{Camera, Device, Frame, Orbit, Projection, Renderer, Settings, TransferFunction, Volume};

const SIDES: (u32, u32) = (118, 109);
const DIMS: [usize; 3] = [47, 52, 44];

/// Views whose columns lean by up to 0.2 in perspectives, and by 0.1 in parallel views, along each layer axis.
fn cameras(volume: &Volume) -> Vec<Camera> {
    let size = viewport(SIDES.0, SIDES.1);
    let at = |orbit: Orbit, projection| Camera::orbit(volume.grid().centre(), 150.0, orbit, projection);
    let orbit = |azimuth, elevation, roll| Orbit { azimuth, elevation, roll };
    let rolled = |orbit| Camera::fit_parallel(volume.grid().centre(), 0.85 * volume.grid().diagonal(), size, orbit);
    let perspective = Projection::Perspective { field_of_view: 28.0 };
    let cameras = vec![
        at(orbit(72.0, 20.0, 0.0), perspective),
        at(orbit(200.0, -15.0, 92.0), perspective),
        at(orbit(6.0, 62.0, 0.0), perspective),
        rolled(orbit(25.0, 15.0, 5.0)),
        rolled(orbit(100.0, -20.0, -87.0)),
    ];
    for camera in &cameras {
        assert!(is_sampled_at_pixels(camera, volume), "{camera:?}");
    }
    cameras
}

/// Whether the samples of a view are its pixels, and columns of pixels lean: three rays of a column of pixels have different u.
fn is_sampled_at_pixels(camera: &Camera, volume: &Volume) -> bool {
    let size = viewport(SIDES.0, SIDES.1);
    let rays = Rays::new(camera, size, volume.grid()).unwrap();
    let Plan::Lattice(lattice, _) = Plan::new(&rays, size, volume.grid(), &Settings::default()).unwrap() else { return false };
    lattice.pixel_rays.is_some()
}

fn render_on(device: &Device, volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) -> Frame {
    let size = viewport(SIDES.0, SIDES.1);
    Renderer::new(device, volume, transfer).unwrap().render(camera, size, settings).unwrap().0
}

fn direct(settings: Settings) -> Settings {
    Settings { algorithm: Layered { evaluation: Evaluation::Direct, ..layered(settings) }.into(), ..settings }
}

fn with(kernel: Kernel, shaded: bool, clipping: Clipping) -> Settings {
    let classification = Classification::Preintegrated { kernel, samples_per_layer: 1 };
    let layered = Layered { classification, evaluation: Evaluation::Lattice(Density::Relaxed), ..Layered::default() };
    let settings = composited(layered.into(), clipping);
    if shaded { settings } else { Settings { shading: None, ..settings } }
}

/// Values that change linearly along all three axes.
fn ramp() -> Volume<'static> {
    let mut values = Vec::new();
    for (k, j, i) in (0..DIMS[2]).flat_map(|k| (0..DIMS[1]).flat_map(move |j| (0..DIMS[0]).map(move |i| (k, j, i)))) {
        values.push(0.9 * i as f32 + 1.3 * j as f32 - 0.7 * k as f32);
    }
    volume(DIMS, DVec3::new(1.0, 0.95, 1.05), Voxels::Float32(values))
}

fn bands() -> TransferFunction {
    let colors = vec![(-30.0, [0.1, 0.3, 0.9]), (20.0, [0.9, 0.2, 0.1]), (90.0, [1.0, 0.9, 0.5])];
    TransferFunction::new("bands", colors, vec![(-30.0, 0.02), (20.0, 0.15), (40.0, 0.0), (60.0, 0.1), (110.0, 0.02)]).unwrap()
}

/// Interpolation along leaning columns is exact for linear fields if the kernel is. What remains are positions in f32.
const LINEAR: f64 = 1e-3;

/// Voxels at the edges, where kernels reach the background, are cut off.
fn inside() -> Clipping {
    crop([3.0; 3], DIMS.map(|n| n as f64 - 4.0))
}

#[test]
fn linear_fields_are_sampled_as_they_are() {
    let (volume, transfer) = (ramp(), bands());
    for camera in cameras(&volume) {
        for (kernel, shaded) in [(Kernel::Linear, true), (Kernel::CatmullRom, false), (Kernel::BSpline, true)] {
            let settings = with(kernel, shaded, inside());
            let [found, expected] = [settings, direct(settings)].map(|s| render_on(&device(), &volume, &transfer, &camera, &s));
            assert!(largest_opacity(&expected) > 0.5);
            let what = format!("{kernel:?}, shading {shaded}, {camera:?}");
            assert_close(&what, &found, &expected, LINEAR);
            let turned = Camera { position: camera.position + DVec3::new(0.3, 0.2, 0.4), ..camera };
            let turned = render_on(&device(), &volume, &transfer, &turned, &settings);
            assert!(compare(&turned, &expected).max_difference > 3.0 * LINEAR, "a turn by a fifth of a degree must be noticed");
        }
    }
}

/// Noise compared with one ray per pixel, in dB, 1 dB below the measured one. Leaning columns are interpolated along their own direction.
const LEAST_OF_NOISE: f64 = 45.0;

#[test]
fn noise_comes_close_to_rays_per_pixel() {
    let volume = random_volume(DIMS, DVec3::new(1.0, 0.95, 1.05), 3);
    for camera in cameras(&volume) {
        for shaded in [true, false] {
            let settings = with(Kernel::Cubic, shaded, Clipping::default());
            let [found, expected] =
                [settings, direct(settings)].map(|s| render_on(&device(), &volume, &smooth_transfer(), &camera, &s));
            let [psnr, shifted] = [&found, &shifted_by_half_a_pixel(&found)].map(|f| compare(f, &expected).psnr_rgba.unwrap());
            assert!(psnr > LEAST_OF_NOISE && psnr > shifted + 10.0, "{psnr} dB, shifted {shifted} dB: {shaded} {camera:?}");
        }
    }
}

/// Sums of floats in another order, and values that round to another entry of the table.
const OTHER_WIDTH: f64 = 1e-3;

/// Tiles of all widths and heights divide the pixels differently. Work-items per sample have no columns: they interpolate along the axes, as one
/// ray per pixel does.
#[test]
fn every_width_draws_the_same() {
    let volume = random_volume(DIMS, DVec3::new(1.0, 0.95, 1.05), 5);
    let device = device();
    let own = *device.tuning();
    let widths = [(16, 16), (8, 5), (4, 30), (1, 1)];
    let tiles = |(vector_width, point_tile_rows)| Tuning {
        vector_width,
        point_tile_rows,
        lattice_schedule: LatticeSchedule::Tiles,
        ..own
    };
    let tunings = widths.map(tiles);
    let gpu = Tuning::new(DeviceKind::Gpu, "", 1, 4);
    let settings = with(Kernel::Cubic, true, Clipping::default());
    for camera in cameras(&volume) {
        let expected = render_on(&device.with_tuning(tunings[0]).unwrap(), &volume, &smooth_transfer(), &camera, &settings);
        assert!(largest_opacity(&expected) > 0.5);
        let per_pixel = render_on(&device, &volume, &smooth_transfer(), &camera, &direct(settings));
        for tuning in tunings.into_iter().chain([gpu]) {
            let found = render_on(&device.with_tuning(tuning).unwrap(), &volume, &smooth_transfer(), &camera, &settings);
            let expected = if tuning.lattice_schedule == LatticeSchedule::Tiles { &expected } else { &per_pixel };
            assert_close(&format!("{tuning:?}, {camera:?}"), &found, expected, OTHER_WIDTH);
        }
    }
}

#[test]
fn culling_changes_no_bit() {
    let volume = random_volume(DIMS, DVec3::new(1.0, 0.95, 1.05), 7);
    let steep = step_transfer(150.0, 0.6);
    for camera in cameras(&volume) {
        for blend in [Blend::Composite, Blend::Maximum, Blend::Iso(130.0)] {
            let settings = Settings { blend, ..with(Kernel::Cubic, true, Clipping::default()) };
            let [culled, all] =
                [true, false].map(|culling| render_on(&device(), &volume, &steep, &camera, &Settings { culling, ..settings }));
            assert!(largest_opacity(&all) > 0.1, "{blend:?}, {camera:?}");
            let apart = pixels_apart(&culled, &all, 0.0);
            assert!(apart == 0, "{apart} pixels differ: {blend:?}, {camera:?}");
        }
    }
}

/// Every pixel has the sample of its own ray, also beside tiles without any. Oblique columns of a wide tile begin at rows far apart.
#[test]
fn samples_are_those_of_the_pixels() {
    let device = device();
    let wide =
        device.with_tuning(Tuning { vector_width: 16, lattice_schedule: LatticeSchedule::Tiles, ..*device.tuning() }).unwrap();
    let noise = random_volume(DIMS, DVec3::new(1.0, 0.95, 1.05), 9);
    for camera in cameras(&noise) {
        assert_samples_of_pixels(&wide, &noise, &camera, SIDES, 1000);
    }
    let dims = [120, 130, 110];
    let mut scattered = vec![0; dims.iter().product()];
    scattered.iter_mut().step_by(19_997).for_each(|voxel| *voxel = 230);
    let scattered = volume(dims, DVec3::ONE, Voxels::Uint8(scattered));
    for azimuth in [-42.0, 42.0] {
        let oblique = Orbit { azimuth, elevation: 30.0, roll: 0.0 };
        let camera = Camera::orbit(scattered.grid().centre(), 420.0, oblique, Projection::Perspective { field_of_view: 28.0 });
        assert_samples_of_pixels(&wide, &scattered, &camera, (270, 250), 100);
    }
}

fn assert_samples_of_pixels(device: &Device, volume: &Volume, camera: &Camera, sides: (u32, u32), least: usize) {
    let size = viewport(sides.0, sides.1);
    let settings = with(Kernel::Cubic, false, Clipping::default());
    let mut renderer = Renderer::new(device, volume, &smooth_transfer()).unwrap();
    let lattice = renderer.lattice_picture(camera, size, &settings).unwrap().expect("a lattice");
    let (frame, _) = renderer.render(camera, size, &settings).unwrap();
    let rays = Rays::new(camera, size, volume.grid()).unwrap();
    let mut found = 0;
    for (sample, n) in lattice.samples.iter().zip(0..) {
        let place = pixel_of(&rays, &lattice.ray(n % lattice.size[0], n / lattice.size[0]));
        assert!(place.iter().all(|at| (at.rem_euclid(1.0) - 0.5).abs() < 1e-6), "{place:?}");
        let [x, y] = place.map(|at| at.floor() as i64);
        let pixel = frame.pixels()[(y * i64::from(size.width) + x) as usize];
        assert_eq!(pixel, *sample, "{x} {y}: {camera:?}");
        found += usize::from(sample[3] > 0.0);
    }
    assert!(found > least && found == frame.pixels().iter().filter(|pixel| pixel[3] > 0.0).count(), "{found}");
}
