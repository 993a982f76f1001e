//! Coordinates of the axes of an array: arrays of the same names in its group, as xarray writes them.

use super::node::{self, Node};
use super::pieces::Pieces;
use crate::volume::format::axes::Axis;
use crate::volume::format::conventions::Packed;
use crate::volume::format::numbered;
use crate::volume::format::parts::Parts;
use crate::volume::wide::Numbers;
use std::path::Path;

/// Limit of the positions along an axis.
const MOST: usize = 1 << 20;

/// The axis of this name of the array in `folder`, at its coordinates if there are such.
pub(super) fn axis(folder: &Path, name: &str) -> Axis {
    let axis = Axis::named(name);
    match read(folder, name) {
        Some((coordinates, unit)) => axis.at(&coordinates, unit),
        None => axis,
    }
}

/// The numbers and the unit of the array `name` beside the one in `folder`.
fn read(folder: &Path, name: &str) -> Option<(Vec<f64>, String)> {
    if name.is_empty() || !numbered::leads_below(name) {
        return None;
    }
    let folder = folder.parent()?.join(name);
    let Node::Array(array) = node::found(&folder).ok()?? else { return None };
    let &[1..=MOST] = &array.shape[..] else { return None };
    let (unit, endian) = (array.unit(), array.endian);
    let Packed { scalar, rescale, .. } = array.packed().ok()?;
    // Along z, whose layers are the parts.
    let mut pieces = Pieces::new(*array, [None, None, Some(0)], vec![0]);
    let mut all = Vec::new();
    for index in 0..pieces.whole().div_ceil(pieces.each()) as usize {
        let bytes = pieces.part(index).ok()?;
        let numbers = Numbers { bytes: &bytes, scalar, endian, missing: None };
        all.extend((0..numbers.count()).map(|n| rescale.value(numbers.get(n))));
    }
    Some((all, unit))
}
