//! 3D Slicer volume properties as JSON (`.vp.json`).

use super::curve::{Mix, Node, pieces};
use super::{MAX_POINTS, bad};
use crate::error::Error;
use crate::transfer::TransferFunction;
use serde::{Deserialize, Serialize};

const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/main/Modules/Loadable/VolumeRendering/Resources/Schema/volume-property-schema-v1.0.0.json#";

#[derive(Deserialize, Serialize)]
struct File {
    #[serde(rename = "@schema", default)]
    schema: String,
    #[serde(rename = "volumeProperties")]
    properties: Vec<Property>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
struct Property {
    #[serde(default)]
    effective_range: Option<[f64; 2]>,
    #[serde(default)]
    independent_components: Option<bool>,
    #[serde(default)]
    interpolation_type: Option<String>,
    components: Vec<Component>,
}

#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
struct Component {
    #[serde(default)]
    component_weight: Option<f64>,
    #[serde(default)]
    shade: Option<bool>,
    #[serde(default)]
    lighting: Option<Lighting>,
    #[serde(default)]
    disable_gradient_opacity: Option<bool>,
    /// World distance to which the opacities apply.
    #[serde(default)]
    scalar_opacity_unit_distance: Option<f64>,
    rgb_transfer_function: Function<Color>,
    scalar_opacity: Function<Opacity>,
    #[serde(default)]
    gradient_opacity: Option<Function<Opacity>>,
}

/// VTK's default lighting.
#[derive(Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
struct Lighting {
    diffuse: f64,
    ambient: f64,
    specular: f64,
    specular_power: f64,
}

impl Default for Lighting {
    fn default() -> Self {
        Self { diffuse: 0.7, ambient: 0.1, specular: 0.2, specular_power: 10.0 }
    }
}

#[derive(Deserialize, Serialize)]
struct Function<P> {
    #[serde(rename = "type", default)]
    kind: String,
    points: Vec<P>,
}

#[derive(Deserialize, Serialize)]
struct Color {
    x: f64,
    color: [f64; 3],
    #[serde(default = "half")]
    midpoint: f64,
    #[serde(default)]
    sharpness: f64,
}

#[derive(Deserialize, Serialize)]
struct Opacity {
    x: f64,
    y: f64,
    #[serde(default = "half")]
    midpoint: f64,
    #[serde(default)]
    sharpness: f64,
}

fn half() -> f64 {
    0.5
}

pub(super) fn parse(text: &str, file: &str) -> Result<TransferFunction, Error> {
    let parsed: File = serde_json::from_str(text).map_err(|e| match e.is_data() {
        true => bad(file, format!("is not a valid 3D Slicer volume property: {e}")),
        false => bad(file, format!("is not JSON: {e}")),
    })?;
    let Some(component) = parsed.properties.first().and_then(|property| property.components.first()) else {
        return Err(bad(file, "holds no volume property with a component"));
    };
    if parsed.properties.len() > 1 || parsed.properties[0].components.len() > 1 {
        tracing::warn!("{file} holds several volume properties or components: using the first");
    }
    if let Some(distance) = component.scalar_opacity_unit_distance.filter(|&distance| distance != 1.0) {
        tracing::warn!("{file}: its opacities apply to a distance of {distance}: set the unit distance to {distance}");
    }
    if let Some(function) = component.gradient_opacity.as_ref().filter(|_| component.disable_gradient_opacity != Some(true)) {
        warn_of_gradients(file, function.points.iter().map(|point| point.y));
    }
    let colors = component.rgb_transfer_function.points.iter();
    let colors = colors.map(|p| Node { value: p.x, y: p.color, midpoint: p.midpoint, sharpness: p.sharpness }).collect();
    let opacities = component.scalar_opacity.points.iter();
    let opacities = opacities.map(|p| Node { value: p.x, y: [p.y], midpoint: p.midpoint, sharpness: p.sharpness }).collect();
    let opacities = drawn(opacities, "opacity by value", file)?.into_iter().map(|(value, [a])| (value, a)).collect();
    TransferFunction::new(file, drawn(colors, "colour by value", file)?, opacities)
}

/// Control points of nodes; Slicer accepts nodes in any order.
fn drawn<const N: usize>(mut nodes: Vec<Node<N>>, what: &str, file: &str) -> Result<Vec<(f64, [f64; N])>, Error> {
    if nodes.len() > MAX_POINTS {
        return Err(bad(file, format!("its {what} has more than {MAX_POINTS} points: use fewer")));
    }
    nodes.sort_by(|a, b| a.value.total_cmp(&b.value));
    pieces(&nodes, &Mix::Straight).map_err(|problem| bad(file, format!("its {what}: {problem}")))
}

/// Warns that gradient opacity is ignored, if it would change the picture.
pub(super) fn warn_of_gradients(file: &str, mut opacities: impl Iterator<Item = f64>) {
    if opacities.any(|opacity| opacity != 1.0) {
        tracing::warn!("{file}: gradient opacity is ignored");
    }
}

pub(super) fn written(transfer: &TransferFunction) -> String {
    let color = |&(x, color): &(f64, [f64; 3])| Color { x, color, midpoint: 0.5, sharpness: 0.0 };
    let opacity = |&(x, y): &(f64, f64)| Opacity { x, y, midpoint: 0.5, sharpness: 0.0 };
    let function = |points: Vec<Opacity>| Function { kind: "piecewiseLinearFunction".into(), points };
    let component = Component {
        component_weight: Some(1.0),
        shade: Some(true),
        lighting: Some(Lighting::default()),
        disable_gradient_opacity: Some(true),
        scalar_opacity_unit_distance: Some(1.0),
        rgb_transfer_function: Function {
            kind: "colorTransferFunction".into(),
            points: transfer.colors().iter().map(color).collect(),
        },
        scalar_opacity: function(transfer.opacities().iter().map(opacity).collect()),
        gradient_opacity: Some(function(vec![opacity(&(0.0, 1.0)), opacity(&(255.0, 1.0))])),
    };
    let (lo, hi) = transfer.range();
    let property = Property {
        effective_range: Some([lo, hi]),
        independent_components: Some(true),
        interpolation_type: Some("linear".into()),
        components: vec![component],
    };
    let file = File { schema: SCHEMA.into(), properties: vec![property] };
    serde_json::to_string_pretty(&file).expect("finite numbers") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"{"@schema": "…", "volumeProperties": [{"components": [{
        "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
            {"x": 100, "color": [1, 0.5, 0]}, {"x": -100, "color": [0, 0, 0], "midpoint": 0.25, "sharpness": 0}]},
        "scalarOpacity": {"points": [{"x": 0, "y": 0, "midpoint": 0.5, "sharpness": 1}, {"x": 10, "y": 0.5}]}}]}]}"#;

    #[test]
    fn points_in_any_order_with_their_curves() {
        let t = parse(SMALL, "f").unwrap();
        assert_eq!((t.color(-50.0), t.color(100.0)), ([0.5, 0.25, 0.0], [1.0, 0.5, 0.0]));
        // Nearly a step.
        assert!(t.opacity(4.0) < 0.01 && (t.opacity(5.0) - 0.25).abs() < 1e-12 && t.opacity(6.0) > 0.49);
    }

    #[test]
    fn bad_ones_say_what_is_wrong() {
        for (from, to, word) in [
            ("\"components\"", "\"parts\"", "components"),
            (r#""x": 10, "y": 0.5"#, r#""x": 10"#, "missing field `y`"),
            (r#""y": 0.5"#, r#""y": "high""#, "invalid type"),
            (r#""y": 0.5"#, r#""y": 1.5"#, "from 0 to 1"),
            ("0.25", "1.25", "midpoint 1.25"),
            ("[1, 0.5, 0]", "[1, 0.5]", "length"),
            ("}}]}]}", "}}]}]", "not JSON"),
            (
                r#"{"points": [{"x": 0, "y": 0, "midpoint": 0.5, "sharpness": 1}, {"x": 10, "y": 0.5}]}"#,
                r#"{"points": []}"#,
                "no points",
            ),
        ] {
            let text = SMALL.replace(from, to);
            assert_ne!(text, SMALL);
            let message = parse(&text, "f.vp.json").unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("f.vp.json"), "{text}: {message}");
        }
        for empty in [r#"{"volumeProperties": []}"#, r#"{"volumeProperties": [{"components": []}]}"#] {
            assert!(parse(empty, "f").unwrap_err().to_string().contains("no volume property"));
        }
    }
}
