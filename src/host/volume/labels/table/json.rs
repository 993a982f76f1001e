//! Tables in JSON: a list of labels, and OME-Zarr's `image-label` (<https://ngff.openmicroscopy.org/0.5/#labels-md>).

use super::wrong;
use crate::error::Error;
use crate::volume::colors;
use crate::volume::labels::{Label, LabelTable};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Keys of a property that may name a label, best first. The format leaves the keys open.
const NAMES: [&str; 4] = ["name", "label", "label-name", "class"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Listed {
    labels: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    id: u32,
    name: Option<String>,
    #[serde(default, deserialize_with = "color")]
    color: Option<[f64; 3]>,
    #[serde(default, deserialize_with = "opacity")]
    opacity: Option<f64>,
    visible: Option<bool>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Color {
    Hex(String),
    Numbers([f64; 3]),
}

fn color<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 3]>, D::Error> {
    let expected = || D::Error::custom("expected a color as \"#rrggbb\" or three numbers from 0 to 1");
    let color = match Color::deserialize(deserializer).map_err(|_| expected())? {
        Color::Hex(text) => colors::from_hex(&text),
        Color::Numbers(numbers) => Some(numbers),
    };
    color.filter(|color| color.iter().all(|c| (0.0..=1.0).contains(c))).map(Some).ok_or_else(expected)
}

fn opacity<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let opacity = f64::deserialize(deserializer)?;
    let is_valid = (0.0..=1.0).contains(&opacity);
    if is_valid { Ok(Some(opacity)) } else { Err(D::Error::custom("expected an opacity from 0 to 1")) }
}

/// Reads a table in JSON.
pub(super) fn read(path: &Path, text: &str) -> Result<LabelTable, Error> {
    let in_line = |e: serde_json::Error| wrong(path, e.line() as u64, format!("{e}: correct the JSON"));
    let value: Value = serde_json::from_str(text).map_err(in_line)?;
    let image_label_in = if value["image-label"].is_object() { &value["image-label"] } else { &value };
    if image_label_in["colors"].is_array() || image_label_in["properties"].is_array() {
        return image_label(image_label_in).map_err(|problem| Error::volume(path, problem));
    }
    let listed: Listed = serde_json::from_str(text).map_err(in_line)?;
    let label = |entry: Entry| {
        let Label { color, opacity, visible, .. } = Label::new(entry.id);
        Label {
            id: entry.id,
            name: entry.name,
            color: entry.color.unwrap_or(color),
            opacity: entry.opacity.unwrap_or(opacity),
            visible: entry.visible.unwrap_or(visible),
        }
    };
    let labels = listed.labels.into_iter().filter(|entry| entry.id > 0).map(label);
    LabelTable::new(labels).map_err(|e| Error::volume(path, e.to_string()))
}

/// The labels of OME-Zarr's metadata `image-label`.
pub(in crate::volume) fn image_label(metadata: &Value) -> Result<LabelTable, String> {
    let list = |key: &str| match &metadata[key] {
        Value::Null => Ok(&[][..]),
        Value::Array(entries) => Ok(&entries[..]),
        other => Err(format!("its image-label has {key} of {other}: expected a list")),
    };
    let id = |entry: &Value| {
        let id = entry["label-value"].as_u64().and_then(|id| u32::try_from(id).ok());
        id.ok_or_else(|| format!("its image-label has {entry}: expected a label-value from 0 to 4294967295"))
    };
    let mut labels: BTreeMap<u32, Label> = BTreeMap::new();
    for entry in list("colors")? {
        let id = id(entry)?;
        if labels.contains_key(&id) {
            return Err(format!("its image-label has two colors for the label {id}: expected one"));
        }
        let label = labels.entry(id).or_insert_with(|| Label::new(id));
        if !entry["rgba"].is_null() {
            let byte = |n: &Value| n.as_u64().filter(|&n| n <= 255).map(|n| n as f64 / 255.0);
            let shares: Option<Vec<f64>> = entry["rgba"].as_array().and_then(|numbers| numbers.iter().map(byte).collect());
            let Some(&[r, g, b, opacity]) = shares.as_deref() else {
                return Err(format!("its image-label has {entry}: expected an rgba of four whole numbers from 0 to 255"));
            };
            (label.color, label.opacity) = ([r, g, b], opacity);
        }
    }
    for entry in list("properties")? {
        let id = id(entry)?;
        let label = labels.entry(id).or_insert_with(|| Label::new(id));
        let name = NAMES.iter().find_map(|key| entry[*key].as_str()).map(str::trim).filter(|name| !name.is_empty());
        label.name = name.map(Into::into).or(label.name.take());
    }
    labels.remove(&0);
    LabelTable::new(labels.into_values()).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn lists_have_defaults() {
        let text = r##"{"labels": [{"id": 0, "name": "none"}, {"id": 9, "name": "b", "color": [0, 0.5, 1], "visible": false},
                        {"id": 3, "color": "#ff0000", "opacity": 0.25}]}"##;
        let table = read(Path::new("t.json"), text).unwrap();
        assert_eq!(table.labels().len(), 2);
        assert_eq!(table.get(3), Some(&Label { color: [1.0, 0.0, 0.0], opacity: 0.25, ..Label::new(3) }));
        assert_eq!(
            table.get(9),
            Some(&Label { name: Some("b".into()), color: [0.0, 0.5, 1.0], visible: false, ..Label::new(9) })
        );
    }

    #[test]
    fn wrong_json_is_named_with_its_line() {
        for (text, expected) in [
            ("{\"labels\": [\n{\"id\": 3,}]}", "t.json, line 2:"),
            ("{\"labels\": [\n{\"id\": 3,\n\"colour\": \"#ff0000\"}]}", "line 3: unknown field `colour`"),
            ("{\"labels\": [\n{\"id\": 3, \"color\": \"red\"}]}", "line 2: expected a color as"),
            ("{\"labels\": [\n{\"id\": 3, \"color\": [0, 2, 0]}]}", "line 2: expected a color as"),
            ("{\"labels\": [\n{\"id\": 3, \"opacity\": 2}]}", "line 2: expected an opacity from 0 to 1"),
            ("{\"labels\": [{\"id\": -3}]}", "line 1: invalid value"),
            ("{\"labels\": [{\"id\": 3}, {\"id\": 3}]}", "t.json: labels: two labels have the id 3"),
            ("[1]", "line 1"),
        ] {
            let message = read(Path::new("t.json"), text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn image_labels_have_colours_and_properties() {
        let metadata = json!({"version": "0.4", "colors": [{"label-value": 1, "rgba": [255, 0, 51, 102]}, {"label-value": 4},
            {"label-value": 0, "rgba": [0, 0, 0, 0]}], "properties": [{"label-value": 7, "class": "cell"}, {"label-value": 1, "area": 5}]});
        let table = image_label(&metadata).unwrap();
        let expected = [
            Label { color: [1.0, 0.0, 0.2], opacity: 0.4, ..Label::new(1) },
            Label::new(4),
            Label { name: Some("cell".into()), ..Label::new(7) },
        ];
        assert_eq!(table.labels(), expected);
        for (bad, expected) in [
            (json!({"colors": 5}), "colors of 5: expected a list"),
            (json!({"colors": [{"rgba": [0, 0, 0, 0]}]}), "expected a label-value"),
            (json!({"colors": [{"label-value": 1, "rgba": [0, 0, 0]}]}), "expected an rgba of four"),
            (json!({"colors": [{"label-value": 1, "rgba": [0, 0, 0, 256]}]}), "expected an rgba of four"),
            (json!({"colors": [{"label-value": 1}, {"label-value": 1}]}), "two colors for the label 1"),
            (json!({"properties": [{"label-value": -1}]}), "expected a label-value"),
        ] {
            let message = image_label(&bad).unwrap_err();
            assert!(message.contains(expected), "{bad}: {message}");
        }
    }
}
