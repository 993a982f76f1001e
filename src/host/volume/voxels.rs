//! Types of voxels and of numbers in files.

use bytemuck::Pod;
use std::fmt;
use std::str::FromStr;

/// Float voxels of larger magnitude are invalid, so that sums of several voxels cannot overflow.
pub(super) const LARGEST_MAGNITUDE: f64 = 1e30;

/// Whether a voxel is valid: finite, and small enough that sums of several voxels do not overflow.
pub(super) fn is_valid(number: f64) -> bool {
    number.abs() <= LARGEST_MAGNITUDE
}

/// Type of voxels in memory and on the device.
///
/// ```
/// use layersplat::volume::VoxelType;
///
/// assert_eq!((VoxelType::Int16.bytes(), VoxelType::Int16.to_string().as_str()), (2, "int16"));
/// ```
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
}

impl VoxelType {
    /// Bytes per voxel.
    pub fn bytes(self) -> usize {
        ScalarType::from(self).bytes()
    }
}

impl fmt::Display for VoxelType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        ScalarType::from(*self).fmt(f)
    }
}

/// Type of numbers in files. Types that are not a [`VoxelType`] are converted on reading.
///
/// ```
/// use layersplat::volume::{ScalarType, VoxelType};
///
/// assert_eq!("float64".parse(), Ok(ScalarType::Float64));
/// // Types without device support become floats.
/// assert_eq!((ScalarType::Float64.voxel_type(), ScalarType::Uint8.voxel_type()), (None, Some(VoxelType::Uint8)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScalarType {
    /// 8 bit, unsigned.
    Uint8,
    /// 8 bit, signed.
    Int8,
    /// 16 bit, unsigned.
    Uint16,
    /// 16 bit, signed.
    Int16,
    /// 32 bit, unsigned.
    Uint32,
    /// 32 bit, signed.
    Int32,
    /// 64 bit, unsigned.
    Uint64,
    /// 64 bit, signed.
    Int64,
    /// 16-bit float.
    Float16,
    /// 32-bit float.
    Float32,
    /// 64-bit float.
    Float64,
}

impl ScalarType {
    const NAMES: [(ScalarType, &'static str); 11] = [
        (ScalarType::Uint8, "uint8"),
        (ScalarType::Int8, "int8"),
        (ScalarType::Uint16, "uint16"),
        (ScalarType::Int16, "int16"),
        (ScalarType::Uint32, "uint32"),
        (ScalarType::Int32, "int32"),
        (ScalarType::Uint64, "uint64"),
        (ScalarType::Int64, "int64"),
        (ScalarType::Float16, "float16"),
        (ScalarType::Float32, "float32"),
        (ScalarType::Float64, "float64"),
    ];

    /// Bytes per number.
    pub fn bytes(self) -> usize {
        match self {
            ScalarType::Uint8 | ScalarType::Int8 => 1,
            ScalarType::Uint16 | ScalarType::Int16 | ScalarType::Float16 => 2,
            ScalarType::Uint32 | ScalarType::Int32 | ScalarType::Float32 => 4,
            ScalarType::Uint64 | ScalarType::Int64 | ScalarType::Float64 => 8,
        }
    }

    /// The corresponding voxel type, if the device supports it.
    pub fn voxel_type(self) -> Option<VoxelType> {
        match self {
            ScalarType::Uint8 => Some(VoxelType::Uint8),
            ScalarType::Int8 => Some(VoxelType::Int8),
            ScalarType::Uint16 => Some(VoxelType::Uint16),
            ScalarType::Int16 => Some(VoxelType::Int16),
            ScalarType::Float32 => Some(VoxelType::Float32),
            ScalarType::Uint32 | ScalarType::Int32 | ScalarType::Uint64 | ScalarType::Int64 => None,
            ScalarType::Float16 | ScalarType::Float64 => None,
        }
    }
}

impl From<VoxelType> for ScalarType {
    fn from(voxel_type: VoxelType) -> Self {
        match voxel_type {
            VoxelType::Uint8 => ScalarType::Uint8,
            VoxelType::Int8 => ScalarType::Int8,
            VoxelType::Uint16 => ScalarType::Uint16,
            VoxelType::Int16 => ScalarType::Int16,
            VoxelType::Float32 => ScalarType::Float32,
        }
    }
}

impl fmt::Display for ScalarType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(t, _)| t == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

impl FromStr for ScalarType {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(_, n)| *n == name).map(|(t, _)| *t);
        found.ok_or_else(|| format!("unknown voxel type '{name}': use {}", Self::NAMES.map(|(_, n)| n).join(", ")))
    }
}

/// Byte order of numbers.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Endian, Grid, Storage, Volume, VoxelType};
///
/// let storage = Storage::from_bytes(vec![0x01, 0x00, 0x00, 0x02], VoxelType::Uint16).with_endian(Endian::Big);
/// let volume = Volume::new("two", Grid::new([2, 1, 1], DVec3::ONE)?, storage)?;
/// assert_eq!(volume.range(), (2.0, 256.0));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// Byte order of this machine.
    pub const NATIVE: Endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };
}

/// A voxel type: `u8`, `i8`, `u16`, `i16` or `f32`. Sealed.
///
/// ```
/// use layersplat::volume::{Storage, Voxel};
///
/// fn lent<T: Voxel>(voxels: &[T]) -> Storage<'_> {
///     Storage::from(voxels)
/// }
/// assert_eq!(lent(&[1i16, 2]).voxel_type().bytes(), 2);
/// ```
pub trait Voxel: Number {
    /// The corresponding [`VoxelType`].
    const TYPE: VoxelType;
}

impl Voxel for u8 {
    const TYPE: VoxelType = VoxelType::Uint8;
}
impl Voxel for i8 {
    const TYPE: VoxelType = VoxelType::Int8;
}
impl Voxel for u16 {
    const TYPE: VoxelType = VoxelType::Uint16;
}
impl Voxel for i16 {
    const TYPE: VoxelType = VoxelType::Int16;
}
impl Voxel for f32 {
    const TYPE: VoxelType = VoxelType::Float32;
}

/// A number type that is converted to voxels: `u32`, `i32`, `u64`, `i64` or `f64`. Sealed.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Grid, Volume};
///
/// let volume = Volume::from_wide("temperature", Grid::new([2, 2, 1], DVec3::ONE)?, &[273.15f64, 280.0, 290.0, 300.0])?;
/// // Rounded to floats.
/// assert!((volume.range().1 - 300.0).abs() < 1e-5);
/// # Ok::<(), layersplat::Error>(())
/// ```
pub trait Wide: Number {
    /// The corresponding [`ScalarType`].
    const TYPE: ScalarType;
}

impl Wide for u32 {
    const TYPE: ScalarType = ScalarType::Uint32;
}
impl Wide for i32 {
    const TYPE: ScalarType = ScalarType::Int32;
}
impl Wide for u64 {
    const TYPE: ScalarType = ScalarType::Uint64;
}
impl Wide for i64 {
    const TYPE: ScalarType = ScalarType::Int64;
}
impl Wide for f64 {
    const TYPE: ScalarType = ScalarType::Float64;
}

pub(super) use number::Number;
mod number {
    /// A plain number in a file or in memory. Private, so that other crates cannot implement [`super::Voxel`] or [`super::Wide`].
    pub trait Number: super::Pod + PartialOrd + Send + Sync {
        /// Conversion to a 64-bit float, exact except for integers beyond 2^53.
        fn value(self) -> f64;
        /// Reversal of the byte order.
        fn swapped(self) -> Self;
        /// Nearest number of this type.
        fn nearest(value: f64) -> Self;
    }

    macro_rules! number {
        ($($type:ty),*) => {$(
            impl Number for $type {
                fn value(self) -> f64 {
                    self as f64
                }

                fn swapped(self) -> Self {
                    let mut bytes = self.to_ne_bytes();
                    bytes.reverse();
                    Self::from_ne_bytes(bytes)
                }

                fn nearest(value: f64) -> Self {
                    value as $type
                }
            }
        )*};
    }
    number!(u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

    impl Number for half::f16 {
        fn value(self) -> f64 {
            self.to_f64()
        }

        fn swapped(self) -> Self {
            Self::from_bits(self.to_bits().swap_bytes())
        }

        fn nearest(value: f64) -> Self {
            Self::from_f64(value)
        }
    }
}

/// Evaluates `$body` with `$Type` as the Rust type of a [`VoxelType`].
macro_rules! with_voxel_type {
    ($voxel_type:expr, $Type:ident => $body:expr) => {
        match $voxel_type {
            $crate::volume::VoxelType::Uint8 => {
                type $Type = u8;
                $body
            }
            $crate::volume::VoxelType::Int8 => {
                type $Type = i8;
                $body
            }
            $crate::volume::VoxelType::Uint16 => {
                type $Type = u16;
                $body
            }
            $crate::volume::VoxelType::Int16 => {
                type $Type = i16;
                $body
            }
            $crate::volume::VoxelType::Float32 => {
                type $Type = f32;
                $body
            }
        }
    };
}
pub(super) use with_voxel_type;

/// A vector of voxels of any type, x fastest, then y, then z.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{Grid, Volume, Voxels};
///
/// let voxels = Voxels::Uint8(vec![0, 128, 255]);
/// let volume = Volume::new("three", Grid::new([3, 1, 1], DVec3::ONE)?, voxels)?;
/// assert_eq!(volume.value(1), 128.0);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Voxels {
    Uint8(Vec<u8>),
    Int8(Vec<i8>),
    Uint16(Vec<u16>),
    Int16(Vec<i16>),
    Float32(Vec<f32>),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_sizes() {
        for (scalar, name) in ScalarType::NAMES {
            assert_eq!((scalar.to_string().as_str(), name.parse()), (name, Ok(scalar)));
            let bits: usize = name.trim_start_matches(char::is_alphabetic).parse().unwrap();
            assert_eq!(8 * scalar.bytes(), bits, "{name}");
            if let Some(voxel) = scalar.voxel_type() {
                assert_eq!((ScalarType::from(voxel), voxel.bytes()), (scalar, scalar.bytes()));
            }
        }
        assert!("int128".parse::<ScalarType>().unwrap_err().contains("uint32"));
    }
}
