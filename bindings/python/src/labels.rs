//! Volumes of labels.

use crate::argument::{Argument, extract};
use crate::arrays;
use crate::calls::abandonable;
use crate::camera::Framing;
use crate::errors::{Result, unknown};
use crate::uploads::Voxels;
use crate::volume::{Affine, grid};
use crate::warned::{warn, warned};
use layersplat::renderer::{Channel, LabelColors, UploadedColors, UploadedVolume};
use layersplat::viewer::IndexedLabels;
use layersplat::volume::{Label, LabelChange, LabelLayer, LabelSurfaces, LabelTable, Labels as Ours};
use layersplat::{Device, Error, OpenOptions};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A volume of labels, drawn by Renderer(labels): surfaces in the colours of a table. Ids are never mixed.
///
/// data: an array (z, y, x) of ids, whole numbers from 0, the background, to 2³² − 1, with at most 65535 different ones; or an image object, see
/// Volume. table: a dict from ids to a name, a colour (#rrggbb, or red, green, blue and possibly opacity, 0 … 1), or a dict with any of
/// name, color, opacity and visible; or a file: look-up tables of FreeSurfer, ITK-SNAP and 3D Slicer, or JSON. Ids without an entry are
/// opaque, in a colour that depends on the id. changes: texts such as 3,7-9:#ff0000:0.4 or liver:only, which change the table: colour,
/// opacity, and show, hide, only or highlight. spacing: one number, or one per axis of the data. surfaces: smooth, or voxels for those of the
/// voxels.
///
/// Labels are drawn in point-sampled layers with the blend mode composite. Renderer.set_label_colors draws a volume in their colours.
#[pyclass(frozen, module = "layersplat")]
pub struct Labels(Drawn);

/// Labels, independent of Python.
#[derive(Clone)]
pub struct Drawn {
    all: IndexedLabels,
    /// Indices of each layer.
    voxels: Vec<Voxels>,
}

impl Drawn {
    fn new(labels: Ours) -> std::result::Result<Self, Error> {
        let all = IndexedLabels::new(labels)?;
        let voxels = all.layers().map(|(_, indices)| Voxels::new(indices.clone())).collect();
        Ok(Self { all, voxels })
    }

    /// The labels with the volumes of their indices.
    pub fn indexed(&self) -> &IndexedLabels {
        &self.all
    }

    fn tables(&self) -> Vec<LabelTable> {
        self.all.labels().layers().iter().map(|layer| layer.table().clone()).collect()
    }

    /// The labels on a device.
    ///
    /// # Errors
    /// If memory is insufficient.
    pub fn on(&self, device: &Device) -> std::result::Result<UploadedColors, Error> {
        let uploaded = self.uploaded(device)?;
        let palettes = self.all.palettes(&self.tables());
        let layers: Vec<(&UploadedVolume, &[[f64; 4]])> = uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
        UploadedColors::from_labels(&layers, self.all.labels().surfaces())
    }

    /// Channels on a device, beside other fields.
    ///
    /// # Errors
    /// If memory is insufficient.
    pub fn channels_on(&self, device: &Device) -> std::result::Result<Vec<Channel>, Error> {
        self.all.channels(&self.uploaded(device)?, &self.tables())
    }

    fn uploaded(&self, device: &Device) -> std::result::Result<Vec<UploadedVolume>, Error> {
        self.voxels.iter().map(|voxels| voxels.on(device)).collect()
    }

    /// Their colours for a scan.
    ///
    /// # Errors
    /// As for `LabelColors::new`.
    pub fn over_scan(&self, device: &Device) -> std::result::Result<LabelColors, Error> {
        self.all.over_scan(device, &self.tables())
    }
}

/// An entry of a table in Python: id, name, colour, opacity and visibility.
type Entry = (u32, Option<String>, Option<[f64; 3]>, f64, bool);

/// A table of `_fields.table`: a path, or entries.
#[derive(FromPyObject)]
enum Table {
    Entries(Vec<Entry>),
    File(PathBuf),
}

impl Table {
    fn open(self) -> std::result::Result<LabelTable, Error> {
        let label = |(id, name, color, opacity, visible): Entry| {
            let default = Label::new(id);
            Label { name, color: color.unwrap_or(default.color), opacity, visible, ..default }
        };
        match self {
            Self::File(path) => LabelTable::open(path),
            Self::Entries(entries) => LabelTable::new(entries.into_iter().map(label)),
        }
    }
}

/// The changes of a table.
fn changes_from(texts: Option<Vec<String>>) -> Result<Vec<LabelChange>> {
    Ok(texts.unwrap_or_default().iter().map(|text| text.parse()).collect::<std::result::Result<_, Error>>()?)
}

/// The surfaces with a name.
fn surfaces_named(name: &str) -> Result<LabelSurfaces> {
    match name {
        "smooth" => Ok(LabelSurfaces::Smooth),
        "voxels" => Ok(LabelSurfaces::Voxels),
        other => Err(unknown("surfaces", other, "smooth or voxels")),
    }
}

impl Labels {
    pub fn drawn(&self) -> &Drawn {
        &self.0
    }
}

#[pymethods]
impl Labels {
    #[new]
    #[pyo3(
        signature = (data, table = None, spacing = None, *, changes = None, surfaces = Argument::Default("smooth".into())),
        text_signature = "(data, table=None, spacing=None, *, changes=None, surfaces='smooth')"
    )]
    fn new(
        data: &Bound<PyAny>,
        table: Option<&Bound<PyAny>>,
        spacing: Option<&Bound<PyAny>>,
        changes: Option<Argument<Vec<String>>>,
        surfaces: Argument<String>,
    ) -> Result<Self> {
        extract!(changes, surfaces);
        let py = data.py();
        let changes = changes_from(changes)?;
        let surfaces = surfaces_named(&surfaces)?;
        let fields = py.import("layersplat._fields")?;
        let table: Option<Table> = fields.call_method1("table", (table,))?.extract()?;
        let (array, affine): (Bound<PyUntypedArray>, Affine) = fields.call_method1("ids", (data, spacing))?.extract()?;
        let shape = array.shape();
        let grid = grid([shape[0], shape[1], shape[2]], affine)?;
        let (numbers, scalar) = arrays::numbers(&array)?;
        abandonable(py, move || {
            let table = table.map(Table::open).transpose()?.unwrap_or_default();
            let mut labels = Ours::from_numbers("labels", grid, numbers, scalar, table)?.with_surfaces(surfaces);
            changes.iter().try_for_each(|change| labels.change(change))?;
            Ok(Self(Drawn::new(labels)?))
        })
    }

    /// Opens a file: .seg.nrrd, also with segments that overlap, NIfTI, OME-Zarr, or any volume of whole numbers. Names and colours come from
    /// table, otherwise from the volume's own metadata. table, changes and surfaces: see Labels.
    #[staticmethod]
    #[pyo3(
        signature = (path, table = None, *, changes = None, surfaces = Argument::Default("smooth".into())),
        text_signature = "(path, table=None, *, changes=None, surfaces='smooth')"
    )]
    fn open(
        py: Python,
        path: Argument<PathBuf>,
        table: Option<&Bound<PyAny>>,
        changes: Option<Argument<Vec<String>>>,
        surfaces: Argument<String>,
    ) -> Result<Self> {
        extract!(path, changes, surfaces);
        let changes = changes_from(changes)?;
        let surfaces = surfaces_named(&surfaces)?;
        let table: Option<Table> = py.import("layersplat._fields")?.call_method1("table", (table,))?.extract()?;
        let (drawn, warnings) = warned(py, move || {
            let (file, entries) = match table {
                Some(Table::File(file)) => (Some(file), None),
                other => (None, other.map(Table::open).transpose()?),
            };
            let mut labels = Ours::open(path, &OpenOptions::default(), file.as_deref())?.with_surfaces(surfaces);
            if let Some(table) = entries {
                labels = labels.with_table(&table);
            }
            changes.iter().try_for_each(|change| labels.change(change))?;
            Ok(Drawn::new(labels)?)
        })?;
        warn(py, warnings)?;
        Ok(Self(drawn))
    }

    /// A copy after further changes, see Labels. It shares the voxels.
    fn changed(&self, changes: Argument<Vec<String>>) -> Result<Self> {
        extract!(changes);
        let Drawn { all, voxels } = self.0.clone();
        Ok(Self(Drawn { all: all.changed(&changes_from(Some(changes))?)?, voxels }))
    }

    /// The framing of the visible labels. Scans all voxels.
    fn framing(&self, py: Python) -> Result<Framing> {
        let drawn = self.0.clone();
        Ok(Framing::from_library(abandonable(py, move || Ok(drawn.all.framing(&drawn.tables())))?))
    }

    /// The labels that voxels have: a dict from ids to dicts of name, color, opacity and visible. It can be changed, and given to Labels.
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        for label in self.0.all.labels().layers().iter().flat_map(LabelLayer::present) {
            let entry = PyDict::new(py);
            entry.set_item("name", &label.name)?;
            entry.set_item("color", <(f64, f64, f64)>::from(label.color))?;
            entry.set_item("opacity", label.opacity)?;
            entry.set_item("visible", label.visible)?;
            table.set_item(label.id, entry)?;
        }
        Ok(table)
    }

    /// Number of voxels along z, y, x.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        let [x, y, z] = self.0.all.labels().layers()[0].grid().dims();
        (z, y, x)
    }

    fn __repr__(&self) -> String {
        let (z, y, x) = self.shape();
        let count: usize = self.0.all.labels().layers().iter().map(|layer| layer.present().count()).sum();
        format!("<layersplat.Labels of {z}x{y}x{x} (z, y, x), {count} labels>")
    }
}
