//! Volumes in buffers on a device.

use crate::argument::{Argument, extract, refused};
use crate::device::Device;
use crate::errors::{Failure, Refusal, Result, unknown};
use crate::handles::{events, memory};
use crate::names::voxel_type;
use crate::volume::{Affine, grid};
use crate::warned::{warn, warned};
use layersplat::renderer::{DeviceVoxels, UploadedVolume};
use layersplat::volume::Description;
use pyo3::prelude::*;

/// A volume whose voxels stay in a buffer of the caller on the device.
///
/// The buffer is retained, and so is its Python object: a memory pool reuses a buffer when its object is gone. Both are held as long
/// as this volume or one of its renderers exists.
///
/// device: a Device of the buffer's context. buffer: an object with int_ptr (pyopencl.Buffer) or an integer handle. shape: (z, y, x).
/// dtype: uint8, int8, uint16, int16 or float32. spacing: one number or (z, y, x), in world units. first: byte offset of the first
/// voxel. pitches: bytes from row to row and from slice to slice. range: (smallest, largest) value, which is not checked; None: it is
/// determined on the device after wait_for, and the constructor waits for it. background: the value around the volume, by default the
/// smallest. name: shown in messages.
///
/// Voxels may change between frames: call Renderer.volume_changed of every renderer.
///
/// Raises InvalidValue if the buffer is too small, belongs to another context, or is write-only.
#[pyclass(frozen, module = "layersplat")]
pub struct DeviceVolume {
    ours: UploadedVolume,
    /// The Python object that owns the voxels.
    owner: Py<PyAny>,
}

impl DeviceVolume {
    pub fn ours(&self) -> &UploadedVolume {
        &self.ours
    }

    /// The Python object that owns the voxels.
    pub fn owner(&self) -> &Py<PyAny> {
        &self.owner
    }
}

#[pymethods]
impl DeviceVolume {
    #[new]
    #[pyo3(
        signature = (
            device, buffer, shape, dtype, *, spacing = None, first = Argument::Default(0), pitches = None, range = None, background = None,
            wait_for = None, name = Argument::Default("buffer".into()),
        ),
        text_signature = "(device, buffer, shape, dtype, *, spacing=None, first=0, pitches=None, range=None, background=None, \
            wait_for=None, name='buffer')"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn new(
        py: Python,
        device: Argument<Bound<Device>>,
        buffer: &Bound<PyAny>,
        shape: Argument<[usize; 3]>,
        dtype: &Bound<PyAny>,
        spacing: Option<&Bound<PyAny>>,
        first: Argument<usize>,
        pitches: Option<Argument<(usize, usize)>>,
        range: Option<Argument<(f64, f64)>>,
        background: Option<Argument<f64>>,
        wait_for: Option<Argument<Vec<Bound<PyAny>>>>,
        name: Argument<String>,
    ) -> Result<Self> {
        extract!(device, shape, first, pitches, range, background, wait_for, name);
        let affine: Affine = py.import("layersplat._arrays")?.call_method1("axes", (spacing,))?.extract()?;
        let dtype = py.import("numpy")?.call_method1("dtype", (dtype,)).map_err(|error| {
            let accepted = "a numpy type: uint8, int8, uint16, int16 or float32";
            refused("dtype", dtype, error, accepted)
        })?;
        if !dtype.getattr("isnative")?.extract::<bool>()? {
            return Err(unknown("voxel type", &dtype.str()?.to_string(), "the device's own byte order"));
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
                    // A range of floats does not imply that all voxels are finite.
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

    /// Number of voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.ours.description().grid().dims();
        (z, y, x)
    }

    /// Voxel type.
    #[getter]
    fn dtype(&self) -> String {
        self.ours.description().voxel_type().to_string()
    }

    /// Voxel spacing along x, y, z, in world units.
    #[getter]
    fn spacing(&self) -> (f64, f64, f64) {
        self.ours.description().grid().spacing().into()
    }

    /// World position (x, y, z) of the centre.
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

pub fn is_pyopencl_array(volume: &Bound<PyAny>) -> PyResult<bool> {
    volume.hasattr("base_data")
}

/// Refuses voxels that are on a device already.
pub fn refuse_voxels_on_device(volume: &Bound<PyAny>) -> Result<()> {
    if !volume.is_instance_of::<DeviceVolume>() && !is_pyopencl_array(volume)? {
        return Ok(());
    }
    let given = volume.get_type().name()?;
    let message =
        format!("volume is of type {given}, with voxels on a device: make a new Renderer of it, or give an array on the host");
    Err(Failure::Refused { class: Refusal::Type, message, field: "volume" })
}
