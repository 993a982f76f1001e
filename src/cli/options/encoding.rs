//! Options for the encoding of picture files.

use crate::cli::parse;
use crate::image::{BitDepth, Encoding};
use clap::Args;
use std::num::NonZeroU16;

/// Bits, dithering and resolution of picture files.
#[derive(Args)]
#[command(next_help_heading = "Camera and picture")]
pub(in crate::cli) struct EncodingOptions {
    /// Bits per channel, 8 or 16 (.png, .tif) [default: 8; .exr and .npy: floats]
    #[arg(long, value_parser = parse::bits, value_name = "N", allow_hyphen_values = true)]
    bits: Option<BitDepth>,
    /// Dither 8-bit pixels by a fixed blue-noise pattern, against bands in smooth shades
    #[arg(long)]
    dither: bool,
    /// Resolution to write into .png, .jpg, .tif and .exr, in pixels per inch
    #[arg(long, value_parser = clap::value_parser!(NonZeroU16), value_name = "N")]
    dpi: Option<NonZeroU16>,
}

impl EncodingOptions {
    pub fn encoding(&self) -> Encoding {
        Encoding { bits: self.bits, dither: self.dither, dpi: self.dpi }
    }
}
