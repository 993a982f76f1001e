//! Images that ITK writes: numbers along z, y and x with components behind, and their placement beside them.

use super::{Declared, number_list};
use crate::error::Error;
use crate::volume::Contents;
use crate::volume::format::axes::Roles;
use glam::{DAffine3, DMat3, DVec3};
use hdf5_reader::{Dataset, Hdf5File};
use std::path::Path;

/// The group that makes a file ITK's, and the voxels of the first image in it.
pub(super) const GROUP: &str = "ITKImage";
pub(super) const IMAGE: &str = "ITKImage/0/VoxelData";
const PLACEMENT: [&str; 3] = ["Origin", "Spacing", "Directions"];

/// What the file declares about its voxels.
///
/// # Errors
/// If numbers of axes disagree.
pub(super) fn declared(path: &Path, file: &Hdf5File, dataset: &Dataset) -> Result<Declared, Error> {
    let numbers = |name: &str| file.dataset(&format!("{GROUP}/0/{name}")).ok().and_then(|found| number_list(&found));
    let [origin, spacing, directions] = PLACEMENT.map(|name| numbers(name).unwrap_or_default());
    let (count, axes) = (origin.len(), dataset.ndim());
    let is_whole = spacing.len() == count && directions.len() == count * count;
    if !is_whole || !(2..=4).contains(&count) || ![count, count + 1].contains(&axes) {
        let problem =
            format!("its voxels have {axes} axes, and its Origin, Spacing and Directions are not those of 2 to 4: it is damaged");
        return Err(Error::volume(path, problem));
    }
    // The fastest of space is x; time is the slowest, and components are behind all.
    let space = [0, 1, 2].map(|i| (i < count).then(|| count - 1 - i));
    let roles = Roles { space, frames: if count == 4 { vec![0] } else { Vec::new() }, channels: (count..axes).collect() };
    let along = |list: &[f64], missing: f64| DVec3::from_array([0, 1, 2].map(|i| list.get(i).copied().unwrap_or(missing)));
    // A row has the direction of an axis.
    let direction = |axis: usize| match axis < count {
        true => along(&directions[axis * count..axis * count + count.min(3)], 0.0),
        false => DVec3::AXES[axis],
    };
    let spacing = along(&spacing, 1.0);
    let axes = DMat3::from_cols(direction(0), direction(1), direction(2)) * DMat3::from_diagonal(spacing);
    // ITK's world is left, posterior, superior.
    let to_ras = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    let index_to_world = DAffine3 { matrix3: to_ras * axes, translation: to_ras * along(&origin, 0.0) };
    Ok(Declared { roles, index_to_world, is_anatomical: true, contents: Contents::default() })
}
