//! A contact sheet of volumes, each with its automatic transfer function, in one look or beside each other in several:
//! `cargo run --release --example contact_sheet docs/guide/images/volumes.jpg plain ../shared/volumes/*.gz`.
//! Looks, separated by commas: `plain`, `shadows` (with ambient occlusion), `studio`, and `traced`, the studio by path tracing, which takes
//! minutes.

use glam::DVec3;
use image::{RgbaImage, imageops};
use layersplat::framing::{Fixed, Framing};
use layersplat::image::Frame;
use layersplat::reference::PathTracer;
use layersplat::settings::{AmbientOcclusion, Light, Lights, Look, Shading, Shadows};
use layersplat::{
    Background, Camera, Device, DeviceChoice, Error, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};

/// Pixels of the sheet from left to right.
const WIDTH: u32 = 1600;
/// Paths per ray of a traced picture, in each of two halves. There are four rays per pixel.
const PATHS: usize = 12;

/// Two lights that stand as those of the studio.
fn shadows() -> Result<Settings, Error> {
    let key = Light::from_camera(DVec3::new(-1.0, 1.1, 0.9));
    let rim = Light { strength: 0.4, ..Light::from_camera(DVec3::new(1.2, 0.45, -0.5)) };
    Ok(Settings {
        shading: Some(Shading { lights: Lights::new(&[key, rim])?, ..Shading::default() }),
        shadows: Some(Shadows::default()),
        ambient_occlusion: Some(AmbientOcclusion::default()),
        ..Settings::default()
    })
}

fn traced(volume: &Volume, transfer: &TransferFunction, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
    let settings = Settings::default().with_look(Look::Studio).with_light_in_world(camera)?;
    let [one, other] = PathTracer::new(volume, transfer, &settings).halves(camera, viewport, 1, PATHS)?;
    let mean = one.pixels().iter().zip(other.pixels()).map(|(a, b)| std::array::from_fn(|n| 0.5 * (a[n] + b[n])));
    Ok(Frame::new(viewport, mean.collect()).with_curve(settings.curve()))
}

/// Pictures of a volume in some looks, of this size.
fn pictures(
    device: &Device,
    source: &str,
    looks: &[&str],
    [width, height]: [u32; 2],
) -> Result<Vec<RgbaImage>, Box<dyn std::error::Error>> {
    let volume = Volume::open(source, &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&volume);
    // Four rays per pixel.
    let viewport = Viewport::new(2 * width, 2 * height)?;
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = Framing::visible(&volume, &transfer, None).parallel(orbit, viewport, Fixed::default());
    let mut renderer = Renderer::new(device, &volume, &transfer)?;
    let mut all = Vec::new();
    for &look in looks {
        let settings = match look {
            "plain" => Some(Settings::default()),
            "shadows" => Some(shadows()?),
            "studio" => Some(Settings::default().with_look(Look::Studio)),
            "traced" => None,
            _ => return Err(format!("look {look}: choose plain, shadows, studio or traced").into()),
        };
        let frame = match settings {
            Some(settings) => renderer.render(&camera, viewport, &settings)?.0,
            None => traced(&volume, &transfer, &camera, viewport)?,
        };
        let bytes = frame.averaged(2)?.to_rgba8(Background::BLACK);
        all.push(RgbaImage::from_raw(width, height, bytes).ok_or("four bytes per pixel")?);
    }
    Ok(all)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [sheet, looks, volumes @ ..] = &arguments[..] else {
        return Err("give the file of the sheet, looks, and volumes".into());
    };
    let looks: Vec<&str> = looks.split(',').collect();
    // Looks of a volume stand beside each other.
    let columns = if looks.len() == 1 { 5 } else { (8 / looks.len()).max(1) * looks.len() };
    let size = [WIDTH / columns as u32, WIDTH * 7 / 8 / columns as u32];
    let device = Device::open(&DeviceChoice::Default)?;
    let rows = (volumes.len() * looks.len()).div_ceil(columns) as u32;
    let mut all = RgbaImage::from_pixel(columns as u32 * size[0], rows * size[1], image::Rgba([0, 0, 0, 255]));
    let mut place = 0;
    for volume in volumes {
        println!("{volume}");
        for picture in pictures(&device, volume, &looks, size)? {
            let [x, y] = [place % columns, place / columns];
            imageops::replace(&mut all, &picture, (x as u32 * size[0]).into(), (y as u32 * size[1]).into());
            place += 1;
        }
        // What is done so far can be looked at.
        image::DynamicImage::from(all.clone()).to_rgb8().save(sheet)?;
    }
    Ok(())
}
