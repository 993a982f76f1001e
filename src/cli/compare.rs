//! `layersplat compare`.

use super::parse;
use crate::error::Error;
use crate::image::{Comparison, read_image};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// First picture: .png, .jpg, .tif, .webp, .exr or .npy
    a: PathBuf,
    /// Second picture, of the same size
    b: PathBuf,
    /// Exit with 1 if any channel of any pixel differs by more than D (0 to 1)
    #[arg(long, value_parser = parse::finite, value_name = "D", visible_alias = "tolerance")]
    max_difference: Option<f64>,
    /// Exit with 1 if the PSNR over red, green and blue is below DB decibels
    #[arg(long, value_parser = parse::finite, value_name = "DB")]
    min_psnr: Option<f64>,
    /// Write a picture of the differences of red, green and blue, scaled so that the largest is full
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    comparison: Comparison,
    /// Roughness of both pictures.
    roughness: [Option<f64>; 2],
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let (a, b) = (read_image(&arguments.a)?, read_image(&arguments.b)?);
    let comparison = a.compare(&b).ok_or_else(|| Error::Image {
        path: arguments.b.clone(),
        problem: format!(
            "it has {}x{} pixels, {} has {}x{}",
            b.width(),
            b.height(),
            arguments.a.display(),
            a.width(),
            a.height()
        ),
    })?;
    if let Some(output) = &arguments.output {
        a.difference(&b)?.save(output, None)?;
    }
    let report = Report { comparison, roughness: [a.roughness(), b.roughness()] };
    super::report(arguments.json, &report, || text(&comparison))?;
    let too_far = arguments.max_difference.is_some_and(|limit| comparison.max_difference > limit)
        || arguments.min_psnr.is_some_and(|limit| comparison.psnr.is_some_and(|psnr| psnr < limit));
    Ok(ExitCode::from(u8::from(too_far)))
}

/// Formats decibels with a number of digits. Values that round to 0 have no sign.
pub(super) fn decibels(psnr: f64, digits: usize) -> String {
    let text = format!("{psnr:.digits$}");
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    text.strip_prefix('-').filter(|_| is_zero).map_or(text.clone(), String::from)
}

fn text(c: &Comparison) -> String {
    let psnr = |p: Option<f64>| p.map_or("identical".into(), |p| format!("{} dB", decibels(p, 2)));
    format!("PSNR RGB        {}\nPSNR RGBA       {}\nmax difference  {:.6}", psnr(c.psnr), psnr(c.psnr_rgba), c.max_difference)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        for (psnr, expected) in
            [(-0.0, "0.00"), (-0.004, "0.00"), (0.0, "0.00"), (-0.006, "-0.01"), (-10.0, "-10.00"), (42.125, "42.12")]
        {
            assert_eq!(decibels(psnr, 2), expected, "{psnr}");
        }
        assert_eq!(decibels(-0.04, 1), "0.0");
    }
}
