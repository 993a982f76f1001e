//! ParaView colour-map presets (JSON): `RGBPoints` of value, r, g, b and `Points` of value, opacity, midpoint, sharpness.

use super::TransferFunction;
use crate::error::Error;
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
#[serde(untagged)]
enum File {
    Several(Vec<Preset>),
    One(Preset),
}

#[derive(Deserialize)]
struct Preset {
    #[serde(rename = "Name", default)]
    name: String,
    #[serde(rename = "ColorSpace")]
    color_space: Option<String>,
    #[serde(rename = "RGBPoints")]
    colors: Vec<f64>,
    #[serde(rename = "Points")]
    opacities: Option<Vec<f64>>,
}

/// Reads the first preset of a file, or the one called `name`.
pub(super) fn read(path: &Path, name: Option<&str>) -> Result<TransferFunction, Error> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::read(path, e))?;
    parse(&text, &path.display().to_string(), name)
}

fn parse(text: &str, file: &str, name: Option<&str>) -> Result<TransferFunction, Error> {
    let error = |problem: String| Error::Transfer { name: file.into(), problem };
    let parsed: File = serde_json::from_str(text).map_err(|e| match e.is_data() {
        true => error("is not a ParaView colour-map preset: an object, or a list of objects, with RGBPoints (numbers)".into()),
        false => error(format!("is not JSON: {e}")),
    })?;
    let presets = match parsed {
        File::Several(presets) => presets,
        File::One(preset) => vec![preset],
    };
    let known = presets.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
    let preset = presets.into_iter().find(|p| name.is_none_or(|n| p.name == n)).ok_or_else(|| match name {
        Some(n) => Error::UnknownName { what: "preset", name: format!("{file}#{n}"), known },
        None => error("holds no preset".into()),
    })?;
    if let Some(space) = preset.color_space.as_deref().filter(|s| *s != "RGB") {
        tracing::warn!("{file}: colour space {space} is interpolated in RGB");
    }
    let rows = |points: &[f64], what: &str| match points.as_chunks::<4>() {
        (rows, []) => Ok(rows.to_vec()),
        _ => Err(error(format!("{what} holds {} numbers, which is not a multiple of 4", points.len()))),
    };
    let colors: Vec<_> = rows(&preset.colors, "RGBPoints")?.iter().map(|&[x, r, g, b]| (x, [r, g, b])).collect();
    let opacities = match &preset.opacities {
        Some(points) => rows(points, "Points")?,
        // ParaView's own default for a preset without opacities.
        None => colors.first().zip(colors.last()).map_or(vec![], |(a, b)| vec![[a.0, 0.0, 0.5, 0.0], [b.0, 1.0, 0.5, 0.0]]),
    };
    if let Some([x, _, midpoint, sharpness]) = opacities.iter().find(|p| p[2] != 0.5 || p[3] != 0.0) {
        return Err(error(format!(
            "the opacity at {x} has midpoint {midpoint} and sharpness {sharpness}: only 0.5 and 0 (linear) are supported; \
             replace the curve by more points"
        )));
    }
    TransferFunction::new(file, colors, opacities.iter().map(|p| (p[0], p[1])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = r#"[{"Name": "a", "RGBPoints": [0,0,0,0, 9,1,1,1], "Points": [0,0,0.5,0, 9,1,0.5,0]},
                          {"Name": "b", "ColorSpace": "Lab", "RGBPoints": [0,0,0,0, 5,1,0,0]}]"#;

    #[test]
    fn the_first_or_the_named_one() {
        assert_eq!(parse(TWO, "f", None).unwrap().range(), (0.0, 9.0));
        let b = parse(TWO, "f", Some("b")).unwrap();
        assert_eq!((b.range(), b.opacity(2.5)), ((0.0, 5.0), 0.5));
        let message = parse(TWO, "f", Some("c")).unwrap_err().to_string();
        assert!(message.contains("f#c") && message.contains("a, b"), "{message}");
    }

    #[test]
    fn a_single_object_is_accepted() {
        let t = parse(r#"{"RGBPoints": [1,0.5,0.5,0.5], "Points": [1,0.25,0.5,0]}"#, "f", None).unwrap();
        assert_eq!((t.opacity(7.0), t.color(0.0)), (0.25, [0.5; 3]));
    }

    #[test]
    fn bad_files_say_what_is_wrong() {
        for (text, word) in [
            ("", "JSON"),
            ("[]", "no preset"),
            ("{}", "RGBPoints"),
            (r#"{"RGBPoints": [0,0,0]}"#, "multiple of 4"),
            (r#"{"RGBPoints": []}"#, "no points"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": []}"#, "no points"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": [0,0,0.3,0]}"#, "midpoint"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": [0,0,0.5,1]}"#, "sharpness"),
            (r#"{"RGBPoints": [5,0,0,0, 1,0,0,0]}"#, "sorted"),
            (r#"{"RGBPoints": [0,0,0,2]}"#, "from 0 to 1"),
        ] {
            let message = parse(text, "f.json", None).unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("f.json"), "{text}: {message}");
        }
    }
}
