//! A slice in a PNG picture.

use super::bytes::{Bytes, Held};
use super::load::{self, Header, Opened, upright};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::memory;
use crate::volume::{ChannelDescription, Contents, Endian, ScalarType};
use glam::DVec3;
use image::codecs::png::PngDecoder;
use image::{ImageDecoder, Limits};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// PNG.
pub(super) struct Png;

/// Largest compression ratio of deflate.
const LIMIT: u64 = 1032;

impl Format for Png {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(b"\x89PNG\r\n\x1a\n")
    }

    fn channels(&self, _: &Found, _: &OpenOptions, count: usize) -> Result<Vec<ChannelDescription>, Error> {
        Ok(ChannelDescription::of_components(count))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let decoder = decoder(path)?;
        let ((x, y), all, color) = (decoder.dimensions(), decoder.total_bytes(), decoder.color_type());
        let channels = usize::from(color.channel_count());
        let scalar = if usize::from(color.bytes_per_pixel()) == channels { ScalarType::Uint8 } else { ScalarType::Uint16 };
        let grid = load::grid(path, [x as usize, y as usize, 1], upright(DVec3::ONE, DVec3::ZERO), options)?;
        let mut contents = Contents { states_spacing: false, ..Contents::default() };
        let channel = contents.choose_channel(path, options, channels)?;
        let header = Header { endian: Endian::NATIVE, ..Header::new(grid, scalar) }
            .with_channels_inside(channel, channels)
            .with_contents(contents);
        let packed = std::fs::metadata(path).map_err(|e| Error::read(path, e))?.len();
        let bytes = Picture { path: path.into(), most: all.min(packed.saturating_mul(LIMIT)), decoded: None };
        Ok(Opened { header, bytes: Box::new(bytes), exact: false })
    }
}

fn decoder(path: &Path) -> Result<PngDecoder<BufReader<File>>, Error> {
    let file = File::open(path).map_err(|e| Error::read(path, e))?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(memory::available());
    PngDecoder::with_limits(BufReader::new(file), limits).map_err(|e| Error::volume(path, format!("its picture is damaged: {e}")))
}

/// A picture that is decoded on first access.
struct Picture {
    path: PathBuf,
    most: u64,
    decoded: Option<Held>,
}

impl Picture {
    fn decoded(&mut self) -> io::Result<&mut Held> {
        let held = match self.decoded.take() {
            Some(held) => held,
            None => {
                let decoder = decoder(&self.path).map_err(|e| io::Error::other(e.to_string()))?;
                let bytes = memory::zeroed(&self.path.display().to_string(), decoder.total_bytes() as usize);
                let mut bytes = bytes.map_err(|e| io::Error::other(e.to_string()))?;
                decoder.read_image(&mut bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.to_string()))?;
                Held(bytes)
            }
        };
        Ok(self.decoded.insert(held))
    }
}

impl Bytes for Picture {
    fn most(&self) -> u64 {
        self.most
    }

    fn read(&mut self, at: u64, bytes: &mut [u8]) -> io::Result<usize> {
        self.decoded()?.read(at, bytes)
    }

    fn ends_at(&mut self, end: u64) -> io::Result<bool> {
        Ok(self.most == end)
    }
}
