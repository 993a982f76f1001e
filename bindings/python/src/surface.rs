//! Surfaces in and around volumes. `layersplat/_surfaces.py` makes arrays of what people have.

use crate::argument::{Argument, accepted, either, extract};
use crate::calls::abandonable;
use crate::camera::Framing;
use crate::errors::{Result, out_of_range};
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use crate::warned::{warn, warned};
use layersplat::framing::Framing as OurFraming;
use layersplat::glam::{DMat4, DVec3, Vec3};
use layersplat::surface::{
    DEFAULT_COLORS, Ends, Per, PointData, Radius, Shape, Space, Spheres, Surface as Ours, SurfaceFile, SurfaceOptions,
    SurfaceShading, Triangles, Tubes, default_radius,
};
use layersplat::{Choice, TransferFunction as Transfer};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::Borrowed;
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::path::PathBuf;

/// A Mesh, Spheres or Tubes: surfaces that Renderer.set_surfaces and render draw in and around a volume. World coordinates are (x, y, z).
///
/// These keywords of Mesh, Spheres, Tubes and replaced say how it looks. color: `#rrggbb` or (red, green, blue), 0 … 1, possibly with alpha;
/// by default light grey. opacity: 0 … 1, multiplies the alpha of colors. matrix: an array of 4 x 4 numbers that places it in the world;
/// spheres and tubes are not deformed. shading: smooth, which needs normals, flat or off. clip: whether the crop box and clip planes cut it.
/// visible: whether it is drawn. name: shown in messages.
#[pyclass(frozen, subclass, module = "layersplat")]
pub struct Surface(Ours);

impl Surface {
    pub fn ours(&self) -> &Ours {
        &self.0
    }

    /// An object of a Python class.
    fn of_class<'py>(self, class: &Bound<'py, PyType>) -> PyResult<Bound<'py, PyAny>> {
        let py = class.py();
        py.get_type::<Self>().getattr("__new__")?.call1((class, Bound::new(py, self)?))
    }
}

/// Colours of values.
enum Colors<'py> {
    Given(Bound<'py, TransferFunction>),
    Named(String),
}

accepted! {
    Vec<Bound<'py, Surface>>: "a list of layersplat.Mesh, Spheres and Tubes";
    Colors<'py>: "a layersplat.TransferFunction, or the name of a colour map";
    Size: "a number, or the name of an array";
}

impl<'a, 'py> FromPyObject<'a, 'py> for Colors<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        either(object, Colors::Given, Colors::Named)
    }
}

/// Colours, independent of Python.
enum Coloring {
    Given(Transfer),
    Named(String),
}

impl From<Colors<'_>> for Coloring {
    fn from(colors: Colors) -> Self {
        match colors {
            Colors::Given(transfer) => Self::Given(transfer.get().ours().clone()),
            Colors::Named(name) => Self::Named(name),
        }
    }
}

impl Coloring {
    fn of(self, values: &Per<f32>) -> std::result::Result<Transfer, layersplat::Error> {
        match self {
            Self::Given(transfer) => Ok(transfer),
            Self::Named(name) => values.colored_by(&name),
        }
    }
}

fn points(array: &PyReadonlyArray2<f64>) -> PyResult<Vec<DVec3>> {
    Ok(array.as_slice()?.chunks_exact(3).map(DVec3::from_slice).collect())
}

/// A radius per point: one for all, or each.
fn radii(radius: Option<PyReadonlyArray1<f64>>, points: &[DVec3]) -> PyResult<Vec<f64>> {
    Ok(match radius {
        None => vec![default_radius(points); points.len()],
        Some(radius) => match radius.as_slice()? {
            &[radius] => vec![radius; points.len()],
            radii => radii.to_vec(),
        },
    })
}

fn per<T>(entries: Vec<T>, of_cells: bool) -> Per<T> {
    if of_cells { Per::Cell(entries) } else { Per::Point(entries) }
}

#[pymethods]
impl Surface {
    #[new]
    fn new(surface: Argument<Bound<Self>>) -> Result<Self> {
        extract!(surface);
        Ok(Self(surface.get().0.clone()))
    }

    /// Opens a file: STL, PLY, OBJ, VTK PolyData, GIFTI or FreeSurfer, as a list: triangles as a Mesh, lines as Tubes, single points as Spheres, each if the file has
    /// them.
    ///
    /// data: a file of GIFTI or FreeSurfer with values or labels of the points, of which labels, else the first values, are shown. values: name
    /// of an array whose values are shown as colours. transfer: a TransferFunction or the name of a colour map, by default
    /// viridis over all values. radius: of tubes and spheres, a number or the name of an array of points; by default 1/200 of the diagonal of
    /// the bounds. ends: flat, open or round, of tubes. space: LPS or RAS, the axes of a patient, if the file states none. volume: a Volume;
    /// where it is a patient's, as those of NIfTI and DICOM files, coordinates that are known to be LPS are turned into its world.
    #[staticmethod]
    #[pyo3(
        signature = (
            path, *, data = None, values = None, transfer = None, radius = None, ends = Argument::Default("flat".into()), space = None, volume = None
        ),
        text_signature = "(path, *, data=None, values=None, transfer=None, radius=None, ends='flat', space=None, volume=None)"
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn open<'py>(
        py: Python<'py>,
        path: Argument<PathBuf>,
        data: Option<Argument<PathBuf>>,
        values: Option<Argument<String>>,
        transfer: Option<Argument<Colors>>,
        radius: Option<Argument<Size>>,
        ends: Argument<String>,
        space: Option<Argument<String>>,
        volume: Option<Argument<Bound<Volume>>>,
    ) -> Result<Vec<Bound<'py, PyAny>>> {
        extract!(path, data, values, transfer, radius, ends, space, volume);
        if transfer.is_some() && values.is_none() && data.is_none() {
            return Err(crate::errors::conflict(
                "transfer",
                "it colours values: name an array by values, or a file by data, too",
            ));
        }
        let coloring = transfer.map(Coloring::from);
        let options = SurfaceOptions {
            values,
            radius: radius.map(|radius| radius.0),
            ends: Ends::from_name(&ends)?,
            space: space.map(|name| Space::from_name(&name)).transpose()?,
            is_anatomical: volume.is_some_and(|volume| volume.get().ours().grid().has_anatomy()),
            ..SurfaceOptions::default()
        };
        let (surfaces, warnings) = warned(py, move || {
            let mut file = SurfaceFile::read(path)?;
            let data = data.map(|data| file.add(PointData::read(data)?)).transpose()?;
            let values = options.values.or(data.flatten());
            let transfer = match (coloring, &values) {
                (Some(coloring), Some(name)) => Some(coloring.of(&file.array(name)?.scalars())?),
                _ => None,
            };
            Ok(file.into_surfaces(&SurfaceOptions { values, transfer, ..options })?)
        })?;
        warn(py, warnings)?;
        let classes = py.import("layersplat._surfaces")?;
        let of_class = |surface: Ours| {
            let name = match surface.shape() {
                Shape::Triangles(_) => "Mesh",
                Shape::Spheres(_) => "Spheres",
                Shape::Tubes(_) => "Tubes",
            };
            Ok(Self(surface).of_class(classes.getattr(name)?.cast().map_err(PyErr::from)?)?)
        };
        surfaces.into_iter().map(of_class).collect()
    }

    #[staticmethod]
    fn _triangles(
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        faces: PyReadonlyArray2<u32>,
        normals: Option<PyReadonlyArray2<f32>>,
    ) -> Result<Self> {
        let points = points(&vertices)?;
        let indices: Vec<[u32; 3]> = faces.as_slice().map_err(PyErr::from)?.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
        let normals: Option<Vec<Vec3>> = match normals {
            Some(normals) => Some(normals.as_slice().map_err(PyErr::from)?.chunks_exact(3).map(Vec3::from_slice).collect()),
            None => None,
        };
        abandonable(py, move || {
            let triangles = Triangles::new(points, indices)?;
            let triangles = normals.map_or(Ok(triangles.clone()), |normals| triangles.with_normals(normals))?;
            Ok(Self(Ours::new("mesh", triangles)))
        })
    }

    #[staticmethod]
    fn _spheres(py: Python, centres: PyReadonlyArray2<f64>, radius: Option<PyReadonlyArray1<f64>>) -> Result<Self> {
        let points = points(&centres)?;
        let radii = radii(radius, &points)?;
        abandonable(py, move || Ok(Self(Ours::new("spheres", Spheres::new(points, radii)?))))
    }

    #[staticmethod]
    fn _tubes(
        py: Python,
        vertices: PyReadonlyArray2<f64>,
        lengths: Vec<usize>,
        radius: Option<PyReadonlyArray1<f64>>,
        ends: Argument<String>,
    ) -> Result<Self> {
        extract!(ends);
        let ends = Ends::from_name(&ends)?;
        let points = points(&vertices)?;
        let radii = radii(radius, &points)?;
        abandonable(py, move || Ok(Self(Ours::new("tubes", Tubes::new(points, radii, &lengths, ends)?))))
    }

    fn _colored(&self, py: Python, colors: PyReadonlyArray2<f32>, of_cells: bool) -> Result<Self> {
        let colors: Vec<[f32; 4]> =
            colors.as_slice().map_err(PyErr::from)?.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        let surface = self.0.clone();
        abandonable(py, move || Ok(Self(surface.with_colors(per(colors, of_cells))?)))
    }

    fn _valued(
        &self,
        py: Python,
        values: PyReadonlyArray1<f32>,
        of_cells: bool,
        transfer: Option<Argument<Colors>>,
    ) -> Result<Self> {
        extract!(transfer);
        let values = per(values.as_slice().map_err(PyErr::from)?.to_vec(), of_cells);
        let coloring = transfer.map_or_else(|| Coloring::Named(DEFAULT_COLORS.into()), Coloring::from);
        let surface = self.0.clone();
        abandonable(py, move || {
            let transfer = coloring.of(&values)?;
            Ok(Self(surface.with_values(values, transfer)?))
        })
    }

    /// A copy that looks otherwise; what is None stays. It shares the points. Keywords: see Surface.
    #[pyo3(
        signature = (
            *, color = None, opacity = None, matrix = None, shading = None, clip = None, visible = None, name = None
        )
    )]
    #[allow(clippy::too_many_arguments)] // Python passes them by keyword.
    fn replaced<'py>(
        slf: &Bound<'py, Self>,
        color: Option<&Bound<PyAny>>,
        opacity: Option<Argument<f64>>,
        matrix: Option<&Bound<PyAny>>,
        shading: Option<Argument<String>>,
        clip: Option<Argument<bool>>,
        visible: Option<Argument<bool>>,
        name: Option<Argument<String>>,
    ) -> Result<Bound<'py, PyAny>> {
        extract!(opacity, shading, clip, visible, name);
        let converted = slf.py().import("layersplat._surfaces")?;
        let mut surface = slf.get().0.clone();
        surface.name = name.unwrap_or(surface.name);
        if let Some(color) = color {
            let ([r, g, b], alpha): ([f32; 3], Option<f32>) = converted.call_method1("color", (color,))?.extract()?;
            surface.color = [r, g, b];
            surface.opacity = alpha.unwrap_or(surface.opacity);
        }
        if let Some(opacity) = opacity {
            if !(0.0..=1.0).contains(&opacity) {
                return Err(out_of_range("opacity", opacity, "a number from 0 to 1"));
            }
            surface.opacity = opacity as f32;
        }
        if let Some(shading) = shading {
            surface.shading = SurfaceShading::from_name(&shading)?;
        }
        surface.is_clipped = clip.unwrap_or(surface.is_clipped);
        surface.is_visible = visible.unwrap_or(surface.is_visible);
        if let Some(matrix) = matrix {
            let rows: [f64; 16] = converted.call_method1("matrix", (matrix,))?.extract()?;
            surface = surface.with_matrix(DMat4::from_cols_array(&rows).transpose())?;
        }
        Ok(Self(surface).of_class(&slf.get_type())?)
    }

    /// The framing of its bounds, see Framing.joined; None if it has no points.
    fn framing(&self, py: Python) -> Result<Option<Framing>> {
        let surface = self.0.clone();
        let bounds = abandonable(py, move || Ok(surface.bounds()))?;
        Ok(bounds.map(|bounds| Framing::from_library(OurFraming::of_box(bounds.lowest, bounds.highest))))
    }

    /// The lowest and the highest corner, (x, y, z) each, of its bounds in the world; None if it has no points.
    #[getter]
    #[allow(clippy::type_complexity)] // Two corners.
    fn bounds(&self) -> Option<((f64, f64, f64), (f64, f64, f64))> {
        self.0.bounds().map(|bounds| (bounds.lowest.into(), bounds.highest.into()))
    }

    /// Number of points: vertices, centres, or points of lines.
    #[getter]
    fn points(&self) -> usize {
        self.0.shape().points()
    }

    /// Number of cells: triangles, spheres or lines.
    #[getter]
    fn cells(&self) -> usize {
        self.0.shape().cells()
    }

    /// Colour (red, green, blue), 0 … 1, where it has no colors and values.
    #[getter]
    fn color(&self) -> (f32, f32, f32) {
        self.0.color.into()
    }

    /// Opacity, 0 … 1.
    #[getter]
    fn opacity(&self) -> f32 {
        self.0.opacity
    }

    /// Whether it is drawn.
    #[getter]
    fn visible(&self) -> bool {
        self.0.is_visible
    }

    /// The name shown in messages.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    fn __repr__(slf: &Bound<Self>) -> PyResult<String> {
        let (class, ours) = (slf.get_type().name()?, &slf.get().0);
        let hidden = if ours.is_visible { "" } else { ", hidden" };
        let (points, cells) = (ours.shape().points(), ours.shape().cells());
        Ok(format!("<layersplat.{class} {} of {points} points and {cells} cells{hidden}>", ours.name))
    }
}

/// A radius in the words of the library.
struct Size(Radius);

impl<'a, 'py> FromPyObject<'a, 'py> for Size {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let own = either(object, Radius::All, Radius::Array)?;
        Ok(Self(own))
    }
}
