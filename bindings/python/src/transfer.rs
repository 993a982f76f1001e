//! Transfer functions.

use crate::calls::abandonable;
use crate::errors::Result;
use crate::given::{Given, accepted, either, given};
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

/// Colour and opacity of a data value, piecewise linear.
///
/// A transfer function of points: colors (value, (red, green, blue)) and opacities (value, opacity), each sorted by value,
/// numbers 0 … 1; name: shown in messages.
///
/// It is linear between points and constant beyond them; two at one value make a step. Opacities are per unit distance, see Settings.
#[pyclass(frozen, module = "layersplat")]
pub struct TransferFunction(Ours);

impl TransferFunction {
    pub fn new_of(transfer: Ours) -> Self {
        Self(transfer)
    }

    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// What a built-in function is stretched onto.
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
        signature = (colors, opacities, *, name = Given::Default("given".into())),
        text_signature = "(colors, opacities, *, name='given')"
    )]
    fn new(colors: Given<Vec<(f64, [f64; 3])>>, opacities: Given<Vec<(f64, f64)>>, name: Given<String>) -> Result<Self> {
        given!(colors, opacities, name);
        Ok(Self(Ours::new(name, colors, opacities)?))
    }

    /// A colour map by name (grey, fire, viridis, cool-warm and those of `layersplat transfer --list`, with _r turned round), stretched onto a Volume's values or onto (lowest, highest).
    #[staticmethod]
    fn builtin(name: Given<String>, onto: Given<Onto>) -> Result<Self> {
        given!(name, onto);
        Ok(Self(match onto {
            Onto::Volume(volume) => Ours::builtin(&name, volume.get().ours())?,
            Onto::Range((lo, hi)) => Ours::builtin(&name, &from_zero_to_one()?)?.stretched(lo, hi)?,
        }))
    }

    /// A sensible first one, from the volume's histogram.
    #[staticmethod]
    fn automatic(py: Python, volume: Given<Bound<Volume>>) -> Result<Self> {
        given!(volume);
        let volume = volume.get().ours().clone();
        Ok(Self(abandonable(py, move || Ok(Ours::automatic(&volume)))?))
    }

    /// A built-in one by its name, or a ParaView colour map: FILE or FILE#PRESET.
    #[staticmethod]
    fn open(py: Python, source: Given<PathBuf>, volume: Given<Bound<Volume>>) -> Result<Self> {
        given!(source, volume);
        let volume = volume.get().ours().clone();
        let (transfer, warnings) = warned(py, move || Ok(Ours::open(source, &volume)?))?;
        warn(py, warnings)?;
        Ok(Self(transfer))
    }

    /// The same with its range of values mapped linearly onto lo … hi.
    fn stretched(&self, lo: Given<f64>, hi: Given<f64>) -> Result<Self> {
        given!(lo, hi);
        Ok(Self(self.0.stretched(lo, hi)?))
    }

    /// The same with its opacities multiplied by a factor, 0 … 1.
    fn faded(&self, factor: Given<f64>) -> Result<Self> {
        given!(factor);
        Ok(Self(self.0.faded(factor)?))
    }

    /// Colour (red, green, blue), 0 … 1, at a value.
    fn color(&self, value: Given<f64>) -> Result<(f64, f64, f64)> {
        given!(value);
        Ok(self.0.color(value).into())
    }

    /// Opacity per unit distance, 0 … 1, at a value.
    fn opacity(&self, value: Given<f64>) -> Result<f64> {
        given!(value);
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

    /// First and last value of a point.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }

    /// Its name.
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

/// The library stretches built-in functions onto a volume's values: onto these they stay what they are.
fn from_zero_to_one() -> Result<OurVolume<'static>> {
    let grid = Grid::new([2, 1, 1], DVec3::ONE)?;
    Ok(OurVolume::new("0 to 1", grid, Voxels::Float32(vec![0.0, 1.0]))?)
}
