//! Volumes of colours.

use crate::argument::{Argument, accepted, either, extract};
use crate::calls::abandonable;
use crate::camera::Framing;
use crate::errors::{Result, unknown};
use crate::transfer::{TransferFunction, checked_color};
use crate::volume::Volume;
use crate::warned::{warn, warned};
use layersplat::framing::Framing as OurFraming;
use layersplat::renderer::{ColorOpacity, UploadedColors, vector_norms};
use layersplat::volume::{ColorChannels, OpenOptions, VoxelType};
use layersplat::{Device, Error, TransferFunction as Transfer, Volume as OurVolume};
use pyo3::Borrowed;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Largest opacity of colours without alpha: of the brightest, or of those that differ most from the background.
const OPACITY: f64 = 0.3;

/// A volume of colours, drawn by Renderer(colors).
///
/// data: an array (z, y, x, 3) or (z, y, x, 4) of uint8, uint16 or float32: red, green, blue and possibly alpha. Integers are intensities up to
/// the largest number of their type; floats are 0 … 1. spacing: one number or (z, y, x), in world units. opacity: alpha, the fourth
/// component, per smallest spacing; luminance; or a background colour (red, green, blue), 0 … 1, from which colours differ. By default
/// alpha if there is one, else luminance. transfer: its opacities apply to luminance and to the difference from the background, in units
/// of the components; by default they rise from 0 to 0.3. direction: whether data are vectors, an array (z, y, x, 3) of the components x, y
/// and z of any type. Their colours are (|x|, |y|, |z|) / norm, and their opacity that of transfer at the norm, automatic by default. Vectors
/// that are 0 or have a component that is not a number are transparent.
///
/// Extinction and extinction times colour are interpolated, so transparent voxels do not bleed their colour. Colours are drawn in
/// point-sampled layers with the blend mode composite.
#[pyclass(frozen, module = "layersplat")]
pub struct Colors(Drawn);

/// Colours, independent of Python.
#[derive(Clone)]
pub struct Drawn {
    components: Arc<[OurVolume<'static>]>,
    opacity: ColorOpacity,
    transfer: Transfer,
    /// Of vectors, which are drawn in the colours of their directions.
    norms: Option<Arc<OurVolume<'static>>>,
}

impl Drawn {
    /// The colours on a device.
    ///
    /// # Errors
    /// If memory is insufficient.
    pub fn on(&self, device: &Device) -> std::result::Result<UploadedColors, Error> {
        match self.norms {
            Some(_) => UploadedColors::from_vectors(device, &self.components, &self.transfer),
            None => UploadedColors::new(device, &self.components, self.opacity, &self.transfer),
        }
    }

    fn framing(&self) -> OurFraming {
        if let Some(norms) = &self.norms {
            return OurFraming::visible(norms, &self.transfer, None);
        }
        let whole = OurFraming::whole(&self.components[0]);
        let (ColorOpacity::Alpha, Some(alpha)) = (self.opacity, self.components.get(3)) else { return whole };
        opacities(alpha.range().1, 1.0).map_or(whole, |visible| OurFraming::visible(alpha, &visible, None))
    }
}

/// White, with an opacity that rises from 0.
fn opacities(full: f64, most: f64) -> std::result::Result<Transfer, Error> {
    Transfer::new("colors", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (full, most)])
}

/// An argument for the opacity.
enum Opacity {
    Name(String),
    Background([f64; 3]),
}

accepted! {
    Opacity: "alpha, luminance, or a background colour (red, green, blue)";
}

impl<'a, 'py> FromPyObject<'a, 'py> for Opacity {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Opacity::Name, Opacity::Background)
    }
}

impl Opacity {
    fn checked(self) -> Result<ColorOpacity> {
        match self {
            Self::Background(color) => Ok(ColorOpacity::FromBackground(checked_color(color)?)),
            Self::Name(name) => match name.as_str() {
                "alpha" => Ok(ColorOpacity::Alpha),
                "luminance" => Ok(ColorOpacity::Luminance),
                _ => Err(unknown("opacity", &name, "alpha, luminance, or a background colour (red, green, blue)")),
            },
        }
    }
}

impl Colors {
    pub fn drawn(&self) -> &Drawn {
        &self.0
    }

    /// Red, green, blue and possibly alpha.
    fn of_components(
        components: Arc<[OurVolume<'static>]>,
        opacity: Option<Opacity>,
        transfer: Option<Bound<TransferFunction>>,
    ) -> Result<Self> {
        let opacity = match opacity {
            Some(opacity) => opacity.checked()?,
            None if components.len() == 4 => ColorOpacity::Alpha,
            None => ColorOpacity::Luminance,
        };
        if opacity == ColorOpacity::Alpha && components.len() < 4 {
            return Err(crate::errors::conflict("opacity", "there is no alpha in three components: use luminance or a colour"));
        }
        let full = match components[0].voxel_type() {
            VoxelType::Uint8 => 255.0,
            VoxelType::Uint16 => 65535.0,
            _ => 1.0,
        };
        let transfer = match transfer {
            Some(transfer) => transfer.get().ours().clone(),
            None => opacities(full, OPACITY)?,
        };
        Ok(Self(Drawn { components, opacity, transfer, norms: None }))
    }

    /// Vectors in the colours of their directions.
    fn of_vectors(data: &Bound<PyAny>, spacing: Option<&Bound<PyAny>>, transfer: Option<Transfer>) -> Result<Self> {
        let fields = data.py().import("layersplat._fields")?;
        let made: Vec<Bound<Volume>> = fields.call_method1("vectors", (data, spacing))?.extract()?;
        let components: Arc<[_]> = made.iter().map(|volume| volume.get().ours().clone()).collect();
        let norms = vector_norms(&components)?;
        let transfer = transfer.unwrap_or_else(|| Transfer::automatic(&norms));
        // Not read: the norm makes the opacity.
        let opacity = ColorOpacity::Alpha;
        Ok(Self(Drawn { components, opacity, transfer, norms: Some(Arc::new(norms)) }))
    }
}

#[pymethods]
impl Colors {
    #[new]
    #[pyo3(signature = (data, spacing = None, *, opacity = None, transfer = None, direction = false))]
    fn new(
        data: &Bound<PyAny>,
        spacing: Option<&Bound<PyAny>>,
        opacity: Option<Argument<Opacity>>,
        transfer: Option<Argument<Bound<TransferFunction>>>,
        direction: bool,
    ) -> Result<Self> {
        extract!(opacity, transfer);
        let py = data.py();
        if direction {
            if opacity.is_some() {
                return Err(crate::errors::conflict("opacity", "with direction, opacities are those of transfer at the norm"));
            }
            return Self::of_vectors(data, spacing, transfer.map(|transfer| transfer.get().ours().clone()));
        }
        let made: Vec<Bound<Volume>> = py.import("layersplat._fields")?.call_method1("components", (data, spacing))?.extract()?;
        Self::of_components(made.iter().map(|volume| volume.get().ours().clone()).collect(), opacity, transfer)
    }

    /// Opens a file of colours: red, green, blue and possibly alpha, its first three or four channels. opacity, transfer: see Colors. Files
    /// of colours are PNG, TIFF (RGB), NRRD, NIfTI (RGB24, RGBA32), DICOM and VTK; any other file of three channels or more is drawn so, too.
    #[staticmethod]
    #[pyo3(signature = (path, *, opacity = None, transfer = None))]
    fn open(
        py: Python,
        path: Argument<PathBuf>,
        opacity: Option<Argument<Opacity>>,
        transfer: Option<Argument<Bound<TransferFunction>>>,
    ) -> Result<Self> {
        extract!(path, opacity, transfer);
        let (components, warnings) = warned(py, move || {
            let options = OpenOptions::default();
            Ok(ColorChannels::of_file(&path, &options)?.open(&path, &options)?)
        })?;
        warn(py, warnings)?;
        Self::of_components(components.into(), opacity, transfer)
    }

    /// The framing of voxels whose alpha is above 0, otherwise of all voxels.
    fn framing(&self, py: Python) -> Result<Framing> {
        let drawn = self.0.clone();
        Ok(Framing::from_library(abandonable(py, move || Ok(drawn.framing()))?))
    }

    /// Number of voxels along z, y, x, and of components.
    #[getter]
    fn shape(&self) -> (usize, usize, usize, usize) {
        let [x, y, z] = self.0.components[0].grid().dims();
        (z, y, x, self.0.components.len())
    }

    fn __repr__(&self) -> String {
        let (z, y, x, count) = self.shape();
        format!("<layersplat.Colors of {z}x{y}x{x} (z, y, x), {count} components>")
    }
}
