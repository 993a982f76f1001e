//! Settings as arguments by name, as the package for Python takes them.

use super::{
    Algorithm, AmbientOcclusion, Blend, Classification, ClipPlane, Evaluation, GradientOpacity, LayerAxis, Layered, Light,
    LightSpace, Lights, Quality, Settings, Shading, Shadows,
};
use crate::choice::Choice;
use crate::layers::{Density, Kernel};
use std::fmt;

/// The value of an argument. It is displayed as code in Python.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// No value.
    Nothing,
    /// True or false.
    Switch(bool),
    /// A whole number.
    Whole(u32),
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// Values of fixed meaning and number.
    Tuple(Vec<Argument>),
    /// Any number of values.
    List(Vec<Argument>),
    /// Values by name.
    Fields(Vec<(&'static str, Argument)>),
}

impl From<f64> for Argument {
    fn from(number: f64) -> Self {
        Argument::Number(number)
    }
}

impl From<[f64; 3]> for Argument {
    fn from(numbers: [f64; 3]) -> Self {
        Argument::Tuple(numbers.map(Argument::Number).into())
    }
}

impl From<&str> for Argument {
    fn from(name: &str) -> Self {
        Argument::Name(name.into())
    }
}

/// A tuple of two values.
fn pair(first: impl Into<Argument>, second: impl Into<Argument>) -> Argument {
    Argument::Tuple(vec![first.into(), second.into()])
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let list = |values: &[Argument]| values.iter().map(Argument::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Argument::Nothing => f.write_str("None"),
            Argument::Switch(on) => f.write_str(if *on { "True" } else { "False" }),
            Argument::Whole(number) => write!(f, "{number}"),
            Argument::Number(number) if number.is_finite() => write!(f, "{number}"),
            Argument::Number(number) => write!(f, "float(\"{number}\")"),
            Argument::Name(name) => write!(f, "{name:?}"),
            Argument::Tuple(values) => write!(f, "({})", list(values)),
            Argument::List(values) => write!(f, "[{}]", list(values)),
            Argument::Fields(fields) => {
                let fields: Vec<_> = fields.iter().map(|(name, value)| format!("{name:?}: {value}")).collect();
                write!(f, "{{{}}}", fields.join(", "))
            }
        }
    }
}

impl Settings {
    /// The arguments that make equal settings, without those that are the default. Layers that no argument describes are those of the
    /// quality that resembles them.
    pub fn arguments(&self) -> Vec<(&'static str, Argument)> {
        let default = Settings::default();
        // All fields: one that is new needs an argument, or a reason to have none.
        #[rustfmt::skip]
        let Self {
            algorithm, blend, clipping, extinction, shading, shadows, ambient_occlusion, light_grid, gradient, gradient_opacity, depth_cue,
            early_termination, unit_distance,
            // The package has square pixels, and verifies nothing.
            pixel_aspect: _, culling: _,
        } = *self;
        let mut all = of_algorithm(algorithm);
        let mut add = |name, value: Option<Argument>| all.extend(value.map(|value| (name, value)));
        let of_blend = || if let Blend::Iso(value) = blend { pair("iso", value) } else { blend.name().into() };
        add("blend", (blend != default.blend).then(of_blend));
        let lights = Lights::default_with(shadows.is_some());
        let is_default = shading == Some(Shading { lights, ..Shading::default() });
        add("shading", (!is_default).then(|| of_shading(shading, lights)));
        let follows = |light: &Light| light.space == LightSpace::Camera;
        let follow = |shading: Shading| shading.lights != lights && shading.lights.as_slice().iter().any(follows);
        add("light_space", shading.is_some_and(follow).then(|| "camera".into()));
        let parts = |own: Shadows| vec![("strength", own.strength.into()), ("forgiveness", own.forgiveness.into())];
        add("shadows", shadows.map(|own| Argument::Fields(parts(own))));
        let parts =
            |own: AmbientOcclusion| own.reach.map(|reach| ("reach", reach.into())).into_iter().chain([("gain", own.gain.into())]);
        add("ambient_occlusion", ambient_occlusion.map(|own| Argument::Fields(parts(own).collect())));
        add("light_grid", (light_grid != default.light_grid).then(|| light_grid.name().into()));
        add("gradient", gradient.map(|gradient| Argument::Name(gradient.to_string())));
        let points = |function: GradientOpacity| function.points().iter().map(|&(length, factor)| pair(length, factor)).collect();
        add("gradient_opacity", gradient_opacity.map(|function| Argument::List(points(function))));
        add("depth_cue", depth_cue.map(|cue| pair(cue.strength, cue.color)));
        add("crop", clipping.crop.map(|crop| pair(crop.lowest.to_array(), crop.highest.to_array())));
        let plane = |plane: &ClipPlane| pair(plane.point.to_array(), plane.normal.to_array());
        let planes: Vec<_> = clipping.planes.iter().flatten().map(plane).collect();
        add("planes", (!planes.is_empty()).then_some(Argument::List(planes)));
        add("unit_distance", unit_distance.map(Argument::Number));
        add("extinction", (extinction != default.extinction).then(|| extinction.name().into()));
        add("early_termination", (!early_termination).then_some(Argument::Switch(early_termination)));
        all
    }
}

fn of_algorithm(algorithm: Algorithm) -> Vec<(&'static str, Argument)> {
    let mut all = match algorithm {
        Algorithm::Layered(layered) => return of_layers(layered),
        Algorithm::AxisSheets { layer_axis } => vec![("layer_axis", layer_axis.name().into())],
        Algorithm::ViewSheets { sheet_distance } => vec![("sheet_distance", sheet_distance.into())],
        Algorithm::Slicing { step } => vec![("step", step.into())],
        Algorithm::Raycast { kernel, step } => vec![("kernel", kernel.name().into()), ("step", step.into())],
    };
    all.insert(0, ("algorithm", algorithm.name().into()));
    all
}

/// A quality with the same evaluation, and the options that differ from it.
fn of_layers(layered: Layered) -> Vec<(&'static str, Argument)> {
    let kernel_of = |layered: Layered| match layered.classification {
        Classification::Preintegrated { kernel, .. } => kernel,
        Classification::Post(_) => Kernel::Cubic,
    };
    let samples = layered.classification.samples_per_layer();
    let (quality, density) = match (layered.classification, layered.evaluation) {
        (Classification::Post(_), _) => (Quality::Paper, None),
        (_, Evaluation::Lattice(Density::Fixed(density) | Density::AtLeast(density))) => {
            // A number of samples that was not given is that of the quality.
            let is_high = layered.adapts_to_opacity && samples == Quality::High.layered().classification.samples_per_layer();
            (if is_high { Quality::High } else { Quality::Standard }, Some(density))
        }
        (_, Evaluation::Lattice(Density::Fine)) => (Quality::High, None),
        (_, Evaluation::Lattice(Density::Relaxed | Density::Screen) | Evaluation::Direct) => (Quality::Standard, None),
    };
    let (kernel, is_splatted) = (kernel_of(layered), quality == Quality::Paper);
    let all = [
        ("quality", (quality != Quality::default()).then(|| quality.name().into())),
        ("kernel", (!is_splatted && kernel != kernel_of(quality.layered())).then(|| kernel.name().into())),
        ("samples_per_layer", (!is_splatted && !layered.adapts_to_opacity).then_some(Argument::Whole(samples))),
        ("density", density.map(Argument::Whole)),
        ("layer_axis", (layered.layer_axis != LayerAxis::Auto).then(|| layered.layer_axis.name().into())),
    ];
    all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}

/// The numbers that are not the default, and the lights unless they are `default_lights`.
fn of_shading(shading: Option<Shading>, default_lights: Lights) -> Argument {
    let (Some(own), default) = (shading, Shading::default()) else { return Argument::Switch(false) };
    let numbers = [
        ("ambient", own.ambient, default.ambient),
        ("diffuse", own.diffuse, default.diffuse),
        ("specular", own.specular, default.specular),
        ("power", own.power, default.power),
    ];
    let numbers = numbers.into_iter().filter(|(_, own, default)| own != default).map(|(name, own, _)| (name, own.into()));
    let color = (own.ambient_color != default.ambient_color).then(|| ("ambient_color", own.ambient_color.into()));
    let lights = || ("light", Argument::List(own.lights.as_slice().iter().map(of_light).collect()));
    Argument::Fields(numbers.chain(color).chain((own.lights != default_lights).then(lights)).collect())
}

/// Direction and strength, then the angle and the colour if they are not the default.
fn of_light(light: &Light) -> Argument {
    let direction = light.direction.map_or(Argument::Nothing, |direction| direction.to_array().into());
    let is_white = light.color == Light::AT_CAMERA.color;
    let mut parts = vec![direction, light.strength.into()];
    parts.extend((!is_white || light.angle != 0.0).then_some(light.angle.into()));
    parts.extend((!is_white).then(|| light.color.into()));
    Argument::Tuple(parts)
}
