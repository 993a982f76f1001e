//! Render settings.

use crate::argument::shown;
use crate::errors::{Failure, Refusal, Result};
use crate::pickled::{Reduced, reduced};
use layersplat::settings::{Argument, Setting};
use layersplat::{Error, Settings as Ours};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Render settings.
///
/// Defaults are those of the command: quality standard, composited, shaded, without clipping.
///
/// quality: draft, standard, high or paper. algorithm: layered, axis-sheets, view-sheets, slicing or raycast. kernel: cubic, linear,
/// catmull-rom or bspline; raycast also supports gaussian. Only for layered: samples_per_layer, 1 to 8; density, samples per voxel, 1 to
/// 16; layer_axis, auto, x, y or z. step: for slicing and raycast, in units of the smallest spacing. sheet_distance: for view-sheets, 0.125
/// to 4 voxels. blend: composite, maximum, minimum, average or ('iso', value). shading: True, False, or a dict of ambient, ambient_color
/// (red, green, blue), diffuse, specular, power and light. A light is a direction (x, y, z) towards it, None for a light at the camera,
/// (direction, strength), (direction, strength, angle) with an angular diameter of 0 to 45 degrees, which softens shadows, or (direction,
/// strength, angle, (red, green, blue)); light is one of these, or a list of up to four. Colours are from 0 to 1. light_space: world, or
/// camera, where directions of lights are (right, up, towards the viewer). shadows: True, False, their
/// share, 0 to 1, or a dict of strength, which is that share, and forgiveness, 1 to 1000: the factor of the light in shadows, by default 4.
/// With shadows and without a light, the light is (-1, 1, 1) in camera space. ambient_occlusion: True, False, or a dict of reach, the world
/// distance over which it decreases to 1/e, by default without limit, and gain, 1 to 1000: the factor of the ambient light, by default 3.
/// light_grid: full, half or quarter, the resolution of shadows, ambient occlusion and scattered light; shadows have at least half. look:
/// plain, or studio, where a sky and lights shine into the volume, which scatters their light, in linear colours; it has lights of its own
/// if none are given, and of shading only specular and power count. sky: of the studio, one colour (red, green, blue), the colours above
/// and below, or a dict of top, bottom, strength, up and space; linear, 0 to 100. scattering: the factor, 0 to 1, of the light that
/// scatters again. exposure: stops, -20 to 20, and tone: shoulder or none, the curve of bright colours; both of 8-bit pictures of the
/// studio. gradient: central,
/// sobel, gaussian:SIGMA (0.3 to 2 voxels) or own, for layered and raycast; by default sobel for layered, central for quality paper, and
/// for raycast the one that fits the kernel most closely. gradient_opacity: up to eight points (magnitude, factor): the opacity factor at a
/// gradient magnitude in values per world unit. depth_cue: the share, 0 to 1, of black that colours fade to at the back of the volume's
/// bounding box, or (share, (red, green, blue)) for another background. crop: ((x, y, z), (x, y, z)), the lowest and the highest visible
/// voxel. planes: up to six clipping planes (point, normal) in world coordinates; the side that the normal points to is shown.
/// unit_distance: thickness in world units at which the opacities apply, by default the smallest spacing. extinction: exponential or
/// linear. early_termination: whether rays stop at a transmittance below 1/4096. gamma: that of 8-bit pictures, 0.2 to 5: their colours
/// are raised to 1/gamma. pixel_aspect: width of a pixel in heights of a pixel, 1/16 to 16; cameras that frame a volume take pixels as
/// square.
#[pyclass(frozen, module = "layersplat")]
pub struct Settings(Ours);

impl Settings {
    pub fn from_library(settings: Ours) -> Self {
        Self(settings)
    }

    /// The code that makes them.
    pub fn code(&self, py: Python) -> PyResult<String> {
        self.__repr__(py)
    }

    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

#[pymethods]
impl Settings {
    #[new]
    #[pyo3(
        signature = (quality = None, **arguments),
        text_signature = "(quality=None, *, algorithm='layered', kernel=None, samples_per_layer=None, density=None, \
            layer_axis=None, step=None, sheet_distance=None, blend=None, shading=None, light_space='world', look='plain', \
            sky=None, scattering=None, exposure=None, tone=None, shadows=False, ambient_occlusion=False, light_grid='full', \
            gradient=None, gradient_opacity=None, depth_cue=None, crop=None, planes=None, unit_distance=None, \
            extinction='exponential', early_termination=True, gamma=1.0, pixel_aspect=1.0)"
    )]
    fn new(py: Python, quality: Option<Bound<PyAny>>, arguments: Option<Bound<PyDict>>) -> Result<Self> {
        let given = arguments.unwrap_or_else(|| PyDict::new(py));
        if let Some(quality) = quality {
            given.set_item("quality", quality)?;
        }
        let mut read = Vec::new();
        for (name, object) in &given {
            let name: String = name.extract()?;
            if Setting::named(&name).is_none() {
                return Err(PyTypeError::new_err(format!("Settings() got an unexpected keyword argument '{name}'")).into());
            }
            read.push((name, argument(&object)?));
        }
        Ours::from_arguments(read).map(Self).map_err(|error| shown_as_given(error, &given))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced::<Self>(py, dict(py, self.0.arguments())?)
    }

    fn __repr__(&self, py: Python) -> PyResult<String> {
        let arguments = dict(py, self.0.arguments())?;
        let shown: PyResult<Vec<_>> = arguments.iter().map(|(name, value)| Ok(format!("{name}={}", value.repr()?))).collect();
        Ok(format!("layersplat.Settings({})", shown?.join(", ")))
    }
}

/// The argument that an object states.
fn argument(object: &Bound<PyAny>) -> PyResult<Argument> {
    if object.is_none() {
        return Ok(Argument::Nothing);
    }
    if let Ok(on) = object.extract() {
        return Ok(Argument::Switch(on));
    }
    if let Ok(name) = object.extract() {
        return Ok(Argument::Name(name));
    }
    if let Ok(fields) = object.cast::<PyDict>() {
        let field = |(name, value): (Bound<PyAny>, Bound<PyAny>)| Ok((name.extract()?, argument(&value)?));
        return Ok(Argument::Fields(fields.iter().map(field).collect::<PyResult<_>>()?));
    }
    if let Ok(values) = object.extract::<Vec<Bound<PyAny>>>() {
        return Ok(Argument::List(values.iter().map(argument).collect::<PyResult<_>>()?));
    }
    match (object.extract(), object.extract()) {
        (Ok(number), _) => Ok(Argument::Whole(number)),
        (_, Ok(number)) => Ok(Argument::Number(number)),
        (_, Err(error)) if error.is_instance_of::<PyTypeError>(object.py()) => Ok(Argument::Other(object.repr()?.to_string())),
        // An exception of the object's own code.
        (_, Err(error)) => Err(error),
    }
}

/// An error whose value is written as the caller gave it, with its type.
fn shown_as_given(error: Error, given: &Bound<PyDict>) -> Failure {
    let Error::Argument { name, part, expected, is_of_other_kind, .. } = error else { return error.into() };
    let found = given.get_item(name).and_then(|found| {
        let whole = found.expect("the argument was given");
        part.map_or_else(|| Ok(whole.clone()), |part| whole.get_item(part))
    });
    let shown_name = part.map_or_else(|| name.to_owned(), |part| format!("{name}['{part}']"));
    let class = if is_of_other_kind { Refusal::Type } else { Refusal::Value };
    match found.and_then(|object| shown(&object)) {
        Ok(value) => Failure::Refused { class, message: format!("{shown_name} is {value}: expected {expected}"), field: name },
        Err(error) => error.into(),
    }
}

/// Arguments by name.
fn dict<'py, Name: AsRef<str>>(py: Python<'py>, named: Vec<(Name, Argument)>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    named.into_iter().try_for_each(|(name, value)| dict.set_item(name.as_ref(), object(py, value)?))?;
    Ok(dict)
}

/// The object that states an argument.
fn object<'py>(py: Python<'py>, argument: Argument) -> PyResult<Bound<'py, PyAny>> {
    let objects = |values: Vec<Argument>| values.into_iter().map(|value| object(py, value)).collect::<PyResult<Vec<_>>>();
    match argument {
        Argument::Nothing => Ok(py.None().into_bound(py)),
        Argument::Switch(on) => on.into_bound_py_any(py),
        Argument::Whole(number) => number.into_bound_py_any(py),
        Argument::Number(number) => number.into_bound_py_any(py),
        Argument::Name(name) | Argument::Other(name) => name.into_bound_py_any(py),
        Argument::Tuple(values) => Ok(PyTuple::new(py, objects(values)?)?.into_any()),
        Argument::List(values) => objects(values)?.into_bound_py_any(py),
        Argument::Fields(fields) => Ok(dict(py, fields)?.into_any()),
    }
}
