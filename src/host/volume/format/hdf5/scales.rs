//! Axes of datasets: the tags of ilastik and vigra, labels and scales of dimensions, and sizes of voxels in microscopy.

use super::attributes::texts;
use super::numbers::Value;
use crate::volume::format::axes::{Axis, Roles};
use crate::volume::format::conventions::Attributes;
use hdf5_reader::reference::resolve_object_reference;
use hdf5_reader::{Dataset, Hdf5File};
use serde_json::Value as Json;
use std::path::Path;

/// Attribute with the distances between voxels along z, y, x in micrometres.
const SPACING: &str = "element_size_um";
/// Limit of the positions along a scale.
const MOST: u64 = 1 << 20;
/// Begins the name of scales of NetCDF dimensions that have no coordinates.
const WITHOUT_COORDINATES: &str = "This is a netCDF dimension but not a netCDF variable";

/// The axes of a dataset, as far as it declares them. Its scales are looked up in `file`, if it is in there.
pub(super) fn axes(path: &Path, file: Option<&Hdf5File>, dataset: &Dataset) -> Vec<Axis> {
    let count = dataset.ndim();
    let mut axes = match dataset.text("axistags") {
        Some(tags) => tagged(path, &tags, count),
        None => labelled(file, dataset),
    };
    let sizes = dataset.numbers(SPACING).map(|(sizes, _)| sizes).unwrap_or_default();
    if let Ok::<[f64; 3], _>(sizes) = sizes.try_into()
        && sizes.iter().all(|size| size.is_finite() && *size > 0.0)
    {
        axes.resize(count, Axis::default());
        let [z, y, x] = sizes;
        for (axis, step) in Roles::new(&axes, count).space.into_iter().zip([x, y, z]) {
            if let Some(axis) = axis {
                axes[axis] = Axis { first: 0.0, step, has_step: true, unit: "um".into(), ..axes[axis].clone() };
            }
        }
    }
    axes
}

/// Axes by vigra's tags in JSON: their keys, and flags of their roles.
fn tagged(path: &Path, tags: &str, count: usize) -> Vec<Axis> {
    let axis = |tag: &Json| {
        let kind = match tag["typeFlags"].as_u64() {
            Some(1) => "channel",
            Some(2) => "space",
            Some(8) => "time",
            _ => "",
        };
        let axis = Axis { kind: kind.into(), ..Axis::named(tag["key"].as_str().unwrap_or_default()) };
        match tag["resolution"].as_f64().filter(|step| *step > 0.0 && step.is_finite()) {
            Some(step) => Axis { step, has_step: true, ..axis },
            None => axis,
        }
    };
    let tags: Option<Json> = serde_json::from_str(tags).ok();
    let axes = tags.and_then(|tags| tags["axes"].as_array().map(|tags| tags.iter().map(axis).collect::<Vec<_>>()));
    axes.filter(|axes| axes.len() == count).unwrap_or_else(|| {
        tracing::warn!("{}: its axistags do not name its {count} axes: the last ones are taken as z, y and x", path.display());
        Vec::new()
    })
}

/// Axes by the labels of dimensions, else by the names of their scales, at the coordinates of these.
fn labelled(file: Option<&Hdf5File>, dataset: &Dataset) -> Vec<Axis> {
    let names = ["DIMENSION_LABELS", "_ARRAY_DIMENSIONS"].map(|attribute| texts(dataset, attribute));
    let names = names.into_iter().find(|names| !names.is_empty()).unwrap_or_default();
    let scales = file.map_or(Vec::new(), |file| scales(file, dataset));
    (0..dataset.ndim())
        .map(|n| {
            let scale = scales.get(n).and_then(Option::as_ref);
            let label = names.get(n).filter(|name| !name.is_empty()).cloned();
            let Some((scale, scale_name)) = scale else { return Axis::named(label.unwrap_or_default()) };
            let own = scale.text("NAME").filter(|name| !name.is_empty());
            let has_coordinates = !own.as_ref().is_some_and(|name| name.starts_with(WITHOUT_COORDINATES));
            let own = own.filter(|_| has_coordinates).unwrap_or_else(|| scale_name.clone());
            let axis = Axis::named(label.unwrap_or(own));
            let axis = axis.with_role(scale.text("axis").as_deref());
            match coordinates(scale).filter(|_| has_coordinates) {
                Some(coordinates) => axis.at(&coordinates, scale.text("units").unwrap_or_default()),
                None => axis,
            }
        })
        .collect()
}

/// The values of a scale.
fn coordinates(scale: &Dataset) -> Option<Vec<f64>> {
    let [1..=MOST] = scale.shape() else { return None };
    let first = |name: &str| scale.numbers(name).and_then(|(numbers, _)| numbers.first().copied());
    let (slope, intercept) = (first("scale_factor").unwrap_or(1.0), first("add_offset").unwrap_or(0.0));
    let found = scale.read_array::<Value>().ok()?;
    Some(found.iter().map(|Value(number)| slope * number + intercept).collect())
}

/// The first scale of each dimension, and its name.
fn scales(file: &Hdf5File, dataset: &Dataset) -> Vec<Option<(Dataset, String)>> {
    let Ok(list) = dataset.attribute("DIMENSION_LIST") else { return Vec::new() };
    let offset_size = file.superblock().offset_size;
    let address = |reference: &[u8]| {
        let bytes = dataset.resolve_vlen_reference_bytes(reference, usize::from(offset_size)).ok()?;
        resolve_object_reference(&bytes, offset_size).ok()
    };
    let addresses: Vec<Option<u64>> = list.raw_data.chunks_exact(dataset.vlen_reference_size().max(1)).map(address).collect();
    let mut found: Vec<Option<(Dataset, String)>> = vec![None; addresses.len()];
    let _ = super::find::each_dataset(file, &mut |name, scale: Dataset| {
        for (address, found) in addresses.iter().zip(&mut found) {
            if *address == Some(scale.address()) && found.is_none() {
                *found = Some((scale.clone(), super::find::last(name).to_owned()));
            }
        }
    });
    found
}
