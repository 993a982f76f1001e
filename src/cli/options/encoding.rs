//! Options for the encoding of picture files.

use crate::cli::{command_line, parse};
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
    /// Leave out the command line, which .png and .exr pictures otherwise have in their metadata
    #[arg(long)]
    no_metadata: bool,
}

impl EncodingOptions {
    /// Pixels per inch, if given.
    pub fn dpi(&self) -> Option<NonZeroU16> {
        self.dpi
    }

    pub fn encoding(&self) -> Encoding {
        let description = (!self.no_metadata).then(command_text);
        Encoding { bits: self.bits, dither: self.dither, dpi: self.dpi, description }
    }
}

/// The command line of this process, as a shell reads it. Arguments that are not Unicode are shown with replacement characters.
fn command_text() -> String {
    let words = command_line::words();
    let arguments = words.iter().skip(1).map(|argument| quoted(&argument.to_string_lossy()));
    std::iter::once("layersplat".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// An argument, in quotes if a shell would change it.
pub(in crate::cli) fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,@%+=".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        return argument.into();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_quoted_where_a_shell_needs_it() {
        for (argument, expected) in [
            ("--size=3x4", "--size=3x4"),
            ("my file.raw", "'my file.raw'"),
            ("", "''"),
            ("it's", r"'it'\''s'"),
            ("#ff0000", "'#ff0000'"),
            ("20:220,:,40:", "20:220,:,40:"),
        ] {
            assert_eq!(quoted(argument), expected);
        }
    }
}
