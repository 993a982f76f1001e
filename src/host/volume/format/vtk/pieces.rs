//! Images in several pieces. Neighbouring pieces may share points.

use super::arrays::{Array, Image};
use crate::error::Error;
use crate::memory;
use crate::volume::format::bytes::Bytes;
use std::path::Path;

/// First and last point along x, y and z.
pub(super) type Extent = [i32; 6];

/// Smallest extent that contains all others.
pub(super) fn union(extents: impl Iterator<Item = Extent>) -> Option<Extent> {
    let larger = |a: Extent, b: Extent| std::array::from_fn(|i| if i % 2 == 0 { a[i].min(b[i]) } else { a[i].max(b[i]) });
    extents.reduce(larger)
}

/// Numbers and extent of a piece.
pub(super) struct Piece {
    pub extent: Extent,
    pub bytes: Box<dyn Bytes>,
}

/// Joins an array from its pieces, which are opened on demand.
///
/// # Errors
/// If pieces are truncated or do not cover the image.
pub(super) fn joined<P>(
    path: &Path,
    array: &Array<P>,
    whole: (&Image, Extent),
    size: usize,
    pieces: impl Iterator<Item = Result<Piece, Error>>,
) -> Result<Vec<u8>, Error> {
    let (image, all) = whole;
    let wrong = |problem: &str| Error::volume(path, problem);
    // A flat piece has no cells, unless the whole image is flat along that axis.
    let along = |extent: Extent| -> [usize; 3] {
        let points = |extent: Extent, i: usize| (i64::from(extent[2 * i + 1]) - i64::from(extent[2 * i]) + 1).max(0) as usize;
        let cells = |i: usize| if points(all, i) == 1 { 1 } else { points(extent, i).saturating_sub(1) };
        [0, 1, 2].map(|i| if array.cell_data { cells(i) } else { points(extent, i) })
    };
    let voxel = size * array.components;
    let [x, y, z] = along(all);
    let count = array.numbers(image) / array.components as u64;
    let pieces: Vec<Piece> = pieces.collect::<Result<_, _>>()?;
    // Check the sizes of all pieces before allocating.
    let most = pieces.iter().fold(0u64, |most, piece| most.saturating_add(piece.bytes.most()));
    if most < count.saturating_mul(voxel as u64) {
        return Err(wrong("its pieces do not cover the image, or are truncated"));
    }
    let name = path.display().to_string();
    let (mut numbers, mut found) = (memory::zeroed::<u8>(&name, x * y * z * voxel)?, memory::zeroed::<u8>(&name, x * y * z)?);
    for Piece { extent, mut bytes } in pieces {
        let [columns, rows, layers] = along(extent);
        if columns * rows * layers == 0 {
            continue;
        }
        let first = [0, 1, 2].map(|i| (i64::from(extent[2 * i]) - i64::from(all[2 * i])) as usize);
        let mut row = memory::zeroed::<u8>(&name, columns * voxel)?;
        for n in 0..rows * layers {
            let read = bytes.read((n * row.len()) as u64, &mut row);
            let read = read.map_err(|e| wrong(&format!("its compressed data are truncated or damaged: {e}")))?;
            if read < row.len() {
                return Err(wrong("one of its pieces is truncated"));
            }
            let at = first[0] + x * (first[1] + n % rows + y * (first[2] + n / rows));
            numbers[at * voxel..][..row.len()].copy_from_slice(&row);
            found[at..at + columns].fill(1);
        }
    }
    if found.contains(&0) {
        return Err(wrong("its pieces do not cover the image"));
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::format::bytes::Held;
    use glam::DAffine3;

    /// Cells of an image of 3×2×1 points. The second piece is flat and has none; the last two are adjacent.
    #[test]
    fn flat_pieces_have_no_cells() {
        let array = Array {
            name: String::new(),
            type_name: String::new(),
            components: 1,
            cell_data: true,
            active: false,
            is_vector: false,
            are_normals: false,
            are_colors: false,
            place: (),
        };
        let image = Image { points: [3, 2, 1], index_to_world: DAffine3::IDENTITY };
        let piece = |extent, bytes: &[u8]| Ok(Piece { extent, bytes: Box::new(Held(bytes.to_vec())) as Box<dyn Bytes> });
        let join = |last| {
            let pieces = [piece([0, 1, 0, 1, 5, 5], &[7]), piece([2, 2, 0, 1, 5, 5], &[9]), piece(last, &[8])];
            joined(Path::new("a"), &array, (&image, [0, 2, 0, 1, 5, 5]), 1, pieces.into_iter())
        };
        assert_eq!(join([1, 2, 0, 1, 5, 5]).unwrap(), [7, 8]);
        assert!(join([0, 1, 0, 1, 5, 5]).unwrap_err().to_string().contains("do not cover"));
    }
}
