//! Options for opening volumes.

use crate::error::Error;
use crate::volume::{Endian, Grid, ScalarType, VoxelBox};
use glam::{DMat3, DVec3};

/// Properties that a file does not declare, or declares wrongly, and the selection of one of several volumes in it. Fields that are set
/// override the file. The default spacing is 1, 1, 1.
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
    /// Number of voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Type of the stored numbers.
    pub voxel_type: Option<ScalarType>,
    /// World distance between voxels along x, y, z. Replaces the file's grid by an axis-aligned one at the origin.
    pub spacing: Option<DVec3>,
    /// World position of the first voxel.
    pub origin: Option<DVec3>,
    /// Spacing and origin of files that state no spacing, unless [`spacing`](Self::spacing) is set.
    pub unstated: Placement,
    /// Byte order; little-endian by default.
    pub endian: Option<Endian>,
    /// Bytes before the first voxel, after decompression; 0 by default.
    pub header_bytes: Option<u64>,
    /// Index of a volume in a sequence; 0 by default.
    pub frame: Option<usize>,
    /// Component (channel) of voxels with several numbers; 0 by default.
    pub channel: Option<usize>,
    /// Name of a component, in files that name them ([`ChannelDescription`](super::ChannelDescription)), instead of
    /// [`channel`](Self::channel).
    pub channel_name: Option<String>,
    /// Reads the magnitude of the components, their Euclidean norm, instead of one of them. Without it and without
    /// [`channel`](Self::channel), components that a file declares as a vector are read so, too: `VECTORS` and `NORMALS` of VTK, vectors of
    /// NRRD and NIfTI.
    pub magnitude: bool,
    /// Name of an array, in formats that name them. By default the one that the file marks as active, else the first.
    pub array: Option<String>,
    /// DICOM series in a folder: its number, description or identifier. Required if there are several.
    pub series: Option<String>,
    /// Resolution level, in multiresolution formats. By default the finest that fits into half of the available memory, and into
    /// [`download`](Self::download).
    pub level: Option<Level>,
    /// Part of the volume to read as if it were all, in voxels of the finest level; other levels have the voxels that cover it. Of Zarr.
    pub region: Option<VoxelBox>,
    /// Most bytes of voxels, unpacked, to read from a server for one volume; 2 GB by default. More are an error, unless a coarser level has
    /// fewer and none is chosen by its number.
    pub download: Option<u64>,
    /// Memory limit in bytes for voxels of files that cannot be mapped. Larger volumes are decompressed to a temporary file (in
    /// `TMPDIR` or the system's default folder), which is mapped. Unlimited by default.
    pub memory: Option<u64>,
    /// Takes chunks of Zarr that a server refuses (403) as not stored, and warns of their number: object stores answer so for missing files where
    /// they have no permission to list. By default they are an error.
    pub fills_refused: bool,
    /// Refuses a header that names files outside its own folder. For files of unknown origin, which could otherwise show any file of this
    /// machine. Refuses addresses, too.
    pub confined: bool,
}

/// Spacing and origin that are assumed of files which state none: several files of one scene share them.
///
/// ```
/// use layersplat::glam::DVec3;
/// use layersplat::volume::{OpenOptions, Placement, Volume};
/// # let folder = tempfile::tempdir().expect("a folder");
/// # let path = folder.path().join("mask.nrrd");
/// # let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 1\nencoding: raw\n\n";
/// # std::fs::write(&path, [header.as_bytes(), &[0, 7, 7, 12]].concat()).expect("a file");
///
/// let unstated = Placement { spacing: Some(DVec3::splat(0.5)), origin: None };
/// let volume = Volume::open(&path, &OpenOptions { unstated, ..OpenOptions::default() })?;
/// assert_eq!(volume.grid().spacing(), DVec3::splat(0.5));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// World distance between voxels along x, y, z; 1 by default.
    pub spacing: Option<DVec3>,
    /// World position of the first voxel; 0 by default.
    pub origin: Option<DVec3>,
}

impl Placement {
    /// The axis-aligned grid of `dims` voxels.
    ///
    /// # Errors
    /// As [`Grid::oriented`].
    pub(in crate::volume) fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        Grid::oriented(dims, self.spacing.unwrap_or(DVec3::ONE), self.origin.unwrap_or_default(), DMat3::IDENTITY)
    }
}

/// Selects one of several resolutions of a volume.
///
/// ```
/// use layersplat::volume::{Level, OpenOptions};
///
/// // As many voxels as a picture of this width can show.
/// let options = OpenOptions { level: Some(Level::Pixels(1024)), ..OpenOptions::default() };
/// # assert_ne!(options, OpenOptions::default());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Level number; 0 is the finest.
    Number(usize),
    /// The coarsest level with at least one voxel per pixel along every axis, if the longest side of the volume, or of its
    /// [`region`](OpenOptions::region), spans this many pixels.
    /// The finest level if none qualifies. Also accepted by formats with one resolution.
    Pixels(usize),
    /// The finest level with at most this many bytes of voxels, else the coarsest. Also accepted by formats with one resolution.
    Bytes(u64),
    /// The level that stands for all ([`Volume::overview`](crate::volume::Volume::overview)). Also accepted by formats with one resolution.
    Overview,
}

impl Level {
    /// Whether formats with a single resolution reject this selection.
    pub(super) fn is_demanded(self) -> bool {
        matches!(self, Self::Number(_))
    }
}

impl OpenOptions {
    /// Most bytes of voxels that are read from a server for one volume, unless [`download`](Self::download) says others.
    pub const DOWNLOAD: u64 = 2_000_000_000;

    /// Axis-aligned grid of `dims` voxels with the given spacing and origin.
    pub(in crate::volume) fn grid(&self, dims: [usize; 3]) -> Result<Grid, Error> {
        Placement { spacing: self.spacing, origin: self.origin }.grid(dims)
    }
}
