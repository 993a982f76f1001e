//! Shadows and ambient occlusion of several ranks compared with those of one process.

use crate::common::*;
use crate::devices::BrickOnDevice;
use crate::pictures::{drawn, shared, whole};
use glam::DVec3;
use layersplat::distributed::{Group, Renderer};
use layersplat::settings::{
    AmbientOcclusion, Blend, Clipping, CropBox, GradientOpacity, Layered, Light, LightGrid, Lights, Look, Quality, Shading,
    Shadows,
};
use layersplat::{Camera, Settings, Viewport};

/// Rounding of the rays' states in another order, which changes few bytes of the light by 1; and of `over`.
const REORDERED: f64 = 2.0 / 255.0;

/// Nothing is forgiven, so that light differs everywhere.
const EXACT: Shadows = Shadows { strength: 1.0, forgiveness: 1.0 };

fn lit(lights: &[Light], settings: Settings) -> Settings {
    let shading = Some(Shading { lights: Lights::new(lights).unwrap(), ..Shading::default() });
    Settings { shading, shadows: Some(EXACT), early_termination: false, ..settings }
}

fn occluded(reach: Option<f64>, settings: Settings) -> Settings {
    let ambient_occlusion = Some(AmbientOcclusion { reach, gain: 1.0 });
    let shading = settings.shading.or(Some(Shading::default()));
    Settings { shading, ambient_occlusion, early_termination: false, ..settings }
}

/// The studio with its own lights, which stand where the first camera sees them.
fn studio(settings: Settings) -> Settings {
    let studio = Settings { light_grid: LightGrid::Quarter, early_termination: false, ..settings }.with_look(Look::Studio);
    studio.with_light_in_world(&cameras()[0]).unwrap()
}

fn towards(x: f64, y: f64, z: f64) -> Light {
    Light::towards(DVec3::new(x, y, z))
}

fn size() -> Viewport {
    viewport(48, 40)
}

/// Along z, x and y, and shared by two axes.
fn cameras() -> Vec<Camera> {
    let turns = [(20.0, -15.0), (80.0, 12.0), (15.0, 72.0), (51.0, 0.0)];
    turns.map(|(azimuth, elevation)| parallel(&whole(), size(), azimuth, elevation)).to_vec()
}

pub fn is_that_of_one_process(group: &Group) {
    let (volume, transfer, device) = (whole(), smooth_transfer(), device());
    let base = Settings::default();
    let thinned = Some(GradientOpacity::new(&[(0.5, 0.2), (20.0, 1.0)]).unwrap());
    let crop = CropBox { lowest: DVec3::splat(3.0), highest: DVec3::new(18.0, 17.0, 20.0) };
    let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
    let corner = CropBox { lowest: DVec3::new(3.0, 3.0, 13.0), ..crop };
    let corner = Clipping { crop: Some(corner), ..Clipping::default() };
    let soft = Light { angle: 20.0, ..towards(0.4, 1.0, 0.8) };
    let diagonal = Light::towards(DVec3::new(1.0, 0.1, 1.0) * DVec3::new(1.0, 1.2, 0.8));
    let splatted = Layered { classification: Quality::Standard.splatted(), ..Layered::default() };
    let cases = [
        ("along z", lit(&[towards(0.3, 0.2, 1.0)], base)),
        ("along z, from behind", lit(&[towards(0.3, 0.2, -1.0)], base)),
        ("along x", lit(&[towards(-1.0, 0.2, 0.3)], base)),
        ("along y", lit(&[towards(0.1, 1.0, 0.3)], base)),
        ("two axes", lit(&[diagonal], base)),
        ("soft, and another", lit(&[soft, towards(1.0, 0.3, 0.2)], base)),
        ("sky", occluded(None, base)),
        ("both, with a reach", occluded(Some(6.0), lit(&[diagonal], base))),
        ("half", lit(&[towards(0.3, 0.2, -1.0)], Settings { light_grid: LightGrid::Half, ..base })),
        ("quarter", occluded(Some(9.0), lit(&[towards(1.0, 0.2, 0.3)], Settings { light_grid: LightGrid::Quarter, ..base }))),
        ("surface", lit(&[towards(1.0, 0.2, 0.3)], Settings { blend: Blend::Iso(140.0), ..base })),
        ("gradient opacity", lit(&[towards(0.3, 0.2, 1.0)], Settings { gradient_opacity: thinned, ..base })),
        ("crop", lit(&[towards(0.3, 0.2, 1.0)], Settings { clipping, ..base })),
        ("splats", lit(&[towards(1.0, 0.2, -0.7)], splatted.into())),
        ("studio", studio(base)),
        // Some ranks have no matter.
        ("cut and thinned in the studio", studio(Settings { clipping: corner, gradient_opacity: thinned, ..base })),
        ("surface in the studio", studio(Settings { blend: Blend::Iso(140.0), ..base })),
    ];
    let mut alone = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    for axis in [2, 0] {
        let mut together = Renderer::new(group, &device, &shared(group, axis, 2), &transfer).unwrap();
        for (what, settings) in &cases {
            for (n, camera) in cameras().iter().enumerate() {
                let Some((frame, _)) = drawn(&mut together, camera, size(), settings) else { continue };
                let (expected, _) = alone.render(camera, size(), settings).unwrap();
                let tolerance = if group.size() == 1 { 0.0 } else { REORDERED };
                let what = format!("{what}, view {n} of {group:?}, slabs along {axis}");
                assert_close(&what, &frame, &expected, tolerance);
                let unlit = Settings { shadows: None, ambient_occlusion: None, studio: None, ..*settings };
                let without = alone.render(camera, size(), &unlit).unwrap().0;
                assert!(pixels_apart(&without, &expected, 2.0 * REORDERED) > 40, "{what}: light must be noticed");
            }
        }
    }
    // Light is kept: another view along the same axis, and another strength, send nothing.
    let mut together = Renderer::new(group, &device, &shared(group, 2, 2), &transfer).unwrap();
    let settings = lit(&[towards(1.0, 0.2, 0.3)], base);
    let weaker = Settings { shadows: Some(Shadows { strength: 0.5, ..EXACT }), ..settings };
    let turned = parallel(&volume, size(), 12.0, -5.0);
    let received = |together: &mut Renderer, camera: &Camera, settings: &Settings| {
        let report = drawn(together, camera, size(), settings).map(|(_, report)| report);
        report.map_or(0, |report| report.ranks.iter().map(|rank| rank.exchanged.received_bytes).sum::<u64>())
    };
    let first = received(&mut together, &cameras()[0], &settings);
    assert!(first > 0 || group.size() == 1 || !group.leads());
    for (camera, settings) in [(&turned, &settings), (&turned, &weaker), (&cameras()[0], &settings)] {
        assert_eq!(received(&mut together, camera, settings), 0);
    }
    for other in [lit(&[towards(1.0, 0.2, -0.3)], base), studio(base)] {
        assert!(received(&mut together, &turned, &other) > 0 || group.size() == 1 || !group.leads());
        assert_eq!(received(&mut together, &cameras()[0], &other), 0);
    }
    let finer = Settings { light_grid: LightGrid::Full, ..studio(base) };
    let refused = together.render(&turned, size(), &finer).map(drop).unwrap_err().to_string();
    assert!(refused.contains("set light_grid to quarter"), "{refused}");
}

pub fn is_the_same_again(group: &Group) {
    let transfer = smooth_transfer();
    let occluded = occluded(Some(6.0), lit(&[towards(1.0, 0.2, 0.3)], Settings::default()));
    for settings in [occluded, studio(Settings::default())] {
        let once = || {
            let mut together = Renderer::new(group, &device(), &shared(group, 2, 2), &transfer).unwrap();
            cameras().iter().map(|camera| drawn(&mut together, camera, size(), &settings)).collect::<Vec<_>>()
        };
        for (first, second) in once().into_iter().zip(once()) {
            assert!(first.map(|(frame, _)| frame) == second.map(|(frame, _)| frame), "not the same bits");
        }
    }
}

/// Bricks that stay on the devices: light along their axis is swept, other light is refused on all ranks.
pub fn of_bricks_on_devices(group: &Group) {
    let (volume, transfer) = (whole(), smooth_transfer());
    let there = BrickOnDevice::new(group, volume.grid());
    let BrickOnDevice { device, brick, all_bytes, description, .. } = &there;
    let mut together = Renderer::in_place(group, device, description, *brick, &there.voxels(), &transfer).unwrap();
    let camera = parallel(&volume, size(), 30.0, 20.0);
    let along = lit(&[towards(0.3, 0.2, 1.0)], Settings::default());
    if let Some((frame, _)) = drawn(&mut together, &camera, size(), &along) {
        let all = layersplat::Volume::new("all", volume.grid().clone(), all_bytes.clone()).unwrap().with_background(0.0).unwrap();
        assert_close("on devices", &frame, &render(&all, &transfer, &camera, size(), &along), REORDERED);
    }
    for (settings, words) in [
        (lit(&[towards(1.0, 0.2, 0.3)], Settings::default()), "no slabs along it"),
        (Settings { light_grid: LightGrid::Quarter, ..occluded(None, along) }, "light_grid to full"),
        (studio(Settings::default()), "choose the plain look"),
    ] {
        let across = together.render(&camera, size(), &settings).map(drop);
        if group.size() == 1 {
            across.unwrap();
        } else {
            let refused = across.unwrap_err().to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }
    assert!(together.render(&camera, size(), &along).is_ok());
}
