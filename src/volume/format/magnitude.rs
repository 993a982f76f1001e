//! Magnitudes of vectors, computed from their components on access.

use super::load::Header;
use crate::volume::storage::Made;
use crate::volume::{Rescale, Storage, VoxelType, wide};
use std::sync::Arc;

/// Bytes that are mapped or held.
pub(super) type Source = Box<dyn AsRef<[u8]> + Send + Sync>;

/// Vectors in bytes, whose Euclidean norms are the voxels.
struct Magnitudes {
    bytes: Source,
    header: Header,
}

/// Storage of the norms as float32, of all components of `header` after its rescale. `bytes` begin with the first component of the first
/// voxel. A component that is invalid makes its voxel invalid.
pub(super) fn storage(bytes: Source, header: Header) -> Storage<'static> {
    Storage::made(Arc::new(Magnitudes { bytes, header }), VoxelType::Float32)
}

/// Distance of components in bytes, and their number.
#[derive(Clone, Copy)]
pub(in crate::volume) struct Components {
    pub stride: u64,
    pub count: usize,
}

impl Components {
    /// Bytes from the first component to the last.
    pub fn extent(self) -> u64 {
        self.stride.saturating_mul(self.count as u64 - 1)
    }
}

impl Made for Magnitudes {
    fn len(&self) -> usize {
        self.header.grid.voxel_count() * size_of::<f32>()
    }

    fn make(&self, first: usize, bytes: &mut [u8]) {
        let Header { ref grid, scalar, endian, rescale, strides, .. } = self.header;
        let numbers = wide::Numbers { bytes: (*self.bytes).as_ref(), scalar, endian };
        let [x, y, _] = grid.dims();
        let (strides, size) = (strides.map(|stride| stride as usize), scalar.bytes());
        let (voxels, _) = bytes.as_chunks_mut::<{ size_of::<f32>() }>();
        for (index, voxel) in (first / size_of::<f32>()..).zip(voxels) {
            let at = index % x * strides[0] + index / x % y * strides[1] + index / x / y * strides[2];
            *voxel = self.norm(numbers, at / size, rescale).to_ne_bytes();
        }
    }
}

impl Magnitudes {
    /// The norm of the voxel whose first component is number `first`.
    fn norm(&self, numbers: wide::Numbers, first: usize, rescale: Rescale) -> f32 {
        let Some(Components { stride, count }) = self.header.components else { unreachable!("a header of vectors") };
        let stride = stride as usize / self.header.scalar.bytes();
        let square = |n: usize| rescale.value(numbers.get(first + n * stride)).powi(2);
        (0..count).map(square).sum::<f64>().sqrt() as f32
    }
}
