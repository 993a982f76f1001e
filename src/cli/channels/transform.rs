//! Where a transform in a file places a field.

use super::FieldSpec;
use crate::error::Error;
use crate::files;
use crate::volume::{Grid, Volume};
use glam::{DAffine3, DMat3, DVec3};
use std::path::{Path, PathBuf};

impl FieldSpec {
    /// Where `at` places volumes.
    pub fn transform(&self) -> Result<FieldTransform, Error> {
        let transform = self.at.as_deref().map(|path| Ok::<_, Error>((path.to_owned(), read_transform(path)?))).transpose()?;
        Ok(FieldTransform(transform))
    }
}

/// A transform from the world of a field's file to that of the scene, and its file.
pub(super) struct FieldTransform(Option<(PathBuf, DAffine3)>);

impl FieldTransform {
    /// The grid where the transform places it, of colours and labels, whose voxels stay as they are.
    pub fn grid(&self, grid: &Grid) -> Result<Grid, Error> {
        let Some((path, transform)) = &self.0 else { return Ok(grid.clone()) };
        let index_to_world = *transform * grid.index_to_world();
        Grid::from_affine(grid.dims(), index_to_world).map_err(|_| match Grid::covering(grid.dims(), index_to_world) {
            Ok(_) => {
                let problem = "it shears, and the voxels of colours and labels stay as they are: give a transform without shear, or resample the \
                               file";
                Error::volume(path, problem)
            }
            Err(error) => Error::volume(path, error.to_string()),
        })
    }

    /// The volume where the transform places it.
    pub fn applied_to(&self, volume: Volume<'static>) -> Result<Volume<'static>, Error> {
        let Some((path, transform)) = &self.0 else { return Ok(volume) };
        let index_to_world = *transform * volume.grid().index_to_world();
        match Grid::from_affine(volume.grid().dims(), index_to_world) {
            Ok(grid) => volume.with_grid(grid),
            // Axes that are not at right angles.
            Err(_) => volume.covering(index_to_world, false).map_err(|error| Error::volume(path, error.to_string())),
        }
    }
}

/// Largest file of a transform in bytes.
const MAX_BYTES: u64 = 1 << 16;

/// Reads a 4 x 4 or 3 x 4 matrix, row by row, whose numbers are separated by spaces, commas or line ends.
pub(in crate::cli) fn read_transform(path: &Path) -> Result<DAffine3, Error> {
    let text = files::read_text(path, MAX_BYTES)?;
    let wrong =
        |problem: String| Error::volume(path, format!("{problem}; a transform has 4 rows of 4 numbers, the last 0 0 0 1"));
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let number =
        |word: &str| word.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| wrong(format!("'{word}' is no number")));
    let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
    if !(numbers.len() == 12 || (numbers.len() == 16 && numbers[12..] == [0.0, 0.0, 0.0, 1.0])) {
        return Err(wrong(format!("it has {} numbers, or another last row", numbers.len())));
    }
    let row = |n: usize| DVec3::new(numbers[4 * n], numbers[4 * n + 1], numbers[4 * n + 2]);
    let matrix3 = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    Ok(DAffine3 { matrix3, translation: DVec3::new(numbers[3], numbers[7], numbers[11]) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_are_matrices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("at.txt");
        std::fs::write(&path, "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n").unwrap();
        let transform = read_transform(&path).unwrap();
        assert_eq!(transform.transform_point3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(3.0, 7.0, 10.0));
        for text in ["1 2 3", "a", &"1 ".repeat(16), "1 0 0 0 0 1 0 0 0 0 1 nan"] {
            std::fs::write(&path, text).unwrap();
            assert!(read_transform(&path).is_err(), "{text}");
        }
    }
}
