//! Shadows and ambient occlusion of volumes beyond the device's memory: the same bits as those of the whole volume.

use crate::common::*;
use glam::{DMat3, DVec3};
use layersplat::layers::{Axis, GradientEstimator, Kernel};
use layersplat::renderer::{PartRenderer, StreamPlan, StreamedRenderer};
use layersplat::settings::{
    AmbientOcclusion, Blend, Clipping, CropBox, GradientOpacity, Layered, Light, LightGrid, Lights, Look, Quality, Shading,
    Shadows, Studio,
};
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Error, Frame, Renderer, Settings, TransferFunction, Viewport, Volume};

const DIMS: [usize; 3] = [150, 130, 170];

/// Soft blobs all over the volume, which cast shadows onto each other across all cuts.
fn scene() -> (Volume<'static>, TransferFunction) {
    let place = |n: usize| DVec3::new((n % DIMS[0]) as f64, (n / DIMS[0] % DIMS[1]) as f64, (n / (DIMS[0] * DIMS[1])) as f64);
    let value =
        |p: DVec3| (128.0 + 60.0 * (p * DVec3::new(0.17, 0.21, 0.15)).sin().element_sum()).clamp(0.0, 255.0).round() as u8;
    let voxels = (0..DIMS.iter().product()).map(|n| value(place(n))).collect();
    let volume = Volume::new("blobs", Grid::new(DIMS, DVec3::new(1.0, 1.2, 0.9)).unwrap(), Voxels::Uint8(voxels)).unwrap();
    let transfer =
        TransferFunction::new("soft", vec![(0.0, [0.9, 0.6, 0.3]), (255.0, [0.4, 0.7, 1.0])], vec![(170.0, 0.0), (255.0, 0.3)])
            .unwrap();
    (volume, transfer)
}

fn size() -> Viewport {
    viewport(40, 32)
}

fn lit(lights: &[Light], settings: Settings) -> Settings {
    let shading = Some(Shading { lights: Lights::new(lights).unwrap(), ..Shading::default() });
    Settings { shading, shadows: Some(Shadows::default()), ..settings }
}

fn occluded(reach: Option<f64>, settings: Settings) -> Settings {
    let ambient_occlusion = Some(AmbientOcclusion { reach, ..AmbientOcclusion::default() });
    Settings { shading: settings.shading.or(Some(Shading::default())), ambient_occlusion, ..settings }
}

fn towards(x: f64, y: f64, z: f64) -> Light {
    Light::towards(DVec3::new(x, y, z))
}

/// A budget too small for the voxels and their light, so that views are streamed. Filtered voxels are floats.
fn budget(volume: &Volume, settings: &Settings) -> u64 {
    let shares = if PartRenderer::around(settings) > 2 { 8 } else { 3 };
    volume.grid().voxel_count() as u64 * shares / 4
}

fn planned(
    budget: u64,
    volume: &Volume,
    transfer: &TransferFunction,
    camera: &Camera,
    settings: &Settings,
) -> Result<Option<StreamPlan>, Error> {
    StreamedRenderer::new(&device().with_memory(budget), volume, transfer).plan(camera, size(), settings)
}

/// The least memory for a view, as errors say.
fn least(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings) -> u64 {
    let mut needed = 1000;
    while let Err(error) = planned(needed, volume, transfer, camera, settings) {
        let Error::LightMemory { needed: more, .. } = error else { panic!("{error}") };
        assert!(more > needed, "{error}");
        needed = more;
    }
    needed
}

fn streamed(renderer: &mut StreamedRenderer, camera: &Camera, settings: &Settings) -> (Frame, StreamPlan) {
    let plan = renderer.plan(camera, size(), settings).unwrap().expect("it is streamed");
    (renderer.render(camera, size(), settings).unwrap().0, plan)
}

/// Renders in parts, compares with the whole volume bit for bit, and shows that light is noticed.
#[track_caller]
fn check(what: &str, axes: &[Axis], (azimuth, elevation): (f64, f64), settings: &Settings) {
    let (volume, transfer) = scene();
    let camera = parallel(&volume, size(), azimuth, elevation);
    check_scene(what, axes, (&volume, &transfer), &camera, budget(&volume, settings), settings);
}

#[track_caller]
fn check_scene(
    what: &str,
    axes: &[Axis],
    (volume, transfer): (&Volume, &TransferFunction),
    camera: &Camera,
    budget: u64,
    settings: &Settings,
) {
    let bounded = device().with_memory(budget);
    let mut renderer = StreamedRenderer::new(&bounded, volume, transfer);
    let (frame, plan) = streamed(&mut renderer, camera, settings);
    assert_eq!(plan.lattices.iter().map(|lattice| lattice.axis).collect::<Vec<_>>(), axes, "{what}");
    // Slabs share layers: light is swept in several.
    assert!(plan.lattices.iter().all(|lattice| lattice.parts > 1) && plan.light_bytes > plan.volume_bytes, "{what}: {plan}");
    let peak = bounded.peak_bytes();
    assert!(peak <= plan.device_bytes && plan.device_bytes <= budget, "{what}: {peak} bytes of {plan}");
    let whole = render(volume, transfer, camera, size(), settings);
    assert_close(what, &frame, &whole, 0.0);
    let unlit = Settings { shadows: None, ambient_occlusion: None, studio: None, ..*settings };
    let unlit = render(volume, transfer, camera, size(), &unlit);
    let changed = pixels_apart(&whole, &unlit, 1.0 / 255.0);
    assert!(changed > 100, "{what}: light changes {changed} pixels only");
    // Kept: another view along the same axis, or along another, sweeps nothing.
    let to_eye = camera.position - camera.focal_point;
    let turned = Camera { position: camera.focal_point + DMat3::from_axis_angle(DVec3::Y, 0.05) * to_eye, ..*camera };
    for camera in [turned, parallel(volume, size(), 20.0, 80.0)] {
        let (frame, plan) = streamed(&mut renderer, &camera, settings);
        assert_eq!(plan.light_bytes, 0, "{what}: {plan}");
        assert_close(what, &frame, &render(volume, transfer, &camera, size(), settings), 0.0);
    }
}

/// Seen along z, from both sides: lights along the cuts and across them, from the viewer's side and from behind.
#[test]
fn shadows_along_the_cuts_and_across_them() {
    for (azimuth, light) in [
        (10.0, towards(0.3, 0.2, 1.0)),
        (10.0, towards(0.3, 0.2, -1.0)),
        (170.0, towards(-0.2, 0.3, 1.0)),
        (10.0, towards(1.0, 0.2, 0.1)),
        (10.0, towards(0.1, -1.0, 0.3)),
    ] {
        check(&format!("{azimuth}, {light:?}"), &[Axis::Z], (azimuth, 5.0), &lit(&[light], Settings::default()));
    }
}

/// Seen along x and y, with lights along the same axis and along another.
#[test]
fn other_axes_of_views() {
    check("x, along", &[Axis::X], (85.0, 5.0), &lit(&[towards(-1.0, 0.2, 0.3)], Settings::default()));
    check("x, across", &[Axis::X], (-85.0, 5.0), &lit(&[towards(0.1, 0.2, 1.0)], Settings::default()));
    check("y, along", &[Axis::Y], (10.0, 80.0), &lit(&[towards(0.1, 1.0, 0.2)], Settings::default()));
    check("y, across", &[Axis::Y], (10.0, -80.0), &lit(&[towards(1.0, 0.1, 0.2)], Settings::default()));
}

/// Sums of sweeps: light shared by axes near 45 degrees, soft light, two lights, and the sky.
#[test]
fn light_of_several_sweeps() {
    let spacing = DVec3::new(1.0, 1.2, 0.9);
    let diagonal = Light::towards(DVec3::new(1.0, 0.1, 1.0) * spacing);
    check("diagonal", &[Axis::Z], (10.0, 5.0), &lit(&[diagonal], Settings::default()));
    let soft = Light { angle: 20.0, ..towards(0.4, 1.0, 0.8) };
    check("soft, and another", &[Axis::Z], (10.0, 5.0), &lit(&[soft, towards(1.0, 0.3, 0.2)], Settings::default()));
    check("sky", &[Axis::Z], (10.0, 5.0), &occluded(None, Settings::default()));
    let both = occluded(Some(12.0), lit(&[diagonal], Settings::default()));
    check("both, with a reach", &[Axis::X], (85.0, 5.0), &both);
}

#[test]
fn lower_resolutions() {
    for light_grid in [LightGrid::Half, LightGrid::Quarter] {
        let settings = Settings { light_grid, ..Settings::default() };
        for light in [towards(0.3, 0.2, -1.0), towards(1.0, 0.2, 0.1), towards(0.1, 1.0, 0.4)] {
            check(&format!("{light_grid:?}, {light:?}"), &[Axis::Z], (10.0, 5.0), &lit(&[light], settings));
        }
        check(&format!("{light_grid:?}, sky"), &[Axis::X], (85.0, 5.0), &occluded(Some(20.0), settings));
    }
}

/// All that changes extinction.
#[test]
fn other_settings() {
    let thinned = Some(GradientOpacity::new(&[(1.0, 0.2), (20.0, 1.0)]).unwrap());
    let crop = CropBox { lowest: DVec3::new(20.0, 10.0, 30.0), highest: DVec3::new(120.0, 140.0, 120.0) };
    let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
    let base = Settings::default();
    for (what, settings) in [
        ("iso", Settings { blend: Blend::Iso(190.0), ..base }),
        ("gradient opacity", Settings { gradient_opacity: thinned, ..base }),
        ("smooth gradients", Settings { gradient_opacity: thinned, gradient: Some(GradientEstimator::Gaussian(1.0)), ..base }),
        ("half, thinned", Settings { gradient_opacity: thinned, light_grid: LightGrid::Half, ..base }),
        ("crop", Settings { clipping, ..base }),
        ("half, crop", Settings { clipping, light_grid: LightGrid::Half, ..base }),
        ("linear", Settings { extinction: layersplat::transfer::Extinction::Linear, ..base }),
        ("splats", Layered { classification: Quality::Standard.splatted(), ..Layered::default() }.into()),
        ("high", Quality::High.settings()),
        ("B-spline", with_kernel(Quality::Standard, Kernel::BSpline).into()),
    ] {
        check(what, &[Axis::Z], (10.0, 5.0), &lit(&[towards(1.0, 0.2, -0.7)], settings));
    }
    check("iso and sky", &[Axis::X], (85.0, 5.0), &occluded(None, Settings { blend: Blend::Iso(190.0), ..base }));
}

/// Light scatters through the whole volume, whose blocks are summed in slabs. Voxels of four bytes take more memory than that.
#[test]
fn the_studio_at_a_quarter_of_the_resolution() {
    let [x, y, z] = [190, 120, 130];
    let place = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64);
    let value = |n: usize| 128.0 + 60.0 * (place(n) * DVec3::new(0.17, 0.21, 0.15)).sin().element_sum();
    let voxels = Voxels::Float32((0..x * y * z).map(|n| value(n) as f32).collect());
    let volume = Volume::new("blobs", Grid::new([x, y, z], DVec3::new(1.0, 1.0, 1.1)).unwrap(), voxels).unwrap();
    let transfer = scene().1;
    let quarter = Settings { light_grid: LightGrid::Quarter, ..Settings::default() }.with_look(Look::Studio);
    let thinned = Some(GradientOpacity::new(&[(1.0, 0.2), (20.0, 1.0)]).unwrap());
    let crop = CropBox { lowest: DVec3::new(20.0, 10.0, 30.0), highest: DVec3::new(150.0, 115.0, 120.0) };
    let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
    let camera = parallel(&volume, size(), 10.0, 5.0);
    for (what, settings) in [
        ("studio", quarter),
        ("studio, cut and thinned", Settings { clipping, gradient_opacity: thinned, ..quarter }),
        ("iso-surface in the studio", Settings { blend: Blend::Iso(190.0), ..quarter }),
    ] {
        let settings = settings.with_light_in_world(&camera).unwrap();
        check_scene(what, &[Axis::Z], (&volume, &transfer), &camera, least(&volume, &transfer, &camera, &settings), &settings);
    }
    // The most memory with which the whole does not fit, and all blocks are one slab.
    let plan = |budget: u64, settings: &Settings| planned(budget, &volume, &transfer, &camera, settings);
    let (mut low, mut high) = (least(&volume, &transfer, &camera, &quarter), 64 * volume.grid().voxel_count() as u64);
    while low + 1 < high {
        let middle = (low + high) / 2;
        let is_streamed = plan(middle, &quarter).unwrap().is_some();
        if is_streamed { low = middle } else { high = middle }
    }
    let mut renderer = StreamedRenderer::new(&device().with_memory(low), &volume, &transfer);
    let (frame, one) = streamed(&mut renderer, &camera, &quarter);
    assert_eq!(one.light_bytes % one.volume_bytes, 0, "{one}");
    let whole = render(&volume, &transfer, &camera, size(), &quarter);
    assert_close("one slab", &frame, &whole, 0.0);
    // What changes the light field is computed again.
    let less = Settings { studio: Some(Studio { scattering: 0.5, ..Studio::default() }), ..quarter };
    let (frame, again) = streamed(&mut renderer, &camera, &less);
    assert_eq!(again.light_bytes, again.volume_bytes, "the lights are kept, and blocks are summed: {again}");
    let expected = render(&volume, &transfer, &camera, size(), &less);
    assert_close("less scattering", &frame, &expected, 0.0);
    assert!(pixels_apart(&whole, &expected, 1.0 / 255.0) > 100, "scattering must be noticed");
    for light_grid in [LightGrid::Half, LightGrid::Full] {
        let message = plan(low, &Settings { light_grid, ..quarter }).unwrap_err().to_string();
        assert!(message.starts_with("light_grid") && message.contains("set light_grid to quarter"), "{message}");
    }
}

/// Near 45 degrees a view has lattices of two axes, which look up the same light.
#[test]
fn views_shared_by_axes() {
    let azimuth = (0.9f64).atan().to_degrees();
    check("shared", &[Axis::X, Axis::Z], (90.0 - azimuth, 5.0), &lit(&[towards(0.3, 0.2, 1.0)], Settings::default()));
}

/// A large picture leaves less room for parts than slabs of light have.
#[test]
fn large_pictures() {
    let (volume, transfer) = scene();
    let size = viewport(300, 250);
    let camera = parallel(&volume, size, 10.0, 5.0);
    let settings = lit(&[towards(0.3, 0.2, 1.0)], Settings::default());
    let device = device().with_memory(2 * volume.grid().voxel_count() as u64);
    let mut renderer = StreamedRenderer::new(&device, &volume, &transfer);
    let plan = renderer.plan(&camera, size, &settings).unwrap().expect("it is streamed");
    assert!(plan.lattices[0].parts > 1 && plan.light_bytes > 0, "{plan}");
    let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
    assert!(device.peak_bytes() <= plan.device_bytes, "{} bytes of {plan}", device.peak_bytes());
    assert_close("a large picture", &frame, &render(&volume, &transfer, &camera, size, &settings), 0.0);
}

/// Light is swept again for another light, transfer function or volume.
#[test]
fn light_is_swept_again_when_it_changes() {
    let (volume, transfer) = scene();
    let camera = parallel(&volume, size(), 10.0, 5.0);
    let one = lit(&[towards(1.0, 0.2, -0.7)], Settings::default());
    let mut renderer = StreamedRenderer::new(&device().with_memory(budget(&volume, &one)), &volume, &transfer);
    let other = lit(&[towards(1.0, 0.2, 0.7)], Settings::default());
    let weaker = Settings { shadows: Some(Shadows { strength: 0.5, ..Shadows::default() }), ..one };
    let swept = |renderer: &mut StreamedRenderer, settings: &Settings| streamed(renderer, &camera, settings).1.light_bytes > 0;
    assert!(swept(&mut renderer, &one) && !swept(&mut renderer, &one) && !swept(&mut renderer, &weaker));
    assert!(swept(&mut renderer, &other) && !swept(&mut renderer, &other) && swept(&mut renderer, &one));
    let occluded = occluded(None, one);
    assert!(swept(&mut renderer, &occluded) && !swept(&mut renderer, &one) && !swept(&mut renderer, &occluded));
    renderer.set_transfer_function(&transfer);
    assert!(!swept(&mut renderer, &one), "it is the same transfer function");
    let shifted = TransferFunction::new("other", vec![(0.0, [0.9, 0.6, 0.3])], vec![(150.0, 0.0), (255.0, 0.3)]).unwrap();
    renderer.set_transfer_function(&shifted);
    let (frame, plan) = streamed(&mut renderer, &camera, &one);
    assert!(plan.light_bytes > 0);
    assert_close("another transfer function", &frame, &render(&volume, &shifted, &camera, size(), &one), 0.0);
    renderer.set_volume(&volume);
    assert!(swept(&mut renderer, &one));
}

/// The announced memory suffices, and a byte less does not. The error says how many bytes are missing, and what needs less.
#[test]
fn too_little_is_refused_with_what_is_needed() {
    let (volume, transfer) = scene();
    let camera = parallel(&volume, size(), 10.0, 5.0);
    let settings = lit(&[Light { angle: 10.0, ..towards(1.0, 0.2, 0.1) }], Settings::default());
    let plan = |budget: u64, settings: &Settings| planned(budget, &volume, &transfer, &camera, settings);
    let least = |settings: &Settings| least(&volume, &transfer, &camera, settings);
    let needed = least(&settings);
    let message = plan(needed - 7, &settings).unwrap_err().to_string();
    assert!(message.contains("7 more than the memory budget") && message.contains("light_grid half needs less"), "{message}");
    let half = Settings { light_grid: LightGrid::Half, ..settings };
    assert!(least(&half) < needed);
    let message = plan(least(&half) - 1, &half).unwrap_err().to_string();
    assert!(message.contains("1 more than") && !message.contains("light_grid"), "{message}");
    let mut renderer = StreamedRenderer::new(&device().with_memory(needed), &volume, &transfer);
    let frame = streamed(&mut renderer, &camera, &settings).0;
    assert_close("least memory", &frame, &render(&volume, &transfer, &camera, size(), &settings), 0.0);
    // Where volume and light fit, all stay on the device.
    let large = device().with_memory(64 * volume.grid().voxel_count() as u64);
    let mut renderer = StreamedRenderer::new(&large, &volume, &transfer);
    assert!(renderer.plan(&camera, size(), &settings).unwrap().is_none());
    let whole = Renderer::new(&device(), &volume, &transfer).unwrap().render(&camera, size(), &settings).unwrap().0;
    assert_close("whole", &renderer.render(&camera, size(), &settings).unwrap().0, &whole, 0.0);
}
