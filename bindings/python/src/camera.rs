//! Cameras, and the outline that they fit.

use crate::calls::abandonable;
use crate::errors::{Result, conflict, out_of_range};
use crate::given::{Given, given};
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

/// Where a picture is seen from, in world coordinates (x, y, z).
///
/// position: the eye, of which in a parallel view only the direction counts. focal_point: in the middle of the picture. view_up: any vector
/// that is up on the screen. scale: half the picture's height in world units, of a parallel view; or field_of_view: vertical, degrees between
/// 0 and 180, of a perspective.
///
/// Raises InvalidValue where these show nothing.
#[pyclass(frozen, module = "layersplat")]
pub struct Camera(Ours);

impl Camera {
    pub fn ours(&self) -> &Ours {
        &self.0
    }
}

/// The one of both that is given.
fn projection(scale: Option<f64>, field_of_view: Option<f64>) -> Result<Projection> {
    match (scale, field_of_view) {
        (Some(scale), None) => Ok(Projection::Parallel { scale }),
        (None, Some(field_of_view)) => Ok(Projection::Perspective { field_of_view }),
        _ => Err(conflict("scale", "give either scale, of a parallel view, or field_of_view, of a perspective")),
    }
}

/// A camera of the same place that sees `zoom` times less of it, that larger.
fn zoomed(camera: Ours, zoom: f64) -> Result<Camera> {
    if !(zoom > 0.0 && zoom.is_finite()) {
        return Err(out_of_range("zoom", zoom, "a finite number above 0"));
    }
    let projection = match camera.projection {
        Projection::Parallel { scale } => Projection::Parallel { scale: scale / zoom },
        // Without a zoom it stays to the bit what it was.
        Projection::Perspective { .. } if zoom == 1.0 => camera.projection,
        Projection::Perspective { field_of_view } => {
            let half = (field_of_view.to_radians() / 2.0).tan() / zoom;
            Projection::Perspective { field_of_view: 2.0 * half.atan().to_degrees() }
        }
    };
    Ok(Camera(Ours { projection, ..camera }))
}

/// Refuses a field of view that no camera has, before it is fitted.
fn checked(field_of_view: Option<f64>) -> Result<Option<f64>> {
    match field_of_view {
        Some(fov) if !(fov > 0.0 && fov < 180.0) => {
            Err(out_of_range("field_of_view", fov, "degrees between 0 and 180, exclusive"))
        }
        fine => Ok(fine),
    }
}

/// A camera in which a whole grid fits from all sides.
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
        signature = (position, focal_point, view_up = Given::Default([0.0, 1.0, 0.0]), *, scale = None, field_of_view = None),
        text_signature = "(position, focal_point, view_up=(0.0, 1.0, 0.0), *, scale=None, field_of_view=None)"
    )]
    fn new(
        position: Given<[f64; 3]>,
        focal_point: Given<[f64; 3]>,
        view_up: Given<[f64; 3]>,
        scale: Option<Given<f64>>,
        field_of_view: Option<Given<f64>>,
    ) -> Result<Self> {
        given!(position, focal_point, view_up, scale, field_of_view);
        let projection = projection(scale, field_of_view)?;
        let camera = Ours { position: position.into(), focal_point: focal_point.into(), view_up: view_up.into(), projection };
        camera.basis()?;
        Ok(Self(camera))
    }

    /// A camera at a distance from a centre, looking at it. azimuth: degrees about y, 0 looks along −z; elevation: above the xz plane; roll:
    /// about the view.
    #[staticmethod]
    #[pyo3(
        signature = (
            centre, distance, *, azimuth = Given::Default(0.0), elevation = Given::Default(0.0), roll = Given::Default(0.0), scale = None,
            field_of_view = None,
        ),
        text_signature = "(centre, distance, *, azimuth=0.0, elevation=0.0, roll=0.0, scale=None, field_of_view=None)"
    )]
    fn orbit(
        centre: Given<[f64; 3]>,
        distance: Given<f64>,
        azimuth: Given<f64>,
        elevation: Given<f64>,
        roll: Given<f64>,
        scale: Option<Given<f64>>,
        field_of_view: Option<Given<f64>>,
    ) -> Result<Self> {
        given!(centre, distance, azimuth, elevation, roll, scale, field_of_view);
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

    /// The point in the middle of the picture.
    #[getter]
    fn focal_point(&self) -> (f64, f64, f64) {
        self.0.focal_point.into()
    }

    /// A vector that is up.
    #[getter]
    fn view_up(&self) -> (f64, f64, f64) {
        self.0.view_up.into()
    }

    /// Half the picture's height in world units; None of a perspective.
    #[getter]
    fn scale(&self) -> Option<f64> {
        match self.0.projection {
            Projection::Parallel { scale } => Some(scale),
            Projection::Perspective { .. } => None,
        }
    }

    /// Vertical, in degrees; None of a parallel view.
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

/// The outline of what is visible of a volume.
#[pyclass(frozen, module = "layersplat")]
pub struct Framing(OurFraming);

#[pymethods]
impl Framing {
    /// What a picture with these settings shows: what is visible through the transfer function, an iso-surface, or all voxels; of these, what
    /// lies in the crop box. It looks at all voxels.
    #[staticmethod]
    #[pyo3(signature = (volume, transfer, settings = None))]
    fn of(
        py: Python,
        volume: Given<Bound<Volume>>,
        transfer: Given<Bound<TransferFunction>>,
        settings: Option<Given<Bound<Settings>>>,
    ) -> Result<Self> {
        given!(volume, transfer, settings);
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

    /// All voxels.
    #[staticmethod]
    fn whole(volume: Given<Bound<Volume>>) -> Result<Self> {
        given!(volume);
        Ok(Self(OurFraming::whole(volume.get().ours())))
    }

    /// World position (x, y, z) of its middle.
    #[getter]
    fn centre(&self) -> (f64, f64, f64) {
        self.0.centre().into()
    }

    /// A camera that it fits from a side, with a small margin; zoom: how many times larger it is seen then.
    ///
    /// size: (width, height) in pixels, or one number of both. field_of_view: vertical, degrees, of a perspective. centre: a world point for
    /// the middle of the picture.
    #[pyo3(
        signature = (
            size, *, azimuth = Given::Default(0.0), elevation = Given::Default(0.0), roll = Given::Default(0.0),
            zoom = Given::Default(1.0), field_of_view = None, centre = None,
        ),
        text_signature = "($self, size, *, azimuth=0.0, elevation=0.0, roll=0.0, zoom=1.0, field_of_view=None, centre=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Each is named where it is given.
    fn camera(
        &self,
        size: Given<Size>,
        azimuth: Given<f64>,
        elevation: Given<f64>,
        roll: Given<f64>,
        zoom: Given<f64>,
        field_of_view: Option<Given<f64>>,
        centre: Option<Given<[f64; 3]>>,
    ) -> Result<Camera> {
        given!(size, azimuth, elevation, roll, zoom, field_of_view, centre);
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
