//! Time for a picture to reach a texture: the figures of docs/dev/gl.md.

use crate::context::OpenGl;
use layersplat::renderer::GlTexture;
use layersplat::{
    Background, Camera, Device, DeviceChoice, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::time::Instant;

const FRAMES: usize = 61;

/// Milliseconds of one frame.
fn time(frame: impl FnOnce()) -> f64 {
    let began = Instant::now();
    frame();
    began.elapsed().as_secs_f64() * 1e3
}

#[test]
#[ignore = "measures: cargo test --features gl-interop --test gl time:: -- --ignored --nocapture"]
fn pictures_in_textures_and_in_host_memory() {
    let opengl = OpenGl::new();
    let device = Device::open_with_gl(&DeviceChoice::Default).unwrap();
    let volume = Volume::open("builtin:hydrogen@64", &OpenOptions::default()).unwrap();
    let mut renderer = Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
    let (centre, size, settings) = (volume.grid().centre(), volume.grid().diagonal(), Settings::default());
    for side in [256, 512, 1024] {
        let viewport = Viewport::new(side, side).unwrap();
        let texture = GlTexture::new(&device, &opengl.functions, opengl.picture(viewport)).unwrap();
        let camera = |azimuth| Camera::fit_parallel(centre, size, viewport, Orbit { azimuth, elevation: 20.0, roll: 0.0 });
        let [mut host, mut onto] = [f64::INFINITY; 2];
        // Alternate, so that other load affects both equally; the fastest of each is disturbed least.
        for azimuth in (0..FRAMES).map(|n| 20.0 + n as f64) {
            let camera = camera(azimuth);
            host = host.min(time(|| {
                renderer.render_rgba8(&camera, viewport, &settings, Background::Transparent).unwrap();
            }));
            onto = onto.min(time(|| {
                renderer.render_into_texture(&camera, &settings, Background::Transparent, &texture).unwrap();
            }));
        }
        let way = if texture.is_shared() { "on the device" } else { "through the host" };
        println!("{side}x{side}: {host:.2} ms into host memory, {onto:.2} ms into a texture {way} ({})", opengl.name());
    }
}
