//! The API in a minimal example: `cargo run --release --example minimal`.

use layersplat::framing::{Fixed, Framing};
use layersplat::{Device, DeviceChoice, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume};

fn main() -> Result<(), layersplat::Error> {
    let volume = Volume::open("builtin:hydrogen@96", &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&volume);
    let device = Device::open(&DeviceChoice::Default)?;
    let mut renderer = Renderer::new(&device, &volume, &transfer)?;

    let viewport = Viewport::new(512, 512)?;
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = Framing::visible(&volume, &transfer, None).parallel(orbit, viewport, Fixed::default());
    let (frame, _) = renderer.render(&camera, viewport, &Settings::default())?;
    frame.save("minimal.png", None)?;
    println!("minimal.png");
    Ok(())
}
