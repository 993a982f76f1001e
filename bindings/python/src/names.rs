//! Conversion of Python arguments: sizes, backgrounds, angles, pixel formats and voxel types.

use crate::argument::{accepted, either};
use crate::errors::{Result, out_of_range, unknown};
use layersplat::Orbit;
use layersplat::renderer::PictureFormat;
use layersplat::volume::{OpenOptions, ScalarType, VoxelType};
use layersplat::{Background, Viewport};
use pyo3::Borrowed;
use pyo3::prelude::*;

accepted! {
    Size: "(width, height) in pixels, or one whole number for both";
    Channel: "a whole number from 0 on, the name of a channel, or magnitude";
    Over: "transparent, black, white, grey, #rrggbb or (red, green, blue), 0 to 1";
}

/// Size of a picture: (width, height) in pixels, or one number for both.
pub enum Size {
    Square(u32),
    Sides([u32; 2]),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Size {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Size::Square, Size::Sides)
    }
}

impl Size {
    pub fn viewport(&self) -> Result<Viewport> {
        let [width, height] = match *self {
            Size::Square(side) => [side; 2],
            Size::Sides(sides) => sides,
        };
        Ok(Viewport::new(width, height)?)
    }
}

/// Component of voxels with several numbers, or the magnitude of all.
pub enum Channel {
    Number(usize),
    Named(String),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Channel {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.extract() {
            Ok(name) => Ok(Channel::Named(name)),
            Err(_) => object.extract().map(Channel::Number),
        }
    }
}

impl Channel {
    /// The options of a file with the component.
    pub fn chosen(self, options: OpenOptions) -> OpenOptions {
        match self {
            Channel::Number(n) => OpenOptions { channel: Some(n), ..options },
            Channel::Named(name) if name == "magnitude" => OpenOptions { magnitude: true, ..options },
            Channel::Named(name) => OpenOptions { channel_name: Some(name), ..options },
        }
    }
}

/// A background: a name or `#rrggbb`, or (red, green, blue), 0 … 1.
pub enum Over {
    Named(String),
    Color([f32; 3]),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Over {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        // Strings first: they are sequences too.
        match object.extract() {
            Ok(name) => Ok(Over::Named(name)),
            Err(_) => object.extract().map(Over::Color),
        }
    }
}

impl Default for Over {
    fn default() -> Self {
        Over::Color([0.0; 3])
    }
}

impl Over {
    pub fn background(&self) -> Result<Background> {
        match self {
            Over::Named(name) => match name.parse() {
                Ok(background) => Ok(background),
                Err(_) => {
                    Err(unknown("background", name, "transparent, black, white, grey, #rrggbb or (red, green, blue), 0 to 1"))
                }
            },
            Over::Color(color) if color.iter().all(|c| (0.0..=1.0).contains(c)) => Ok(Background::Color(*color)),
            Over::Color(color) => Err(out_of_range("background", format!("{color:?}"), "red, green and blue from 0 to 1")),
        }
    }
}

/// The orbit of camera angles in degrees.
///
/// # Errors
/// A non-finite angle.
pub fn orbit(azimuth: f64, elevation: f64, roll: f64) -> Result<Orbit> {
    match [("azimuth", azimuth), ("elevation", elevation), ("roll", roll)].into_iter().find(|(_, angle)| !angle.is_finite()) {
        Some((name, angle)) => Err(out_of_range(name, angle, "a finite number of degrees")),
        None => Ok(Orbit { azimuth, elevation, roll }),
    }
}

/// The pixel format of a picture in the caller's memory.
pub fn picture_format(name: &str, background: &Over) -> Result<PictureFormat> {
    match name {
        "rgba8" => Ok(PictureFormat::Rgba8(background.background()?)),
        "float" => Ok(PictureFormat::Floats),
        _ => Err(unknown(
            "format",
            name,
            "rgba8 (a byte per channel, over the background) or float (premultiplied, no background)",
        )),
    }
}

/// The voxel type of a numpy type name.
pub fn voxel_type(name: &str) -> Result<VoxelType> {
    let scalar = name.parse::<ScalarType>().ok().and_then(ScalarType::voxel_type);
    scalar.ok_or_else(|| unknown("voxel type", name, "uint8, int8, uint16, int16 or float32"))
}
