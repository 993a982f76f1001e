//! What users tell of a file.

use crate::error::Error;
use crate::volume::{Endian, Grid, ScalarType};
use glam::DVec3;

/// What a file, or a raw file's name, does not tell, or tells wrongly, and which of several volumes it is to be; what is given here wins.
/// Spacing defaults to 1,1,1.
///
/// ```
/// use layersplat::volume::{OpenOptions, ScalarType, Volume};
/// # let folder = tempfile::tempdir().expect("a folder");
/// # let path = folder.path().join("bonsai.raw");
/// # std::fs::write(&path, [0u8; 24]).expect("a file");
///
/// let options = OpenOptions { dims: Some([4, 3, 2]), voxel_type: Some(ScalarType::Uint8), ..OpenOptions::default() };
/// let volume = Volume::open(&path, &options)?;
/// assert_eq!(volume.grid().dims(), [4, 3, 2]);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Type of the numbers.
    pub voxel_type: Option<ScalarType>,
    /// World distance between voxels along x, y, z, along the world's axes, whatever a file says of its grid.
    pub spacing: Option<DVec3>,
    /// Byte order; little if it is not given.
    pub endian: Option<Endian>,
    /// Bytes before the first voxel, of a gzip file once unpacked; 0 if not given.
    pub header_bytes: Option<u64>,
    /// Which of several volumes, in formats that hold a sequence of them; the first if not given.
    pub frame: Option<usize>,
    /// Which of several numbers per voxel; the first if not given.
    pub channel: Option<usize>,
    /// Which of several arrays, by its name, in formats that name them; the one that the file marks, or the first, if not given.
    pub array: Option<String>,
    /// Which of several series of DICOM images in a folder: its number, its description or its identifier. An error if there are several
    /// and it is not given.
    pub series: Option<String>,
    /// Which of several resolutions, in formats that hold them; the finest that fits into half of the free memory if not given.
    pub level: Option<Level>,
    /// Bytes that voxels may take in memory where a file cannot be mapped as it is: larger ones are unpacked to a temporary file (in the
    /// system's folder for these, `TMPDIR`), which is mapped. As many as there are if not given.
    pub memory: Option<u64>,
}

/// Which of several resolutions of a volume.
///
/// ```
/// use layersplat::volume::{Level, OpenOptions};
///
/// // As many voxels as a picture of this width shows.
/// let options = OpenOptions { level: Some(Level::Pixels(1024)), ..OpenOptions::default() };
/// # assert_ne!(options, OpenOptions::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// By its number: 0 is the finest.
    Number(usize),
    /// The coarsest that has a voxel per pixel along every axis, in a picture of which the volume's longest side takes so many pixels; the
    /// finest if none has.
    Pixels(usize),
    /// The finest of which the voxels have no more bytes; the coarsest if all have. Where there is only one, that.
    Bytes(u64),
}

impl Level {
    /// Whether a volume of which there is only one resolution refuses it.
    pub(super) fn is_demanded(self) -> bool {
        !matches!(self, Self::Bytes(_))
    }
}

impl OpenOptions {
    /// The grid of `dims` with the wanted spacing.
    pub(in crate::volume) fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        Grid::new(dims, self.spacing.unwrap_or(DVec3::ONE))
    }
}
