//! Volumes: fields with transfer functions.

use crate::colors;
use crate::field::{Field, FieldKey};
use crate::handle::Handle;
use crate::objects::{Object, Objects};
use crate::status::Problem;
use anari_sys::*;
use layersplat::TransferFunction;
use layersplat::glam::DAffine3;

/// A volume to draw.
pub struct DrawnVolume {
    pub field: Field,
    pub transfer: TransferFunction,
    /// World distance to which opacities apply.
    pub unit_distance: f64,
    /// Transform from the object to the world.
    pub placement: DAffine3,
    /// Its id in the channel objectId.
    pub id: u32,
}

/// Voxels and where they are. Volumes of one place share them on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub field: FieldKey,
    placement: DAffine3,
}

impl DrawnVolume {
    /// What its voxels on the device depend on.
    pub fn place(&self) -> Place {
        Place { field: self.field.key, placement: self.placement }
    }

    /// Whether its instance shears it.
    pub fn is_sheared(&self) -> bool {
        self.field.is_sheared(self.placement)
    }

    /// The volume of an object.
    ///
    /// # Errors
    /// If it has no field or no transfer function, or the transform of its instance is singular.
    pub fn from_object(objects: &Objects, handle: Handle, placement: DAffine3, index: u32) -> Result<Self, Problem> {
        let volume = objects.known(handle)?;
        let field = volume.object(c"value").ok_or_else(|| Problem::argument("the volume has no field: commit one as value"))?;
        let id = volume.bytes_of(c"id", ANARI_UINT32).and_then(|bytes| bytes.try_into().ok()).map(u32::from_ne_bytes);
        let field = Field::from_object(objects, field)?;
        field.grid(placement).map_err(|error| Problem::argument(format!("the volume is not drawn: {error}")))?;
        Ok(Self {
            field,
            transfer: transfer(objects, volume)?,
            unit_distance: volume.float(c"unitDistance").unwrap_or(1.0).into(),
            placement,
            id: id.filter(|&id| id != u32::MAX).unwrap_or(index),
        })
    }
}

/// The range of values of a volume.
fn value_range(volume: &Object) -> [f64; 2] {
    match volume.bytes_of(c"valueRange", ANARI_FLOAT64_BOX1) {
        Some(bytes) => {
            let ends = bytes.as_chunks::<8>().0;
            [0, 1].map(|end| f64::from_ne_bytes(ends[end]))
        }
        None => volume.floats(c"valueRange").unwrap_or([0.0, 1.0]).map(f64::from),
    }
}

/// The elements of an array that its region selects.
fn region<T: Copy>(array: &Object, elements: &[T]) -> Vec<T> {
    let Some(bytes) = array.bytes_of(c"region", ANARI_UINT64_REGION1) else { return elements.to_vec() };
    let ends = bytes.as_chunks::<8>().0;
    let [lower, upper] = [0, 1].map(|end| u64::from_ne_bytes(ends[end]));
    let upper = upper.max(lower.saturating_add(1)).min(elements.len() as u64).max(1) as usize;
    let lower = (lower as usize).min(upper - 1);
    elements[lower..upper].to_vec()
}

/// The handles of an array of objects, in its region.
pub fn handles(objects: &Objects, array: Handle) -> Vec<Handle> {
    let Some(object) = objects.get(array) else { return Vec::new() };
    let Some(array) = object.array().filter(|array| !array.elements.is_empty()) else { return Vec::new() };
    region(object, &array.elements)
}

/// The transfer function of a volume.
fn transfer(objects: &Objects, volume: &Object) -> Result<TransferFunction, Problem> {
    let [lowest, highest] = value_range(volume);
    if lowest > highest {
        return Err(Problem::argument(format!("valueRange is {lowest} to {highest}: the first must not be above the second")));
    }
    let array = |name| volume.object(name).and_then(|handle| objects.get(handle));
    let decode = |object: &Object| object.array().map(|array| region(object, &colors::decoded(array))).unwrap_or_default();
    let uniform = || {
        let opaque = volume.floats::<3>(c"color").map(|[r, g, b]| [r, g, b, 1.0]);
        vec![volume.floats::<4>(c"color").or(opaque).unwrap_or([1.0; 4])]
    };
    let rgba = array(c"color").map_or_else(uniform, decode);
    let opacities = match array(c"opacity") {
        Some(object) => decode(object).iter().map(|&[opacity, ..]| opacity).collect(),
        None => vec![volume.float(c"opacity").unwrap_or(1.0)],
    };
    // The weighted sum reproduces both ends exactly.
    let value = |t: f64| lowest * (1.0 - t) + highest * t;
    let unit = |component: f32| f64::from(component.clamp(0.0, 1.0));
    let points = places(rgba.len()).zip(&rgba).map(|(t, &[r, g, b, _])| (value(t), [unit(r), unit(g), unit(b)])).collect();
    let alphas: Vec<f64> = rgba.iter().map(|color| unit(color[3])).collect();
    let opacities: Vec<f64> = opacities.into_iter().map(unit).collect();
    let product = products(&alphas, &opacities).into_iter().map(|(t, opacity)| (value(t), opacity)).collect();
    TransferFunction::new("the volume", points, product).map_err(|error| Problem::argument(error.to_string()))
}

/// The places of `count` elements in the range of values, from 0 to 1.
fn places(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| if count > 1 { i as f64 / (count - 1) as f64 } else { 0.0 })
}

/// The product of two piecewise-linear functions at the elements of both.
fn products(a: &[f64], b: &[f64]) -> Vec<(f64, f64)> {
    let mut all: Vec<f64> = if b.len() > 1 { places(b.len()).collect() } else { Vec::new() };
    if a.windows(2).any(|pair| pair[0] != pair[1]) || all.is_empty() {
        all.extend(places(a.len()));
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    all.into_iter().map(|t| (t, interpolated(a, t) * interpolated(b, t))).collect()
}

fn interpolated(values: &[f64], t: f64) -> f64 {
    let place = t * (values.len() - 1) as f64;
    let first = (place as usize).min(values.len() - 1);
    let next = (first + 1).min(values.len() - 1);
    let part = place - first as f64;
    // Exact at elements.
    if part == 0.0 { values[first] } else { values[first] + (values[next] - values[first]) * part }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacities_are_multiplied_at_the_elements_of_both_arrays() {
        assert_eq!(products(&[1.0], &[0.0, 0.5]), [(0.0, 0.0), (1.0, 0.5)]);
        assert_eq!(products(&[1.0; 3], &[0.0, 0.5]), [(0.0, 0.0), (1.0, 0.5)]);
        assert_eq!(products(&[0.5], &[0.5]), [(0.0, 0.25)]);
        assert_eq!(products(&[0.0, 1.0, 0.0], &[0.5]), [(0.0, 0.0), (0.5, 0.5), (1.0, 0.0)]);
        assert_eq!(products(&[0.0, 1.0, 0.0], &[1.0, 0.5]), [(0.0, 0.0), (0.5, 0.75), (1.0, 0.0)]);
    }
}
