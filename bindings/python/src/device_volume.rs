//! Volumes in buffers on a device.

use crate::device::Device;
use crate::errors::{Result, unknown};
use crate::given::{Given, given, refused};
use crate::handles::{events, memory};
use crate::names::voxel_type;
use crate::volume::{Affine, grid};
use crate::warned::{warn, warned};
use layersplat::renderer::{DeviceVoxels, UploadedVolume};
use layersplat::volume::Description;
use pyo3::prelude::*;

/// A volume whose voxels stay in a buffer of the caller's.
///
/// The buffer is retained, and the Python object too: a memory pool gives a buffer to others as soon as its object is gone. Both are held
/// as long as this volume or a renderer of it lives.
///
/// device: whose context the buffer is of. buffer: an object with int_ptr (pyopencl.Buffer) or a number. shape: (z, y, x). dtype: uint8, int8,
/// uint16, int16 or float32. spacing: one number or (z, y, x). first: byte of the first voxel. pitches: bytes from row to row and from layer
/// to layer. range: (smallest, largest) value, a promise; None: they are looked for, which waits until that is done, after wait_for.
/// background: the value around the volume, the smallest by default. name: shown in messages.
///
/// Voxels may change from frame to frame if every renderer is told so (Renderer.volume_changed).
///
/// Raises InvalidValue where the buffer is too small, of another context, or written only.
#[pyclass(frozen, module = "layersplat")]
pub struct DeviceVolume {
    ours: UploadedVolume,
    /// What the voxels belong to.
    owner: Py<PyAny>,
}

impl DeviceVolume {
    pub fn ours(&self) -> &UploadedVolume {
        &self.ours
    }

    /// The Python object that the voxels belong to.
    pub fn owner(&self) -> &Py<PyAny> {
        &self.owner
    }
}

#[pymethods]
impl DeviceVolume {
    #[new]
    #[pyo3(
        signature = (
            device, buffer, shape, dtype, *, spacing = None, first = Given::Default(0), pitches = None, range = None, background = None,
            wait_for = None, name = Given::Default("buffer".into()),
        ),
        text_signature = "(device, buffer, shape, dtype, *, spacing=None, first=0, pitches=None, range=None, background=None, \
            wait_for=None, name='buffer')"
    )]
    #[allow(clippy::too_many_arguments)] // Each is named where it is given.
    fn new(
        py: Python,
        device: Given<Bound<Device>>,
        buffer: &Bound<PyAny>,
        shape: Given<[usize; 3]>,
        dtype: &Bound<PyAny>,
        spacing: Option<&Bound<PyAny>>,
        first: Given<usize>,
        pitches: Option<Given<(usize, usize)>>,
        range: Option<Given<(f64, f64)>>,
        background: Option<Given<f64>>,
        wait_for: Option<Given<Vec<Bound<PyAny>>>>,
        name: Given<String>,
    ) -> Result<Self> {
        given!(device, shape, first, pitches, range, background, wait_for, name);
        let affine: Affine = py.import("layersplat._arrays")?.call_method1("axes", (spacing,))?.extract()?;
        let dtype = py.import("numpy")?.call_method1("dtype", (dtype,)).map_err(|error| {
            let accepted = "a type of numpy's: uint8, int8, uint16, int16 or float32";
            refused("dtype", dtype, error, accepted)
        })?;
        if !dtype.getattr("isnative")?.extract::<bool>()? {
            return Err(unknown("type of voxels", &dtype.str()?.to_string(), "the device's own byte order"));
        }
        let (voxel_type, grid) = (voxel_type(&dtype.str()?.to_string())?, grid(shape, affine)?);
        let mut voxels = DeviceVoxels::new(&memory("buffer", buffer)?, voxel_type).with_first(first);
        if let Some((row, slice)) = pitches {
            voxels = voxels.with_pitches(row, slice);
        }
        let (wait, device) = (events(wait_for)?, device.get().ours().clone());
        let (volume, warnings) = warned(py, move || {
            let description = match range {
                Some(range) if voxel_type == layersplat::volume::VoxelType::Float32 => {
                    // Who says the range of floats has not said that all of them are numbers.
                    Description::new(name, grid, voxel_type, range)?.with_invalid_voxels()
                }
                Some(range) => Description::new(name, grid, voxel_type, range)?,
                None => voxels.describe(&device, name, grid, &wait.iter().collect::<Vec<_>>())?,
            };
            let description = match background {
                Some(value) => description.with_background(value)?,
                None => description,
            };
            Ok(UploadedVolume::in_place(&device, &description, &voxels)?)
        })?;
        warn(py, warnings)?;
        Ok(Self { ours: volume, owner: buffer.clone().unbind() })
    }

    /// Voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.ours.description().grid().dims();
        (z, y, x)
    }

    /// Type of the voxels.
    #[getter]
    fn dtype(&self) -> String {
        self.ours.description().voxel_type().to_string()
    }

    /// Distance of voxels along x, y, z.
    #[getter]
    fn spacing(&self) -> (f64, f64, f64) {
        self.ours.description().grid().spacing().into()
    }

    /// World position (x, y, z) of the middle.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.ours.description().grid().centre().into()
    }

    /// Smallest and largest value.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.ours.description().range()
    }
}
