//! Render settings.

mod light;

use crate::argument::{Argument, accepted, either, extract};
use crate::errors::{Result, conflict};
use crate::pickled::{Reduced, reduced};
use layersplat::settings::{
    self, Algorithm, Blend, Classification, ClipPlane, Clipping, CropBox, DepthCue, Evaluation, GradientOpacity, LayerAxis,
    Layered, LightGrid, LightSpace, Lights,
};
use layersplat::{Choice, Density, GradientEstimator, Kernel, Quality, Settings as Ours, transfer::Extinction};
use light::{Lighting, Occluding, Shadowing};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{Borrowed, IntoPyObjectExt};

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
/// light_grid: full, half or quarter, the resolution of shadows and ambient occlusion; shadows have at least half. gradient: central,
/// sobel, gaussian:SIGMA (0.3 to 2 voxels) or own, for layered and raycast; by default sobel for layered, central for quality paper, and
/// for raycast the one that fits the kernel most closely. gradient_opacity: up to eight points (magnitude, factor): the opacity factor at a
/// gradient magnitude in values per world unit. depth_cue: the share, 0 to 1, of black that colours fade to at the back of the volume's
/// bounding box, or (share, (red, green, blue)) for another background. crop: ((x, y, z), (x, y, z)), the lowest and the highest visible
/// voxel. planes: up to six clipping planes (point, normal) in world coordinates; the side that the normal points to is shown.
/// unit_distance: thickness in world units at which the opacities apply, by default the smallest spacing. extinction: exponential or
/// linear. early_termination: whether rays stop at a transmittance below 1/4096.
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

/// A blend mode by name, or an iso-surface with its value.
enum BlendName {
    Named(String),
    Iso((String, f64)),
}

accepted! {
    BlendName: "composite, maximum, minimum, average or ('iso', value)";
    Cue: "a strength from 0 to 1, or (strength, (red, green, blue))";
}

impl<'a, 'py> FromPyObject<'a, 'py> for BlendName {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.extract() {
            Ok(name) => Ok(BlendName::Named(name)),
            Err(_) => object.extract().map(BlendName::Iso),
        }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Cue {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Cue::Strength, Cue::Colored)
    }
}

/// The strength of depth cueing, and the colour that is faded to if it isn't black.
enum Cue {
    Strength(f64),
    Colored((f64, [f64; 3])),
}

impl Cue {
    fn depth_cue(self) -> DepthCue {
        match self {
            Cue::Strength(strength) => DepthCue { strength, ..DepthCue::default() },
            Cue::Colored((strength, color)) => DepthCue { strength, color },
        }
    }
}

/// Algorithm-specific options.
struct AlgorithmOptions {
    quality: Option<Quality>,
    samples_per_layer: Option<u32>,
    density: Option<u32>,
    only_some: settings::AlgorithmOptions,
}

#[pymethods]
impl Settings {
    #[new]
    #[pyo3(
        signature = (
            quality = None, *, algorithm = Argument::Default("layered".into()), kernel = None, samples_per_layer = None, density = None,
            layer_axis = None, step = None, sheet_distance = None, blend = None, shading = None,
            light_space = Argument::Default("world".into()), shadows = Argument::Default(Shadowing::Switch(false)),
            ambient_occlusion = Argument::Default(Occluding::Switch(false)),
            light_grid = Argument::Default("full".into()), gradient = None, gradient_opacity = None, depth_cue = None, crop = None,
            planes = None, unit_distance = None, extinction = Argument::Default("exponential".into()),
            early_termination = Argument::Default(true),
        ),
        text_signature = "(quality=None, *, algorithm='layered', kernel=None, samples_per_layer=None, density=None, layer_axis=None, \
            step=None, sheet_distance=None, blend=None, shading=None, light_space='world', shadows=False, ambient_occlusion=False, \
            light_grid='full', gradient=None, gradient_opacity=None, depth_cue=None, crop=None, planes=None, unit_distance=None, \
            extinction='exponential', early_termination=True)"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn new(
        quality: Option<Argument<String>>,
        algorithm: Argument<String>,
        kernel: Option<Argument<String>>,
        samples_per_layer: Option<Argument<u32>>,
        density: Option<Argument<u32>>,
        layer_axis: Option<Argument<String>>,
        step: Option<Argument<f64>>,
        sheet_distance: Option<Argument<f64>>,
        blend: Option<Argument<BlendName>>,
        shading: Option<Argument<Lighting<'_>>>,
        light_space: Argument<String>,
        shadows: Argument<Shadowing<'_>>,
        ambient_occlusion: Argument<Occluding<'_>>,
        light_grid: Argument<String>,
        gradient: Option<Argument<String>>,
        gradient_opacity: Option<Argument<Vec<(f64, f64)>>>,
        depth_cue: Option<Argument<Cue>>,
        crop: Option<Argument<[[f64; 3]; 2]>>,
        planes: Option<Argument<Vec<[[f64; 3]; 2]>>>,
        unit_distance: Option<Argument<f64>>,
        extinction: Argument<String>,
        early_termination: Argument<bool>,
    ) -> Result<Self> {
        extract!(quality, algorithm, kernel, samples_per_layer, density, layer_axis, step, sheet_distance);
        extract!(
            blend,
            shading,
            light_space,
            shadows,
            ambient_occlusion,
            light_grid,
            gradient,
            gradient_opacity,
            depth_cue,
            crop,
            planes,
            unit_distance,
            extinction,
            early_termination
        );
        let quality = quality.as_deref().map(Quality::from_name).transpose()?;
        let kernel = kernel.as_deref().map(Kernel::from_name).transpose()?;
        let layer_axis = layer_axis.as_deref().map(LayerAxis::from_name).transpose()?;
        let only_some = settings::AlgorithmOptions { kernel, step, sheet_distance, layer_axis };
        let options = AlgorithmOptions { quality, samples_per_layer, density, only_some };
        let shadows = shadows.shadows()?;
        let lights = Lights::default_with(shadows.is_some());
        let shading = shading.unwrap_or(Lighting::Switch(true)).shading(lights, LightSpace::from_name(&light_space)?)?;
        Ok(Self(Ours {
            blend: blend.map_or(Ok(Blend::Composite), |blend| blend.blend())?,
            clipping: clipping(crop, planes.unwrap_or_default())?,
            extinction: Extinction::from_name(&extinction)?,
            shading,
            shadows,
            ambient_occlusion: ambient_occlusion.occlusion()?,
            light_grid: LightGrid::from_name(&light_grid)?,
            gradient: gradient.as_deref().map(estimator).transpose()?,
            gradient_opacity: gradient_opacity.map(|points| GradientOpacity::new(&points)).transpose()?,
            depth_cue: depth_cue.map(Cue::depth_cue),
            early_termination,
            unit_distance,
            ..options.algorithm(Algorithm::from_name(&algorithm)?)?.into()
        }))
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced::<Self>(py, arguments(py, self.0.arguments())?)
    }

    fn __repr__(&self, py: Python) -> PyResult<String> {
        let arguments = arguments(py, self.0.arguments())?;
        let shown: PyResult<Vec<_>> = arguments.iter().map(|(name, value)| Ok(format!("{name}={}", value.repr()?))).collect();
        Ok(format!("layersplat.Settings({})", shown?.join(", ")))
    }
}

/// Arguments by name.
fn arguments<'py>(py: Python<'py>, named: Vec<(&'static str, settings::Argument)>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    named.into_iter().try_for_each(|(name, value)| dict.set_item(name, object(py, value)?))?;
    Ok(dict)
}

fn object<'py>(py: Python<'py>, argument: settings::Argument) -> PyResult<Bound<'py, PyAny>> {
    use settings::Argument;
    let objects = |values: Vec<Argument>| values.into_iter().map(|value| object(py, value)).collect::<PyResult<Vec<_>>>();
    match argument {
        Argument::Nothing => Ok(py.None().into_bound(py)),
        Argument::Switch(on) => on.into_bound_py_any(py),
        Argument::Whole(number) => number.into_bound_py_any(py),
        Argument::Number(number) => number.into_bound_py_any(py),
        Argument::Name(name) => name.into_bound_py_any(py),
        Argument::Tuple(values) => Ok(PyTuple::new(py, objects(values)?)?.into_any()),
        Argument::List(values) => objects(values)?.into_bound_py_any(py),
        Argument::Fields(fields) => Ok(arguments(py, fields)?.into_any()),
    }
}

fn estimator(name: &str) -> Result<GradientEstimator> {
    name.parse().map_err(|problem| conflict("gradient", problem))
}

impl BlendName {
    fn blend(self) -> Result<Blend> {
        match self {
            BlendName::Iso((name, value)) => match Blend::from_name(&name)? {
                Blend::Iso(_) => Ok(Blend::Iso(value)),
                _ => Err(conflict("blend", format!("{name} takes no value; only iso does"))),
            },
            BlendName::Named(name) => match Blend::from_name(&name)? {
                Blend::Iso(_) => Err(conflict("blend", "an iso-surface needs its data value: give ('iso', value)")),
                blend => Ok(blend),
            },
        }
    }
}

fn clipping(crop: Option<[[f64; 3]; 2]>, planes: Vec<[[f64; 3]; 2]>) -> Result<Clipping> {
    if planes.len() > Clipping::MAX_PLANES {
        let problem = format!("there are {} planes, more than {}: leave some out", planes.len(), Clipping::MAX_PLANES);
        return Err(conflict("clipping", problem));
    }
    let crop = crop.map(|[lowest, highest]| CropBox { lowest: lowest.into(), highest: highest.into() });
    let planes = planes.into_iter().map(|[point, normal]| ClipPlane { point: point.into(), normal: normal.into() });
    Ok(Clipping { crop, ..Clipping::default() }.with_planes(planes))
}

impl AlgorithmOptions {
    /// The algorithm with its options. Rejects options of other algorithms.
    fn algorithm(&self, algorithm: Algorithm) -> Result<Algorithm> {
        if let Algorithm::Layered(_) = algorithm {
            return Ok(Algorithm::from(self.layered()?).with(self.only_some)?);
        }
        algorithm.reject(&[
            ("quality", self.quality.is_some()),
            ("samples_per_layer", self.samples_per_layer.is_some()),
            ("density", self.density.is_some()),
        ])?;
        Ok(algorithm.with(self.only_some)?)
    }

    /// The options of the quality, overridden by explicit ones.
    fn layered(&self) -> Result<Layered> {
        let mut layered = self.quality.unwrap_or_default().layered();
        match &mut layered.classification {
            Classification::Preintegrated { samples_per_layer, .. } => {
                *samples_per_layer = self.samples_per_layer.unwrap_or(*samples_per_layer);
                layered.adapts_to_opacity = self.samples_per_layer.is_none();
            }
            Classification::Post(_) => {
                let fixed =
                    [("kernel", self.only_some.kernel.is_some()), ("samples_per_layer", self.samples_per_layer.is_some())];
                if let Some((field, _)) = fixed.iter().find(|(_, is_set)| *is_set) {
                    return Err(conflict(field, "this quality uses the paper's own: leave it out, or choose another quality"));
                }
            }
        }
        match (self.density, layered.evaluation) {
            (None, _) => {}
            (Some(density), Evaluation::Lattice(_)) => layered.evaluation = Evaluation::Lattice(Density::Fixed(density)),
            (Some(_), Evaluation::Direct) => {
                return Err(conflict("density", "this quality has no lattice: leave it out, or choose another quality"));
            }
        }
        Ok(layered)
    }
}
