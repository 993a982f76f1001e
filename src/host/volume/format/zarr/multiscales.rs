//! OME-Zarr multiscales metadata: an image at several resolutions (<https://ngff.openmicroscopy.org>).

use crate::volume::format::axes::Axis;
use serde_json::Value;

/// Limit of resolutions.
const MOST_LEVELS: usize = 64;

/// An image at several resolutions, finest first.
pub(super) struct Multiscales {
    pub levels: Vec<Level>,
    /// Whether the coarser levels were moved, because the metadata move none.
    pub moved: bool,
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
        let mut levels = levels?;
        let moves = |level: &Value| {
            let steps = level["coordinateTransformations"].as_array();
            steps.is_some_and(|steps| steps.iter().any(|step| step["type"] == "translation"))
        };
        let moved = !datasets.iter().any(moves) && covered(&mut levels);
        Ok(Some(Self { levels, moved }))
    }
}

/// Moves the first voxels of coarser levels, so that all levels begin at the same face: a voxel covers several of the finest level. Returns
/// whether there were such.
fn covered(levels: &mut [Level]) -> bool {
    let Some((finest, coarser)) = levels.split_first_mut() else { return false };
    let mut moved = false;
    for (axis, fine) in coarser.iter_mut().flat_map(|level| level.axes.iter_mut().zip(&finest.axes)) {
        // Frames and channels are points, not boxes.
        let is_point = matches!(axis.kind.as_str(), "time" | "channel") || matches!(axis.name.as_str(), "t" | "c");
        let times = axis.step / fine.step;
        if !is_point && times.is_finite() && times > 1.0 {
            axis.first += (axis.step - fine.step) / 2.0;
            moved = true;
        }
    }
    moved
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn levels_without_translations_begin_at_the_same_face() {
        let firsts = |more: Value| {
            let scale = |by: [f64; 3]| json!({"type": "scale", "scale": by});
            let level = |path: &str, by, more: &Value| json!({"path": path, "coordinateTransformations": std::iter::once(scale(by)).chain(more.as_array().cloned().unwrap_or_default()).collect::<Vec<_>>()});
            let metadata = json!({"multiscales": [{
                "axes": [{"name": "t", "type": "time"}, {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
                "datasets": [level("0", [1.0, 2.0, 1.0], &json!([])), level("1", [2.0, 2.0, 4.0], &more)],
                "coordinateTransformations": [scale([1.0, 1.0, 10.0])],
            }]});
            let image = Multiscales::new(&metadata).unwrap().unwrap();
            (
                image.moved,
                image.levels.iter().map(|level| level.axes.iter().map(|axis| axis.first).collect()).collect::<Vec<Vec<f64>>>(),
            )
        };
        assert_eq!(firsts(json!([])), (true, vec![vec![0.0; 3], vec![0.0, 0.0, 15.0]]));
        let stated = json!([{"type": "translation", "translation": [0.0, 0.0, 0.0]}]);
        assert_eq!(firsts(stated), (false, vec![vec![0.0; 3]; 2]));
    }
}
