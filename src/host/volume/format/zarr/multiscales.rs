//! OME-Zarr multiscales metadata: an image at several resolutions (<https://ngff.openmicroscopy.org>).

use crate::volume::format::axes::Axis;
use serde_json::Value;

/// Limit of resolutions.
const MOST_LEVELS: usize = 64;

/// An image at several resolutions, finest first.
pub(super) struct Multiscales {
    pub levels: Vec<Level>,
}

/// An array: its path in the group, and its axes.
pub(super) struct Level {
    pub path: String,
    pub axes: Vec<Axis>,
}

/// The axes of the versions that do not name them, 0.1 and 0.2.
const FIRST_AXES: [&str; 5] = ["t", "c", "z", "y", "x"];

impl Multiscales {
    /// `None` if the attributes have no multiscales metadata.
    pub fn new(attributes: &Value) -> Result<Option<Self>, String> {
        let all = if attributes["ome"]["multiscales"].is_array() { &attributes["ome"] } else { attributes };
        let Some(metadata) = all["multiscales"].as_array().and_then(|several| several.first()) else { return Ok(None) };
        let axes: Vec<Axis> = match metadata["axes"].as_array() {
            Some(axes) => axes.iter().map(axis).collect(),
            None => FIRST_AXES.map(Axis::named).into(),
        };
        let datasets = metadata["datasets"].as_array().filter(|levels| (1..=MOST_LEVELS).contains(&levels.len()));
        let datasets = datasets.ok_or("its multiscales metadata name no arrays, or too many")?;
        let levels: Result<Vec<Level>, String> = datasets.iter().map(|level| Level::new(level, metadata, &axes)).collect();
        Ok(Some(Self { levels: levels? }))
    }
}

/// Parses an axis: an object from version 0.4 on, a name before.
fn axis(metadata: &Value) -> Axis {
    let text = |metadata: &Value| metadata.as_str().unwrap_or_default().to_owned();
    if metadata.is_string() {
        Axis::named(text(metadata))
    } else {
        Axis { kind: text(&metadata["type"]), unit: text(&metadata["unit"]), ..Axis::named(text(&metadata["name"])) }
    }
}

impl Level {
    /// The transformations of the level come first, then those of all levels.
    fn new(metadata: &Value, all: &Value, axes: &[Axis]) -> Result<Self, String> {
        let path = metadata["path"].as_str().ok_or("its multiscales metadata have an array without a path")?.to_owned();
        let mut axes = axes.to_vec();
        let steps = [metadata, all].map(|source| source["coordinateTransformations"].as_array().cloned().unwrap_or_default());
        for step in steps.iter().flatten() {
            match step["type"].as_str() {
                Some("identity") => {}
                Some("scale") => {
                    let factors = numbers(&step["scale"], axes.len())?;
                    for (axis, by) in axes.iter_mut().zip(factors) {
                        *axis = Axis { step: axis.step * by, first: axis.first * by, has_step: true, ..axis.clone() };
                    }
                }
                Some("translation") => {
                    let by = numbers(&step["translation"], axes.len())?;
                    axes.iter_mut().zip(by).for_each(|(axis, by)| axis.first += by);
                }
                _ => return Err(format!("its coordinateTransformations have {step}: expected scale and translation")),
            }
        }
        Ok(Self { path, axes })
    }
}

fn numbers(metadata: &Value, count: usize) -> Result<Vec<f64>, String> {
    let found: Option<Vec<f64>> = metadata.as_array().and_then(|numbers| numbers.iter().map(Value::as_f64).collect());
    found
        .filter(|numbers| numbers.len() == count)
        .ok_or_else(|| format!("its coordinateTransformations have {metadata} for {count} axes"))
}
