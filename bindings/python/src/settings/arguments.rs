//! The arguments that make settings again.

use crate::errors::conflict;
use layersplat::settings::{Algorithm, Blend, Classification, CropBox, Evaluation, LayerAxis, Layered, Light, Shading};
use layersplat::{Axis, Density, Settings, transfer::Extinction};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Arguments of `Settings(…)` whose result is equal to settings that it made.
pub fn arguments<'py>(py: Python<'py>, settings: &Settings) -> PyResult<Bound<'py, PyDict>> {
    let given = PyDict::new(py);
    algorithm(&given, settings.algorithm)?;
    match settings.blend {
        Blend::Composite => given.set_item("blend", "composite")?,
        Blend::Maximum => given.set_item("blend", "maximum")?,
        Blend::Minimum => given.set_item("blend", "minimum")?,
        Blend::Average => given.set_item("blend", "average")?,
        Blend::Iso(value) => given.set_item("blend", ("iso", value))?,
        other => return Err(conflict("blend", format!("{other:?} has no name in Python")).into()),
    }
    match settings.shading {
        Some(numbers) => given.set_item("shading", shading(py, &numbers)?)?,
        None => given.set_item("shading", false)?,
    }
    if let Some(gradient_opacity) = &settings.gradient_opacity {
        given.set_item("gradient_opacity", gradient_opacity.points())?;
    }
    if let Some(CropBox { lowest, highest }) = settings.clipping.crop {
        given.set_item("crop", (lowest.to_array(), highest.to_array()))?;
    }
    let planes = settings.clipping.planes.iter().flatten();
    given.set_item("planes", planes.map(|plane| (plane.point.to_array(), plane.normal.to_array())).collect::<Vec<_>>())?;
    given.set_item("unit_distance", settings.unit_distance)?;
    given.set_item(
        "extinction",
        match settings.extinction {
            Extinction::Exponential => "exponential",
            Extinction::Linear => "linear",
        },
    )?;
    given.set_item("early_termination", settings.early_termination)?;
    Ok(given)
}

fn algorithm(given: &Bound<PyDict>, algorithm: Algorithm) -> PyResult<()> {
    given.set_item("algorithm", algorithm.name())?;
    match algorithm {
        Algorithm::Layered(choices) => layered(given, choices),
        Algorithm::AxisSheets { layer_axis: axis } => given.set_item("layer_axis", layer_axis(axis)),
        Algorithm::ViewSheets { sheet_distance } => given.set_item("sheet_distance", sheet_distance),
        Algorithm::Slicing { step } => given.set_item("step", step),
        Algorithm::Raycast { kernel, step } => {
            given.set_item("kernel", kernel.name())?;
            given.set_item("step", step)
        }
    }
}

/// A quality that has the same evaluation, and what else is chosen.
fn layered(given: &Bound<PyDict>, Layered { layer_axis: axis, evaluation, classification, .. }: Layered) -> PyResult<()> {
    given.set_item("layer_axis", layer_axis(axis))?;
    let Classification::Preintegrated { kernel, samples_per_layer } = classification else {
        return given.set_item("quality", "paper");
    };
    given.set_item("kernel", kernel.name())?;
    given.set_item("samples_per_layer", samples_per_layer)?;
    match evaluation {
        Evaluation::Lattice(Density::Fixed(density) | Density::AtLeast(density)) => given.set_item("density", density),
        Evaluation::Lattice(Density::Fine) => given.set_item("quality", "high"),
        Evaluation::Lattice(Density::Relaxed) | Evaluation::Direct => given.set_item("quality", "standard"),
    }
}

fn layer_axis(axis: LayerAxis) -> &'static str {
    match axis {
        LayerAxis::Auto => "auto",
        LayerAxis::Forced(Axis::X) => "x",
        LayerAxis::Forced(Axis::Y) => "y",
        LayerAxis::Forced(Axis::Z) => "z",
    }
}

fn shading<'py>(py: Python<'py>, shading: &Shading) -> PyResult<Bound<'py, PyDict>> {
    let numbers = PyDict::new(py);
    numbers.set_item("ambient", shading.ambient)?;
    numbers.set_item("diffuse", shading.diffuse)?;
    numbers.set_item("specular", shading.specular)?;
    numbers.set_item("power", shading.power)?;
    let light = |light: &Light| (light.direction.map(|direction| direction.to_array()), light.strength);
    numbers.set_item("light", shading.lights.as_slice().iter().map(light).collect::<Vec<_>>())?;
    Ok(numbers)
}
