//! ParaView colour-map presets (JSON): `RGBPoints` of value, r, g, b and `Points` of value, opacity, midpoint, sharpness.

use super::TransferFunction;
use crate::error::Error;
use serde::Deserialize;
use serde_json::Value;
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
    colors: Option<Vec<f64>>,
    #[serde(rename = "Points")]
    opacities: Option<Vec<f64>>,
    #[serde(rename = "UseLogScale", default)]
    log_scale: Value,
    #[serde(rename = "IndexedColors", default)]
    indexed_colors: Vec<f64>,
}

impl Preset {
    /// Parts of it that change what ParaView shows, and nothing here.
    fn ignored(&self) -> Vec<String> {
        let space = self.color_space.as_deref().filter(|space| *space != "RGB");
        let space = space.map(|space| format!("its colour space is {space}: colours between points are mixed in RGB"));
        let logarithmic = !matches!(&self.log_scale, Value::Null | Value::Bool(false)) && self.log_scale.as_f64() != Some(0.0);
        let scale = logarithmic.then(|| "UseLogScale is ignored: the scale is linear".into());
        let categories =
            (!self.indexed_colors.is_empty()).then(|| "IndexedColors are ignored: values have the colours of RGBPoints".into());
        [space, scale, categories].into_iter().flatten().collect()
    }
}

/// `FILE#PRESET`.
#[cfg(unix)]
pub(super) fn file_and_preset(source: &Path) -> Option<(&Path, &str)> {
    use std::os::unix::ffi::OsStrExt;
    let bytes = source.as_os_str().as_bytes();
    let mark = bytes.iter().rposition(|&byte| byte == b'#')?;
    let preset = str::from_utf8(&bytes[mark + 1..]).ok()?;
    Some((Path::new(std::ffi::OsStr::from_bytes(&bytes[..mark])), preset))
}

/// `FILE#PRESET`, of files whose names are Unicode.
#[cfg(not(unix))]
pub(super) fn file_and_preset(source: &Path) -> Option<(&Path, &str)> {
    let (file, preset) = source.to_str()?.rsplit_once('#')?;
    Some((Path::new(file), preset))
}

/// Reads the first preset of a file, or the one called `name`.
pub(super) fn read(path: &Path, name: Option<&str>) -> Result<TransferFunction, Error> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::read(path, e))?;
    parse(&text, &path.display().to_string(), name)
}

fn parse(text: &str, file: &str, name: Option<&str>) -> Result<TransferFunction, Error> {
    let error = |problem: String| Error::Transfer { name: file.into(), problem };
    // Some editors begin a file with a byte-order mark, which JSON does not have.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
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
    for ignored in preset.ignored() {
        tracing::warn!("{file}, preset '{}': {ignored}", preset.name);
    }
    let rows = |points: &[f64], what: &str| match points.as_chunks::<4>() {
        (rows, []) => Ok(rows.to_vec()),
        _ => Err(error(format!("{what} holds {} numbers, which is not a multiple of 4", points.len()))),
    };
    let Some(colors) = &preset.colors else {
        return Err(error(format!("preset '{}' has no RGBPoints: it is no colour map, or has categories alone", preset.name)));
    };
    let colors: Vec<_> = rows(colors, "RGBPoints")?.iter().map(|&[x, r, g, b]| (x, [r, g, b])).collect();
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
    fn categories_do_not_spoil_the_presets_beside_them() {
        let beside = format!(r#"[{{"Name": "kinds", "IndexedColors": [1, 0, 0]}}, {}"#, &TWO[1..]);
        assert_eq!(parse(&beside, "f", Some("a")).unwrap(), parse(TWO, "f", None).unwrap());
    }

    #[test]
    fn a_byte_order_mark_is_no_part_of_it() {
        assert_eq!(parse(&format!("\u{feff}{TWO}"), "f", None).unwrap(), parse(TWO, "f", None).unwrap());
    }

    #[test]
    fn what_is_ignored_is_said() {
        let ignored = |more: &str| {
            let preset: Preset = serde_json::from_str(&format!(r#"{{"RGBPoints": [0,0,0,0]{more}}}"#)).unwrap();
            preset.ignored()
        };
        for nothing in ["", r#", "UseLogScale": 0, "IndexedColors": []"#, r#", "UseLogScale": false, "ColorSpace": "RGB""#] {
            assert_eq!(ignored(nothing), [""; 0], "{nothing}");
        }
        for (more, word) in [
            (r#", "UseLogScale": 1"#, "UseLogScale"),
            (r#", "UseLogScale": true"#, "UseLogScale"),
            (r#", "IndexedColors": [1, 0, 0]"#, "IndexedColors"),
            (r#", "ColorSpace": "Lab""#, "Lab"),
        ] {
            assert!(matches!(&ignored(more)[..], [one] if one.contains(word)), "{more}");
        }
    }

    #[test]
    fn bad_files_say_what_is_wrong() {
        for (text, word) in [
            ("", "JSON"),
            ("[]", "no preset"),
            ("{}", "RGBPoints"),
            (r#"{"Name": "kinds", "IndexedColors": [1, 0, 0]}"#, "'kinds' has no RGBPoints"),
            (r#"{"RGBPoints": ["red"]}"#, "RGBPoints (numbers)"),
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
