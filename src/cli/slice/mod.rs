//! `layersplat slice`.

mod colors;
mod fields;
mod labels;

use crate::annotation::with_letters;
use crate::camera::Up;
use crate::check::Family;
use crate::cli::channels::{ChannelOptions, FieldLook, Fields};
use crate::cli::check;
use crate::cli::colors::reject_beside_labels;
use crate::cli::compiling;
use crate::cli::names;
use crate::cli::options::{DeviceOptions, EncodingOptions, LabelOptions, TransferOptions, VolumeOptions};
use crate::cli::parse;
use crate::cli::remarks::{describe, remark_on_volume};
use crate::cli::scene::{adjusted, open_transfer};
use crate::cli::standard::Output;
use crate::cli::values::{Along, Component};
use crate::device::Device;
use crate::error::Error;
use crate::files::check_writable;
use crate::framing::Orientation;
use crate::image::{Background, Frame, ImageFormat};
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::settings::{Blend, ClipPlane};
use crate::slice::{Convention, Slice, SliceAxis, SliceColors, patient_letters};
use crate::transfer::{TransferFunction, Value};
use crate::viewport::Viewport;
use crate::volume::{ColorChannels, Grid, Labels, Volume};
use colors::slice_of_colors;
use fields::{SliceView, over};
use glam::DVec3;
use labels::{ids_on_slice, slice_of_labels, slice_under_labels};
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
    channels: ChannelOptions,
    #[command(flatten)]
    labels: LabelOptions,
    #[command(flatten)]
    transfer: TransferOptions,
    /// With a transfer function: opacity of a layer this many unit distances thick [default: opaque wherever there is any opacity; of several fields: 1]
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
    /// Letters of the patient's directions at the edges [default: on in pictures of 8 bits, if the file says how the patient lies]
    #[arg(long, value_parser = parse::switch, value_name = "on|off")]
    letters: Option<bool>,
    #[command(flatten)]
    encoding: EncodingOptions,
}

/// What a slice shows.
enum Content {
    Labels(Labels),
    /// Red, green, blue and possibly alpha.
    Colors(Vec<Volume<'static>>),
    /// Values of a volume, and of these fields.
    Values(Box<Fields>),
}

#[derive(Serialize)]
struct Sliced {
    output: String,
    volume: String,
    /// Present unless labels are shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    device: Option<String>,
    width: u32,
    height: u32,
    axis: Option<&'static str>,
    /// Coordinate along the axis.
    at: Option<f64>,
    center: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    /// Whether the patient's left is on the right (radiological) or on the left, if the file says how the patient lies.
    convention: Option<&'static str>,
    parallel_scale: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    kernel: Option<Kernel>,
    /// Level and width.
    window: Option<[f64; 2]>,
    transfer: Option<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let output = Output::new(&arguments.output, Some("png"))?;
    output.check_report(arguments.json)?;
    arguments.check_output(output.path()).map_err(|e| output.with_given_name(e))?;
    let Arguments { picture, .. } = arguments;
    if arguments.volume.is_default() && !arguments.channels.has_scene() {
        eprintln!("volume: {}, which is built in; name a file to show your own", VolumeOptions::DEFAULT);
    }
    let (volume, content) = match arguments.volume.labels(&arguments.labels, picture.size)? {
        // The first layer places the slice.
        Some(labels) => (labels.layers()[0].indices(None)?, Content::Labels(labels)),
        None => arguments.open_values()?,
    };
    remark_on_volume(&arguments.volume, &volume);
    let grid = volume.grid();
    let axis = arguments.place.axis(grid);
    let slice = arguments.place.slice(grid, axis, picture.size)?;
    let report = arguments.report(&volume, axis, &slice)?;
    let report = match content {
        Content::Labels(labels) => {
            arguments.draw_labels(&labels, &slice, output.path(), grid)?;
            report
        }
        Content::Colors(components) => arguments.draw_colors(&components, &slice, output.path(), report)?,
        Content::Values(fields) => arguments.draw_values(&volume, *fields, &slice, output.path(), report)?,
    };
    if output.is_standard() {
        return output.finish(output.path());
    }
    if let Some(convention) = report.convention {
        let side = if convention == Convention::Radiological.name() { "right" } else { "left" };
        eprintln!("convention: {convention}, the patient's left is on the {side}");
    }
    crate::cli::report(arguments.json, &report, || report.output.clone())?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    /// Whether the slice shows the colours of the file: it says that it has some, and no option is about values.
    fn shows_colors(&self) -> bool {
        let are_values = self.values
            || self.thickness.is_some()
            || self.channels.are_given()
            || self.labels.is_given()
            || self.volume.has_background_value()
            || self.transfer.given().next().is_some();
        !are_values && self.volume.declares_colors(self.picture.size)
    }

    /// Opens the volume and the fields that are drawn together with it, or its colours.
    fn open_values(&self) -> Result<(Volume<'static>, Content), Error> {
        let size = self.picture.size;
        if self.shows_colors() {
            let colors =
                ColorChannels::of(&self.volume.channel_descriptions(Some(size))?).expect("colours are three channels or more");
            let component = |&number: &usize| self.volume.open_component(&Component::Number(number), Some(size));
            let components = colors.straight(colors.numbers().iter().map(component).collect::<Result<_, _>>()?)?;
            return Ok((components[0].clone(), Content::Colors(components)));
        }
        let volume = match self.channels.first_component() {
            Some(first) => self.volume.open_component(&first, Some(size))?,
            None => self.volume.open(Some(size), None)?,
        };
        let mut fields = self.channels.open(&self.volume, (&volume, None), size, &[])?;
        if !fields.surfaces.is_empty() {
            let problem = "has surfaces, which slices do not show: take them out of the scene".into();
            return Err(Error::Settings { field: "scene", problem });
        }
        if fields.first_shown.is_some() {
            let problem =
                "begins with colours or labels, which slices draw alone: slice their file, or name the scan first".into();
            return Err(Error::Settings { field: "scene", problem });
        }
        let volume = fields.first.take().unwrap_or(volume);
        Ok((self.labels.masked(volume, self.volume.placement())?, Content::Values(Box::new(fields))))
    }

    /// The report, but for what values are shown with.
    fn report(&self, volume: &Volume, axis: Option<SliceAxis>, slice: &Slice) -> Result<Sliced, Error> {
        let (grid, [right, up], size) = (volume.grid(), slice.basis()?, self.picture.size);
        let convention = if grid.has_anatomy() { slice.convention()? } else { None };
        Ok(Sliced {
            output: self.output.display().to_string(),
            volume: volume.name().into(),
            device: None,
            width: size.width,
            height: size.height,
            axis: axis.map(SliceAxis::name),
            at: axis.map(|axis| axis.coordinate(grid, slice.centre)),
            center: slice.centre.to_array(),
            right: right.to_array(),
            up: up.to_array(),
            convention: convention.map(Convention::name),
            parallel_scale: slice.scale,
            kernel: None,
            window: None,
            transfer: None,
        })
    }

    /// Writes a slice of values, with labels over it if they are asked for.
    fn draw_values(&self, volume: &Volume, fields: Fields, slice: &Slice, path: &Path, report: Sliced) -> Result<Sliced, Error> {
        let SlicePicture { kernel, size, .. } = self.picture;
        let labels =
            self.labels.label_colors(self.volume.placement())?.map(|labels| labels.over(volume.description())).transpose()?;
        let own = fields.first_transfer(volume, Blend::Composite)?.filter(|_| !self.transfer.is_given());
        let look = fields.first_look(volume);
        let others = fields.into_others(Blend::Composite)?;
        if others.iter().map(|field| &field.look).chain([&look]).any(|look| look.iso.is_some() || look.gradient_opacity.is_some())
        {
            let problem = "have no surfaces and gradients in slices: omit iso and gradient-opacity".into();
            return Err(Error::Settings { field: "channels", problem });
        }
        let (transfer, colors) = match own {
            Some(own) => {
                let thickness = self.thickness.unwrap_or(f64::INFINITY);
                (adjusted(&self.transfer, volume, own)?, SliceColors::Transfer { thickness })
            }
            None => self.colors(volume)?,
        };
        colors.check()?;
        let device = Device::open(&self.device.choice())?;
        // Slices sample and colour the field by the code of these kernels.
        check::require(&device, &BTreeSet::from([Family::CastValues]), &self.device)?;
        let mut renderer = Renderer::new(&device, volume, &transfer)?;
        let is_one = others.is_empty() && look == FieldLook::default();
        if self.values {
            if !is_one {
                let problem = "are those of one field: omit the others".into();
                return Err(Error::Settings { field: "channels", problem });
            }
            if labels.is_some() {
                let problem = "colour pictures, and the values of the scan are written: omit it".into();
                return Err(Error::Settings { field: "label_colors", problem });
            }
            compiling::while_rendering(|| renderer.slice_values(slice, size, kernel))?.save(path)?;
        } else {
            let view = SliceView { device: &device, slice, size, kernel, thickness: self.thickness.unwrap_or(1.0) };
            let frame = compiling::while_rendering(|| match colors {
                _ if is_one => renderer.slice(slice, size, kernel, colors),
                // Further fields lie over a slice in grey, and are mixed with one in colours.
                SliceColors::Window { .. } if look.visible => {
                    Ok(over(&view.together(None, &others)?, &renderer.slice(slice, size, kernel, colors)?))
                }
                SliceColors::Window { .. } => view.together(None, &others),
                SliceColors::Transfer { .. } => {
                    let first = if look.visible { Some(view.colors(&mut renderer, look.factor)?) } else { None };
                    view.together(first, &others)
                }
            })?;
            let frame = match labels {
                Some(labels) => slice_under_labels(&frame, &labels, slice)?,
                None => frame,
            };
            self.save(frame, slice, volume.grid(), path)?;
        }
        let has_transfer = matches!(colors, SliceColors::Transfer { .. });
        Ok(Sliced {
            device: Some(device.info().name.clone()),
            kernel: Some(kernel),
            window: if let SliceColors::Window { level, width } = colors { Some([level, width]) } else { None },
            transfer: has_transfer.then(|| transfer.name().into()),
            ..report
        })
    }

    /// Writes a slice of colours.
    fn draw_colors(&self, components: &[Volume], slice: &Slice, path: &Path, report: Sliced) -> Result<Sliced, Error> {
        let SlicePicture { kernel, size, .. } = self.picture;
        let device = Device::open(&self.device.choice())?;
        check::require(&device, &BTreeSet::from([Family::CastValues]), &self.device)?;
        let frame = compiling::while_rendering(|| slice_of_colors(&device, components, slice, size, kernel))?;
        self.save(frame, slice, components[0].grid(), path)?;
        Ok(Sliced { device: Some(device.info().name.clone()), kernel: Some(kernel), ..report })
    }

    /// Writes a slice of labels: the colours of the nearest ones, or their ids.
    fn draw_labels(&self, labels: &Labels, slice: &Slice, path: &Path, grid: &Grid) -> Result<(), Error> {
        if self.channels.are_given() {
            let problem = "are not drawn together with labels: omit them, or lay the labels over the scan, as `slice SCAN --label-colors LABELS`";
            return Err(Error::Settings { field: "channels", problem: problem.into() });
        }
        reject_beside_labels(&self.transfer, &self.volume, &self.labels)?;
        if self.thickness.is_some() {
            let problem = "is that of a layer of values; labels have their own opacities: omit it".into();
            return Err(Error::Settings { field: "thickness", problem });
        }
        if self.labels.has_surfaces() {
            let problem = "are those of pictures; slices show the label of the nearest voxel: omit it".into();
            return Err(Error::Settings { field: "label_surfaces", problem });
        }
        if self.values {
            return ids_on_slice(labels, slice, self.picture.size)?.save(path);
        }
        self.save(slice_of_labels(labels, slice, self.picture.size)?, slice, grid, path)
    }

    /// Writes a picture, with the letters of a patient's directions.
    fn save(&self, frame: Frame, slice: &Slice, grid: &Grid, path: &Path) -> Result<(), Error> {
        let SlicePicture { background, letters, .. } = self.picture;
        if letters == Some(true) && !grid.has_anatomy() {
            let problem = "need a volume that states how the patient lies, which this one does not: omit them";
            return Err(Error::Settings { field: "letters", problem: problem.into() });
        }
        let is_data = matches!(ImageFormat::from_path(path)?, ImageFormat::Npy | ImageFormat::Exr);
        let frame = if letters.unwrap_or(grid.has_anatomy() && !is_data) {
            let [right, up] = slice.basis()?;
            with_letters(frame, &[right, -right, up, -up].map(patient_letters), background.unwrap_or(Background::BLACK))?
        } else {
            frame
        };
        frame.save_encoded(path, background, &self.picture.encoding.encoding(), None)
    }

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
