//! Magnitudes of vectors, computed from their components on access.

use super::load::Header;
use crate::volume::storage::Made;
use crate::volume::voxels::{Number, is_valid};
use crate::volume::{Endian, ScalarType, Storage, VoxelType};
use rayon::prelude::*;
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

/// Voxels per unit of parallel work.
const BLOCK: usize = 1 << 14;

/// A float32 as bytes.
type Voxel = [u8; size_of::<f32>()];

impl Made for Magnitudes {
    fn len(&self) -> usize {
        self.header.grid.voxel_count() * size_of::<Voxel>()
    }

    fn make(&self, first: usize, bytes: &mut [u8]) {
        let first = first / size_of::<Voxel>();
        let (voxels, _) = bytes.as_chunks_mut();
        voxels.par_chunks_mut(BLOCK).enumerate().for_each(|(n, voxels)| self.block(first + n * BLOCK, voxels));
    }
}

impl Magnitudes {
    /// Computes voxels from voxel `first` on.
    fn block(&self, first: usize, voxels: &mut [Voxel]) {
        match self.header.scalar {
            ScalarType::Uint8 => self.rows::<u8>(first, voxels),
            ScalarType::Int8 => self.rows::<i8>(first, voxels),
            ScalarType::Uint16 => self.rows::<u16>(first, voxels),
            ScalarType::Int16 => self.rows::<i16>(first, voxels),
            ScalarType::Uint32 => self.rows::<u32>(first, voxels),
            ScalarType::Int32 => self.rows::<i32>(first, voxels),
            ScalarType::Uint64 => self.rows::<u64>(first, voxels),
            ScalarType::Int64 => self.rows::<i64>(first, voxels),
            ScalarType::Float16 => self.rows::<half::f16>(first, voxels),
            ScalarType::Float32 => self.rows::<f32>(first, voxels),
            ScalarType::Float64 => self.rows::<f64>(first, voxels),
        }
    }

    fn rows<T: Number>(&self, first: usize, mut voxels: &mut [Voxel]) {
        let ([x, y, _], strides) = (self.header.grid.dims(), self.header.strides.map(|stride| stride as usize));
        let mut index = first;
        while !voxels.is_empty() {
            let (i, row) = (index % x, index / x);
            let (here, rest) = voxels.split_at_mut((x - i).min(voxels.len()));
            let start = i * strides[0] + row % y * strides[1] + row / y * strides[2];
            for (n, voxel) in here.iter_mut().enumerate() {
                *voxel = self.norm::<T>(start + n * strides[0]).to_ne_bytes();
            }
            (index, voxels) = (index + here.len(), rest);
        }
    }

    /// The norm of the voxel whose first component is at byte `at`.
    fn norm<T: Number>(&self, at: usize) -> f32 {
        let Header { components: Some(Components { stride, count }), endian, rescale, ref missing, .. } = self.header else {
            unreachable!("a header of vectors")
        };
        let bytes = (*self.bytes).as_ref();
        let square = |n: usize| {
            let at = at + n * stride as usize;
            let number = bytemuck::pod_read_unaligned::<T>(&bytes[at..at + size_of::<T>()]);
            let number = if endian == Endian::NATIVE { number } else { number.swapped() }.value();
            let value = if is_valid(number) && !missing.has(number) { rescale.value(number) } else { f64::NAN };
            value * value
        };
        (0..count).map(square).sum::<f64>().sqrt() as f32
    }
}
