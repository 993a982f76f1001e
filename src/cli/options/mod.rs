//! Options that `render`, `rotate` and `bench` share.

mod quality;
mod volume;

pub(super) use quality::QualityOptions;
pub(super) use volume::{FileOptions, LevelChoice, VolumeOptions};

use super::parse;
use crate::camera::Orbit;
use crate::device::DeviceChoice;
use crate::image::Background;
use crate::transfer::Value;
use crate::viewport::Viewport;
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::PathBuf;

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
    /// Index, or part of the name of a device or platform (`pocl`: PoCL), see `layersplat devices` [default: a GPU if there is one, else the CPU]
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
