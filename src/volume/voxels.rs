//! Voxel types and arrays.

use std::fmt;
use std::str::FromStr;

/// Type of a voxel as stored and rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VoxelType {
    /// 8 bit, unsigned.
    Uint8,
    /// 8 bit, signed.
    Int8,
    /// 16 bit, unsigned.
    Uint16,
    /// 16 bit, signed.
    Int16,
    /// 32-bit float.
    Float32,
    /// 64-bit float: converted to 32 bits on reading.
    Float64,
}

impl VoxelType {
    const NAMES: [(VoxelType, &'static str); 6] = [
        (VoxelType::Uint8, "uint8"),
        (VoxelType::Int8, "int8"),
        (VoxelType::Uint16, "uint16"),
        (VoxelType::Int16, "int16"),
        (VoxelType::Float32, "float32"),
        (VoxelType::Float64, "float64"),
    ];

    /// Bytes per voxel in a file.
    pub fn bytes(self) -> usize {
        match self {
            VoxelType::Uint8 | VoxelType::Int8 => 1,
            VoxelType::Uint16 | VoxelType::Int16 => 2,
            VoxelType::Float32 => 4,
            VoxelType::Float64 => 8,
        }
    }
}

impl fmt::Display for VoxelType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(t, _)| t == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

impl FromStr for VoxelType {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(_, n)| *n == name);
        found
            .map(|(t, _)| *t)
            .ok_or_else(|| format!("unknown voxel type '{name}': use uint8, int8, uint16, int16, float32 or float64"))
    }
}

/// Voxels of one type, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Voxels {
    Uint8(Vec<u8>),
    Int8(Vec<i8>),
    Uint16(Vec<u16>),
    Int16(Vec<i16>),
    Float32(Vec<f32>),
}

/// Runs `$body` with `$values` bound to the vector inside.
macro_rules! for_voxels {
    ($voxels:expr, $values:ident => $body:expr) => {
        match $voxels {
            $crate::volume::Voxels::Uint8($values) => $body,
            $crate::volume::Voxels::Int8($values) => $body,
            $crate::volume::Voxels::Uint16($values) => $body,
            $crate::volume::Voxels::Int16($values) => $body,
            $crate::volume::Voxels::Float32($values) => $body,
        }
    };
}
pub(crate) use for_voxels;

impl Voxels {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        for_voxels!(self, values => values.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their type.
    pub fn voxel_type(&self) -> VoxelType {
        match self {
            Voxels::Uint8(_) => VoxelType::Uint8,
            Voxels::Int8(_) => VoxelType::Int8,
            Voxels::Uint16(_) => VoxelType::Uint16,
            Voxels::Int16(_) => VoxelType::Int16,
            Voxels::Float32(_) => VoxelType::Float32,
        }
    }

    /// Value of voxel `index`.
    pub fn value(&self, index: usize) -> f64 {
        for_voxels!(self, values => f64::from(values[index]))
    }

    /// Calls `visit` with every value, in order.
    pub fn for_each(&self, mut visit: impl FnMut(f64)) {
        for_voxels!(self, values => values.iter().for_each(|&v| visit(f64::from(v))));
    }

    /// Smallest and largest value; of floats, those that are `usable`.
    pub(super) fn range_where(&self, usable: impl Fn(f32) -> bool) -> Option<(f64, f64)> {
        fn range<T: Copy + PartialOrd + Into<f64>>(values: impl Iterator<Item = T>) -> Option<(f64, f64)> {
            let bounds = values.fold(None, |bounds: Option<(T, T)>, v| {
                let (lo, hi) = bounds.unwrap_or((v, v));
                Some((if v < lo { v } else { lo }, if v > hi { v } else { hi }))
            });
            bounds.map(|(lo, hi)| (lo.into(), hi.into()))
        }
        match self {
            Voxels::Uint8(v) => range(v.iter().copied()),
            Voxels::Int8(v) => range(v.iter().copied()),
            Voxels::Uint16(v) => range(v.iter().copied()),
            Voxels::Int16(v) => range(v.iter().copied()),
            Voxels::Float32(v) => range(v.iter().copied().filter(|&v| usable(v))),
        }
    }

    /// Replaces floats that are not `usable`; returns how many.
    pub(super) fn replace_where_not(&mut self, usable: impl Fn(f32) -> bool, by: f32) -> usize {
        let Voxels::Float32(values) = self else {
            return 0;
        };
        let mut replaced = 0;
        for value in values.iter_mut().filter(|v| !usable(**v)) {
            *value = by;
            replaced += 1;
        }
        replaced
    }
}
