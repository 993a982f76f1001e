//! Light in JSON: fields of a line of `--cameras` that replace the options of the same name.

use super::light::LightOptions;
use crate::settings::Look;
use clap::{Args, Command, FromArgMatches};
use serde_json::{Map, Value};

/// A value as its option takes it; `on` and `off` may be true and false.
fn text(value: &Value) -> String {
    match value {
        Value::Bool(true) => "on".into(),
        Value::Bool(false) => "off".into(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The lines of an error that say what is wrong and what is possible.
fn problem(refused: &clap::Error) -> String {
    let text = refused.to_string();
    let lines =
        text.trim_start_matches("error: ").lines().map(str::trim).take_while(|line| !line.starts_with("For more information"));
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

impl LightOptions {
    /// Takes the fields about light out of a JSON object: the options, with `_` for `-`. Options that can be repeated may have lists.
    ///
    /// # Errors
    /// A description of the problem, with the option's name.
    pub fn from_fields(fields: &mut Map<String, Value>) -> Result<Self, String> {
        let command = Self::augment_args(Command::new("light").no_binary_name(true));
        let mut words = Vec::new();
        for argument in command.get_arguments() {
            let values = match fields.remove(argument.get_id().as_str()) {
                None => continue,
                Some(Value::Array(values)) => values,
                Some(value) => vec![value],
            };
            let long = argument.get_long().expect("options of light have names");
            words.extend(values.iter().map(|value| format!("--{long}={}", text(value))));
        }
        let matches = command.try_get_matches_from(words).map_err(|refused| problem(&refused))?;
        Self::from_arg_matches(&matches).map_err(|refused| problem(&refused))
    }

    /// These options, with those of `other` where they are not given. Where these choose another look, or disable shadows or ambient
    /// occlusion, the details that `other` gives of them do not apply.
    pub fn or(self, other: &Self) -> Self {
        let look = self.look.or(other.look);
        let is_studio = look == Some(Look::Studio);
        // The studio has none of these.
        let of_plain = |on: Option<bool>| on.filter(|_| !is_studio);
        let shadows = self.shadows.or(of_plain(other.shadows));
        let ambient_occlusion = self.ambient_occlusion.or(of_plain(other.ambient_occlusion));
        let [has_shadows, has_occlusion] = [shadows, ambient_occlusion].map(|on| on == Some(true));
        Self {
            look,
            sky: self.sky.or(other.sky.filter(|_| is_studio)),
            sky_up: self.sky_up.or(other.sky_up.filter(|_| is_studio)),
            scattering: self.scattering.or(other.scattering.filter(|_| is_studio)),
            exposure: self.exposure.or(other.exposure.filter(|_| is_studio)),
            tone: self.tone.or(other.tone.filter(|_| is_studio)),
            shading: self.shading.or(of_plain(other.shading)),
            light: if self.light.is_empty() { other.light.clone() } else { self.light },
            ambient_color: self.ambient_color.or(other.ambient_color.filter(|_| !is_studio)),
            light_space: self.light_space.or(other.light_space),
            shadows,
            shadow_strength: self.shadow_strength.or(other.shadow_strength.filter(|_| has_shadows)),
            shadow_forgiveness: self.shadow_forgiveness.or(other.shadow_forgiveness.filter(|_| has_shadows)),
            ambient_occlusion,
            ao_reach: self.ao_reach.or(other.ao_reach.filter(|_| has_occlusion)),
            light_grid: self.light_grid.or(other.light_grid.filter(|_| has_shadows || has_occlusion || is_studio)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{LightGrid, Settings};

    fn options(text: &str) -> Result<LightOptions, String> {
        LightOptions::from_fields(&mut serde_json::from_str(text).unwrap())
    }

    #[test]
    fn problems_are_named() {
        for (text, word) in [
            (r#"{"shadows":"perhaps"}"#, "'--shadows <on|off>': use on or off"),
            (r#"{"shadow_strength":2}"#, "'--shadow-strength <SHARE>': '2' is not a strength from 0 to 1"),
            (r#"{"light":["0,0,1:2","up"]}"#, "invalid light 'up'"),
            (r#"{"light_grid":"eighth"}"#, "'--light-grid <NAME>' [possible values: full, half, quarter]"),
            (r#"{"ao_reach":-1}"#, "'-1' is not inf or a length above 0"),
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
        // A line of the other look.
        let plain = r#"{"shadows":true,"shading":true,"ambient_color":"white","light_grid":"half"}"#;
        let studio = r#"{"look":"studio","sky":"white","sky_up":"0,1,0","exposure":1,"light_grid":"half"}"#;
        let to_studio = options(r#"{"look":"studio"}"#).unwrap().or(&options(plain).unwrap()).apply(Settings::default()).unwrap();
        assert_eq!((to_studio.look(), to_studio.shadows, to_studio.light_grid), (Look::Studio, None, LightGrid::Half));
        let to_plain = options(r#"{"look":"plain"}"#).unwrap().or(&options(studio).unwrap()).apply(Settings::default()).unwrap();
        assert_eq!(to_plain, Settings::default());
        let kept = options("{}").unwrap().or(&options(studio).unwrap()).apply(Settings::default()).unwrap();
        let exposure = kept.studio.map(|studio| (studio.exposure, studio.sky.up.y));
        assert_eq!((exposure, kept.light_grid), (Some((1.0, 1.0)), LightGrid::Half));
    }
}
