//! What the arguments of settings state, and back.

use super::argument::{Argument, OTHER_KIND, Stated, stated};
use super::{
    Algorithm, AmbientOcclusion, Blend, Classification, ClipPlane, Clipping, CropBox, DepthCue, Evaluation, GradientOpacity,
    LayerAxis, Layered, Light, LightGrid, LightSpace, Lights, Look, Quality, Shading, Shadows, Sky, Tone,
};
use crate::choice::{Choice, in_words};
use crate::error::Error;
use crate::layers::{Density, GradientEstimator, Kernel};
use crate::transfer::Extinction;

/// States values of enumerations by their names.
macro_rules! by_name {
    ($($type:ty),+) => {
        $(stated!($type: String::EXPECTED;
            |argument| Self::from_name(&String::read(argument)?);
            |own| Argument::Name(own.name().into()));)+
    };
}

by_name!(Algorithm, Extinction, Kernel, LayerAxis, LightGrid, LightSpace, Look, Quality, Tone);

/// States structures by the names of their fields.
macro_rules! by_field {
    ($type:ty, $name:literal; $($key:literal $field:ident),+) => {
        impl $type {
            /// The fields that an argument states, and the others as they are here.
            fn with_fields(mut self, argument: &Argument) -> Result<Self, Error> {
                let Argument::Fields(fields) = argument else { return Err(OTHER_KIND) };
                for (key, value) in fields {
                    match key.as_str() {
                        $($key => self.$field = value.part($key)?,)+
                        _ => return Err(Error::UnknownName { what: $name, name: key.clone(), known: in_words([$($key),+].into_iter()) }),
                    }
                }
                Ok(self)
            }

            /// All fields that have a value.
            fn fields(&self) -> Vec<(String, Argument)> {
                let fields = [$(($key.to_owned(), self.$field.argument())),+];
                fields.into_iter().filter(|(_, argument)| *argument != Argument::Nothing).collect()
            }
        }
    };
}

by_field!(Shading, "shading"; "ambient" ambient, "ambient_color" ambient_color, "diffuse" diffuse, "specular" specular, "power" power, "light" lights);
by_field!(Shadows, "shadows"; "strength" strength, "forgiveness" forgiveness);
stated!(glam::DVec3: <[f64; 3]>::EXPECTED;
    |argument| <[f64; 3]>::read(argument).map(Into::into);
    |own| own.to_array().argument());

by_field!(Sky, "sky"; "top" top, "bottom" bottom, "strength" strength, "up" up, "space" space);
by_field!(AmbientOcclusion, "ambient_occlusion"; "reach" reach, "gain" gain);

stated!(Option<Shading>: "True, False, or a dict of ambient, ambient_color, diffuse, specular, power and light";
    |argument| {
        shading_from(argument, Shading::default())
    };
    |own| of_shading(*own, Shading::default()));

/// The shading that an argument states, whose other fields are those of `default`.
pub(super) fn shading_from(argument: &Argument, default: Shading) -> Result<Option<Shading>, Error> {
    if let Argument::Switch(on) = argument { Ok(on.then_some(default)) } else { default.with_fields(argument).map(Some) }
}

/// What differs from the default.
pub(super) fn of_shading(shading: Option<Shading>, default: Shading) -> Argument {
    let Some(own) = shading else { return Argument::Switch(false) };
    let fields = own.fields().into_iter().zip(default.fields());
    let differ = |(field, default): &(_, _)| field != default;
    let mut all: Vec<_> = fields.filter(|(field, _)| field.0 != "light").filter(differ).map(|(field, _)| field).collect();
    // Lights of other axes are stated alike.
    all.extend((own.lights != default.lights).then(|| ("light".into(), own.lights.argument())));
    Argument::Fields(all)
}

stated!(Option<Shadows>: "True, False, a strength from 0 to 1, or a dict of strength and forgiveness";
    |argument| {
        let default = Shadows::default();
        match argument {
            Argument::Switch(on) => Ok(on.then_some(default)),
            Argument::Fields(_) => default.with_fields(argument).map(Some),
            strength => Ok(Some(Shadows { strength: f64::read(strength)?, ..default })),
        }
    };
    |own| own.map_or(Argument::Switch(false), |own| Argument::Fields(own.fields())));

stated!(Sky: "a colour (r, g, b), a pair of colours of which the first is above, or a dict of top, bottom, strength and space";
    |argument| {
        let default = Sky::default();
        if let Argument::Fields(_) = argument {
            return default.with_fields(argument);
        }
        // A colour alone is the same from everywhere.
        let (top, bottom) = <([f64; 3], [f64; 3])>::read(argument).or_else(|_| <[f64; 3]>::read(argument).map(|one| (one, one)))?;
        Ok(Sky { top, bottom, strength: 1.0, ..default })
    };
    |own| Argument::Fields(own.fields()));

stated!(Option<AmbientOcclusion>: "True, False, or a dict of reach and gain";
    |argument| {
        let default = AmbientOcclusion::default();
        if let Argument::Switch(on) = argument {
            return Ok(on.then_some(default));
        }
        let own = default.with_fields(argument)?;
        Ok(Some(AmbientOcclusion { reach: own.reach.filter(|&reach| reach != f64::INFINITY), ..own }))
    };
    |own| own.map_or(Argument::Switch(false), |own| Argument::Fields(own.fields())));

stated!(GradientEstimator: String::EXPECTED;
    |argument| String::read(argument)?.parse().map_err(|problem| Error::Settings { field: "gradient", problem });
    |own| Argument::Name(own.to_string()));

stated!(Blend: "composite, maximum, minimum, average or ('iso', value)";
|argument| {
    let (name, value) = match argument {
        Argument::Name(name) => (name.clone(), None),
        _ => <(String, f64)>::read(argument).map(|(name, value)| (name, Some(value)))?,
    };
    let problem = match (Blend::from_name(&name)?, value) {
        (Blend::Iso(_), Some(value)) => return Ok(Blend::Iso(value)),
        (Blend::Iso(_), None) => "an iso-surface needs its data value: give ('iso', value)".into(),
        (blend, None) => return Ok(blend),
        (_, Some(_)) => format!("{name} takes no value; only iso does"),
    };
    Err(Error::Settings { field: "blend", problem })
};
|own| {
    let name = own.name().to_owned();
    if let Blend::Iso(value) = *own { (name, value).argument() } else { name.argument() }
});

stated!(GradientOpacity: "a list of pairs of numbers";
    |argument| GradientOpacity::new(&<Vec<_>>::read(argument)?);
    |own| own.points().to_vec().argument());

stated!(DepthCue: "a strength from 0 to 1, or (strength, (red, green, blue))";
    |argument| {
        let (strength, color) = match argument.values() {
            Ok(_) => Stated::read(argument)?,
            Err(_) => (f64::read(argument)?, DepthCue::default().color),
        };
        Ok(DepthCue { strength, color })
    };
    |own| (own.strength, own.color).argument());

stated!(CropBox: "two points, ((x, y, z), (x, y, z))";
    |argument| {
        let (lowest, highest) = <([f64; 3], [f64; 3])>::read(argument)?;
        Ok(CropBox { lowest: lowest.into(), highest: highest.into() })
    };
    |own| (own.lowest.to_array(), own.highest.to_array()).argument());

stated!([Option<ClipPlane>; Clipping::MAX_PLANES]: "a list of (point, normal), each of them (x, y, z)";
|argument| {
    let planes = <Vec<([f64; 3], [f64; 3])>>::read(argument)?;
    if planes.len() > Clipping::MAX_PLANES {
        let problem = format!("there are {} planes, more than {}: leave some out", planes.len(), Clipping::MAX_PLANES);
        return Err(Error::Settings { field: "clipping", problem });
    }
    let plane = |(point, normal): ([f64; 3], [f64; 3])| ClipPlane { point: point.into(), normal: normal.into() };
    Ok(Clipping::default().with_planes(planes.into_iter().map(plane)).planes)
};
|own| {
    let planes = own.iter().flatten().map(|plane| (plane.point.to_array(), plane.normal.to_array()));
    planes.collect::<Vec<_>>().argument()
});

// Direction and strength, then the angle and the colour if they are not the default.
stated!(Light: "a light";
|argument| {
    let mut light = Light::AT_CAMERA;
    let alone = <Option<[f64; 3]>>::read(argument);
    let direction = match (alone, argument.values()) {
        (Err(_), Ok([direction, rest @ ..])) if rest.len() <= 3 => {
            light.strength = rest.first().map_or(Ok(light.strength), f64::read)?;
            light.angle = rest.get(1).map_or(Ok(light.angle), f64::read)?;
            light.color = rest.get(2).map_or(Ok(light.color), <[f64; 3]>::read)?;
            <Option<[f64; 3]>>::read(direction)
        }
        (alone, _) => alone,
    };
    Ok(Light { direction: direction?.map(Into::into), ..light })
};
|own| {
    let direction = own.direction.map(|direction| direction.to_array());
    let is_white = own.color == Light::AT_CAMERA.color;
    let mut parts = vec![direction.argument(), own.strength.argument()];
    parts.extend((!is_white || own.angle != 0.0).then(|| own.angle.argument()));
    parts.extend((!is_white).then(|| own.color.argument()));
    Argument::Tuple(parts)
});

// The axes of their directions are an argument of their own.
stated!(Lights: "a direction (x, y, z), None, (direction, strength), (direction, strength, angle), (direction, strength, angle, (r, g, b)), or a list of up to four of these";
    |argument| {
        let lights = Light::read(argument).map(|light| vec![light]).or_else(|_| Stated::read(argument));
        Lights::new(&lights?)
    };
    |own| own.as_slice().to_vec().argument());

/// Arguments of an algorithm. Layers that no argument describes are those of the quality that resembles them.
pub(super) fn of_algorithm(algorithm: Algorithm) -> Vec<(&'static str, Argument)> {
    let mut all = match algorithm {
        Algorithm::Layered(layered) => return of_layers(layered),
        Algorithm::AxisSheets { layer_axis } => vec![("layer_axis", layer_axis.argument())],
        Algorithm::ViewSheets { sheet_distance } => vec![("sheet_distance", sheet_distance.argument())],
        Algorithm::Slicing { step } => vec![("step", step.argument())],
        Algorithm::Raycast { kernel, step } => vec![("kernel", kernel.argument()), ("step", step.argument())],
    };
    all.insert(0, ("algorithm", algorithm.argument()));
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
        ("quality", (quality != Quality::default()).then(|| quality.argument())),
        ("kernel", (!is_splatted && kernel != kernel_of(quality.layered())).then(|| kernel.argument())),
        ("samples_per_layer", (!is_splatted && !layered.adapts_to_opacity).then(|| samples.argument())),
        ("density", density.map(|density| density.argument())),
        ("layer_axis", (layered.layer_axis != LayerAxis::Auto).then(|| layered.layer_axis.argument())),
    ];
    all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
}
