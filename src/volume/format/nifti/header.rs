//! Where the fields of both versions are.

use crate::volume::Endian;

/// Bytes of the longer header.
pub(super) const LARGEST: usize = 540;

/// Bytes of the header of either version, in either order.
pub(super) struct Fields {
    bytes: Vec<u8>,
    endian: Endian,
    second: bool,
}

impl Fields {
    /// Nothing if these are not the first bytes of such a file.
    pub fn new(bytes: Vec<u8>) -> Option<Self> {
        let size = bytes.first_chunk::<4>()?;
        let endian = if size[0] == 0 { Endian::Big } else { Endian::Little };
        let size = if endian == Endian::Big { u32::from_be_bytes(*size) } else { u32::from_le_bytes(*size) };
        let mark = |at: usize| bytes.get(at..at + 4).filter(|mark| [&mark[..1], &mark[3..]] == [b"n", b"\0"]);
        let second = match (size, mark(344), mark(4)) {
            (348, Some(b"n+1\0" | b"ni1\0"), _) => false,
            (540, _, Some(b"n+2\0" | b"ni2\0")) => true,
            _ => return None,
        };
        Some(Self { bytes, endian, second })
    }

    pub fn endian(&self) -> Endian {
        self.endian
    }

    /// Zeros where the file ends before.
    fn get<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut bytes = self.bytes.get(at..).and_then(|rest| rest.first_chunk().copied()).unwrap_or([0; N]);
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    }

    fn int16(&self, at: usize) -> i16 {
        i16::from_le_bytes(self.get(at))
    }

    fn int32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.get(at))
    }

    fn int64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.get(at))
    }

    fn float32(&self, at: usize) -> f64 {
        f32::from_le_bytes(self.get(at)).into()
    }

    fn float64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.get(at))
    }

    /// Numbers one after the other, of 32 bits at one place in the first version, of 64 at another in the second.
    fn floats<const N: usize>(&self, first: usize, second: usize) -> [f64; N] {
        std::array::from_fn(|i| if self.second { self.float64(second + 8 * i) } else { self.float32(first + 4 * i) })
    }

    /// How many axes there are, and their sizes.
    pub fn dims(&self) -> [i64; 8] {
        std::array::from_fn(|i| if self.second { self.int64(16 + 8 * i) } else { self.int16(40 + 2 * i).into() })
    }

    pub fn datatype(&self) -> i16 {
        self.int16(if self.second { 12 } else { 70 })
    }

    /// The sign of the third axis, and distances between voxels.
    pub fn spacings(&self) -> [f64; 4] {
        self.floats(76, 104)
    }

    /// Whether the voxels are in another file.
    pub fn is_of_a_pair(&self) -> bool {
        self.bytes[if self.second { 4 } else { 344 } + 1] == b'i'
    }

    /// Byte of the first voxel, in the file that has it.
    pub fn first(&self) -> Option<u64> {
        let (given, behind) = if self.second { (self.int64(168), 544) } else { (self.float32(108) as i64, 352) };
        match u64::try_from(given).ok()? {
            // Some writers leave it out.
            0 if !self.is_of_a_pair() => Some(behind),
            first => Some(first),
        }
    }

    /// Slope and intercept; none where numbers are values.
    pub fn rescale(&self) -> Option<(f64, f64)> {
        let [slope, intercept] = self.floats(112, 176);
        (slope != 0.0 && slope.is_finite() && intercept.is_finite()).then_some((slope, intercept))
    }

    /// What the transform by a quaternion, and that by a matrix, are good for: 0 for nothing.
    pub fn codes(&self) -> [i32; 2] {
        if self.second { [self.int32(344), self.int32(348)] } else { [self.int16(252).into(), self.int16(254).into()] }
    }

    /// Three parts of a quaternion of length 1, and an origin.
    pub fn quaternion(&self) -> [f64; 6] {
        self.floats(256, 352)
    }

    /// The rows of a matrix.
    pub fn rows(&self) -> [f64; 12] {
        self.floats(280, 400)
    }
}
