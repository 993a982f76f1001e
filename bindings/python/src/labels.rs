//! Volumes of labels.

use crate::argument::{Argument, extract};
use crate::arrays;
use crate::calls::abandonable;
use crate::camera::Framing;
use crate::errors::Result;
use crate::uploads::Voxels;
use crate::volume::{Affine, grid};
use crate::warned::{warn, warned};
use layersplat::framing::Framing as OurFraming;
use layersplat::renderer::{UploadedColors, UploadedVolume};
use layersplat::volume::{Label, LabelChange, LabelTable, Labels as Ours};
use layersplat::{Device, Error, OpenOptions, TransferFunction as Transfer};
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A volume of labels, drawn by Renderer(labels): smooth surfaces in the colours of a table. Ids are never mixed.
///
/// data: an array (z, y, x) of ids, whole numbers from 0, the background, to 2³² − 1, with at most 65535 different ones; or an image object, see
/// Volume. table: a dict from ids to a name, a colour (#rrggbb, or red, green, blue and possibly opacity, 0 … 1), or a dict with any of
/// name, color, opacity and visible; or a file: look-up tables of FreeSurfer, ITK-SNAP and 3D Slicer, or JSON. Ids without an entry are
/// opaque, in a colour that depends on the id. changes: texts such as 3,7-9:#ff0000:0.4 or liver:only, which change the table: colour,
/// opacity, and show, hide, only or highlight. spacing: one number, or one per axis of the data.
///
/// Labels are drawn in point-sampled layers with the blend mode composite.
#[pyclass(frozen, module = "layersplat")]
pub struct Labels(Drawn);

/// Labels, independent of Python.
#[derive(Clone)]
pub struct Drawn {
    layers: Vec<Layer>,
}

/// Labels that do not overlap.
#[derive(Clone)]
struct Layer {
    /// Positions in `labels`, from 1; 0 is the background.
    indices: Voxels,
    labels: Vec<Label>,
}

impl Layer {
    fn palette(&self) -> Vec<[f64; 4]> {
        let of = |label: &Label| [label.color[0], label.color[1], label.color[2], label.drawn_opacity()];
        std::iter::once([0.0; 4]).chain(self.labels.iter().map(of)).collect()
    }

    fn framing(&self) -> std::result::Result<OurFraming, Error> {
        let points = self.palette().iter().enumerate().map(|(n, entry)| (n as f64, entry[3])).collect();
        let visible = Transfer::new("visible", vec![(0.0, [1.0; 3])], points)?;
        Ok(OurFraming::visible(self.indices.volume(), &visible, None))
    }
}

impl Drawn {
    /// The labels on a device.
    ///
    /// # Errors
    /// If memory is insufficient.
    pub fn on(&self, device: &Device) -> std::result::Result<UploadedColors, Error> {
        let uploaded: Vec<_> = self.layers.iter().map(|layer| layer.indices.on(device)).collect::<std::result::Result<_, _>>()?;
        let palettes: Vec<_> = self.layers.iter().map(Layer::palette).collect();
        let layers: Vec<(&UploadedVolume, &[[f64; 4]])> = uploaded.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
        UploadedColors::from_labels(&layers)
    }

    fn framing(&self) -> std::result::Result<OurFraming, Error> {
        let mut framings = self.layers.iter().map(Layer::framing);
        let first = framings.next().expect("there is a layer")?;
        framings.try_fold(first, |joined, framing| Ok(joined.joined(framing?)))
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

impl Labels {
    pub fn drawn(&self) -> &Drawn {
        &self.0
    }
}

#[pymethods]
impl Labels {
    #[new]
    #[pyo3(signature = (data, table = None, spacing = None, *, changes = None))]
    fn new(
        data: &Bound<PyAny>,
        table: Option<&Bound<PyAny>>,
        spacing: Option<&Bound<PyAny>>,
        changes: Option<Argument<Vec<String>>>,
    ) -> Result<Self> {
        extract!(changes);
        let py = data.py();
        let changes = changes_from(changes)?;
        let fields = py.import("layersplat._fields")?;
        let table: Option<Table> = fields.call_method1("table", (table,))?.extract()?;
        let found = fields.call_method1("indices", (data, spacing))?;
        let (array, affine, ids): (Bound<PyUntypedArray>, Affine, Vec<u32>) = found.extract()?;
        let shape = array.shape();
        let (indices, _) = arrays::volume(&array, "labels", grid([shape[0], shape[1], shape[2]], affine)?)?;
        // Beyond the grid there are no labels.
        let indices = Voxels::new(indices.with_background(0.0)?);
        let labels = abandonable(py, move || {
            let table = table.map(Table::open).transpose()?.unwrap_or_default();
            let label = |&id: &u32| table.get(id).cloned().unwrap_or_else(|| Label::new(id));
            let absent = table.labels().iter().filter(|label| ids.binary_search(&label.id).is_err()).cloned();
            let mut complete = LabelTable::new(ids.iter().map(label).chain(absent))?;
            changes.iter().try_for_each(|change| complete.change(change))?;
            Ok(ids.iter().filter_map(|&id| complete.get(id).cloned()).collect())
        })?;
        Ok(Self(Drawn { layers: vec![Layer { indices, labels }] }))
    }

    /// Opens a file: .seg.nrrd, also with segments that overlap, NIfTI, OME-Zarr, or any volume of whole numbers. Names and colours come from
    /// the file table, otherwise from the volume's own metadata. changes: see Labels.
    #[staticmethod]
    #[pyo3(signature = (path, table = None, *, changes = None))]
    fn open(
        py: Python,
        path: Argument<PathBuf>,
        table: Option<Argument<PathBuf>>,
        changes: Option<Argument<Vec<String>>>,
    ) -> Result<Self> {
        extract!(path, table, changes);
        let changes = changes_from(changes)?;
        let (layers, warnings) = warned(py, move || {
            let mut labels = Ours::open(path, &OpenOptions::default(), table.as_deref())?;
            changes.iter().try_for_each(|change| labels.change(change))?;
            let layer = |layer: &layersplat::volume::LabelLayer| {
                Ok(Layer { indices: Voxels::new(layer.indices(None)?), labels: layer.present().cloned().collect() })
            };
            labels.layers().iter().map(layer).collect::<Result<Vec<_>>>()
        })?;
        warn(py, warnings)?;
        Ok(Self(Drawn { layers }))
    }

    /// The framing of the visible labels. Scans all voxels.
    fn framing(&self, py: Python) -> Result<Framing> {
        let drawn = self.0.clone();
        Ok(Framing::from_library(abandonable(py, move || Ok(drawn.framing()?))?))
    }

    /// The labels that voxels have: a dict from ids to dicts of name, color, opacity and visible. It can be changed, and given to Labels.
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = PyDict::new(py);
        for label in self.0.layers.iter().flat_map(|layer| &layer.labels) {
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
        let [x, y, z] = self.0.layers[0].indices.volume().grid().dims();
        (z, y, x)
    }

    fn __repr__(&self) -> String {
        let (z, y, x) = self.shape();
        let count: usize = self.0.layers.iter().map(|layer| layer.labels.len()).sum();
        format!("<layersplat.Labels of {z}x{y}x{x} (z, y, x), {count} labels>")
    }
}
