//! Segments of 3D Slicer's `.seg.nrrd` (<https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html>).

use super::fields::Fields;
use crate::error::Error;
use crate::volume::{Label, LabelTable};

/// Limit of segments, and of layers.
const MOST: usize = 1 << 16;

/// Whether the voxels are ids of segments.
pub(super) fn are_declared(fields: &Fields) -> bool {
    fields.keys().any(|key| number_of(key).is_some())
}

/// The number of a key `SegmentN_…`.
fn number_of(key: &str) -> Option<usize> {
    let (number, _) = key.strip_prefix("Segment")?.split_once('_')?;
    number.parse().ok()
}

/// The labels of each layer.
pub(super) fn layers(fields: &Fields, count: usize) -> Result<Vec<LabelTable>, Error> {
    let mut numbers: Vec<usize> = fields.keys().filter_map(number_of).collect();
    numbers.sort_unstable();
    numbers.dedup();
    if numbers.len() > MOST {
        return Err(fields.wrong(format!("it has more than {MOST} segments: merge some")));
    }
    if count > MOST {
        return Err(fields.wrong(format!("it has {count} layers of segments: expected at most {MOST}")));
    }
    let mut layers = vec![Vec::new(); count];
    for &n in &numbers {
        let (layer, label) = segment(fields, n, count)?;
        layers[layer].push(label);
    }
    let table = |(layer, labels): (usize, Vec<Label>)| {
        LabelTable::new(labels).map_err(|e| fields.wrong(format!("its segments of layer {layer} cannot be told apart: {e}")))
    };
    layers.into_iter().enumerate().map(table).collect()
}

/// Layer and label of segment `n`.
fn segment(fields: &Fields, n: usize, layers: usize) -> Result<(usize, Label), Error> {
    let key = |what: &str| format!("Segment{n}_{what}");
    let value = |what: &str| fields.value(&key(what)).map(str::trim);
    let wrong = |what: &str, expected: &str| {
        fields.wrong(format!("its {} is '{}': expected {expected}", key(what), value(what).unwrap_or_default()))
    };
    // Files of older versions have neither: each segment has a layer, in which its voxels are 1.
    let (id, layer) = match (value("LabelValue"), value("Layer")) {
        (None, None) => (1, n),
        (id, layer) => {
            let id = id.map_or(Some(1), |id| id.parse().ok().filter(|&id: &u32| id > 0));
            let layer = layer.map_or(Some(0), |layer| layer.parse().ok());
            (
                id.ok_or_else(|| wrong("LabelValue", "a whole number from 1 to 4294967295"))?,
                layer.ok_or_else(|| wrong("Layer", "a whole number from 0"))?,
            )
        }
    };
    if layer >= layers {
        return Err(fields.wrong(format!("its segment {n} is in layer {layer}, but its sizes have layers 0 to {}", layers - 1)));
    }
    let mut label = Label { name: value("Name").filter(|name| !name.is_empty()).map(Into::into), ..Label::new(id) };
    if let Some(text) = value("Color") {
        let color: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let color: Option<[f64; 3]> = color.and_then(|color| color.try_into().ok());
        let valid = color.filter(|color| color.iter().all(|c| (0.0..=1.0).contains(c)));
        label.color = valid.ok_or_else(|| wrong("Color", "three numbers from 0 to 1"))?;
    }
    Ok((layer, label))
}
