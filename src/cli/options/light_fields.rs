//! Light in JSON: fields of a line of `--cameras` that replace the options of the same name.

use super::light::LightOptions;
use crate::cli::parse;
use clap::ValueEnum;
use serde_json::{Map, Value};

/// Removes the field `name` and parses it like the option; `on` and `off` may be true and false.
fn take<T>(fields: &mut Map<String, Value>, name: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<Option<T>, String> {
    fields.remove(name).map(|value| parse(&text(&value)).map_err(|problem| format!("{name}: {problem}"))).transpose()
}

fn text(value: &Value) -> String {
    match value {
        Value::Bool(true) => "on".into(),
        Value::Bool(false) => "off".into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn named<T: ValueEnum>(text: &str) -> Result<T, String> {
    T::from_str(text, false).map_err(|_| {
        let names = T::value_variants().iter().filter_map(|name| Some(name.to_possible_value()?.get_name().to_owned()));
        format!("'{text}' is none of {}", names.collect::<Vec<_>>().join(", "))
    })
}

impl LightOptions {
    /// Takes the fields about light out of a JSON object. `light` is the option's text, or a list of such texts.
    ///
    /// # Errors
    /// A description of the problem, with the field's name.
    pub fn from_fields(fields: &mut Map<String, Value>) -> Result<Self, String> {
        let lights = match fields.remove("light") {
            None => Vec::new(),
            Some(Value::Array(lights)) => lights,
            Some(light) => vec![light],
        };
        let light = lights.iter().map(|light| parse::light(&text(light)).map_err(|problem| format!("light: {problem}")));
        Ok(Self {
            light: light.collect::<Result<_, _>>()?,
            ambient_color: take(fields, "ambient_color", parse::color)?,
            shading: take(fields, "shading", parse::switch)?,
            light_space: take(fields, "light_space", named)?,
            shadows: take(fields, "shadows", parse::switch)?,
            shadow_strength: take(fields, "shadow_strength", parse::share)?,
            shadow_forgiveness: take(fields, "shadow_forgiveness", parse::positive)?,
            ambient_occlusion: take(fields, "ambient_occlusion", parse::switch)?,
            ao_reach: take(fields, "ao_reach", parse::reach)?,
            light_grid: take(fields, "light_grid", named)?,
        })
    }

    /// These options, with those of `other` where they are not given. Where these disable shadows or ambient occlusion, the details that
    /// `other` gives of them do not apply.
    pub fn or(self, other: &Self) -> Self {
        let shadows = self.shadows.or(other.shadows);
        let ambient_occlusion = self.ambient_occlusion.or(other.ambient_occlusion);
        let [has_shadows, has_occlusion] = [shadows, ambient_occlusion].map(|on| on == Some(true));
        Self {
            shading: self.shading.or(other.shading),
            light: if self.light.is_empty() { other.light.clone() } else { self.light },
            ambient_color: self.ambient_color.or(other.ambient_color),
            light_space: self.light_space.or(other.light_space),
            shadows,
            shadow_strength: self.shadow_strength.or(other.shadow_strength.filter(|_| has_shadows)),
            shadow_forgiveness: self.shadow_forgiveness.or(other.shadow_forgiveness.filter(|_| has_shadows)),
            ambient_occlusion,
            ao_reach: self.ao_reach.or(other.ao_reach.filter(|_| has_occlusion)),
            light_grid: self.light_grid.or(other.light_grid.filter(|_| has_shadows || has_occlusion)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(text: &str) -> Result<LightOptions, String> {
        LightOptions::from_fields(&mut serde_json::from_str(text).unwrap())
    }

    #[test]
    fn problems_are_named() {
        for (text, word) in [
            (r#"{"shadows":"perhaps"}"#, "shadows: use on or off"),
            (r#"{"shadow_strength":2}"#, "shadow_strength: '2'"),
            (r#"{"light":["0,0,1:2","up"]}"#, "light: invalid light 'up'"),
            (r#"{"light_grid":"eighth"}"#, "light_grid: 'eighth' is none of full, half, quarter"),
            (r#"{"ao_reach":-1}"#, "ao_reach: use inf"),
        ] {
            let Err(message) = options(text) else { panic!("{text} is accepted") };
            assert!(message.contains(word), "{text}: {message}");
        }
    }

    #[test]
    fn fields_replace_options() {
        let line = options(r#"{"shadows":false,"light":"0,0,1:2","ao_reach":"inf","output":"a.png"}"#).unwrap();
        let command =
            options(r#"{"shadows":true,"shadow_strength":0.5,"ambient_occlusion":true,"ao_reach":3,"light_grid":"half"}"#);
        let both = line.or(&command.unwrap());
        assert_eq!((both.shadows, both.shadow_strength, both.light.len()), (Some(false), None, 1));
        assert!(both.ao_reach.is_some_and(|reach| reach.0.is_none()) && both.light_grid.is_some());
    }
}
