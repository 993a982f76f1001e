//! Arguments that reproduce settings, for pickling and `repr`.

use super::light::default_lights;
use crate::errors::conflict;
use layersplat::settings::{
    Algorithm, Blend, Classification, CropBox, Evaluation, LayerAxis, Layered, Light, LightSpace, Lights, Shading,
};
use layersplat::{Axis, Density, Quality, Settings, transfer::Extinction};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Arguments with which `Settings(…)` makes equal settings.
pub fn arguments<'py>(py: Python<'py>, settings: &Settings) -> PyResult<Bound<'py, PyDict>> {
    let arguments = PyDict::new(py);
    algorithm(&arguments, settings.algorithm)?;
    match settings.blend {
        Blend::Composite => arguments.set_item("blend", "composite")?,
        Blend::Maximum => arguments.set_item("blend", "maximum")?,
        Blend::Minimum => arguments.set_item("blend", "minimum")?,
        Blend::Average => arguments.set_item("blend", "average")?,
        Blend::Iso(value) => arguments.set_item("blend", ("iso", value))?,
        other => return Err(conflict("blend", format!("{other:?} has no name in Python")).into()),
    }
    match settings.shading {
        Some(numbers) => shading(&arguments, &numbers, default_lights(settings.shadows.is_some()))?,
        None => arguments.set_item("shading", false)?,
    }
    if let Some(shadows) = settings.shadows {
        let numbers = PyDict::new(py);
        numbers.set_item("strength", shadows.strength)?;
        numbers.set_item("forgiveness", shadows.forgiveness)?;
        arguments.set_item("shadows", numbers)?;
    }
    if let Some(occlusion) = settings.ambient_occlusion {
        let numbers = PyDict::new(py);
        if let Some(reach) = occlusion.reach {
            numbers.set_item("reach", reach)?;
        }
        numbers.set_item("gain", occlusion.gain)?;
        arguments.set_item("ambient_occlusion", numbers)?;
    }
    arguments.set_item("light_grid", settings.light_grid.name())?;
    if let Some(gradient) = settings.gradient {
        arguments.set_item("gradient", gradient.to_string())?;
    }
    if let Some(gradient_opacity) = &settings.gradient_opacity {
        arguments.set_item("gradient_opacity", gradient_opacity.points())?;
    }
    if let Some(cue) = settings.depth_cue {
        arguments.set_item("depth_cue", (cue.strength, cue.color))?;
    }
    if let Some(CropBox { lowest, highest }) = settings.clipping.crop {
        arguments.set_item("crop", (lowest.to_array(), highest.to_array()))?;
    }
    let planes = settings.clipping.planes.iter().flatten();
    arguments.set_item("planes", planes.map(|plane| (plane.point.to_array(), plane.normal.to_array())).collect::<Vec<_>>())?;
    arguments.set_item("unit_distance", settings.unit_distance)?;
    arguments.set_item(
        "extinction",
        match settings.extinction {
            Extinction::Exponential => "exponential",
            Extinction::Linear => "linear",
        },
    )?;
    arguments.set_item("early_termination", settings.early_termination)?;
    Ok(arguments)
}

fn algorithm(arguments: &Bound<PyDict>, algorithm: Algorithm) -> PyResult<()> {
    arguments.set_item("algorithm", algorithm.name())?;
    match algorithm {
        Algorithm::Layered(choices) => layered(arguments, choices),
        Algorithm::AxisSheets { layer_axis: axis } => arguments.set_item("layer_axis", layer_axis(axis)),
        Algorithm::ViewSheets { sheet_distance } => arguments.set_item("sheet_distance", sheet_distance),
        Algorithm::Slicing { step } => arguments.set_item("step", step),
        Algorithm::Raycast { kernel, step } => {
            arguments.set_item("kernel", kernel.name())?;
            arguments.set_item("step", step)
        }
    }
}

/// A quality with the same evaluation, and the options that differ from it.
fn layered(
    arguments: &Bound<PyDict>,
    Layered { layer_axis: axis, evaluation, classification, adapts_to_opacity, .. }: Layered,
) -> PyResult<()> {
    arguments.set_item("layer_axis", layer_axis(axis))?;
    let Classification::Preintegrated { kernel, samples_per_layer } = classification else {
        return arguments.set_item("quality", "paper");
    };
    arguments.set_item("kernel", kernel.name())?;
    if !adapts_to_opacity {
        arguments.set_item("samples_per_layer", samples_per_layer)?;
    }
    match evaluation {
        Evaluation::Lattice(Density::Fixed(density) | Density::AtLeast(density)) => {
            // A number of samples that was not given is that of the quality.
            if adapts_to_opacity && samples_per_layer == Quality::High.layered().classification.samples_per_layer() {
                arguments.set_item("quality", "high")?;
            }
            arguments.set_item("density", density)
        }
        Evaluation::Lattice(Density::Fine) => arguments.set_item("quality", "high"),
        Evaluation::Lattice(Density::Relaxed | Density::Screen) | Evaluation::Direct => arguments.set_item("quality", "standard"),
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

/// The coefficients, and the lights where they are not the default ones.
fn shading(arguments: &Bound<PyDict>, shading: &Shading, default_lights: Lights) -> PyResult<()> {
    let numbers = PyDict::new(arguments.py());
    numbers.set_item("ambient", shading.ambient)?;
    if shading.ambient_color != [1.0; 3] {
        numbers.set_item("ambient_color", shading.ambient_color)?;
    }
    numbers.set_item("diffuse", shading.diffuse)?;
    numbers.set_item("specular", shading.specular)?;
    numbers.set_item("power", shading.power)?;
    if shading.lights != default_lights {
        let lights = shading.lights.as_slice();
        let light = |light: &Light| {
            let Light { strength, angle, color, .. } = *light;
            (light.direction.map(|direction| direction.to_array()), strength, angle, color)
        };
        numbers.set_item("light", lights.iter().map(light).collect::<Vec<_>>())?;
        // The constructor gives all directions the same axes.
        if lights.iter().any(|light| light.space == LightSpace::Camera) {
            arguments.set_item("light_space", "camera")?;
        }
    }
    arguments.set_item("shading", numbers)
}
