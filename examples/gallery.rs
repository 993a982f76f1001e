//! Writes pictures of two built-in volumes with transfer functions of its own to a folder: `cargo run --release --example gallery FOLDER`.

use layersplat::{
    Background, Camera, Device, DeviceChoice, Error, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::path::PathBuf;

/// Shells of the orbital, similar to iso-surfaces: a faint outer one, and a bright inner one.
fn shells() -> Result<TransferFunction, Error> {
    let colors = vec![(0.0, [0.2, 0.5, 1.0]), (60.0, [0.3, 0.8, 1.0]), (120.0, [1.0, 0.65, 0.2]), (255.0, [1.0, 0.95, 0.7])];
    let opacities =
        vec![(0.0, 0.0), (20.0, 0.0), (28.0, 0.09), (40.0, 0.005), (105.0, 0.005), (125.0, 0.5), (150.0, 0.3), (255.0, 0.6)];
    TransferFunction::new("shells", colors, opacities)
}

/// The test signal as a solid: everything above its mean.
fn solid() -> Result<TransferFunction, Error> {
    let colors = vec![(0.0, [0.85, 0.8, 0.7]), (127.0, [0.85, 0.8, 0.7]), (255.0, [0.3, 0.5, 0.75])];
    TransferFunction::new("solid", colors, vec![(0.0, 0.0), (120.0, 0.0), (135.0, 0.9), (255.0, 0.95)])
}

fn main() -> Result<(), Error> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    let device = Device::open(&DeviceChoice::Default)?;
    let viewport = Viewport::new(512, 512)?;
    let background = Some(Background::Color([0.04, 0.05, 0.08]));
    let pictures = [
        ("hydrogen", "builtin:hydrogen@160", shells()?, 62.0, 18.0, 0.66),
        ("marschner-lobb", "builtin:marschner-lobb@128", solid()?, 25.0, 35.0, 1.0),
    ];
    for (name, source, transfer, azimuth, elevation, zoom) in pictures {
        let volume = Volume::open(source, &OpenOptions::default())?;
        let orbit = Orbit { azimuth, elevation, roll: 0.0 };
        let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal() * zoom, viewport, orbit);
        let mut renderer = Renderer::new(&device, &volume, &transfer)?;
        let (frame, _) = renderer.render(&camera, viewport, &Settings::default())?;
        let path = folder.join(format!("{name}.png"));
        frame.save(&path, background)?;
        println!("{}", path.display());
    }
    Ok(())
}
