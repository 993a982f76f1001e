//! How long pictures take to be in a texture: the figures of docs/gl.md.

use crate::context::OpenGl;
use layersplat::renderer::GlTexture;
use layersplat::{
    Background, Camera, Device, DeviceChoice, Orbit, RawOptions, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::time::Instant;

const FRAMES: usize = 31;

/// Of frames from sides that differ, the median in milliseconds.
fn median(mut frame: impl FnMut(f64)) -> f64 {
    let mut times: Vec<f64> = (0..FRAMES)
        .map(|n| {
            let began = Instant::now();
            frame(20.0 + n as f64);
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[FRAMES / 2]
}

#[test]
#[ignore = "measures: cargo test --features gl-interop --test gl time:: -- --ignored --nocapture"]
fn pictures_in_textures_and_in_host_memory() {
    let opengl = OpenGl::new();
    let device = Device::open_with_gl(&DeviceChoice::Default).unwrap();
    let volume = Volume::open("builtin:hydrogen@64", &RawOptions::default()).unwrap();
    let mut renderer = Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
    let (centre, size, settings) = (volume.grid().centre(), volume.grid().diagonal(), Settings::default());
    for side in [256, 512, 1024] {
        let viewport = Viewport::new(side, side).unwrap();
        let texture = GlTexture::new(&device, &opengl.functions, opengl.picture(viewport)).unwrap();
        let camera = |azimuth| Camera::fit_parallel(centre, size, viewport, Orbit { azimuth, elevation: 20.0, roll: 0.0 });
        let host = median(|azimuth| {
            renderer.render_rgba8(&camera(azimuth), viewport, &settings, Background::Transparent).unwrap();
        });
        let onto = median(|azimuth| {
            renderer.render_into_texture(&camera(azimuth), &settings, Background::Transparent, &texture).unwrap();
        });
        let way = if texture.is_shared() { "on the device" } else { "through the host" };
        println!("{side}x{side}: {host:.2} ms into host memory, {onto:.2} ms into a texture {way} ({})", opengl.name());
    }
}
