//! Options that `render`, `rotate` and `bench` share.

use super::algorithm::{AlgorithmOptions, no_meaning};
use super::{parse, standard};
use crate::camera::Orbit;
use crate::device::DeviceChoice;
use crate::image::Background;
use crate::layers::{Correction, Density, Kernel};
use crate::settings::{
    Algorithm, Classification, Evaluation, Footprints, GradientOpacity, LayerAxis, Layered, Light, Lights, Quality, Settings,
    Shading,
};
use crate::transfer::{Extinction, Value};
use crate::viewport::Viewport;
use crate::volume::{Endian, Level, OpenOptions, ScalarType, Volume};
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::PathBuf;

/// Which volume, and what its name does not tell.
#[derive(Args)]
pub(super) struct VolumeOptions {
    /// A file (NRRD, NIfTI, MetaImage, VTK image data, NumPy, BOV, TIFF, DICOM, HDF5; NAME_XxYxZ_TYPE.raw or .raw.gz), a folder of Zarr or
    /// of DICOM images, a folder or NAME%d.ENDING of numbered slices, or builtin: marschner-lobb, hydrogen, shepp-logan, gyroid,
    /// torus-knot or cube, as builtin:hydrogen, with @N or @XxYxZ; - is standard input
    #[arg(default_value = "builtin:hydrogen")]
    pub volume: PathBuf,
    #[command(flatten)]
    file: FileOptions,
    /// Value around the volume and of voxels that are NaN or infinite [default: the smallest valid value; of built-in volumes 0]
    #[arg(long, value_parser = parse::finite, value_name = "V", allow_hyphen_values = true, help_heading = "Volume")]
    background_value: Option<f64>,
}

/// What a file does not tell, and which of its volumes.
#[derive(Args)]
pub(super) struct FileOptions {
    /// Voxels along x, y, z, where the file's name does not tell them: XxYxZ
    #[arg(long, value_parser = parse::dims, value_name = "XxYxZ", help_heading = "Volume")]
    dims: Option<[usize; 3]>,
    /// uint8, int8, uint16, int16, uint32, int32, uint64, int64, float16, float32 or float64, where the file's name does not tell it
    #[arg(long = "type", help_heading = "Volume")]
    voxel_type: Option<ScalarType>,
    /// Distance between voxels along x, y, z [default: 1,1,1]
    #[arg(long, value_parser = parse::spacing, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Volume")]
    spacing: Option<DVec3>,
    /// Byte order of the file [default: little]
    #[arg(long, help_heading = "Volume")]
    endian: Option<EndianName>,
    /// Bytes before the first voxel, of a .gz file once unpacked [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    header_bytes: Option<u64>,
    /// Which of several volumes that a file holds, from 0 on [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    frame: Option<usize>,
    /// Which of several numbers per voxel, from 0 on [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    channel: Option<usize>,
    /// Which of several arrays that a file names [default: the one that it marks, or the first]
    #[arg(long, value_name = "NAME", help_heading = "Volume")]
    array: Option<String>,
    /// Which of several series of DICOM images in a folder: its number, its description or its identifier
    #[arg(long, value_name = "NAME", help_heading = "Volume")]
    series: Option<String>,
    /// Which of several resolutions, 0 the finest, or auto: for a picture, the coarsest that still has a voxel per pixel [default: the finest
    /// that fits into memory]
    #[arg(long, value_parser = parse::level, value_name = "N|auto", help_heading = "Volume")]
    level: Option<LevelChoice>,
}

/// A resolution, as it is given.
#[derive(Clone, Copy)]
pub(super) enum LevelChoice {
    Auto,
    Number(usize),
}

#[derive(Clone, Copy, ValueEnum)]
enum EndianName {
    Little,
    Big,
}

impl VolumeOptions {
    /// Opens the volume, for pictures of a size if there will be any, of which memory is to hold so many bytes at most where it cannot be
    /// mapped.
    pub fn open(&self, size: Option<Viewport>, memory: Option<u64>) -> Result<Volume<'static>, crate::Error> {
        let options = OpenOptions { memory, ..self.file.raw(size)? };
        let volume = standard::opened(&self.volume, |path| Volume::open(path, &options))?;
        match self.background_value {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

impl FileOptions {
    /// The same for the library.
    pub fn raw(&self, size: Option<Viewport>) -> Result<OpenOptions, crate::Error> {
        let endian = self.endian.map(|endian| match endian {
            EndianName::Little => Endian::Little,
            EndianName::Big => Endian::Big,
        });
        let Self { dims, voxel_type, spacing, header_bytes, frame, channel, .. } = *self;
        let (array, series) = (self.array.clone(), self.series.clone());
        let level = match (self.level, size) {
            (None, _) => None,
            (Some(LevelChoice::Number(n)), _) => Some(Level::Number(n)),
            (Some(LevelChoice::Auto), Some(size)) => Some(Level::Pixels(size.width.max(size.height) as usize)),
            (Some(LevelChoice::Auto), None) => {
                let problem = "auto is for pictures, and none is made here: give a number".into();
                return Err(crate::Error::Settings { field: "level", problem });
            }
        };
        Ok(OpenOptions { dims, voxel_type, spacing, endian, header_bytes, frame, channel, array, series, level, memory: None })
    }
}

/// Which transfer function.
#[derive(Args)]
#[command(next_help_heading = "Transfer function")]
pub(super) struct TransferOptions {
    /// A name that `layersplat transfer --list` tells, with _r behind it turned round; or a file of ParaView (FILE.json or FILE.json#PRESET),
    /// 3D Slicer (.vp, .vp.json) or lines of value,r,g,b,a (.csv) [default: from the histogram; with --window: grey]
    #[arg(long, value_name = "FILE|NAME")]
    pub transfer: Option<PathBuf>,
    /// Stretch the transfer function onto this range of data values; a value is a number or a percentile of the voxels, as p99.5
    #[arg(long, value_parser = parse::range, value_name = "LO,HI", allow_hyphen_values = true)]
    pub transfer_range: Option<(Value, Value)>,
    /// Opacities of data values, even between them, instead of the transfer function's: V:OPACITY,V:OPACITY,…
    #[arg(long, value_parser = parse::opacities, value_name = "V:A,V:A", allow_hyphen_values = true)]
    pub opacity: Option<Opacities>,
    /// Colours and opacity rise over a window, as radiologists give it: nothing WIDTH/2 below LEVEL, opaque WIDTH/2 above it; --opacity and
    /// --tent take the opacity's place
    #[arg(long, value_parser = parse::window, value_name = "LEVEL,WIDTH", allow_hyphen_values = true, conflicts_with = "transfer_range")]
    pub window: Option<(Value, f64)>,
    /// A thin tent of opacity around a value, of this width at its foot and this opacity (0.5) at its top; may be given several times. The
    /// rest is clear, or as --opacity says
    #[arg(long, value_parser = parse::tent, value_name = "V,WIDTH[,OPACITY]", allow_hyphen_values = true)]
    pub tent: Vec<Tent>,
}

/// Opacities by value, as they are given.
#[derive(Clone)]
pub(super) struct Opacities(pub Vec<(Value, f64)>);

/// A tent of opacity, as it is given.
#[derive(Clone, Copy)]
pub(super) struct Tent {
    pub value: Value,
    pub width: f64,
    pub opacity: f64,
}

/// Camera and picture.
#[derive(Args, Clone)]
#[command(next_help_heading = "Camera and picture")]
pub(super) struct CameraOptions {
    /// Degrees about the y axis
    #[arg(long, default_value_t = 0.0, value_parser = parse::finite, allow_hyphen_values = true)]
    pub azimuth: f64,
    /// Degrees above the xz plane [default: 0; rotate and bench: 20]
    #[arg(long, value_parser = parse::finite, allow_hyphen_values = true)]
    pub elevation: Option<f64>,
    /// Degrees about the view direction
    #[arg(long, default_value_t = 0.0, value_parser = parse::finite, allow_hyphen_values = true)]
    pub roll: f64,
    /// What the picture fits: what is visible from here, with a small margin (of `rotate`, in the whole turn), or the whole volume from
    /// all sides [default: visible; bench: volume]
    #[arg(long)]
    pub fit: Option<Fit>,
    /// Half the picture's height in world units [default: see --fit]
    #[arg(long, value_parser = parse::positive, conflicts_with = "perspective", allow_hyphen_values = true)]
    pub parallel_scale: Option<f64>,
    /// Perspective with this vertical field of view in degrees [default: parallel]
    #[arg(long, value_parser = parse::field_of_view, value_name = "FOV", allow_hyphen_values = true)]
    pub perspective: Option<f64>,
    /// Distance of the eye from the centre, in a perspective [default: see --fit]
    #[arg(long, value_parser = parse::positive, requires = "perspective", allow_hyphen_values = true)]
    pub distance: Option<f64>,
    /// World point in the middle of the picture [default: see --fit]
    #[arg(long, value_parser = parse::vector, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub center: Option<DVec3>,
    /// Size of the picture in pixels
    #[arg(long, default_value = "512x512", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Viewport,
    /// black, white, grey, #rrggbb, R,G,B or transparent [default: .png and .jpg on black, .exr and .npy bare]
    #[arg(long)]
    pub background: Option<Background>,
}

/// What a camera fits into the picture.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(super) enum Fit {
    Visible,
    Volume,
}

impl CameraOptions {
    pub fn orbit(&self, default_elevation: f64) -> Orbit {
        Orbit { azimuth: self.azimuth, elevation: self.elevation.unwrap_or(default_elevation), roll: self.roll }
    }
}

/// Which device.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceOptions {
    /// Index or part of a name, see `layersplat devices` [default: a GPU if there is one, else the CPU]
    #[arg(long, env = "LAYERSPLAT_DEVICE")]
    pub device: Option<String>,
    /// Use the device whether or not it draws what it should: without a check, and in spite of one
    #[arg(long)]
    pub device_unchecked: bool,
}

impl DeviceOptions {
    /// An empty name, as of an empty LAYERSPLAT_DEVICE, is none.
    pub fn choice(&self) -> DeviceChoice {
        self.device.clone().filter(|name| !name.is_empty()).map_or(DeviceChoice::Default, DeviceChoice::Named)
    }
}

/// How the picture is made. Each option overrides the quality's choice.
#[derive(Args)]
#[command(next_help_heading = "Quality")]
pub(super) struct QualityOptions {
    #[command(flatten)]
    algorithm: AlgorithmOptions,
    /// draft, standard, high or paper [default: standard; of --algorithm layered]
    #[arg(long)]
    quality: Option<Quality>,
    /// When samples become colours: each after interpolation, or each segment between two as a whole
    #[arg(long)]
    classification: Option<ClassificationName>,
    /// What makes up for kernels that reach into neighbouring layers; implies --classification post
    #[arg(long)]
    correction: Option<CorrectionName>,
    /// Samples per layer: 1 to 8; with --classification post 1 to 16
    #[arg(long, value_parser = parse::sub_layers, value_name = "N", allow_hyphen_values = true)]
    sublayers: Option<u32>,
    /// How opacity becomes attenuation over a distance
    #[arg(long)]
    extinction: Option<ExtinctionName>,
    /// on or off
    #[arg(long, value_parser = parse::switch)]
    shading: Option<bool>,
    /// Direction to a light, in world coordinates, or camera, and its strength (1): white, and on both sides of surfaces; may be given up to
    /// four times [default: camera]
    #[arg(long, value_parser = parse::light, value_name = "X,Y,Z[:S]", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// What is left of the opacity where the field changes by so much, in values per world distance: G:FACTOR,G:FACTOR,…, even between;
    /// "5:0,20:1" hides what lies even and shows where materials meet
    #[arg(long, value_parser = parse::gradient_opacity, value_name = "G:F,G:F")]
    gradient_opacity: Option<GradientOpacity>,
    /// auto, direct (per pixel) or samples per voxel, 1 to 16
    #[arg(long, value_parser = parse::lattice, value_name = "auto|direct|N", allow_hyphen_values = true)]
    lattice: Option<Evaluation>,
    /// Source of the footprints; the set goes with --lattice direct, and implies --classification post
    #[arg(long)]
    footprints: Option<FootprintsName>,
    /// Whether opaque tiles stop: on or off
    #[arg(long, value_parser = parse::switch)]
    early_termination: Option<bool>,
    /// auto (the 45° rule), x, y or z
    #[arg(long, default_value = "auto", value_parser = parse::layer_axis)]
    layer_axis: LayerAxis,
    /// World distance that opacities are for [default: the smallest spacing]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    unit_distance: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum ClassificationName {
    Post,
    Preintegrated,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum CorrectionName {
    None,
    Constant,
    Sublayers,
}

#[derive(Clone, Copy, ValueEnum)]
enum ExtinctionName {
    Exponential,
    Linear,
}

#[derive(Clone, Copy, ValueEnum)]
enum FootprintsName {
    Exact,
    Set,
}

impl QualityOptions {
    /// The quality's settings with what was asked for otherwise, or what is contradictory.
    pub fn settings(&self) -> Result<Settings, crate::Error> {
        let algorithm = self.algorithm.algorithm(self.quality().layered(), self.layer_axis)?;
        self.check_meaning(algorithm)?;
        let algorithm = match algorithm {
            Algorithm::Layered(own) => self.layered(own)?.into(),
            other => other,
        };
        let settings = Settings::from(algorithm);
        Ok(Settings {
            unit_distance: self.unit_distance,
            extinction: match self.extinction {
                None => settings.extinction,
                Some(ExtinctionName::Exponential) => Extinction::Exponential,
                Some(ExtinctionName::Linear) => Extinction::Linear,
            },
            shading: self.lit(settings.shading)?,
            gradient_opacity: self.gradient_opacity,
            early_termination: self.early_termination.unwrap_or(settings.early_termination),
            ..settings
        })
    }

    /// The settings' shading with what was asked for otherwise.
    fn lit(&self, own: Option<Shading>) -> Result<Option<Shading>, crate::Error> {
        let shading = self.shading.map_or(own, |on| on.then(Shading::default));
        match shading {
            _ if self.light.is_empty() => Ok(shading),
            Some(shading) => Ok(Some(Shading { lights: Lights::new(&self.light)?, ..shading })),
            None => {
                let problem = "nothing is shaded: leave it out, or switch shading on".into();
                Err(crate::Error::Settings { field: "light", problem })
            }
        }
    }

    /// The quality's choices of layered rendering with what was asked for otherwise.
    fn layered(&self, own: Layered) -> Result<Layered, crate::Error> {
        let classification = self.classification(own.classification)?;
        let evaluation = match (self.lattice, own.evaluation) {
            (None, own) => own,
            // `auto` leaves a quality its own density, unless that is a number or none.
            (Some(Evaluation::Lattice(Density::Relaxed)), Evaluation::Lattice(own @ Density::Fine)) => Evaluation::Lattice(own),
            (Some(evaluation), _) => evaluation,
        };
        let footprints = match self.footprints {
            // The set comes with the paper's direct evaluation; on a lattice it has no meaning.
            None if self.lattice.is_some() && evaluation != Evaluation::Direct => Footprints::Exact,
            None => own.footprints,
            Some(FootprintsName::Exact) => Footprints::Exact,
            Some(FootprintsName::Set) => Footprints::Set,
        };
        Ok(Layered { classification, evaluation, footprints, ..own })
    }

    /// The bundle that the options begin with.
    pub fn quality(&self) -> Quality {
        self.quality.unwrap_or_default()
    }

    /// Refuses options that an algorithm does not have.
    fn check_meaning(&self, algorithm: Algorithm) -> Result<(), crate::Error> {
        if let Algorithm::Layered(_) = algorithm {
            return Ok(());
        }
        let layer_axis = self.layer_axis != LayerAxis::Auto && !matches!(algorithm, Algorithm::AxisSheets { .. });
        let given = [
            (self.quality.is_some(), "quality"),
            (self.classification.is_some(), "classification"),
            (self.correction.is_some(), "correction"),
            (self.sublayers.is_some(), "samples_per_layer"),
            (self.lattice.is_some(), "evaluation"),
            (self.footprints.is_some(), "footprints"),
            (layer_axis, "layer_axis"),
        ];
        no_meaning(algorithm, &given)
    }

    /// Corrections and the footprint set are for classification after interpolation, and imply it.
    fn classification(&self, own: Classification) -> Result<Classification, crate::Error> {
        let conflict = |problem: &str| Err(crate::Error::Settings { field: "correction", problem: problem.into() });
        let asked_kernel = self.algorithm.kernel();
        let post = match (self.classification, own) {
            (Some(ClassificationName::Post), _) => true,
            (Some(ClassificationName::Preintegrated), _) => false,
            (None, own) => {
                let for_post = self.correction.is_some() || matches!(self.footprints, Some(FootprintsName::Set));
                for_post || matches!(own, Classification::Post(_))
            }
        };
        if !post {
            if self.correction.is_some() {
                return conflict("it has no meaning where classification is pre-integrated: leave one of them out");
            }
            let (kernel, points) = match own {
                Classification::Preintegrated { kernel, samples_per_layer } => (kernel, samples_per_layer),
                Classification::Post(_) => (Kernel::Cubic, 1),
            };
            return Ok(Classification::Preintegrated {
                kernel: asked_kernel.unwrap_or(kernel),
                samples_per_layer: self.sublayers.unwrap_or(points),
            });
        }
        if asked_kernel.is_some_and(|kernel| kernel != Kernel::Cubic) {
            let problem = "splats are the paper's cubic: leave it out, or choose --classification preintegrated".into();
            return Err(crate::Error::Settings { field: "kernel", problem });
        }
        Ok(match (self.correction, self.sublayers) {
            (None, None) => match own {
                Classification::Post(_) => own,
                Classification::Preintegrated { .. } => self.quality().splatted(),
            },
            (None | Some(CorrectionName::Sublayers), Some(n)) => Classification::Post(Correction::SubLayers(n)),
            (Some(CorrectionName::Sublayers), None) => {
                Classification::Post(Correction::SubLayers(own.samples_per_layer().max(2)))
            }
            (Some(CorrectionName::None), None) => Classification::Post(Correction::None),
            (Some(CorrectionName::Constant), None) => Classification::Post(Correction::Constant),
            (Some(_), Some(_)) => {
                return conflict("only that by sub-layers takes a number of them: leave one of them out");
            }
        })
    }
}
