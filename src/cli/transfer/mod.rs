//! `layersplat transfer`: transfer functions by themselves.

mod picture;

use super::options::{TransferOptions, VolumeOptions};
use super::parse;
use super::scene::{described, open_transfer};
use super::standard::Output;
use crate::error::Error;
use crate::image::{ImageFormat, write_whole};
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
    /// List the names that --transfer takes
    #[arg(long, conflicts_with_all = ["output", "json"])]
    list: bool,
    /// Picture of histogram, opacities and colours (.png, .npy), or the function itself for ParaView (.json), 3D Slicer (.vp, .vp.json) or
    /// as lines of value,r,g,b,a (.csv); on standard output - for PNG, or json:- and so on [default: tell it in a line]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Size of the picture in pixels
    #[arg(long, default_value = "640x360", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    size: Viewport,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

/// A transfer function as it is told: values with opacities; values with red, green and blue.
#[derive(Serialize)]
pub(super) struct Told {
    name: String,
    opacities: Vec<[f64; 2]>,
    colors: Vec<[f64; 4]>,
}

impl Told {
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
        let names: Vec<&str> = TransferFunction::names().collect();
        super::report(false, &names, || names.join("\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    // A wrong ending is refused before any work.
    let target = arguments.output.as_deref().map(|path| Output::of(path, Some("png"))).transpose()?;
    let output = target.as_ref().map(|target| Content::of(target.path()).map_err(|e| target.renamed(e))).transpose()?;
    target.as_ref().map_or(Ok(()), |target| target.refuse_report(arguments.json))?;
    let volume = arguments.volume.open(None, None)?;
    let transfer = open_transfer(&arguments.transfer, &volume)?;
    if let (Some(target), Some(output)) = (&target, output) {
        output.write(target.path(), &transfer, &volume, arguments.size)?;
        if target.is_standard() {
            return target.finish(target.path());
        }
    }
    super::report(arguments.json, &Told::new(&transfer), || match &arguments.output {
        Some(path) => path.display().to_string(),
        None => described(&transfer),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// What is written.
enum Content {
    Picture,
    Function(FileFormat),
}

impl Content {
    /// What a file name's ending asks for.
    fn of(path: &Path) -> Result<Self, Error> {
        if ImageFormat::from_path(path).is_ok() {
            return Ok(Content::Picture);
        }
        FileFormat::from_path(path).map(Content::Function).map_err(|_| Error::UnknownName {
            what: "transfer function format",
            name: path.display().to_string(),
            known: "a name ending in .png or .npy for a picture, .json (ParaView), .vp or .vp.json (3D Slicer), or .csv".into(),
        })
    }

    fn write(&self, path: &Path, transfer: &TransferFunction, volume: &Volume, size: Viewport) -> Result<(), Error> {
        match self {
            Content::Picture => picture::drawn(transfer, volume, size)?.save(path, None),
            Content::Function(format) => {
                let text = transfer.to_text(*format);
                write_whole(path, |out| out.write_all(text.as_bytes()))
            }
        }
    }
}
