//! Volumes on the host.

use crate::arrays;
use crate::errors::{Result, unknown};
use crate::given::{Given, given};
use crate::warned::{warn, warned};
use layersplat::glam::{DAffine3, DMat3, DVec3};
use layersplat::volume::{Endian, Grid, Level};
use layersplat::{OpenOptions, Volume as Ours};
use numpy::PyUntypedArray;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Three axes and an origin in the world: the columns of a transform from voxels (x, y, z) to the world.
pub type Affine = [[f64; 3]; 4];

/// A grid of an array's shape, (z, y, x), and a transform.
pub fn grid(shape: [usize; 3], [x, y, z, origin]: Affine) -> Result<Grid> {
    let axes = DMat3::from_cols(x.into(), y.into(), z.into());
    let dims = [shape[2], shape[1], shape[0]];
    Ok(Grid::from_affine(dims, DAffine3::from_mat3_translation(axes, origin.into()))?)
}

/// A scalar volume: voxels, where they lie in the world, and what surrounds them.
///
/// A volume of an array (z, y, x), or of an image of nibabel (x, y, z), SimpleITK, ITK or xarray.
///
/// data: integers, floats or booleans, of any strides and byte order. The volume has a copy, so the array may change afterwards; memory that
/// nobody can write is not copied: bytes (numpy.frombuffer), and files mapped for reading only (numpy.memmap and numpy.load with mode "r"), of
/// uint8, int8, uint16, int16 or float32. Wider types are converted. Floats that are NaN, infinite or beyond ±1e30, and what
/// is masked, count as background. spacing: distance of voxels in world units, above 0: one number, or one per axis in the order of
/// the data's own axes; 1 by default, and of image objects their own. background: the value around the volume, and of voxels that have
/// none; the smallest by default. name: shown in messages.
///
/// Warns (DataWarning) of values that are NaN, infinite or beyond ±1e30, and of those that 32-bit floats cannot tell apart.
/// Raises InvalidValue where data has not three axes, or is of another type, or its grid is sheared.
#[pyclass(frozen, module = "layersplat")]
pub struct Volume(Ours<'static>);

impl Volume {
    pub fn ours(&self) -> &Ours<'static> {
        &self.0
    }

    /// What `Volume(data)` makes.
    pub fn of(data: &Bound<PyAny>) -> Result<Self> {
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
        background: Option<Given<f64>>,
        name: Option<Given<String>>,
    ) -> Result<Self> {
        given!(background, name);
        let py = data.py();
        let placed = py.import("layersplat._arrays")?.call_method1("placed", (data, spacing))?;
        let (array, affine, masked): (Bound<PyUntypedArray>, Affine, usize) = placed.extract()?;
        let shape = numpy::PyUntypedArrayMethods::shape(&array);
        let grid = grid([shape[0], shape[1], shape[2]], affine)?;
        let (volume, mut warnings) = arrays::volume(&array, name.as_deref().unwrap_or("array"), grid)?;
        if volume.invalid() == masked {
            // Whoever masks voxels expects it.
            warnings.retain(|text| !text.contains("count as the background"));
        }
        warn(py, warnings)?;
        Ok(Self(match background {
            Some(value) => volume.with_background(value)?,
            None => volume,
        }))
    }

    /// Opens a file, or builtin:marschner-lobb, builtin:hydrogen or builtin:cube with @N or @XxYxZ.
    ///
    /// dims: voxels along x, y, z. voxel_type, endian (little or big), header_bytes: what the name of a raw file does not tell. spacing: along
    /// x, y, z. frame, channel: which volume of several, which number of several per voxel. array: a dataset, by its name or path. series: of
    /// DICOM images in a folder. level: a resolution, 0 the finest.
    #[staticmethod]
    #[pyo3(signature = (
        path, *, dims = None, voxel_type = None, spacing = None, endian = None, header_bytes = None, background = None, frame = None,
        channel = None, array = None, series = None, level = None,
    ))]
    #[allow(clippy::too_many_arguments)] // Each is a field of a file whose name does not tell it, or a choice between what it holds.
    fn open(
        py: Python,
        path: Given<PathBuf>,
        dims: Option<Given<[usize; 3]>>,
        voxel_type: Option<Given<String>>,
        spacing: Option<Given<[f64; 3]>>,
        endian: Option<Given<String>>,
        header_bytes: Option<Given<u64>>,
        background: Option<Given<f64>>,
        frame: Option<Given<usize>>,
        channel: Option<Given<usize>>,
        array: Option<Given<String>>,
        series: Option<Given<String>>,
        level: Option<Given<usize>>,
    ) -> Result<Self> {
        given!(path, dims, voxel_type, spacing, endian, header_bytes, background, frame, channel, array, series, level);
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
        let voxel_type = voxel_type.transpose()?;
        let (spacing, level) = (spacing.map(DVec3::from), level.map(Level::Number));
        let options =
            OpenOptions { dims, voxel_type, spacing, endian, header_bytes, frame, channel, array, series, level, memory: None };
        let (volume, warnings) = warned(py, move || Ok(Ours::open(path, &options)?))?;
        warn(py, warnings)?;
        Ok(Self(match background {
            Some(value) => volume.with_background(value)?,
            None => volume,
        }))
    }

    /// Voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.0.grid().dims();
        (z, y, x)
    }

    /// Type of the voxels as they go to a device: uint8, int8, uint16, int16 or float32.
    #[getter]
    fn dtype(&self) -> String {
        self.0.voxel_type().to_string()
    }

    /// Distance of voxels along x, y, z, in world units.
    #[getter]
    fn spacing(&self) -> (f64, f64, f64) {
        self.0.grid().spacing().into()
    }

    /// World position (x, y, z) of voxel (0, 0, 0).
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.0.grid().origin().into()
    }

    /// World position (x, y, z) of the middle.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.0.grid().centre().into()
    }

    /// Smallest and largest value.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range()
    }

    /// The value around the volume, and of voxels that have none.
    #[getter]
    fn background(&self) -> f64 {
        self.0.background()
    }

    /// How many voxels have no value: NaN, infinite or beyond ±1e30.
    #[getter]
    fn invalid(&self) -> usize {
        self.0.invalid()
    }

    /// What it is called in messages.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    fn __repr__(&self) -> String {
        let ((z, y, x), (lo, hi)) = (self.shape(), self.0.range());
        format!("<layersplat.Volume {} of {z}x{y}x{x} (z, y, x) {}, {lo} to {hi}>", self.0.name(), self.0.voxel_type())
    }
}
