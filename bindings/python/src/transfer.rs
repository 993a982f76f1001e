//! Transfer functions.

use crate::argument::{Argument, accepted, either, extract};
use crate::calls::abandonable;
use crate::errors::{Result, out_of_range};
use crate::pickled::{Reduced, reduced};
use crate::volume::Volume;
use crate::warned::{warn, warned};
use layersplat::glam::DVec3;
use layersplat::volume::{Grid, Voxels};
use layersplat::{TransferFunction as Ours, Volume as OurVolume};
use pyo3::Borrowed;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A piecewise linear transfer function: colour and opacity by data value.
///
/// colors: points (value, (red, green, blue)). opacities: points (value, opacity). Both are sorted by value; colours and opacities are
/// 0 … 1. name: shown in messages.
///
/// The function is constant beyond its end points. Two points at the same value make a step. Opacities are per unit distance, see
/// Settings.
#[pyclass(frozen, module = "layersplat")]
pub struct TransferFunction(Ours);

impl TransferFunction {
    pub fn from_library(transfer: Ours) -> Self {
        Self(transfer)
    }

    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// The range to which a built-in function is stretched.
pub enum Onto<'py> {
    Volume(Bound<'py, Volume>),
    Range((f64, f64)),
}

accepted! {
    Onto<'py>: "a layersplat.Volume, or (lowest, highest)";
}

impl<'a, 'py> FromPyObject<'a, 'py> for Onto<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Onto::Volume, Onto::Range)
    }
}

#[pymethods]
impl TransferFunction {
    #[new]
    #[pyo3(
        signature = (colors, opacities, *, name = Argument::Default("given".into())),
        text_signature = "(colors, opacities, *, name='given')"
    )]
    fn new(colors: Argument<Vec<(f64, [f64; 3])>>, opacities: Argument<Vec<(f64, f64)>>, name: Argument<String>) -> Result<Self> {
        extract!(colors, opacities, name);
        Ok(Self(Ours::new(name, colors, opacities)?))
    }

    /// A built-in colour map by name, stretched to the range of a Volume or to (lowest, highest). Names: grey, fire, viridis, cool-warm
    /// and others of `layersplat transfer --list`; append _r to reverse.
    #[staticmethod]
    fn builtin(name: Argument<String>, onto: Argument<Onto>) -> Result<Self> {
        extract!(name, onto);
        Ok(Self(match onto {
            Onto::Volume(volume) => Ours::builtin(&name, volume.get().ours())?,
            Onto::Range((lo, hi)) => Ours::builtin(&name, &unit_range()?)?.stretched(lo, hi)?,
        }))
    }

    /// A default transfer function from the volume's histogram.
    #[staticmethod]
    fn automatic(py: Python, volume: Argument<Bound<Volume>>) -> Result<Self> {
        extract!(volume);
        let volume = volume.get().ours().clone();
        Ok(Self(abandonable(py, move || Ok(Ours::automatic(&volume)))?))
    }

    /// The transfer function of a channel that is drawn with others: one color (red, green, blue), 0 … 1, and an opacity that rises from the
    /// end of the background's noise to the 99.9th percentile of the voxels. ramp: colours rise from black too, for the blend modes maximum,
    /// minimum and average.
    #[staticmethod]
    #[pyo3(
        signature = (volume, color, *, ramp = Argument::Default(false)),
        text_signature = "(volume, color, *, ramp=False)"
    )]
    fn channel(py: Python, volume: Argument<Bound<Volume>>, color: Argument<[f64; 3]>, ramp: Argument<bool>) -> Result<Self> {
        extract!(volume, color, ramp);
        let color = checked_color(color)?;
        let volume = volume.get().ours().clone();
        let made = move || Ok(if ramp { Ours::channel_ramp(&volume, color) } else { Ours::channel(&volume, color) });
        Ok(Self(abandonable(py, made)?))
    }

    /// A built-in transfer function by name, or a ParaView colour map: FILE or FILE#PRESET.
    #[staticmethod]
    fn open(py: Python, source: Argument<PathBuf>, volume: Argument<Bound<Volume>>) -> Result<Self> {
        extract!(source, volume);
        let volume = volume.get().ours().clone();
        let (transfer, warnings) = warned(py, move || Ok(Ours::open(source, &volume)?))?;
        warn(py, warnings)?;
        Ok(Self(transfer))
    }

    /// A copy, mapped linearly to the range lo … hi.
    fn stretched(&self, lo: Argument<f64>, hi: Argument<f64>) -> Result<Self> {
        extract!(lo, hi);
        Ok(Self(self.0.stretched(lo, hi)?))
    }

    /// A copy with opacities multiplied by a factor, 0 … 1.
    fn faded(&self, factor: Argument<f64>) -> Result<Self> {
        extract!(factor);
        Ok(Self(self.0.faded(factor)?))
    }

    /// Colour (red, green, blue), 0 … 1, at a value.
    fn color(&self, value: Argument<f64>) -> Result<(f64, f64, f64)> {
        extract!(value);
        Ok(self.0.color(value).into())
    }

    /// Opacity per unit distance, 0 … 1, at a value.
    fn opacity(&self, value: Argument<f64>) -> Result<f64> {
        extract!(value);
        Ok(self.0.opacity(value))
    }

    /// Points (value, (red, green, blue)), ascending.
    #[getter]
    fn colors(&self) -> Vec<(f64, (f64, f64, f64))> {
        self.0.colors().iter().map(|&(value, color)| (value, color.into())).collect()
    }

    /// Points (value, opacity), ascending.
    #[getter]
    fn opacities(&self) -> Vec<(f64, f64)> {
        self.0.opacities().to_vec()
    }

    /// Values of the first and the last point.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }

    /// The name shown in messages.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let arguments = PyDict::new(py);
        arguments.set_item("colors", self.colors())?;
        arguments.set_item("opacities", self.opacities())?;
        arguments.set_item("name", self.name())?;
        reduced::<Self>(py, arguments)
    }

    fn __repr__(&self) -> String {
        let (lo, hi) = self.0.range();
        format!("<layersplat.TransferFunction {} from {lo} to {hi}>", self.0.name())
    }
}

/// A colour whose components are in range.
///
/// # Errors
/// `InvalidValue` otherwise.
pub fn checked_color(color: [f64; 3]) -> Result<[f64; 3]> {
    if color.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Ok(color);
    }
    Err(out_of_range("color", format!("{color:?}"), "red, green and blue from 0 to 1"))
}

/// A dummy volume with the range 0 to 1: the library fits built-in functions to a volume.
fn unit_range() -> Result<OurVolume<'static>> {
    let grid = Grid::new([2, 1, 1], DVec3::ONE)?;
    Ok(OurVolume::new("0 to 1", grid, Voxels::Float32(vec![0.0, 1.0]))?)
}
