//! Cameras and framing.

use crate::argument::{Argument, extract};
use crate::calls::abandonable;
use crate::errors::{Result, conflict, out_of_range};
use crate::names::{Size, orbit};
use crate::pickled::{Reduced, reduced};
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use layersplat::framing::{Fixed, Framing as OurFraming};
use layersplat::glam::DVec3;
use layersplat::settings::{Blend, CropBox};
use layersplat::volume::Grid;
use layersplat::{Camera as Ours, Orbit, Projection, Settings as OurSettings, Viewport};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A camera in world coordinates (x, y, z).
///
/// position: the eye; a parallel view uses only its direction. focal_point: the point at the centre of the picture. view_up: any vector
/// that points up on the screen. Exactly one of: scale, half the picture's height in world units, for a parallel view; field_of_view,
/// the vertical angle between 0 and 180 degrees, for a perspective.
///
/// Raises InvalidValue if there is no valid view.
#[pyclass(frozen, module = "layersplat")]
pub struct Camera(Ours);

impl Camera {
    pub fn from_library(camera: Ours) -> Self {
        Self(camera)
    }

    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// The projection that exactly one of the arguments selects.
fn projection(scale: Option<f64>, field_of_view: Option<f64>) -> Result<Projection> {
    match (scale, field_of_view) {
        (Some(scale), None) => Ok(Projection::Parallel { scale }),
        (None, Some(field_of_view)) => Ok(Projection::Perspective { field_of_view }),
        _ => Err(conflict("scale", "give either scale, for a parallel view, or field_of_view, for a perspective")),
    }
}

/// The same camera with the picture magnified by `zoom`.
fn zoomed(camera: Ours, zoom: f64) -> Result<Camera> {
    if !(zoom > 0.0 && zoom.is_finite()) {
        return Err(out_of_range("zoom", zoom, "a finite number above 0"));
    }
    let projection = match camera.projection {
        Projection::Parallel { scale } => Projection::Parallel { scale: scale / zoom },
        // Avoids rounding without a zoom.
        Projection::Perspective { .. } if zoom == 1.0 => camera.projection,
        Projection::Perspective { field_of_view } => {
            let half = (field_of_view.to_radians() / 2.0).tan() / zoom;
            Projection::Perspective { field_of_view: 2.0 * half.atan().to_degrees() }
        }
    };
    Ok(Camera(Ours { projection, ..camera }))
}

/// Rejects an invalid field of view before fitting.
fn checked(field_of_view: Option<f64>) -> Result<Option<f64>> {
    match field_of_view {
        Some(fov) if !(fov > 0.0 && fov < 180.0) => {
            Err(out_of_range("field_of_view", fov, "degrees between 0 and 180, exclusive"))
        }
        valid => Ok(valid),
    }
}

/// A camera that shows the whole grid from all sides.
pub fn around(grid: &Grid, viewport: Viewport, orbit: Orbit, zoom: f64, field_of_view: Option<f64>) -> Result<Camera> {
    let (centre, diagonal) = (grid.centre(), grid.diagonal());
    let camera = match checked(field_of_view)? {
        None => Ours::fit_parallel(centre, diagonal, viewport, orbit),
        Some(fov) => Ours::fit_perspective(centre, diagonal, fov, viewport, orbit),
    };
    zoomed(camera, zoom)
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(
        signature = (position, focal_point, view_up = Argument::Default([0.0, 1.0, 0.0]), *, scale = None, field_of_view = None),
        text_signature = "(position, focal_point, view_up=(0.0, 1.0, 0.0), *, scale=None, field_of_view=None)"
    )]
    fn new(
        position: Argument<[f64; 3]>,
        focal_point: Argument<[f64; 3]>,
        view_up: Argument<[f64; 3]>,
        scale: Option<Argument<f64>>,
        field_of_view: Option<Argument<f64>>,
    ) -> Result<Self> {
        extract!(position, focal_point, view_up, scale, field_of_view);
        let projection = projection(scale, field_of_view)?;
        let camera = Ours { position: position.into(), focal_point: focal_point.into(), view_up: view_up.into(), projection };
        camera.basis()?;
        Ok(Self(camera))
    }

    /// A camera at a distance from a centre, looking at it. Angles in degrees: azimuth about y, 0 looks along −z; elevation above the xz
    /// plane; roll about the view direction.
    #[staticmethod]
    #[pyo3(
        signature = (
            centre, distance, *, azimuth = Argument::Default(0.0), elevation = Argument::Default(0.0), roll = Argument::Default(0.0), scale = None,
            field_of_view = None,
        ),
        text_signature = "(centre, distance, *, azimuth=0.0, elevation=0.0, roll=0.0, scale=None, field_of_view=None)"
    )]
    fn orbit(
        centre: Argument<[f64; 3]>,
        distance: Argument<f64>,
        azimuth: Argument<f64>,
        elevation: Argument<f64>,
        roll: Argument<f64>,
        scale: Option<Argument<f64>>,
        field_of_view: Option<Argument<f64>>,
    ) -> Result<Self> {
        extract!(centre, distance, azimuth, elevation, roll, scale, field_of_view);
        let orbit = orbit(azimuth, elevation, roll)?;
        let camera = Ours::orbit(centre.into(), distance, orbit, projection(scale, field_of_view)?);
        camera.basis()?;
        Ok(Self(camera))
    }

    /// The eye.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    /// The point at the centre of the picture.
    #[getter]
    fn focal_point(&self) -> (f64, f64, f64) {
        self.0.focal_point.into()
    }

    /// A vector that points up on the screen.
    #[getter]
    fn view_up(&self) -> (f64, f64, f64) {
        self.0.view_up.into()
    }

    /// Half the picture's height in world units; None for a perspective.
    #[getter]
    fn scale(&self) -> Option<f64> {
        match self.0.projection {
            Projection::Parallel { scale } => Some(scale),
            Projection::Perspective { .. } => None,
        }
    }

    /// Vertical field of view in degrees; None for a parallel view.
    #[getter]
    fn field_of_view(&self) -> Option<f64> {
        match self.0.projection {
            Projection::Parallel { .. } => None,
            Projection::Perspective { field_of_view } => Some(field_of_view),
        }
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let arguments = PyDict::new(py);
        arguments.set_item("position", self.position())?;
        arguments.set_item("focal_point", self.focal_point())?;
        arguments.set_item("view_up", self.view_up())?;
        arguments.set_item("scale", self.scale())?;
        arguments.set_item("field_of_view", self.field_of_view())?;
        reduced::<Self>(py, arguments)
    }

    fn __repr__(&self) -> String {
        let Ours { position, focal_point, .. } = self.0;
        format!("<layersplat.Camera at {position} looking at {focal_point}>")
    }
}

/// The outline of the visible part of a volume, to which cameras are fitted.
#[pyclass(frozen, module = "layersplat")]
pub struct Framing(OurFraming);

impl Framing {
    pub fn from_library(framing: OurFraming) -> Self {
        Self(framing)
    }
}

#[pymethods]
impl Framing {
    /// The framing of what these settings show: voxels that the transfer function makes visible, the iso-surface, or all voxels, each
    /// restricted to the crop box. Scans all voxels.
    #[staticmethod]
    #[pyo3(signature = (volume, transfer, settings = None))]
    fn of(
        py: Python,
        volume: Argument<Bound<Volume>>,
        transfer: Argument<Bound<TransferFunction>>,
        settings: Option<Argument<Bound<Settings>>>,
    ) -> Result<Self> {
        extract!(volume, transfer, settings);
        let settings = settings.map_or_else(OurSettings::default, |settings| *settings.get().ours());
        let (volume, transfer) = (volume.get().ours(), transfer.get().ours());
        let (shared, transfer) = (volume.clone(), transfer.clone());
        let framing = abandonable(py, move || {
            Ok(match settings.blend {
                Blend::Composite => OurFraming::visible(&shared, &transfer, settings.unit_distance),
                Blend::Iso(value) => OurFraming::iso(&shared, value),
                _ => OurFraming::whole(&shared),
            })
        })?;
        Ok(Self(match settings.clipping.crop {
            Some(CropBox { lowest, highest }) => framing.cropped(volume.grid(), lowest, highest),
            None => framing,
        }))
    }

    /// The framing of the whole volume.
    #[staticmethod]
    fn whole(volume: Argument<Bound<Volume>>) -> Result<Self> {
        extract!(volume);
        Ok(Self(OurFraming::whole(volume.get().ours())))
    }

    /// The framing of both, such as two channels.
    fn joined(&self, other: Argument<Bound<Self>>) -> Result<Self> {
        extract!(other);
        Ok(Self(self.0.clone().joined(other.get().0.clone())))
    }

    /// World position (x, y, z) of its centre.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.0.centre().into()
    }

    /// A camera that fits the framing with a small margin. zoom: magnification relative to the fit.
    ///
    /// size: (width, height) in pixels, or one number for both. azimuth, elevation, roll: degrees, see Camera.orbit. field_of_view: the
    /// vertical angle of a perspective in degrees. centre: the world point at the centre of the picture.
    #[pyo3(
        signature = (
            size, *, azimuth = Argument::Default(0.0), elevation = Argument::Default(0.0), roll = Argument::Default(0.0),
            zoom = Argument::Default(1.0), field_of_view = None, centre = None,
        ),
        text_signature = "($self, size, *, azimuth=0.0, elevation=0.0, roll=0.0, zoom=1.0, field_of_view=None, centre=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn camera(
        &self,
        size: Argument<Size>,
        azimuth: Argument<f64>,
        elevation: Argument<f64>,
        roll: Argument<f64>,
        zoom: Argument<f64>,
        field_of_view: Option<Argument<f64>>,
        centre: Option<Argument<[f64; 3]>>,
    ) -> Result<Camera> {
        extract!(size, azimuth, elevation, roll, zoom, field_of_view, centre);
        let (viewport, orbit) = (size.viewport()?, orbit(azimuth, elevation, roll)?);
        if let Some(centre) = centre.filter(|centre| !centre.iter().all(|x| x.is_finite())) {
            return Err(out_of_range("centre", format!("{centre:?}"), "three finite numbers"));
        }
        let fixed = Fixed { centre: centre.map(DVec3::from), ..Fixed::default() };
        let camera = match checked(field_of_view)? {
            None => self.0.parallel(orbit, viewport, fixed),
            Some(fov) => self.0.perspective(orbit, viewport, fov, fixed),
        };
        zoomed(camera, zoom)
    }
}
