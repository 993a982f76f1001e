//! Slices.

use crate::argument::{Argument, extract};
use crate::device_volume::DeviceVolume;
use crate::errors::{Failure, Refusal, Result, conflict};
use crate::names::Size;
use crate::pickled::{Reduced, reduced};
use crate::renderer::Renderer;
use crate::volume::Volume;
use layersplat::glam::DVec3;
use layersplat::slice::{Slice as Ours, SliceAxis, SliceColors};
use layersplat::volume::Grid;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A rectangle of a plane through a volume, in world coordinates (x, y, z). Drawn by Renderer.slice and Renderer.slice_values.
///
/// centre: the point at the centre of the picture. right: direction that points right in the picture; its length does not matter. up: any
/// vector that points up in the picture. scale: half the picture's height in world units.
///
/// Raises InvalidValue if these span no plane.
#[pyclass(frozen, module = "layersplat")]
pub struct Slice(Ours);

impl Slice {
    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// The grid of a Volume, a DeviceVolume or a Renderer.
fn grid(of: &Bound<PyAny>) -> Result<Grid> {
    if let Ok(volume) = of.cast::<Volume>() {
        Ok(volume.get().ours().grid().clone())
    } else if let Ok(volume) = of.cast::<DeviceVolume>() {
        Ok(volume.get().ours().description().grid().clone())
    } else if let Ok(renderer) = of.cast::<Renderer>() {
        renderer.get().grid(of.py())
    } else {
        let message = "of is neither a layersplat.Volume nor a layersplat.DeviceVolume nor a layersplat.Renderer".into();
        Err(Failure::Refused { class: Refusal::Type, message, field: "of" })
    }
}

/// Colours of a slice: a window of grey, or those of the transfer function.
///
/// # Errors
/// If both are given.
pub fn colors(window: Option<(f64, f64)>, thickness: Option<f64>) -> Result<SliceColors> {
    match (window, thickness) {
        (Some(_), Some(_)) => Err(conflict("thickness", "it is that of colours, and window is grey: omit one of them")),
        (Some((level, width)), None) => Ok(SliceColors::Window { level, width }),
        (None, Some(thickness)) => Ok(SliceColors::Transfer { thickness }),
        (None, None) => Ok(SliceColors::TRANSFER),
    }
}

#[pymethods]
impl Slice {
    #[new]
    fn new(centre: Argument<[f64; 3]>, right: Argument<[f64; 3]>, up: Argument<[f64; 3]>, scale: Argument<f64>) -> Result<Self> {
        extract!(centre, right, up, scale);
        let slice = Ours { centre: centre.into(), right: right.into(), up: up.into(), scale };
        slice.basis()?;
        Ok(Self(slice))
    }

    /// The slice perpendicular to an axis; it shows the whole volume.
    ///
    /// of: a Volume, DeviceVolume or Renderer. size: (width, height) of the picture in pixels, or one number for both. axis: x, y or z,
    /// seen along that axis of the voxels, or axial, coronal or sagittal, if the volume states how the patient lies; by default axial if it
    /// does, else z. at: number of a slice of voxels along x, y or z, from 0, or any number between two; otherwise the world coordinate
    /// along the axis; by default the middle. point: a world point in the slice and at the centre of the picture, instead of at.
    #[staticmethod]
    #[pyo3(signature = (of, size, axis = None, at = None, *, point = None))]
    fn at(
        of: &Bound<PyAny>,
        size: Argument<Size>,
        axis: Option<Argument<String>>,
        at: Option<Argument<f64>>,
        point: Option<Argument<[f64; 3]>>,
    ) -> Result<Self> {
        extract!(size, axis, at, point);
        let (grid, viewport) = (grid(of)?, size.viewport()?);
        let axis = axis.map_or(Ok(SliceAxis::three(&grid)[0]), |name| name.parse())?;
        match (at, point) {
            (Some(_), Some(_)) => Err(conflict("point", "it says where the slice lies, as at does: omit one of them")),
            (None, Some(point)) => {
                let point = DVec3::from(point);
                let slice = Ours { centre: point, ..Ours::through(&grid, axis, point, viewport)? };
                slice.basis()?;
                Ok(Self(slice))
            }
            (at, None) => {
                let (lo, hi) = axis.range(&grid)?;
                Ok(Self(Ours::at(&grid, axis, at.unwrap_or((lo + hi) / 2.0), viewport)?))
            }
        }
    }

    /// The slice through a world point that is seen from where normal points; up points up as far as possible. It shows the whole section
    /// through the volume. of, size: see at.
    #[staticmethod]
    #[pyo3(
        signature = (of, size, point, normal, up = Argument::Default([0.0, 1.0, 0.0])),
        text_signature = "(of, size, point, normal, up=(0.0, 1.0, 0.0))"
    )]
    fn facing(
        of: &Bound<PyAny>,
        size: Argument<Size>,
        point: Argument<[f64; 3]>,
        normal: Argument<[f64; 3]>,
        up: Argument<[f64; 3]>,
    ) -> Result<Self> {
        extract!(size, point, normal, up);
        Ok(Self(Ours::facing(&grid(of)?, point.into(), normal.into(), up.into(), size.viewport()?)?))
    }

    /// The point at the centre of the picture.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.0.centre.into()
    }

    /// Direction that points right in the picture.
    #[getter]
    fn right(&self) -> (f64, f64, f64) {
        self.0.right.into()
    }

    /// A vector that points up in the picture.
    #[getter]
    fn up(&self) -> (f64, f64, f64) {
        self.0.up.into()
    }

    /// Half the picture's height in world units.
    #[getter]
    fn scale(&self) -> f64 {
        self.0.scale
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let arguments = PyDict::new(py);
        arguments.set_item("centre", self.centre())?;
        arguments.set_item("right", self.right())?;
        arguments.set_item("up", self.up())?;
        arguments.set_item("scale", self.scale())?;
        reduced::<Self>(py, arguments)
    }

    fn __repr__(&self) -> String {
        let Ours { centre, scale, .. } = self.0;
        format!("<layersplat.Slice through {centre}, {} high>", 2.0 * scale)
    }
}
