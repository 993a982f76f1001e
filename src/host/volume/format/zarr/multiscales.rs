//! OME-Zarr multiscales metadata: an image at several resolutions (<https://ngff.openmicroscopy.org>).

use serde_json::Value;

/// Limit of resolutions.
const MOST_LEVELS: usize = 64;

/// An image at several resolutions, finest first.
pub(super) struct Multiscales {
    pub axes: Vec<Axis>,
    pub levels: Vec<Level>,
}

/// An axis shared by all levels.
#[derive(Clone, Default)]
pub(super) struct Axis {
    pub name: String,
    /// `space`, `time` or `channel`, or empty if not specified.
    pub kind: String,
    /// Unit, or empty if not specified.
    pub unit: String,
}

/// An array: its path in the group, and its scale and translation per axis.
pub(super) struct Level {
    pub path: String,
    pub scale: Vec<f64>,
    pub translation: Vec<f64>,
}

impl Multiscales {
    /// `None` if the attributes have no multiscales metadata.
    pub fn new(attributes: &Value) -> Result<Option<Self>, String> {
        let all = if attributes["ome"]["multiscales"].is_array() { &attributes["ome"] } else { attributes };
        let Some(metadata) = all["multiscales"].as_array().and_then(|several| several.first()) else { return Ok(None) };
        let axes: Vec<Axis> = metadata["axes"].as_array().map(|axes| axes.iter().map(axis).collect()).unwrap_or_default();
        let datasets = metadata["datasets"].as_array().filter(|levels| (1..=MOST_LEVELS).contains(&levels.len()));
        let datasets = datasets.ok_or("its multiscales metadata name no arrays, or too many")?;
        let levels: Result<Vec<Level>, String> = datasets.iter().map(|level| Level::new(level, metadata, axes.len())).collect();
        Ok(Some(Self { axes, levels: levels? }))
    }
}

/// Parses an axis: an object from version 0.4 on, a name before.
fn axis(metadata: &Value) -> Axis {
    let text = |metadata: &Value| metadata.as_str().unwrap_or_default().to_owned();
    if metadata.is_string() {
        Axis { name: text(metadata), ..Axis::default() }
    } else {
        Axis { name: text(&metadata["name"]), kind: text(&metadata["type"]), unit: text(&metadata["unit"]) }
    }
}

impl Level {
    /// The transformations of the level come first, then those of all levels.
    fn new(metadata: &Value, all: &Value, axes: usize) -> Result<Self, String> {
        let path = metadata["path"].as_str().ok_or("its multiscales metadata have an array without a path")?.to_owned();
        let (mut scale, mut translation) = (vec![1.0; axes], vec![0.0; axes]);
        let steps = [metadata, all].map(|source| source["coordinateTransformations"].as_array().cloned().unwrap_or_default());
        for step in steps.iter().flatten() {
            match step["type"].as_str() {
                Some("identity") => {}
                Some("scale") => {
                    for (i, by) in numbers(&step["scale"], axes)?.into_iter().enumerate() {
                        scale[i] *= by;
                        translation[i] *= by;
                    }
                }
                Some("translation") => {
                    let by = numbers(&step["translation"], axes)?;
                    translation.iter_mut().zip(by).for_each(|(to, by)| *to += by);
                }
                _ => return Err(format!("its coordinateTransformations have {step}: expected scale and translation")),
            }
        }
        Ok(Self { path, scale, translation })
    }
}

fn numbers(metadata: &Value, count: usize) -> Result<Vec<f64>, String> {
    let found: Option<Vec<f64>> = metadata.as_array().and_then(|numbers| numbers.iter().map(Value::as_f64).collect());
    found
        .filter(|numbers| numbers.len() == count)
        .ok_or_else(|| format!("its coordinateTransformations have {metadata} for {count} axes"))
}
