//! Options shared by several subcommands.

mod bounds;
mod encoding;
mod labels;
mod light;
mod light_fields;
mod mask;
mod plain;
mod quality;
mod volume;

pub(super) use bounds::BoundOptions;
pub(super) use encoding::{EncodingOptions, quoted};
pub(super) use labels::LabelOptions;
pub(super) use light::LightOptions;
pub(super) use mask::Mask;
use plain::PlainOptions;
pub(super) use quality::QualityOptions;
pub(super) use volume::{Described, FileOptions, VolumeOptions};

use super::values::{Opacities, Tent};
use super::{names, parse};
use crate::camera::Up;
use crate::device::DeviceChoice;
use crate::framing::Side;
use crate::image::Background;
use crate::transfer::{TransferFunction, Value};
use crate::viewport::Viewport;
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::PathBuf;

/// Selection and changes of the transfer function.
#[derive(Args)]
#[command(next_help_heading = "Transfer function")]
pub(super) struct TransferOptions {
    /// Name or file of the transfer function, see below [default: from the histogram; for --blend maximum, minimum and average, and with --window: grey]
    #[arg(long, value_name = "FILE|NAME")]
    pub transfer: Option<PathBuf>,
    /// Transfer function for a kind of data
    #[arg(long, value_name = "NAME", conflicts_with_all = ["transfer", "window"],
        value_parser = names::from_list(TransferFunction::presets().map(|(name, _)| name)))]
    pub preset: Option<String>,
    /// Colours of the automatic transfer function [default: calm]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["transfer", "window", "preset"],
        value_parser = names::from_list(TransferFunction::palettes()))]
    pub palette: Option<String>,
    /// Stretch the transfer function to this range of data values
    #[arg(long, value_parser = parse::range, value_name = "LO,HI", allow_hyphen_values = true)]
    pub transfer_range: Option<(Value, Value)>,
    /// Replace the opacities by A at data values V, interpolated linearly
    #[arg(long, value_parser = parse::opacities, value_name = "V:A,V:A", allow_hyphen_values = true)]
    pub opacity: Option<Opacities>,
    /// Window level and width (CT): colours and opacity rise across the window; --opacity or --tent replace the opacity
    #[arg(long, value_parser = parse::window, value_name = "LEVEL,WIDTH", allow_hyphen_values = true, conflicts_with = "transfer_range")]
    pub window: Option<(Value, f64)>,
    /// Triangular opacity peak (0.5) at V; WIDTH is its base. Elsewhere transparent, or as --opacity says. Repeatable
    #[arg(long, value_parser = parse::tent, value_name = "V,WIDTH[,OPACITY]", allow_hyphen_values = true)]
    pub tent: Vec<Tent>,
}

impl TransferOptions {
    /// Whether an option chooses colours, instead of those made from the voxels.
    pub fn is_given(&self) -> bool {
        self.transfer.is_some() || self.preset.is_some() || self.palette.is_some() || self.window.is_some()
    }

    /// Names of all options that are given.
    pub fn given(&self) -> impl Iterator<Item = &'static str> + use<> {
        let all = [
            ("preset", self.preset.is_some()),
            ("palette", self.palette.is_some()),
            ("transfer", self.transfer.is_some()),
            ("transfer_range", self.transfer_range.is_some()),
            ("window", self.window.is_some()),
            ("opacity", self.opacity.is_some()),
            ("tent", !self.tent.is_empty()),
        ];
        all.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name)
    }

    /// Whether an option replaces the opacities.
    pub fn changes_opacity(&self) -> bool {
        self.opacity.is_some() || !self.tent.is_empty()
    }
}

/// Camera and picture.
#[derive(Args, Clone)]
#[command(next_help_heading = "Camera and picture")]
pub(super) struct CameraOptions {
    /// Axis of the world that points up; the camera turns around it [default: z if the file says so, see the guide, else y; bench: y]
    #[arg(long, value_parser = names::of::<Up>(), value_name = "AXIS", allow_hyphen_values = true)]
    pub up: Option<Up>,
    /// Side to look from, instead of an azimuth and an elevation
    #[arg(long, value_parser = names::of::<Side>(), value_name = "SIDE", conflicts_with_all = ["azimuth", "elevation"])]
    pub from: Option<Side>,
    /// Turn the camera around the vertical axis, in degrees [default: 0; render without any angle: 30]
    #[arg(long, value_parser = parse::finite, value_name = "DEGREES", allow_hyphen_values = true)]
    pub azimuth: Option<f64>,
    /// Raise the camera, in degrees [default: 0; render without any angle, rotate and bench: 20]
    #[arg(long, value_parser = parse::finite, value_name = "DEGREES", allow_hyphen_values = true)]
    pub elevation: Option<f64>,
    /// Turn the camera around the view direction, in degrees [default: 0]
    #[arg(long, value_parser = parse::finite, value_name = "DEGREES", allow_hyphen_values = true)]
    pub roll: Option<f64>,
    /// What to frame: the visible part, or the whole volume [default: visible; bench: volume]
    #[arg(long, value_name = "WHAT", value_parser = names::of_enum::<Fit>())]
    pub fit: Option<Fit>,
    /// Half the height of the picture in world units [default: see --fit]
    #[arg(long, value_parser = parse::positive, conflicts_with = "perspective", value_name = "SCALE", allow_hyphen_values = true)]
    pub parallel_scale: Option<f64>,
    /// Perspective projection with this vertical field of view in degrees [default: parallel]
    #[arg(long, value_parser = parse::field_of_view, value_name = "FOV", allow_hyphen_values = true)]
    pub perspective: Option<f64>,
    /// Distance from the eye to the centre, with --perspective [default: see --fit]
    #[arg(long, value_parser = parse::positive, requires = "perspective", value_name = "D", allow_hyphen_values = true)]
    pub distance: Option<f64>,
    /// World point at the centre of the picture [default: see --fit]
    #[arg(long, value_parser = parse::vector, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub center: Option<DVec3>,
    /// Size of the picture in pixels
    #[arg(long, default_value = "512x512", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Viewport,
    /// black, white, grey, #rrggbb, R,G,B or transparent [default: black; .exr and .npy: no background]
    #[arg(long, value_name = "COLOR")]
    pub background: Option<Background>,
}

/// What a camera frames.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(super) enum Fit {
    Visible,
    Volume,
}

/// Selection of the device.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceOptions {
    /// Index in `layersplat devices`, or part of a device or platform name, e.g. pocl [default: a GPU if available, else the CPU]
    #[arg(long, env = "LAYERSPLAT_DEVICE", value_name = "NAME")]
    pub device: Option<String>,
    /// Skip the device check, and use devices that failed it
    #[arg(long)]
    pub device_unchecked: bool,
}

impl DeviceOptions {
    /// The chosen device. An empty name, for example an empty LAYERSPLAT_DEVICE, means the default.
    pub fn choice(&self) -> DeviceChoice {
        self.device.clone().filter(|name| !name.is_empty()).map_or(DeviceChoice::Default, DeviceChoice::Named)
    }
}
