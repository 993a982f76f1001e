//! Light volumes of media whose shadows are known.

mod energy;

use crate::camera::{Camera, Orbit};
use crate::device::{Device, LatticeSchedule, Tuning};
use crate::layers::{GradientEstimator, Kernel};
use crate::renderer::Renderer;
use crate::renderer::frame::{Declaring, Output, Stage};
use crate::settings::{
    Algorithm, AmbientOcclusion, Blend, Clipping, CropBox, GradientOpacity, Light, LightGrid, Lights, Look, Settings, Shading,
    Shadows,
};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume, Voxels};
use glam::DVec3;

/// Difference of the transmittance from closed forms: a step of 1/255 to store it, and the curvature of the field between voxels.
const TOLERANCE: f64 = 0.01;
pub(super) const SIZE: Viewport = Viewport { width: 16, height: 16 };

/// A volume of bytes, 0 or 200.
pub(super) fn volume(dims: [usize; 3], spacing: DVec3, is_dense: impl Fn(DVec3) -> bool) -> Volume<'static> {
    let [x, y, _] = dims;
    let place = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64);
    let voxels = (0..dims.iter().product()).map(|n| if is_dense(place(n)) { 200 } else { 0 }).collect();
    Volume::new("dense", Grid::new(dims, spacing).unwrap(), Voxels::Uint8(voxels)).unwrap()
}

/// Opacity from half the dense value on.
pub(super) fn transfer(opacity: f64) -> TransferFunction {
    TransferFunction::new("step", vec![(0.0, [1.0; 3])], vec![(99.99, 0.0), (100.01, opacity)]).unwrap()
}

/// Settings with the exact shadow of one light.
pub(super) fn shadow_of(light: Light) -> Settings {
    let shading = Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() });
    Settings { shading, shadows: Some(Shadows { forgiveness: 1.0, ..Shadows::default() }), ..Settings::default() }
}

/// The values of a light volume.
pub(super) struct Light3 {
    pub bytes: Vec<u8>,
    outer: [usize; 3],
    /// Whether values are codes of light.
    coded: bool,
}

impl Light3 {
    /// The light at a voxel, from -1 on.
    fn at(&self, [x, y, z]: [i64; 3]) -> f64 {
        let [nx, ny, _] = self.outer;
        let value = f64::from(self.bytes[((z + 1) as usize * ny + (y + 1) as usize) * nx + (x + 1) as usize]) / 255.0;
        if self.coded { 510f64.powf(-(1.0 - value).powi(2)) } else { value }
    }

    /// The light between voxels, linear along x.
    fn between(&self, x: f64, y: i64, z: i64) -> f64 {
        let i = x.floor();
        let [low, high] = [0, 1].map(|n| self.at([i as i64 + n, y, z]));
        low + (x - i) * (high - low)
    }
}

pub(super) fn light_of(volume: &Volume, transfer: &TransferFunction, settings: &Settings) -> Light3 {
    light_on(&Device::shared(), volume, transfer, settings)
}

fn light_on(device: &Device, volume: &Volume, transfer: &TransferFunction, settings: &Settings) -> Light3 {
    let grid = volume.grid();
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 33.0, elevation: 5.0, roll: 0.0 });
    let mut renderer = Renderer::new(device, volume, transfer).unwrap();
    let planned = renderer.planned(&camera, SIZE, settings).unwrap();
    let light = renderer.engine.illumination(&planned.rays, SIZE, &planned.settings).unwrap();
    let coded = light.lights.is_some();
    let buffer = light.lights.or(light.sky).expect("light is swept");
    let mut bytes = vec![0; buffer.len()];
    buffer.read(device, &mut bytes).unwrap();
    let voxels = settings.light_grid.voxels();
    Light3 { bytes, outer: grid.dims().map(|n| n.div_ceil(voxels) + 2), coded }
}

/// A slab across z, seen by lights along and oblique to all axes: e^(-kappa d).
#[test]
fn slabs_dim_light_by_their_optical_depth() {
    for (axis, to_light) in
        [(2, DVec3::Z), (2, DVec3::new(0.3, -0.4, 1.0)), (1, DVec3::new(0.2, -1.0, 0.5)), (0, DVec3::new(1.0, 0.2, -0.3))]
    {
        let spacing = DVec3::new(1.0, 1.5, 1.2);
        let slab = volume([40; 3], spacing, |p| (10.0..=29.0).contains(&p[axis]));
        let light = light_of(&slab, &transfer(0.05), &shadow_of(Light::towards(to_light)));
        let kappa = -(1.0f64 - 0.05).ln();
        let towards = to_light.normalize();
        println!(
            "{to_light}: {:?}",
            (0..40)
                .map(|k| {
                    let mut q = [20; 3];
                    q[axis] = k;
                    (-light.at(q).ln() / kappa * towards[axis].abs() / spacing[axis] * 100.0).round() / 100.0
                })
                .collect::<Vec<_>>()
        );
        for k in [5, 12, 20, 28, 35] {
            let mut place = [20; 3];
            place[axis] = k;
            let behind = if towards[axis] > 0.0 { 29.5 - k as f64 } else { k as f64 - 9.5 };
            let depth = behind.clamp(0.0, 20.0) * spacing[axis] / towards[axis].abs();
            let (found, expected) = (light.at(place), (-kappa * depth).exp());
            assert!((found - expected).abs() < TOLERANCE, "{to_light} at {place:?}: {found}, not {expected}");
        }
    }
}

/// The shadow of a sphere, exp(-2 kappa sqrt(r^2 - b^2)), and where its centre lies.
#[test]
fn spheres_cast_round_shadows() {
    let (centre, radius, kappa) = (DVec3::new(28.0, 28.0, 40.0), 12.0, -(0.97f64).ln());
    let sphere = |p: DVec3| p.distance(centre) - radius;
    let dims = [57, 57, 60];
    let place = |n: usize| DVec3::new((n % 57) as f64, (n / 57 % 57) as f64, (n / (57 * 57)) as f64);
    // A soft edge places the surface between voxels.
    let voxels = (0..dims.iter().product()).map(|n| (100.0 - 60.0 * sphere(place(n))).clamp(0.0, 200.0).round() as u8).collect();
    let volume = Volume::new("sphere", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Uint8(voxels)).unwrap();
    let to_light = DVec3::new(0.25, 0.0, 1.0);
    // Opacity rises over the two voxels of the edge, so that samples one layer apart integrate it.
    let ramp = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], vec![(40.0, 0.0), (160.0, 0.03)]).unwrap();
    let light = light_of(&volume, &ramp, &shadow_of(Light::towards(to_light)));
    let towards = to_light.normalize();
    // On a row behind the sphere.
    let z = 8;
    let (mut weight, mut moment) = (0.0, 0.0);
    for x in 0..57 {
        let p = DVec3::new(x as f64, 28.0, z as f64) - centre;
        let beside = (p - towards * p.dot(towards)).length();
        let expected = (-2.0 * kappa * (radius * radius - beside * beside).max(0.0).sqrt()).exp();
        let found = light.at([x, 28, z]);
        // At the edge the closed form has infinite slope.
        let tolerance = if (beside - radius).abs() < 1.5 { 0.06 } else { TOLERANCE };
        assert!((found - expected).abs() < tolerance, "at x = {x}: {found}, not {expected}");
        (weight, moment) = (weight + 1.0 - found, moment + (1.0 - found) * x as f64);
    }
    let expected = centre.x + (8.0 - centre.z) * 0.25;
    let found = moment / weight;
    assert!((found - expected).abs() < 0.05, "the shadow's centre is at {found}, not {expected}");
}

/// The shadow of a knife edge stays as sharp as it begins.
#[test]
fn shadows_stay_sharp() {
    let edge = volume([140, 110, 250], DVec3::ONE, |p| p.z > 246.0 && p.x < 110.0);
    let to_light = DVec3::new(0.37, 0.21, 1.0);
    let light = light_of(&edge, &transfer(1.0), &shadow_of(Light::towards(to_light)));
    let width = |z: i64| {
        let start = 110.0 - 0.37 * (246 - z) as f64 - 8.0;
        let crossing =
            |level: f64| (0..1600).map(|n| start + 0.01 * f64::from(n)).find(|&x| light.between(x, 20, z) > level).unwrap();
        crossing(0.9) - crossing(0.1)
    };
    // The mean over ten layers, since the width depends on where rays lie between the voxels of a layer.
    let widths = [232, 202, 162, 3].map(|z| (z..z + 10).map(width).collect::<Vec<_>>());
    let means = widths.each_ref().map(|widths| widths.iter().sum::<f64>() / 10.0);
    let widest = widths.iter().flatten().copied().fold(0.0, f64::max);
    println!("10-90 % width of a knife edge's shadow after 9, 39, 79, 238 layers: {means:.2?}, widest {widest:.2}");
    assert!(widest < 1.8, "{widest}");
    assert!(means[3] < means[0] + 0.2, "{means:?}");
}

#[test]
fn culling_changes_no_bit() {
    let blobs = volume([50, 41, 37], DVec3::new(1.0, 1.3, 0.8), |p| (p * 0.31).sin().element_sum() > 2.1);
    for to_light in [DVec3::new(0.3, 0.2, -1.0), DVec3::new(-1.0, 0.4, 0.3), DVec3::new(0.1, 1.0, 0.6)] {
        for blend in [Blend::Composite, Blend::Iso(100.0)] {
            let settings = Settings { blend, ..shadow_of(Light::towards(to_light)) };
            let [with, without] =
                [true, false].map(|culling| light_of(&blobs, &transfer(0.3), &Settings { culling, ..settings }).bytes);
            let values = with.len() - super::PADDING;
            assert!(with[..values] == without[..values], "{to_light}, {blend:?}");
            assert!(with[..values].iter().any(|&t| t < 50) && with[..values].contains(&255), "{to_light}, {blend:?}");
        }
    }
}

/// A work-item per ray, and tiles of other sizes, make the same light.
#[test]
fn both_schedules_make_the_same_light() {
    let blobs = volume([50, 41, 37], DVec3::new(1.0, 1.3, 0.8), |p| (p * 0.31).sin().element_sum() > 2.1);
    let own = Device::shared();
    let samples = Tuning { lattice_schedule: LatticeSchedule::Samples, ..*own.tuning() };
    let tunings = [samples, Tuning { vector_width: 4, ..*own.tuning() }];
    let exact = shadow_of(Light::towards(DVec3::new(0.3, 0.2, -1.0)));
    let crop = Some(CropBox { lowest: DVec3::ZERO, highest: DVec3::new(30.0, 29.0, 20.0) });
    let occlusion = Some(AmbientOcclusion { reach: Some(9.0), gain: 1.0 });
    for settings in [
        exact,
        shadow_of(Light::towards(DVec3::new(-1.0, 0.4, 0.3))),
        shadow_of(Light { angle: 20.0, ..Light::towards(DVec3::new(0.1, 1.0, 0.6)) }),
        Settings { blend: Blend::Iso(100.0), ..exact },
        Settings { clipping: Clipping { crop, ..Clipping::default() }, ..exact },
        Settings { gradient_opacity: Some(GradientOpacity::new(&[(1.0, 0.1), (60.0, 1.0)]).unwrap()), ..exact },
        Settings { extinction: Extinction::Linear, ..exact },
        Settings { light_grid: LightGrid::Half, ..exact },
        Settings { shadows: None, ambient_occlusion: occlusion, light_grid: LightGrid::Quarter, ..exact },
        Settings { shadows: None, ambient_occlusion: occlusion, ..exact },
    ] {
        let expected = light_of(&blobs, &transfer(0.3), &settings).bytes;
        let apart = |other: Vec<u8>| {
            let values = other.len() - super::PADDING;
            other.iter().zip(&expected).take(values).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
        };
        for tuning in tunings {
            let steps = apart(light_on(&own.with_tuning(tuning).unwrap(), &blobs, &transfer(0.3), &settings).bytes);
            assert!(steps <= 1, "{settings:?}, {tuning:?}: {steps} steps apart");
        }
        let turned = Settings {
            shading: shadow_of(Light::towards(DVec3::new(-0.2, 1.0, 0.3))).shading,
            unit_distance: Some(0.5),
            ..settings
        };
        let steps = apart(light_of(&blobs, &transfer(0.3), &turned).bytes);
        assert!(steps > 10, "{settings:?}: another light is noticed by {steps} steps");
    }
}

/// What is cut away casts no shadow.
#[test]
fn shadows_follow_cuts() {
    let slab = volume([30; 3], DVec3::ONE, |p| (15.0..=20.0).contains(&p.z));
    let cut = CropBox { lowest: DVec3::ZERO, highest: DVec3::new(15.0, 29.0, 29.0) };
    let clipping = Clipping { crop: Some(cut), ..Clipping::default() };
    for light_grid in [LightGrid::Full, LightGrid::Half] {
        let settings = Settings { clipping, light_grid, ..shadow_of(Light::towards(DVec3::Z)) };
        let light = light_of(&slab, &transfer(0.9), &settings);
        let below = 5 / light_grid.voxels() as i64;
        let [under, beside] = [5, 25].map(|x| light.at([x / light_grid.voxels() as i64, below, below]));
        assert!(under < 0.01 && beside > 0.99, "{light_grid:?}: {under} under the slab, {beside} where it is cut away");
    }
}

/// Coarse volumes hold the same shadow, at their places.
#[test]
fn coarse_volumes_are_near_fine_ones() {
    let slab = volume([48; 3], DVec3::ONE, |p| (16.0..=31.0).contains(&p.z) && p.x > 20.0);
    for to_light in [DVec3::new(0.2, 0.0, 1.0), DVec3::new(0.0, 1.0, 0.4), DVec3::new(1.0, 0.1, 0.3)] {
        let settings = shadow_of(Light::towards(to_light));
        let [full, half] = [LightGrid::Full, LightGrid::Half]
            .map(|light_grid| light_of(&slab, &transfer(0.1), &Settings { light_grid, ..settings }));
        let apart: Vec<f64> = (0..24i64.pow(3))
            .map(|n| {
                let [x, y, z] = [n % 24, n / 24 % 24, n / 576];
                let mean = (0..8).map(|c| full.at([2 * x + (c & 1), 2 * y + (c >> 1 & 1), 2 * z + (c >> 2)])).sum::<f64>() / 8.0;
                (half.at([x, y, z]) - mean).abs()
            })
            .collect();
        let mean = apart.iter().sum::<f64>() / apart.len() as f64;
        assert!(mean < 0.02, "{to_light}: {mean}");
    }
}

/// A recurrence with a limited reach: behind an opaque plane, light comes back as 1 - e^(-d/reach).
#[test]
fn occlusion_of_limited_reach_decreases_with_the_distance() {
    let reach = 8.0;
    let occlusion = Some(AmbientOcclusion { reach: Some(reach), gain: 1.0 });
    let settings = Settings { shadows: None, ambient_occlusion: occlusion, ..shadow_of(Light::AT_CAMERA) };
    // Opaque everywhere but in a gap, in whose middle the sky is hidden at a distance of 6 in both directions along z.
    let gap = volume([80, 80, 40], DVec3::ONE, |p| (p.z - 20.0).abs() > 6.5);
    let light = light_of(&gap, &transfer(1.0), &settings);
    // Sweeps along x and y are clear. Those along z and the diagonals come from a plane 6.5 layers away along z.
    let behind = |d: f64| 1.0 - (-d / reach).exp();
    let expected = 4.0 / 15.0 + 2.0 / 15.0 * behind(6.5) + 8.0 * 3.0 / 40.0 * behind(6.5 * 3f64.sqrt());
    let found = light.at([40, 40, 20]);
    assert!((found - expected).abs() < TOLERANCE, "{found}, not {expected}");
    let unlimited = light_of(
        &gap,
        &transfer(1.0),
        &Settings { ambient_occlusion: Some(AmbientOcclusion { gain: 1.0, reach: None }), ..settings },
    );
    assert!((unlimited.at([40, 40, 20]) - 4.0 / 15.0).abs() < TOLERANCE);
}

/// Light is swept once, again for another transfer function or light, and not for another view or quality.
#[test]
fn light_is_kept() {
    let volume = volume([20; 3], DVec3::ONE, |p| p.distance(DVec3::splat(9.5)) < 6.0);
    let mut renderer = Renderer::new(&Device::shared(), &volume, &transfer(0.5)).unwrap();
    let camera = |azimuth: f64| {
        let grid = volume.grid();
        Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth, elevation: 10.0, roll: 5.0 })
    };
    let settings = shadow_of(Light::towards(DVec3::new(1.0, 2.0, 3.0)));
    let after = |renderer: &mut Renderer, azimuth: f64, settings: &Settings| {
        renderer.render(&camera(azimuth), SIZE, settings).unwrap();
        renderer.engine.light_volumes_made()
    };
    assert_eq!(after(&mut renderer, 0.0, &settings), 1);
    let high = Settings { shadows: settings.shadows, shading: settings.shading, ..crate::Quality::High.settings() };
    assert_eq!((after(&mut renderer, 70.0, &settings), after(&mut renderer, 200.0, &high)), (1, 1));
    let weaker = Settings { shadows: settings.shadows.map(|shadows| Shadows { strength: 0.5, ..shadows }), ..settings };
    assert_eq!(after(&mut renderer, 0.0, &weaker), 1);
    assert_eq!(after(&mut renderer, 0.0, &shadow_of(Light::towards(DVec3::X))), 2);
    renderer.set_transfer_function(&transfer(0.2));
    assert_eq!(after(&mut renderer, 0.0, &settings), 3);
    assert_eq!(after(&mut renderer, 30.0, &settings), 3);
}

/// Memory stays the same over a hundred changes of the light: lights that move with the camera never come back to a direction.
#[test]
fn changes_of_light_free_their_memory() {
    /// The volume, its layouts, and what a frame needs besides. All light volumes together take 28 MB.
    const FRAME: u64 = 8 << 20;
    let device = Device::shared();
    let volume = volume([64; 3], DVec3::ONE, |p| p.x > 32.0);
    let mut renderer = Renderer::new(&device.with_memory(super::LEAST as u64 + FRAME), &volume, &transfer(0.5)).unwrap();
    let grid = volume.grid();
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 33.0, elevation: 5.0, roll: 0.0 });
    for n in 0..100 {
        let (sin, cos) = (0.1 * f64::from(n)).sin_cos();
        let light = Light::towards(DVec3::new(sin, 0.3, cos));
        renderer.render(&camera, SIZE, &shadow_of(light)).unwrap();
    }
    assert_eq!(renderer.engine.light_volumes_made(), 100);
}

/// Every buffer that light takes is declared.
#[test]
fn light_takes_what_it_declares() {
    let volume = volume([40, 36, 30], DVec3::new(1.0, 1.2, 1.5), |p| p.distance(DVec3::splat(17.0)) < 10.0);
    let grid = volume.grid();
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 33.0, elevation: 5.0, roll: 0.0 });
    let shadows = shadow_of(Light { angle: 10.0, ..Light::towards(DVec3::new(-1.0, 1.0, 1.0)) });
    let high = Settings { shading: shadows.shading, shadows: shadows.shadows, ..crate::Quality::High.settings() };
    let occluded = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..high };
    let thinned = GradientOpacity::new(&[(1.0, 0.2), (30.0, 1.0)]).unwrap();
    let gaussian = Some(GradientEstimator::Gaussian(1.0));
    let cases = [
        shadows,
        occluded,
        Settings { light_grid: LightGrid::Quarter, ..occluded },
        Settings { gradient_opacity: Some(thinned), gradient: gaussian, ..shadows },
        Settings { blend: Blend::Iso(100.0), ..shadows },
        Settings::default().with_look(Look::Studio),
        Settings { light_grid: LightGrid::Quarter, ..Settings::default().with_look(Look::Studio) },
    ];
    for settings in cases {
        let device = Device::shared().with_memory(u64::MAX - 1);
        let mut renderer = Renderer::new(&device, &volume, &transfer(0.4)).unwrap();
        renderer.render(&camera, SIZE, &settings).unwrap();
        let planned = renderer.planned(&camera, SIZE, &settings).unwrap();
        let declare = |declaring: &Declaring| Stage::from_plan(&planned.plan, Output::Floats, false, declaring).resources.bytes();
        let (declared, peak) = (renderer.engine.declaring(SIZE, &planned.settings, declare).sum, device.peak_bytes());
        assert!(peak <= declared, "{settings:?}: {peak} bytes are more than the {declared} declared");
    }
}

/// Rays from a light have gradients of their own where the frame's are those of another kernel.
#[test]
fn gradient_opacity_does_not_depend_on_the_kernel_of_the_frame() {
    let ball = volume([30; 3], DVec3::ONE, |p| p.distance(DVec3::splat(14.5)) < 9.0);
    let gradient_opacity = Some(GradientOpacity::new(&[(1.0, 0.1), (60.0, 1.0)]).unwrap());
    let base = Settings { gradient_opacity, ..shadow_of(Light::towards(DVec3::new(0.3, 0.4, 1.0))) };
    for light_grid in [LightGrid::Full, LightGrid::Half] {
        let of = |kernel, gradient| {
            let algorithm = Algorithm::Raycast { kernel, step: 0.5 };
            light_of(&ball, &transfer(0.1), &Settings { algorithm, gradient: Some(gradient), light_grid, ..base }).bytes
        };
        let own = of(Kernel::BSpline, GradientEstimator::Own);
        let values = own.len() - super::PADDING;
        assert!(own[..values] == of(Kernel::Cubic, GradientEstimator::Sobel)[..values], "{light_grid:?}");
        assert!(own[..values] != of(Kernel::Cubic, GradientEstimator::Central)[..values], "{light_grid:?}: estimators differ");
    }
}

/// Surfaces are swept and looked up at full resolution.
#[test]
fn surfaces_have_full_resolution() {
    let ball = volume([30; 3], DVec3::ONE, |p| p.distance(DVec3::splat(14.5)) < 6.0 || p.y < 4.0);
    let size = Viewport { width: 48, height: 48 };
    let grid = ball.grid();
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), size, Orbit { azimuth: 33.0, elevation: 30.0, roll: 0.0 });
    let mut renderer = Renderer::new(&Device::shared(), &ball, &transfer(0.5)).unwrap();
    let base = Settings { blend: Blend::Iso(100.0), ..shadow_of(Light::towards(DVec3::new(0.4, 1.0, 0.2))) };
    let occluded = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..base };
    let mut picture = |settings: &Settings| renderer.render(&camera, size, settings).unwrap().0.pixels().to_vec();
    let full = picture(&occluded);
    for light_grid in [LightGrid::Half, LightGrid::Quarter] {
        assert!(picture(&Settings { light_grid, ..occluded }) == full, "{light_grid:?}");
    }
    assert!(picture(&Settings { shadows: None, ..occluded }) != full, "shadows are seen");
}
