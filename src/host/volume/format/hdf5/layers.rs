//! Voxels of an HDF5 dataset, read several layers at a time.

use crate::volume::ScalarType;
use crate::volume::format::parts::Parts;
use hdf5_reader::{Dataset, H5Type, SliceInfo, SliceInfoElem};
use std::io;

/// Bytes read at a time from datasets without chunks.
const TOGETHER: usize = 1 << 24;

/// One volume of a dataset, x fastest.
pub(super) struct Layers {
    dataset: Dataset,
    scalar: ScalarType,
    /// Index along the axes before the spatial ones.
    place: Vec<u64>,
    dims: [usize; 3],
    /// Number of layers read together.
    deep: usize,
    most: u64,
}

impl Layers {
    /// Volume `frame` of those along the axes before the spatial ones. `most` is an upper bound of its bytes.
    pub fn new(dataset: Dataset, scalar: ScalarType, before: &[usize], mut frame: usize, dims: [usize; 3], most: u64) -> Self {
        let mut place = vec![0; before.len()];
        for axis in (0..before.len()).rev() {
            place[axis] = (frame % before[axis]) as u64;
            frame /= before[axis];
        }
        let layer = dims[0].saturating_mul(dims[1]).saturating_mul(scalar.bytes());
        let chunk = dataset.chunks().filter(|_| dataset.ndim() >= 3).and_then(|chunks| chunks.get(before.len()).copied());
        let deep = chunk.map_or(TOGETHER / layer.max(1), |chunk| chunk as usize).clamp(1, dims[2]);
        Self { dataset, scalar, place, dims, deep, most }
    }

    fn layer(&self) -> usize {
        self.dims[0] * self.dims[1] * self.scalar.bytes()
    }

    fn numbers<T: H5Type + bytemuck::Pod>(&self, index: usize) -> io::Result<Vec<u8>> {
        let all = SliceInfoElem::Slice { start: 0, end: u64::MAX, step: 1 };
        let start = (index * self.deep) as u64;
        let layers = SliceInfoElem::Slice { start, end: (start + self.deep as u64).min(self.dims[2] as u64), step: 1 };
        let mut selections: Vec<SliceInfoElem> = self.place.iter().map(|&at| SliceInfoElem::Index(at)).collect();
        let space = self.dataset.ndim() - self.place.len();
        selections.extend((0..space).map(|axis| if space == 3 && axis == 0 { layers.clone() } else { all.clone() }));
        let failed = |e: hdf5_reader::error::Error| io::Error::new(io::ErrorKind::InvalidData, e.to_string());
        let found = self.dataset.read_slice::<T>(&SliceInfo { selections }).map_err(failed)?;
        Ok(found.iter().flat_map(|number| bytemuck::bytes_of(number)).copied().collect())
    }
}

impl Parts for Layers {
    fn most(&self) -> u64 {
        self.most
    }

    fn whole(&self) -> u64 {
        (self.layer() * self.dims[2]) as u64
    }

    fn each(&self) -> u64 {
        (self.layer() * self.deep) as u64
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        match self.scalar {
            ScalarType::Uint8 => self.numbers::<u8>(index),
            ScalarType::Int8 => self.numbers::<i8>(index),
            ScalarType::Uint16 => self.numbers::<u16>(index),
            ScalarType::Int16 => self.numbers::<i16>(index),
            ScalarType::Uint32 => self.numbers::<u32>(index),
            ScalarType::Int32 => self.numbers::<i32>(index),
            ScalarType::Uint64 => self.numbers::<u64>(index),
            ScalarType::Int64 => self.numbers::<i64>(index),
            ScalarType::Float32 => self.numbers::<f32>(index),
            ScalarType::Float64 => self.numbers::<f64>(index),
            ScalarType::Float16 => Err(io::Error::new(io::ErrorKind::InvalidData, "16-bit floats are not supported")),
        }
    }
}
