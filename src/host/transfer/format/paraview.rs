//! ParaView colour-map presets (JSON): `RGBPoints` of value, r, g, b and `Points` of value, opacity, midpoint, sharpness.

use super::ciede2000;
use super::color_space::ColorSpace;
use super::curve::{Mix, Node, pieces};
use super::{MAX_POINTS, bad};
use crate::error::Error;
use crate::transfer::{ControlPoint, TransferFunction};
use serde::{Deserialize, Serialize};
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
    #[serde(rename = "HSVWrap", default)]
    wrapped: Value,
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
    /// Warnings about properties that ParaView honours and this crate ignores.
    fn ignored(&self) -> Vec<String> {
        let scale = is_set(&self.log_scale).then(|| "UseLogScale is ignored: the scale is linear".into());
        let categories =
            (!self.indexed_colors.is_empty()).then(|| "IndexedColors are ignored: colours come from RGBPoints".into());
        [scale, categories].into_iter().flatten().collect()
    }

    fn space(&self) -> Result<ColorSpace, String> {
        Ok(match self.color_space.as_deref() {
            None | Some("RGB") => ColorSpace::Rgb,
            Some("HSV") => ColorSpace::Hsv { shorter_way: is_set(&self.wrapped) },
            Some("Lab" | "CIELAB") => ColorSpace::Lab,
            Some("Lab/CIEDE2000") => ColorSpace::Ciede2000,
            Some("Diverging") => ColorSpace::Diverging,
            Some("Step") => ColorSpace::Step,
            Some(other) => {
                return Err(format!(
                    "its ColorSpace is {other}: expected RGB, HSV, Lab, Lab/CIEDE2000, Diverging or Step; choose one of them in ParaView"
                ));
            }
        })
    }

    /// Control points of the colours.
    fn colors(&self) -> Result<Vec<ControlPoint<[f64; 3]>>, String> {
        let Some(points) = &self.colors else {
            return Err("has no RGBPoints: it is not a colour map, or holds categories only".into());
        };
        let nodes: Vec<_> = rows(points, "RGBPoints")?.iter().map(|&[x, r, g, b]| Node::straight(x, [r, g, b])).collect();
        // Mixing would clamp invalid colours; pass them on so that validation rejects them.
        let are_colors = nodes.iter().all(|node| node.y.iter().all(|c| (0.0..=1.0).contains(c)));
        match self.space()? {
            ColorSpace::Rgb => pieces(&nodes, &Mix::Straight),
            _ if !are_colors => pieces(&nodes, &Mix::Straight),
            ColorSpace::Step => Ok(stepped(&nodes)),
            ColorSpace::Ciede2000 if nodes.len() <= MAX_PATHS => Ok(along_paths(&nodes)),
            space => pieces(&nodes, &Mix::Curved(&|from, to, share| space.mixed(from, to, share).map(|c| c.min(1.0)))),
        }
    }

    /// Control points of the opacities.
    fn opacities(&self, colors: &[ControlPoint<[f64; 3]>]) -> Result<Vec<ControlPoint<f64>>, String> {
        let nodes = match &self.opacities {
            Some(points) => {
                let rows = rows(points, "Points")?;
                rows.iter().map(|&[value, y, midpoint, sharpness]| Node { value, y: [y], midpoint, sharpness }).collect()
            }
            // ParaView's default for a preset without opacities.
            None => colors
                .first()
                .zip(colors.last())
                .map_or(vec![], |(a, b)| vec![Node::straight(a.0, [0.0]), Node::straight(b.0, [1.0])]),
        };
        let points = pieces(&nodes, &Mix::Straight).map_err(|problem| format!("Points: {problem}"))?;
        Ok(points.into_iter().map(|(value, [opacity])| (value, opacity)).collect())
    }
}

/// Whether a switch is on; presets store it as a number or a boolean.
fn is_set(switch: &Value) -> bool {
    !matches!(switch, Value::Null | Value::Bool(false)) && switch.as_f64() != Some(0.0)
}

/// Groups numbers into points of four.
fn rows(points: &[f64], what: &str) -> Result<Vec<[f64; 4]>, String> {
    match points.as_chunks::<4>() {
        (rows, _) if rows.len() > MAX_POINTS => Err(format!("{what} holds more than {MAX_POINTS} points: use fewer")),
        (rows, []) => Ok(rows.to_vec()),
        _ => Err(format!("{what} holds {} numbers, which is not a multiple of 4", points.len())),
    }
}

/// Above this many points, CIELAB replaces CIEDE2000 paths. Neighbouring points are then so close that the difference is invisible,
/// and each path takes milliseconds.
const MAX_PATHS: usize = 300;

/// Control points along the CIEDE2000 paths between the nodes.
fn along_paths(nodes: &[Node<3>]) -> Vec<ControlPoint<[f64; 3]>> {
    let between = nodes.windows(2).flat_map(|pair| {
        let (from, to) = (pair[0].value, pair[1].value);
        let value = move |share: f64| if share < 1.0 { from + (to - from) * share } else { to };
        ciede2000::path(pair[0].y, pair[1].y).into_iter().map(move |(share, color)| (value(share), color))
    });
    nodes.first().map(|node| (node.value, node.y)).into_iter().chain(between).collect()
}

/// A step function: each point's colour holds from above the previous point up to the point itself.
fn stepped(nodes: &[Node<3>]) -> Vec<ControlPoint<[f64; 3]>> {
    let steps = nodes.windows(2).flat_map(|pair| {
        let above = pair[0].value.next_up();
        [(above, pair[0].y), (above, pair[1].y)]
    });
    steps.chain(nodes.last().map(|node| (node.value.next_up(), node.y))).collect()
}

/// Splits `FILE#PRESET`.
#[cfg(unix)]
pub(in crate::transfer) fn file_and_preset(source: &Path) -> Option<(&Path, &str)> {
    use std::os::unix::ffi::OsStrExt;
    let bytes = source.as_os_str().as_bytes();
    let mark = bytes.iter().rposition(|&byte| byte == b'#')?;
    let preset = str::from_utf8(&bytes[mark + 1..]).ok()?;
    Some((Path::new(std::ffi::OsStr::from_bytes(&bytes[..mark])), preset))
}

/// Splits `FILE#PRESET`, for Unicode file names.
#[cfg(not(unix))]
pub(in crate::transfer) fn file_and_preset(source: &Path) -> Option<(&Path, &str)> {
    let (file, preset) = source.to_str()?.rsplit_once('#')?;
    Some((Path::new(file), preset))
}

/// The preset called `name`, or the first one.
pub(super) fn parse(text: &str, file: &str, name: Option<&str>) -> Result<TransferFunction, Error> {
    let parsed: File = serde_json::from_str(text).map_err(|e| match e.is_data() {
        true => bad(file, "is not a ParaView colour-map preset: an object, or a list of objects, with RGBPoints (numbers)"),
        false => bad(file, format!("is not JSON: {e}")),
    })?;
    let presets = match parsed {
        File::Several(presets) => presets,
        File::One(preset) => vec![preset],
    };
    let known = presets.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
    let preset = presets.into_iter().find(|p| name.is_none_or(|n| p.name == n)).ok_or_else(|| match name {
        Some(n) => Error::UnknownName { what: "preset", name: format!("{file}#{n}"), known },
        None => bad(file, "holds no preset"),
    })?;
    for ignored in preset.ignored() {
        tracing::warn!("{file}, preset '{}': {ignored}", preset.name);
    }
    let preset_error = |problem| bad(file, format!("preset '{}': {problem}", preset.name));
    let colors = preset.colors().map_err(preset_error)?;
    let opacities = preset.opacities(&colors).map_err(preset_error)?;
    TransferFunction::new(file, colors, opacities)
}

#[derive(Serialize)]
#[serde(rename_all = "PascalCase")]
struct Written<'a> {
    name: &'a str,
    creator: &'static str,
    color_space: &'static str,
    nan_color: [f64; 3],
    #[serde(rename = "RGBPoints")]
    colors: Vec<f64>,
    points: Vec<f64>,
}

/// A list of one preset, which ParaView can import.
pub(super) fn written(transfer: &TransferFunction) -> String {
    let preset = Written {
        name: transfer.name(),
        creator: "layersplat",
        color_space: "RGB",
        nan_color: [0.0; 3],
        colors: transfer.colors().iter().flat_map(|&(value, [r, g, b])| [value, r, g, b]).collect(),
        points: transfer.opacities().iter().flat_map(|&(value, opacity)| [value, opacity, 0.5, 0.0]).collect(),
    };
    serde_json::to_string_pretty(&[preset]).expect("finite numbers") + "\n"
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
        assert_eq!(super::super::parse(&format!("\u{feff}{TWO}"), "f", None).unwrap(), parse(TWO, "f", None).unwrap());
    }

    #[test]
    fn what_is_ignored_is_said() {
        let ignored = |more: &str| {
            let preset: Preset = serde_json::from_str(&format!(r#"{{"RGBPoints": [0,0,0,0]{more}}}"#)).unwrap();
            preset.ignored()
        };
        for nothing in ["", r#", "UseLogScale": 0, "IndexedColors": []"#, r#", "UseLogScale": false, "ColorSpace": "Lab""#] {
            assert_eq!(ignored(nothing), [""; 0], "{nothing}");
        }
        for (more, word) in [
            (r#", "UseLogScale": 1"#, "UseLogScale"),
            (r#", "UseLogScale": true"#, "UseLogScale"),
            (r#", "IndexedColors": [1, 0, 0]"#, "IndexedColors"),
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
            (r#"{"Name": "kinds", "IndexedColors": [1, 0, 0]}"#, "'kinds': has no RGBPoints"),
            (r#"{"RGBPoints": ["red"]}"#, "RGBPoints (numbers)"),
            (r#"{"RGBPoints": [0,0,0]}"#, "multiple of 4"),
            (r#"{"RGBPoints": []}"#, "no points"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": []}"#, "no points"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": [0,0,-0.3,0]}"#, "midpoint"),
            (r#"{"RGBPoints": [0,0,0,0], "Points": [0,0,0.5,1.5]}"#, "sharpness"),
            (r#"{"RGBPoints": [0,0,0,0], "ColorSpace": "CMYK"}"#, "CMYK"),
            (r#"{"RGBPoints": [0,0,0,0, 1,0,0,7], "ColorSpace": "Lab"}"#, "from 0 to 1"),
            (r#"{"RGBPoints": [5,0,0,0, 1,0,0,1], "ColorSpace": "Lab"}"#, "sorted"),
            (r#"{"RGBPoints": [5,0,0,0, 1,0,0,1], "ColorSpace": "Step"}"#, "sorted"),
            (r#"{"RGBPoints": [5,0,0,0, 1,0,0,0]}"#, "sorted"),
            (r#"{"RGBPoints": [0,0,0,2]}"#, "from 0 to 1"),
        ] {
            let message = parse(text, "f.json", None).unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("f.json"), "{text}: {message}");
        }
    }
}
