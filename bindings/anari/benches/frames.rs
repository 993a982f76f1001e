//! Compares the time of frames by the API with that of the library, by turns: `cargo bench -p layersplat-anari`.

#[path = "../tests/device/client.rs"]
#[allow(dead_code)]
mod client;

use anari_sys::*;
use client::Device;
use cpu_time::ProcessTime;
use layersplat::glam::{DAffine3, DVec3};
use layersplat::settings::Settings;
use layersplat::volume::{Grid, Volume};
use layersplat::{Background, Camera, Kernel, OpenOptions, Projection, Quality, Renderer, TransferFunction, Viewport};
use std::time::{Duration, Instant};

/// Voxels along each side; width and height of frames; frames of each.
const SIDE: usize = 128;
const SIZE: u32 = 512;
const FRAMES: usize = 201;

/// Types of colours. The library has bytes and floats; sRGB is compared with floats.
const FORMATS: [(&str, ANARIDataType); 3] =
    [("UFIXED8_VEC4", ANARI_UFIXED8_VEC4), ("FLOAT32_VEC4", ANARI_FLOAT32_VEC4), ("UFIXED8_RGBA_SRGB", ANARI_UFIXED8_RGBA_SRGB)];

fn main() {
    let source = Volume::open(format!("builtin:gyroid@{SIDE}"), &OpenOptions::default()).unwrap();
    let (lo, hi) = source.range();
    let voxels: Vec<f32> = (0..SIDE.pow(3)).map(|i| ((source.value(i) - lo) / (hi - lo)) as f32).collect();
    let (colors, opacities) = ([[0.1f32, 0.2, 0.9], [1.0, 0.8, 0.2]], [0.0f32, 0.0, 0.0, 0.3]);
    let centre = DVec3::splat((SIDE as f64 - 1.0) / 2.0);
    let position = centre + DVec3::new(1.1, 0.7, 1.6) * SIDE as f64;

    let device = Device::new();
    let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
    field.set_object(c"data", &device.array(ANARI_FLOAT32, &[SIDE as u64; 3], &voxels)).commit();
    let volume = device.make(ANARI_VOLUME, c"transferFunction1D");
    volume.set_object(c"value", &field).set_object(c"color", &device.array(ANARI_FLOAT32_VEC3, &[2], &colors));
    volume.set_object(c"opacity", &device.array(ANARI_FLOAT32, &[4], &opacities)).commit();
    let light = device.make(ANARI_LIGHT, c"directional");
    light.set(c"direction", [0.5f32, -1.0, -1.0]).commit();
    let world = device.make(ANARI_WORLD, c"");
    world.set_object(c"volume", &device.objects(&[&volume])).set_object(c"light", &device.objects(&[&light])).commit();
    let camera = device.make(ANARI_CAMERA, c"orthographic");
    camera.set(c"position", position.as_vec3().to_array()).set(c"direction", (centre - position).as_vec3().to_array());
    camera.set(c"height", SIDE as f32 * 1.5).commit();
    let renderer = device.make(ANARI_RENDERER, c"default");
    renderer.set(c"ambientRadiance", 0.2f32).commit();
    let frame = device.make(ANARI_FRAME, c"");
    frame.set_object(c"world", &world).set_object(c"camera", &camera).set_object(c"renderer", &renderer);
    frame.set(c"size", [SIZE; 2]);

    let opened = layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap();
    let grid = Grid::from_affine([SIDE; 3], DAffine3::IDENTITY).unwrap();
    let transfer = TransferFunction::new(
        "the same",
        vec![(0.0, colors[0].map(f64::from)), (1.0, colors[1].map(f64::from))],
        opacities.iter().enumerate().map(|(i, &opacity)| (i as f64 / 3.0, opacity.into())).collect(),
    );
    let mut library = Renderer::new(&opened, &Volume::new("the same", grid, &voxels).unwrap(), &transfer.unwrap()).unwrap();
    let view = Camera {
        position,
        focal_point: centre,
        view_up: DVec3::Y,
        projection: Projection::Parallel { scale: SIDE as f64 * 0.75 },
    };
    let viewport = Viewport::new(SIZE, SIZE).unwrap();
    let settings = settings();
    println!("gyroid@{SIDE}, {SIZE}x{SIZE}, lit, medians of {FRAMES} by turns");
    for (name, format) in FORMATS {
        frame.set_type(c"channel.color", format).commit();
        let mut by_library = || match format {
            ANARI_UFIXED8_VEC4 => drop(library.render_rgba8(&view, viewport, &settings, Background::BLACK).unwrap()),
            _ => drop(library.render(&view, viewport, &settings).unwrap()),
        };
        // Built and uploaded before the measurement.
        by_library();
        frame.render();
        let (mut library, mut api) = (Vec::new(), Vec::new());
        for _ in 0..FRAMES {
            library.push(timed(&mut by_library));
            api.push(timed(|| frame.render()));
        }
        for (what, of) in [("wall", 0), ("CPU", 1)] {
            let [library, api] = [&library, &api].map(|times| median(times, of));
            let ratio = api.as_secs_f64() / library.as_secs_f64();
            println!("{name:>17}, {what:>4}: library {library:.2?}, ANARI {api:.2?}, ratio {ratio:.3}");
        }
    }
}

fn median(times: &[[Duration; 2]], of: usize) -> Duration {
    let mut times: Vec<_> = times.iter().map(|both| both[of]).collect();
    times.sort();
    times[times.len() / 2]
}

fn settings() -> Settings {
    use layersplat::settings::{Light, Lights, Shading};
    let mut layered = Quality::Standard.layered();
    layered.classification = layered.classification.with_kernel(Kernel::Linear);
    let lights = Lights::new(&[Light::towards(DVec3::new(-0.5, 1.0, 1.0))]).unwrap();
    Settings { shading: Some(Shading { lights, ..Shading::default() }), unit_distance: Some(1.0), ..layered.into() }
}

/// Wall and CPU time of all threads.
fn timed<R>(act: impl FnOnce() -> R) -> [Duration; 2] {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    act();
    [wall.elapsed(), cpu.elapsed()]
}
