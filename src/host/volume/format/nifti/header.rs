//! Header fields of both NIfTI versions.

use crate::volume::{Endian, FrameSpacing};

/// Size of the larger header in bytes.
pub(super) const LARGEST: usize = 540;

/// Header of either version and byte order.
pub(super) struct Fields {
    bytes: Vec<u8>,
    endian: Endian,
    second: bool,
}

impl Fields {
    /// `None` if the bytes are not a NIfTI header.
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

    /// Bytes at an offset, as little-endian; zeros if the file ends before.
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

    /// Consecutive floats: 32-bit at offset `first` in version 1, 64-bit at offset `second` in version 2.
    fn floats<const N: usize>(&self, first: usize, second: usize) -> [f64; N] {
        std::array::from_fn(|i| if self.second { self.float64(second + 8 * i) } else { self.float32(first + 4 * i) })
    }

    /// Number of axes, and their sizes.
    pub fn dims(&self) -> [i64; 8] {
        std::array::from_fn(|i| if self.second { self.int64(16 + 8 * i) } else { self.int16(40 + 2 * i).into() })
    }

    pub fn datatype(&self) -> i16 {
        self.int16(if self.second { 12 } else { 70 })
    }

    /// Whether the intent is a vector per voxel: a displacement or another one.
    pub fn is_vector(&self) -> bool {
        let intent = if self.second { self.int32(504) } else { self.int16(68).into() };
        [1006, 1007].contains(&intent)
    }

    /// Sign of the third axis (qfac), and spacings.
    pub fn spacings(&self) -> [f64; 4] {
        self.floats(76, 104)
    }

    /// `xyzt_units`.
    fn units(&self) -> i32 {
        if self.second { self.int32(500) } else { i32::from(self.bytes[123]) }
    }

    /// Unit of lengths.
    pub fn length_unit(&self) -> Option<&'static str> {
        match self.units() & 7 {
            1 => Some("m"),
            2 => Some("mm"),
            3 => Some("µm"),
            _ => None,
        }
    }

    /// Distance between volumes of a sequence. The unit is that of `xyzt_units`.
    pub fn time_spacing(&self) -> Option<FrameSpacing> {
        let [distance] = self.floats(76 + 4 * 4, 104 + 4 * 8);
        let unit = match self.units() & 0x38 {
            8 => Some("s"),
            16 => Some("ms"),
            24 => Some("µs"),
            32 => Some("Hz"),
            40 => Some("ppm"),
            48 => Some("rad/s"),
            _ => None,
        };
        FrameSpacing::new(distance, unit)
    }

    /// Whether the intent is one of those of CIFTI-2.
    pub fn is_cifti(&self) -> bool {
        self.second && (3000..=3099).contains(&self.int32(504))
    }

    /// Whether numbers are ids of labels (NIFTI_INTENT_LABEL).
    pub fn is_of_labels(&self) -> bool {
        (if self.second { self.int32(504) } else { self.int16(68).into() }) == 1002
    }

    /// Name of an auxiliary file, which holds names of labels; empty if there is none.
    pub fn auxiliary_file(&self) -> String {
        let first = if self.second { 320 } else { 228 };
        let bytes = self.bytes.get(first..first + 24).unwrap_or_default();
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
    }

    /// Whether the voxels are in a separate file.
    pub fn is_of_a_pair(&self) -> bool {
        self.bytes[if self.second { 4 } else { 344 } + 1] == b'i'
    }

    /// Byte of the first voxel in its file.
    pub fn first(&self) -> Option<u64> {
        let (given, behind) = if self.second { (self.int64(168), 544) } else { (self.float32(108) as i64, 352) };
        match u64::try_from(given).ok()? {
            // Some writers leave vox_offset at 0.
            0 if !self.is_of_a_pair() => Some(behind),
            first => Some(first),
        }
    }

    /// Slope and intercept; `None` if numbers are values.
    pub fn rescale(&self) -> Option<(f64, f64)> {
        let [slope, intercept] = self.floats(112, 176);
        (slope != 0.0 && slope.is_finite() && intercept.is_finite()).then_some((slope, intercept))
    }

    /// Codes of the quaternion and the matrix transform; 0 if undefined.
    pub fn codes(&self) -> [i32; 2] {
        if self.second { [self.int32(344), self.int32(348)] } else { [self.int16(252).into(), self.int16(254).into()] }
    }

    /// Components b, c, d of a unit quaternion, and the origin.
    pub fn quaternion(&self) -> [f64; 6] {
        self.floats(256, 352)
    }

    /// Rows of the matrix transform.
    pub fn rows(&self) -> [f64; 12] {
        self.floats(280, 400)
    }
}
