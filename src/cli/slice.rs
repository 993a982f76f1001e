//! `layersplat slice`.

use super::check;
use super::compiling;
use super::names;
use super::options::{DeviceOptions, EncodingOptions, TransferOptions, VolumeOptions};
use super::parse;
use super::remarks::{describe, remark_on_volume};
use super::scene::open_transfer;
use super::standard::Output;
use super::values::Along;
use crate::camera::Up;
use crate::check::Family;
use crate::device::Device;
use crate::error::Error;
use crate::files::check_writable;
use crate::framing::Orientation;
use crate::image::{Background, ImageFormat};
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::settings::{Blend, ClipPlane};
use crate::slice::{Slice, SliceAxis, SliceColors};
use crate::transfer::{TransferFunction, Value};
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use glam::DVec3;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    volume: VolumeOptions,
    #[command(flatten)]
    place: PlaceOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    /// With a transfer function: opacity of a layer this many unit distances thick [default: opaque wherever there is any opacity]
    #[arg(long, value_parser = parse::positive, value_name = "T", allow_hyphen_values = true, help_heading = "Transfer function")]
    thickness: Option<f64>,
    #[command(flatten)]
    picture: SlicePicture,
    #[command(flatten)]
    device: DeviceOptions,
    /// Output picture: .png, .jpg, .tif, .webp, .exr or .npy; standard output: - (PNG), jpg:-, npy:- and so on
    #[arg(short, long, default_value = "slice.png", value_name = "FILE")]
    output: PathBuf,
    /// Write the data values instead of colours, NaN outside the volume (.npy)
    #[arg(long)]
    values: bool,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

/// Where a slice lies.
#[derive(clap::Args)]
#[command(next_help_heading = "Slice")]
struct PlaceOptions {
    /// Axis that the slice is perpendicular to [default: axial if the file says how the patient lies, else z]
    #[arg(long, value_name = "AXIS", value_parser = names::of::<SliceAxis>())]
    axis: Option<SliceAxis>,
    /// Place along the axis: number of a slice of x, y, z from 0, also between two; axial, coronal, sagittal: world coordinate; N%: of all [default: 50%]
    #[arg(long, value_name = "N|N%", value_parser = parse::along, allow_hyphen_values = true)]
    at: Option<Along>,
    /// World point in the slice and at the centre of the picture, instead of --at
    #[arg(long, value_parser = parse::vector, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "at")]
    center: Option<DVec3>,
    /// Any plane: a world point, at the centre of the picture with --parallel-scale, and the direction from which the slice is seen
    #[arg(long, value_parser = parse::clip_plane, value_name = "X,Y,Z,NX,NY,NZ", allow_hyphen_values = true,
        conflicts_with_all = ["axis", "at", "center"])]
    plane: Option<ClipPlane>,
    /// Axis of the world that points up in the picture of a plane [default: as in render]
    #[arg(long, value_parser = names::of::<Up>(), value_name = "AXIS", allow_hyphen_values = true, requires = "plane")]
    up: Option<Up>,
    /// Half the height of the picture in world units [default: all of the slice]
    #[arg(long, value_parser = parse::positive, value_name = "SCALE", allow_hyphen_values = true)]
    parallel_scale: Option<f64>,
}

/// Size, kernel and encoding of the picture.
#[derive(clap::Args)]
#[command(next_help_heading = "Picture")]
struct SlicePicture {
    /// Reconstruction kernel
    #[arg(long, visible_alias = "interpolation", value_name = "NAME", default_value = "linear", value_parser = names::of::<Kernel>())]
    kernel: Kernel,
    /// Size of the picture in pixels
    #[arg(long, default_value = "512x512", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    size: Viewport,
    /// black, white, grey, #rrggbb, R,G,B or transparent [default: black; .exr and .npy: no background]
    #[arg(long, value_name = "COLOR")]
    background: Option<Background>,
    #[command(flatten)]
    encoding: EncodingOptions,
}

#[derive(Serialize)]
struct Sliced<'a> {
    output: String,
    volume: &'a str,
    device: &'a str,
    width: u32,
    height: u32,
    axis: Option<&'static str>,
    /// Coordinate along the axis.
    at: Option<f64>,
    center: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    parallel_scale: f64,
    kernel: Kernel,
    /// Level and width.
    window: Option<[f64; 2]>,
    transfer: Option<&'a str>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let output = Output::new(&arguments.output, Some("png"))?;
    output.check_report(arguments.json)?;
    arguments.check_output(output.path()).map_err(|e| output.with_given_name(e))?;
    let Arguments { picture, .. } = arguments;
    if arguments.volume.is_default() {
        eprintln!("volume: {}, which is built in; name a file to show your own", VolumeOptions::DEFAULT);
    }
    let volume = arguments.volume.open(Some(picture.size), None)?;
    remark_on_volume(&arguments.volume, &volume);
    let grid = volume.grid();
    let axis = arguments.place.axis(grid);
    let slice = arguments.place.slice(grid, axis, picture.size)?;
    let (transfer, colors) = arguments.colors(&volume)?;
    colors.check()?;
    let device = Device::open(&arguments.device.choice())?;
    // Slices sample and colour the field by the code of these kernels.
    check::require(&device, &BTreeSet::from([Family::CastValues]), &arguments.device)?;
    let mut renderer = Renderer::new(&device, &volume, &transfer)?;
    let kernel = picture.kernel;
    if arguments.values {
        compiling::while_rendering(|| renderer.slice_values(&slice, picture.size, kernel))?.save(output.path())?;
    } else {
        let frame = compiling::while_rendering(|| renderer.slice(&slice, picture.size, kernel, colors))?;
        frame.save_encoded(output.path(), picture.background, &picture.encoding.encoding(), None)?;
    }
    if output.is_standard() {
        return output.finish(output.path());
    }
    let [right, up] = slice.basis()?;
    let has_transfer = matches!(colors, SliceColors::Transfer { .. });
    let report = Sliced {
        output: arguments.output.display().to_string(),
        volume: volume.name(),
        device: &device.info().name,
        width: picture.size.width,
        height: picture.size.height,
        axis: axis.map(SliceAxis::name),
        at: axis.map(|axis| axis.coordinate(grid, slice.centre)),
        center: slice.centre.to_array(),
        right: right.to_array(),
        up: up.to_array(),
        parallel_scale: slice.scale,
        kernel,
        window: if let SliceColors::Window { level, width } = colors { Some([level, width]) } else { None },
        transfer: has_transfer.then(|| transfer.name()),
    };
    super::report(arguments.json, &report, || report.output.clone())?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn check_output(&self, path: &Path) -> Result<(), Error> {
        let (format, encoding) = (ImageFormat::from_path(path)?, self.picture.encoding.encoding());
        if self.values && format != ImageFormat::Npy {
            let problem = format!("{} cannot hold data values: use an .npy file", path.display());
            return Err(Error::Settings { field: "values", problem });
        }
        format.accept(self.picture.background)?;
        encoding.check(format)?;
        check_writable(path)
    }

    /// The transfer function and what is shown of it: its colours if any option is about them, else a window of grey.
    fn colors(&self, volume: &Volume) -> Result<(TransferFunction, SliceColors), Error> {
        let options = &self.transfer;
        let chooses_colors = options.transfer.is_some() || options.preset.is_some() || options.palette.is_some();
        let is_colored =
            chooses_colors || options.changes_opacity() || options.transfer_range.is_some() || self.thickness.is_some();
        if is_colored {
            let mut transfer = open_transfer(options, volume, Blend::Composite)?;
            if let Some((lo, _)) = options.window.map(|_| transfer.range()).filter(|_| !options.changes_opacity()) {
                // A window of colours has no opacity of its own.
                transfer = transfer.with_opacities(vec![(lo, 1.0)])?;
            }
            if !chooses_colors {
                eprintln!("transfer function: {} (choose another with --transfer)", describe(&transfer));
            }
            return Ok((transfer, SliceColors::Transfer { thickness: self.thickness.unwrap_or(f64::INFINITY) }));
        }
        let ramp = TransferFunction::grey_ramp(volume);
        let (level, width) = match options.window {
            Some((level, width)) => (Value::finder(volume)(level), width),
            None => {
                let (lo, hi) = ramp.range();
                let (level, width) = ((lo + hi) / 2.0, hi - lo);
                eprintln!(
                    "window: level {level:.6}, width {width:.6} (choose another with --window, or colours with --transfer)"
                );
                (level, width)
            }
        };
        Ok((ramp, SliceColors::Window { level, width }))
    }
}

impl PlaceOptions {
    /// The axis of the slice; `None` for a plane.
    fn axis(&self, grid: &Grid) -> Option<SliceAxis> {
        self.plane.is_none().then(|| self.axis.unwrap_or(SliceAxis::three(grid)[0]))
    }

    fn slice(&self, grid: &Grid, axis: Option<SliceAxis>, size: Viewport) -> Result<Slice, Error> {
        let slice = match (axis, self.plane) {
            (Some(axis), _) => match (self.center, self.at.unwrap_or(Along::Share(0.5))) {
                (Some(point), _) => Slice { centre: point, ..Slice::through(grid, axis, point, size)? },
                (None, Along::Coordinate(at)) => Slice::at(grid, axis, at, size)?,
                (None, Along::Share(share)) => {
                    let (lo, hi) = axis.range(grid)?;
                    Slice::at(grid, axis, lo + (hi - lo) * share, size)?
                }
            },
            (None, plane) => {
                let ClipPlane { point, normal } = plane.expect("without an axis there is a plane");
                let fitted = Slice::facing(grid, point, normal, self.up_of_plane(grid, normal), size)?;
                if self.parallel_scale.is_some() { Slice { centre: point, ..fitted } } else { fitted }
            }
        };
        Ok(Slice { scale: self.parallel_scale.unwrap_or(slice.scale), ..slice })
    }

    /// The direction that points up: as given, or that of the volume, or another if it is the normal of the plane.
    fn up_of_plane(&self, grid: &Grid, normal: DVec3) -> DVec3 {
        let of_volume = Orientation::of(grid).up().direction();
        let is_along = normal.normalize().dot(of_volume).abs() > 1.0 - 1e-9;
        self.up.map_or(if is_along { of_volume.any_orthogonal_vector() } else { of_volume }, Up::direction)
    }
}
