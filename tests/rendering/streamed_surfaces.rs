//! Surfaces in volumes beyond the device's memory: the same bits as in the whole volume.

use crate::common::*;
use glam::DVec3;
use layersplat::renderer::volume_renderer;
use layersplat::settings::{AmbientOcclusion, Blend, Light, LightGrid, Lights, Shading, Shadows};
use layersplat::surface::{Per, Spheres, Surface, Triangles};
use layersplat::{Camera, Error, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport, Volume};

const DIMS: [usize; 3] = [150, 130, 170];
/// Layers beside those without which nothing is drawn.
const MORE_LAYERS: u64 = 16;

/// A translucent volume, so that every part contributes.
fn scene() -> (Volume<'static>, TransferFunction, Viewport) {
    (random_volume(DIMS, DVec3::new(1.0, 0.9, 1.1), 5), smooth_transfer(), viewport(72, 64))
}

/// So close that pixels are smaller than voxels: others have no lattice of their own.
fn close(volume: &Volume, size: Viewport, azimuth: f64, elevation: f64) -> Camera {
    scaled(parallel(volume, size, azimuth, elevation), 26.0)
}

/// Thin enough for light and rays to reach the other side.
fn thin() -> Settings {
    Settings { unit_distance: Some(40.0), ..Settings::default() }
}

/// Translucent spheres that overlap, within parts and across them, also outside the volume.
fn spheres(volume: &Volume) -> Surface {
    let (centre, radius) = (volume.grid().centre(), 0.05 * volume.grid().diagonal());
    let offsets = [[0.0; 3], [0.9, 0.3, 0.4], [-1.5, 1.0, -2.0], [0.5, -0.5, 4.0], [1.0, 2.5, 1.0], [-3.5, 0.0, 0.5]];
    let centres = offsets.map(|offset| centre + radius * DVec3::from_array(offset)).to_vec();
    let spheres =
        Surface::new("spheres", Spheres::new(centres, vec![radius, 1.2 * radius, radius, radius, radius, radius]).unwrap());
    let colors = [[0.9, 0.2, 0.1], [0.1, 0.8, 0.3], [0.2, 0.3, 1.0], [0.9, 0.9, 0.2], [0.2, 0.8, 0.9], [0.8, 0.8, 0.8]];
    let mut spheres = spheres.with_colors(Per::Cell(colors.map(|[r, g, b]| [r, g, b, 1.0]).to_vec())).unwrap();
    spheres.opacity = 0.4;
    spheres
}

/// An opaque triangle that slants through all layers.
fn opaque(volume: &Volume) -> Surface {
    let (centre, size) = (volume.grid().centre(), 0.2 * volume.grid().diagonal());
    let corner = |x: f64, y: f64, z: f64| centre + size * DVec3::new(x, y, z);
    let corners = vec![corner(-1.0, -0.8, -0.9), corner(0.9, -0.2, 0.8), corner(-0.2, 1.0, 0.1)];
    let mut surface = Surface::new("opaque", Triangles::new(corners, vec![[0, 1, 2]]).unwrap());
    surface.color = [0.7, 0.7, 0.9];
    surface
}

fn close_perspective(volume: &Volume, size: Viewport, azimuth: f64, elevation: f64) -> Camera {
    let orbit = Orbit { azimuth, elevation, roll: 2.0 };
    let camera = Camera::fit_perspective(volume.grid().centre(), volume.grid().diagonal(), 25.0, size, orbit);
    Camera { projection: Projection::Perspective { field_of_view: 5.0 }, ..camera }
}

/// The least memory for a view, as errors say.
fn least(surfaces: &[Surface], camera: &Camera, settings: &Settings) -> u64 {
    let (volume, transfer, size) = scene();
    let plan = |budget: u64| {
        let mut renderer = volume_renderer(&device().with_memory(budget), &volume, &transfer)?;
        renderer.set_surfaces(surfaces)?;
        renderer.stream_plan(camera, size, settings)
    };
    let mut least = 100_000;
    while let Err(error) = plan(least) {
        let (Error::LightMemory { needed, taken, .. } | Error::MemoryBudget { needed, taken, .. }) = error else {
            panic!("{error}")
        };
        least = needed + taken;
    }
    least
}

/// Renders in parts, and as a whole. Bits must be equal, and surfaces in the picture.
#[track_caller]
fn check(what: &str, surfaces: &[Surface], camera: &Camera, settings: &Settings) {
    let (volume, transfer, size) = scene();
    let mut budget = least(surfaces, camera, settings);
    budget += MORE_LAYERS * (DIMS[0] * DIMS[2]) as u64;
    let small = device().with_memory(budget);
    let mut renderer = volume_renderer(&small, &volume, &transfer).unwrap();
    renderer.set_surfaces(surfaces).unwrap();
    let plan = renderer.stream_plan(camera, size, settings).unwrap().expect("it is streamed");
    assert!(plan.lattices.len() == 1 && plan.lattices[0].parts > 3, "{what}: {plan}");
    let frame = renderer.render(camera, size, settings).unwrap().0.expect("one process");
    let peak = small.peak_bytes();
    assert!(peak <= budget && budget < (DIMS.iter().product::<usize>()) as u64, "{what}: {peak} bytes of {plan}");
    let mut whole = Renderer::new(&device(), &volume, &transfer).unwrap();
    whole.set_surfaces(surfaces).unwrap();
    let expected = whole.render(camera, size, settings).unwrap().0;
    assert_close(what, &frame, &expected, 0.0);
    whole.set_surfaces(&[]).unwrap();
    let changed = pixels_apart(&whole.render(camera, size, settings).unwrap().0, &expected, 4.0 / 255.0);
    assert!(changed > 100, "{what}: surfaces change {changed} pixels only");
}

#[test]
fn translucent_and_opaque_surfaces_from_each_side() {
    let (volume, _, size) = scene();
    let all = [spheres(&volume), opaque(&volume)];
    check("translucent", &all[..1], &close(&volume, size, 20.0, -15.0), &thin());
    check("from below", &all, &close(&volume, size, 2.0, -78.0), &thin());
    check("from behind", &all, &close_perspective(&volume, size, 170.0, 8.0), &thin());
    check("along x", &all, &close_perspective(&volume, size, 80.0, 12.0), &thin());
}

/// Light is that of the whole volume, of which half the resolution fits.
#[test]
fn shadows_and_other_settings() {
    let (volume, _, size) = scene();
    let all = [spheres(&volume), opaque(&volume)];
    let lights = Lights::new(&[Light::towards(DVec3::new(1.0, 0.4, 0.3))]).unwrap();
    let shading = Some(Shading { lights, ..Shading::default() });
    let shadows = Settings { shading, shadows: Some(Shadows::default()), light_grid: LightGrid::Half, ..thin() };
    let occluded = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..shadows };
    let camera = close(&volume, size, 20.0, -15.0);
    for (what, settings) in [
        ("shadows", shadows),
        ("occlusion", occluded),
        ("maximum", Settings { blend: Blend::Maximum, ..thin() }),
        ("iso", Settings { blend: Blend::Iso(200.0), ..thin() }),
    ] {
        check(what, &all, &camera, &settings);
    }
}

/// Where rays have no lattice whose samples are pixels, the whole volume is needed.
#[test]
fn rays_need_the_whole_volume() {
    let (volume, transfer, size) = scene();
    let inside = Camera {
        position: volume.grid().centre() + DVec3::X,
        projection: Projection::Perspective { field_of_view: 60.0 },
        ..parallel(&volume, size, 20.0, 5.0)
    };
    let mut renderer = volume_renderer(&device().with_memory(1_000_000), &volume, &transfer).unwrap();
    renderer.set_surfaces(&[spheres(&volume)]).unwrap();
    let error = renderer.render(&inside, size, &thin()).expect_err("too little");
    assert!(matches!(error, Error::MemoryBudget { .. }) && error.to_string().contains("needs the whole volume"), "{error}");
    renderer.set_surfaces(&[]).unwrap();
    let camera = close(&volume, size, 20.0, -15.0);
    let without = renderer.render(&camera, size, &thin()).unwrap().0.expect("one process");
    assert_close("no surfaces", &without, &render(&volume, &transfer, &camera, size, &thin()), 0.0);
}
