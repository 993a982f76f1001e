//! `layersplat transfer`: lists, plots and converts transfer functions.

mod picture;

use super::options::{TransferOptions, VolumeOptions};
use super::parse;
use super::remarks::describe;
use super::scene::open_transfer;
use super::standard::Output;
use crate::error::Error;
use crate::image::{ImageFormat, write_whole};
use crate::settings::Blend;
use crate::transfer::{FileFormat, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::Volume;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    volume: VolumeOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    /// List the names accepted by --transfer, --preset and --palette
    #[arg(long, conflicts_with_all = ["output", "json"])]
    list: bool,
    /// Write a plot (.png, .npy), or the function (.json, .vp, .vp.json, .csv); standard output: -, json:- and so on
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Size of the plot in pixels
    #[arg(long, default_value = "640x360", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    size: Viewport,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

/// Report on a transfer function.
#[derive(Serialize)]
pub(super) struct TransferReport {
    name: String,
    /// Values with opacities.
    opacities: Vec<[f64; 2]>,
    /// Values with red, green and blue.
    colors: Vec<[f64; 4]>,
}

impl TransferReport {
    pub fn new(transfer: &TransferFunction) -> Self {
        Self {
            name: transfer.name().into(),
            opacities: transfer.opacities().iter().map(|&(value, opacity)| [value, opacity]).collect(),
            colors: transfer.colors().iter().map(|&(value, [r, g, b])| [value, r, g, b]).collect(),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    if arguments.list {
        super::report(false, &(), listed)?;
        return Ok(ExitCode::SUCCESS);
    }
    // Checks the file name before any work.
    let target = arguments.output.as_deref().map(|path| Output::new(path, Some("png"))).transpose()?;
    let content =
        target.as_ref().map(|target| Content::from_path(target.path()).map_err(|e| target.with_given_name(e))).transpose()?;
    target.as_ref().map_or(Ok(()), |target| target.check_report(arguments.json))?;
    let volume = arguments.volume.open(None, None)?;
    let transfer = open_transfer(&arguments.transfer, &volume, Blend::Composite)?;
    if let (Some(target), Some(content)) = (&target, content) {
        content.write(target.path(), &transfer, &volume, arguments.size)?;
        if target.is_standard() {
            return target.finish(target.path());
        }
    }
    super::report(arguments.json, &TransferReport::new(&transfer), || match &arguments.output {
        Some(path) => path.display().to_string(),
        None => describe(&transfer),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// All names, in a group for each option.
fn listed() -> String {
    let lines = |names: &mut dyn Iterator<Item = String>| names.map(|name| format!("  {name}\n")).collect::<String>();
    let names = lines(&mut TransferFunction::names().map(String::from));
    let presets = lines(&mut TransferFunction::presets().map(|(name, shows)| format!("{name:<12} {shows}")));
    let palettes = lines(&mut TransferFunction::palettes().map(String::from));
    format!("--transfer\n{names}--preset\n{presets}--palette\n{palettes}")
}

/// Content of the output file.
enum Content {
    Plot,
    Function(FileFormat),
}

impl Content {
    /// The content for a file name's extension.
    fn from_path(path: &Path) -> Result<Self, Error> {
        if ImageFormat::from_path(path).is_ok() {
            return Ok(Content::Plot);
        }
        FileFormat::from_path(path).map(Content::Function).map_err(|_| Error::UnknownName {
            what: "transfer function format",
            name: path.display().to_string(),
            known: "a name ending in .png or .npy for a plot, .json (ParaView), .vp or .vp.json (3D Slicer), or .csv".into(),
        })
    }

    fn write(&self, path: &Path, transfer: &TransferFunction, volume: &Volume, size: Viewport) -> Result<(), Error> {
        match self {
            Content::Plot => picture::plot(transfer, volume, size)?.save(path, None),
            Content::Function(format) => {
                let text = transfer.to_text(*format);
                write_whole(path, |out| out.write_all(text.as_bytes()))
            }
        }
    }
}
