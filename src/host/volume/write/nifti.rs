//! Single-file NIfTI-1.

use super::Written;
use crate::volume::ScalarType;

/// Byte of the first voxel.
const HEAD: usize = 352;

pub(super) fn head(written: &Written) -> Result<Vec<u8>, String> {
    let dims = written.grid.dims().map(i16::try_from);
    let [Ok(x), Ok(y), Ok(z)] = dims else {
        return Err(format!(
            "NIfTI-1 supports up to 32767 voxels per axis, not {:?}: choose another format",
            written.grid.dims()
        ));
    };
    let code: i16 = match written.scalar {
        ScalarType::Uint8 => 2,
        ScalarType::Int16 => 4,
        ScalarType::Int32 => 8,
        ScalarType::Float32 => 16,
        ScalarType::Float64 => 64,
        ScalarType::Int8 => 256,
        ScalarType::Uint16 => 512,
        ScalarType::Uint32 => 768,
        ScalarType::Int64 => 1024,
        ScalarType::Uint64 => 1280,
        ScalarType::Float16 => return Err("the format does not support float16: choose .npy or .raw".into()),
    };
    let mut head = vec![0; HEAD];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    let floats = |numbers: &[f64]| numbers.iter().flat_map(|&n| (n as f32).to_le_bytes()).collect::<Vec<u8>>();
    put(0, &348i32.to_le_bytes());
    put(40, &[3, x, y, z, 1, 1, 1, 1].map(i16::to_le_bytes).concat());
    put(70, &code.to_le_bytes());
    put(72, &(8 * written.scalar.bytes() as i16).to_le_bytes());
    let spacing = written.grid.spacing();
    put(76, &floats(&[1.0, spacing.x, spacing.y, spacing.z]));
    put(108, &floats(&[HEAD as f64, written.rescale.slope(), written.rescale.intercept()]));
    // The sform: a transform to scanner coordinates, row-major.
    put(254, &1i16.to_le_bytes());
    let place = written.grid.index_to_world();
    for row in 0..3 {
        let numbers = [0, 1, 2].map(|i| place.matrix3.col(i)[row]);
        put(280 + 16 * row, &floats(&numbers));
        put(292 + 16 * row, &floats(&[place.translation[row]]));
    }
    // A unit that the format does not know is not stated.
    put(
        123,
        &[match written.length_unit {
            Some("m") => 1,
            Some("mm") => 2,
            Some("µm") => 3,
            _ => 0,
        }],
    );
    put(344, b"n+1\0");
    Ok(head)
}
