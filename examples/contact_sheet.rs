//! A contact sheet of all volumes of a folder, each with its automatic transfer function:
//! `cargo run --release --example contact_sheet ../shared/volumes docs/guide/images/volumes.jpg`.

use image::{RgbaImage, imageops};
use layersplat::framing::{Fixed, Framing};
use layersplat::{
    Background, Device, DeviceChoice, Error, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::path::{Path, PathBuf};

const COLUMNS: usize = 5;
const SIZE: [u32; 2] = [320, 280];

fn picture(device: &Device, path: &Path) -> Result<RgbaImage, Error> {
    let volume = Volume::open(path, &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&volume);
    // Four rays per pixel.
    let viewport = Viewport::new(2 * SIZE[0], 2 * SIZE[1])?;
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = Framing::visible(&volume, &transfer, None).parallel(orbit, viewport, Fixed::default());
    let (frame, _) = Renderer::new(device, &volume, &transfer)?.render(&camera, viewport, &Settings::default())?;
    let bytes = frame.averaged(2)?.to_rgba8(Background::BLACK);
    Ok(RgbaImage::from_raw(SIZE[0], SIZE[1], bytes).expect("four bytes per pixel"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let (Some(folder), Some(sheet)) = (arguments.next(), arguments.next()) else {
        return Err("give a folder of volumes and the file of the picture".into());
    };
    let mut volumes: Vec<PathBuf> = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    volumes.retain(|path| path.extension().is_some_and(|ending| ending != "md"));
    volumes.sort();
    let device = Device::open(&DeviceChoice::Default)?;
    let rows = volumes.len().div_ceil(COLUMNS) as u32;
    let mut all = RgbaImage::from_pixel(COLUMNS as u32 * SIZE[0], rows * SIZE[1], image::Rgba([0, 0, 0, 255]));
    for (n, path) in volumes.iter().enumerate() {
        let place = [n % COLUMNS, n / COLUMNS].map(|at| at as i64);
        imageops::replace(&mut all, &picture(&device, path)?, place[0] * i64::from(SIZE[0]), place[1] * i64::from(SIZE[1]));
        println!("{}", path.display());
    }
    image::DynamicImage::from(all).to_rgb8().save(sheet)?;
    Ok(())
}
