//! Volumes on the host.

use crate::argument::{Argument, extract};
use crate::arrays;
use crate::errors::{Result, unknown};
use crate::names::Channel;
use crate::warned::{warn, warned};
use layersplat::glam::{DAffine3, DMat3, DVec3};
use layersplat::volume::{Endian, Grid, Level, VoxelBox};
use layersplat::{OpenOptions, Volume as Ours};
use numpy::PyUntypedArray;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The columns of an affine transform from voxels (x, y, z) to world coordinates: three axes and the origin.
pub type Affine = [[f64; 3]; 4];

/// The grid of an array of shape (z, y, x) with a transform.
pub fn grid(shape: [usize; 3], [x, y, z, origin]: Affine) -> Result<Grid> {
    let axes = DMat3::from_cols(x.into(), y.into(), z.into());
    let dims = [shape[2], shape[1], shape[0]];
    Ok(Grid::from_affine(dims, DAffine3::from_mat3_translation(axes, origin.into()))?)
}

/// The library's options for opening files.
#[allow(clippy::too_many_arguments)] // Those of `open`.
pub fn opening(
    dims: Option<Argument<[usize; 3]>>,
    voxel_type: Option<Argument<String>>,
    spacing: Option<Argument<[f64; 3]>>,
    endian: Option<Argument<String>>,
    header_bytes: Option<Argument<u64>>,
    frame: Option<Argument<usize>>,
    channel: Option<Argument<Channel>>,
    array: Option<Argument<String>>,
    series: Option<Argument<String>>,
    level: Option<Argument<usize>>,
) -> Result<OpenOptions> {
    extract!(dims, voxel_type, spacing, endian, header_bytes, frame, channel, array, series, level);
    let endian = match endian.as_deref() {
        None => None,
        Some("little") => Some(Endian::Little),
        Some("big") => Some(Endian::Big),
        Some(other) => return Err(unknown("endian", other, "little or big")),
    };
    let voxel_type = voxel_type.as_deref().map(|name| {
        let known = "uint8, int8, uint16, int16, uint32, int32, uint64, int64, float16, float32 or float64";
        name.parse().map_err(|_| unknown("voxel_type", name, known))
    });
    let (voxel_type, spacing, level) = (voxel_type.transpose()?, spacing.map(DVec3::from), level.map(Level::Number));
    let options =
        OpenOptions { dims, voxel_type, spacing, endian, header_bytes, frame, array, series, level, ..OpenOptions::default() };
    Ok(channel.map_or(options.clone(), |channel| channel.chosen(options)))
}

/// A scalar volume: voxels, their grid in the world, and a background value.
///
/// Volume(data) takes an array (z, y, x), or an image of nibabel (x, y, z), SimpleITK, ITK or xarray.
///
/// data: integers, floats or booleans, of any strides and byte order. The volume keeps a copy, so the array may change afterwards.
/// Immutable memory is not copied: bytes (numpy.frombuffer), and files mapped read-only (numpy.memmap and numpy.load with mode "r"),
/// of uint8, int8, uint16, int16 or float32. Wider types are converted. Masked voxels, and floats that are NaN, infinite or beyond
/// ±1e30, count as background. spacing: voxel spacing in world units, above 0: one number, or one per axis in the order of the data's
/// axes. The default is 1, or the spacing of an image object. background: the value around the volume and of voxels without a value;
/// by default the smallest value. name: shown in messages.
///
/// Warns (DataWarning) about values that are NaN, infinite or beyond ±1e30, and about integers that 32-bit floats cannot distinguish.
/// Raises InvalidValue if data does not have three axes, has an unsupported type, or has a sheared grid.
#[pyclass(frozen, module = "layersplat")]
pub struct Volume(Ours<'static>);

impl Volume {
    pub fn ours(&self) -> &Ours<'static> {
        &self.0
    }

    pub fn from_library(volume: Ours<'static>) -> Self {
        Self(volume)
    }

    /// `Volume(data)`.
    pub fn from_data(data: &Bound<PyAny>) -> Result<Self> {
        Self::new(data, None, None, None)
    }
}

#[pymethods]
impl Volume {
    #[new]
    #[pyo3(signature = (data, spacing = None, *, background = None, name = None))]
    fn new(
        data: &Bound<PyAny>,
        spacing: Option<&Bound<PyAny>>,
        background: Option<Argument<f64>>,
        name: Option<Argument<String>>,
    ) -> Result<Self> {
        extract!(background, name);
        let py = data.py();
        let placed = py.import("layersplat._arrays")?.call_method1("placed", (data, spacing))?;
        let (array, affine, masked): (Bound<PyUntypedArray>, Affine, usize) = placed.extract()?;
        let shape = numpy::PyUntypedArrayMethods::shape(&array);
        let grid = grid([shape[0], shape[1], shape[2]], affine)?;
        let (volume, mut warnings) = arrays::volume(&array, name.as_deref().unwrap_or("array"), grid)?;
        if volume.invalid() == masked {
            // All of these were masked on purpose.
            warnings.retain(|text| !text.contains("count as the background"));
        }
        warn(py, warnings)?;
        Ok(Self(match background {
            Some(value) => volume.with_background(value)?,
            None => volume,
        }))
    }

    /// Zeros on a coarse grid around a box.
    #[staticmethod]
    fn _around(lowest: [f64; 3], highest: [f64; 3]) -> Result<Self> {
        let grid = Grid::around(lowest.into(), highest.into())?;
        let voxels = vec![0u8; grid.voxel_count()];
        Ok(Self(Ours::new("surfaces", grid, voxels)?))
    }

    /// Opens a file, or builtin:marschner-lobb, builtin:hydrogen or builtin:cube with @N or @XxYxZ.
    ///
    /// dims: number of voxels along x, y, z. voxel_type, endian (little or big), header_bytes: properties of a raw file that its name
    /// does not contain. spacing: along x, y, z. background: as for Volume(data). frame: index of one of several volumes; VolumeSequence opens
    /// all. channel: index of one of several components per voxel, or
    /// "magnitude", which is the default for those that a file declares as a vector. array: a dataset, by name or path. series: a DICOM series in a folder.
    /// level: resolution level, 0 is the finest. region: ((x0, x1), (y0, y1), (z0, z1)), the part of a Zarr to read as if it were all, in
    /// voxels of level 0, without the last ones. Of URLs: download, the most bytes of voxels, 2 GB by default; missing: chunks that the server
    /// refuses are an error ("refuse"), or not stored ("fill").
    #[staticmethod]
    #[pyo3(signature = (
        path, *, dims = None, voxel_type = None, spacing = None, endian = None, header_bytes = None, background = None, frame = None,
        channel = None, array = None, series = None, level = None, region = None, download = None, missing = None,
    ))]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn open(
        py: Python,
        path: Argument<PathBuf>,
        dims: Option<Argument<[usize; 3]>>,
        voxel_type: Option<Argument<String>>,
        spacing: Option<Argument<[f64; 3]>>,
        endian: Option<Argument<String>>,
        header_bytes: Option<Argument<u64>>,
        background: Option<Argument<f64>>,
        frame: Option<Argument<usize>>,
        channel: Option<Argument<Channel>>,
        array: Option<Argument<String>>,
        series: Option<Argument<String>>,
        level: Option<Argument<usize>>,
        region: Option<Argument<[(usize, usize); 3]>>,
        download: Option<Argument<u64>>,
        missing: Option<Argument<String>>,
    ) -> Result<Self> {
        extract!(path, background, region, download, missing);
        let options = opening(dims, voxel_type, spacing, endian, header_bytes, frame, channel, array, series, level)?;
        let region = region.map(|sides| {
            let dims = sides.map(|(first, end)| end.saturating_sub(first));
            VoxelBox { first: sides.map(|(first, _)| first), dims }
        });
        let fills_refused = match missing.as_deref() {
            None | Some("refuse") => false,
            Some("fill") => true,
            Some(other) => return Err(unknown("missing", other, "refuse or fill")),
        };
        let options = OpenOptions { region, download, fills_refused, ..options };
        let (volume, warnings) = warned(py, move || Ok(Ours::open(path, &options)?))?;
        warn(py, warnings)?;
        Ok(Self(match background {
            Some(value) => volume.with_background(value)?,
            None => volume,
        }))
    }

    /// Number of voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.0.grid().dims();
        (z, y, x)
    }

    /// Voxel type on the device: uint8, int8, uint16, int16 or float32.
    #[getter]
    fn dtype(&self) -> String {
        self.0.voxel_type().to_string()
    }

    /// Voxel spacing along x, y, z, in world units.
    #[getter]
    fn spacing(&self) -> (f64, f64, f64) {
        self.0.grid().spacing().into()
    }

    /// World position (x, y, z) of voxel (0, 0, 0).
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.0.grid().origin().into()
    }

    /// World position (x, y, z) of the centre.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.0.grid().centre().into()
    }

    /// Smallest and largest value.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }

    /// The value around the volume and of voxels without a value.
    #[getter]
    fn background(&self) -> f64 {
        self.0.background()
    }

    /// Number of voxels without a value: NaN, infinite or beyond ±1e30.
    #[getter]
    fn invalid(&self) -> usize {
        self.0.invalid()
    }

    /// The name shown in messages.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    fn __repr__(&self) -> String {
        let ((z, y, x), (lo, hi)) = (self.shape(), self.0.range());
        let [lo, hi] = [lo, hi].map(|value| {
            if (1e-9..1e15).contains(&value.abs()) || value == 0.0 { value.to_string() } else { format!("{value:e}") }
        });
        format!("<layersplat.Volume {} of {z}x{y}x{x} (z, y, x) {}, {lo} to {hi}>", self.0.name(), self.0.voxel_type())
    }
}
