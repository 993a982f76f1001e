//! Label volumes of files, with their tables.

use super::Declared;
use super::change::change_all;
use super::ids::Ids;
use super::table;
use super::{Label, LabelChange, LabelSurfaces, LabelTable};
use crate::error::Error;
use crate::url;
use crate::volume::missing_data::MissingData;
use crate::volume::wide::Numbers;
use crate::volume::{Contents, Endian, Grid, OpenOptions, Rescale, ScalarType, Volume, format};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Ids that a message lists.
const LISTED: usize = 8;

/// The labels of a file, or of numbers in memory. Most files have one layer; in `.seg.nrrd` files and segmentations of DICOM
/// whose segments overlap, each layer holds some of them.
///
/// ```
/// use layersplat::volume::{Labels, OpenOptions};
/// # let folder = tempfile::tempdir().expect("a folder");
/// # let path = folder.path().join("organs.nrrd");
/// # let header = "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 2 2 1\nendian: little\nencoding: raw\n\n";
/// # let ids = [0u32, 614_454_277, 614_454_277, 12].map(u32::to_le_bytes).concat();
/// # std::fs::write(&path, [header.as_bytes(), &ids].concat()).expect("a file");
///
/// let mut labels = Labels::open(&path, &OpenOptions::default(), None)?;
/// labels.change(&"12:hide".parse()?)?;
/// let layer = &labels.layers()[0];
/// assert_eq!(layer.ids(), [0, 12, 614_454_277]);
/// assert_eq!(layer.voxels_of(614_454_277), 2);
/// // Voxel values are positions in `ids`, and in `palette`.
/// let indices = layer.indices(None)?;
/// assert_eq!([0, 1, 2, 3].map(|voxel| indices.value(voxel)), [0.0, 2.0, 2.0, 1.0]);
/// assert_eq!(layer.palette()[1][3], 0.0);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Labels {
    pub(super) layers: Vec<LabelLayer>,
    surfaces: LabelSurfaces,
}

/// Labels that do not overlap: each voxel has one, or none. Clones share the numbers of voxels.
#[derive(Clone)]
pub struct LabelLayer {
    pub(super) path: PathBuf,
    pub(super) grid: Grid,
    table: LabelTable,
    /// Ids of voxels, ascending from 0, and the number of voxels of each.
    ids: Vec<u32>,
    voxels: Vec<u64>,
    stored: Stored,
    pub(super) contents: Contents,
}

/// Numbers in memory, or of a file that is mapped.
#[derive(Clone)]
struct Stored {
    bytes: Arc<dyn AsRef<[u8]> + Send + Sync>,
    scalar: ScalarType,
    endian: Endian,
    rescale: Rescale,
    missing: MissingData,
}

impl Labels {
    /// Opens a volume whose voxels are ids of labels, and counts the voxels of each id in one pass. Uncompressed files are mapped;
    /// others take the memory of their stored numbers, or a temporary file if these exceed [`OpenOptions::memory`].
    ///
    /// Names and colours come from the file `table` ([`LabelTable::open`]) if it is given, else from the volume's own metadata: of
    /// `.seg.nrrd` files, of segmentations of DICOM, of OME-Zarr's `image-label`, or from the file that a NIfTI file with the label intent names; else from a table
    /// beside the file that is called like it (`aal.txt`, `aal.nii.txt`, `aal.nii.lut` beside `aal.nii.gz`). Ids without an entry
    /// get the colour of the file's palette ([`Contents::palette`]), else a [default colour](LabelTable::default_color).
    ///
    /// # Errors
    /// As [`Volume::open`] and [`LabelTable::open`]; [`Error::Volume`] for built-in volumes, for voxels that are not whole numbers from 0 to
    /// 4294967295, and for more than 65535 different ids.
    pub fn open(source: impl AsRef<Path>, options: &OpenOptions, table: Option<&Path>) -> Result<Self, Error> {
        let path = &*url::public(source.as_ref());
        if path.to_str().is_some_and(|name| name.starts_with("builtin:")) {
            return Err(Error::volume(path, "built-in volumes have values, not labels: name a file"));
        }
        let given = table.map(LabelTable::open).transpose()?;
        let declared = match &given {
            // The layers count even if the names do not.
            Some(_) => format::labels(path, options).ok().flatten(),
            None => format::labels(path, options)?,
        };
        let mut tables = declared.map_or(vec![LabelTable::default()], |Declared { layers }| layers);
        if let ([only], None) = (&mut tables[..], &given)
            && only.labels().is_empty()
        {
            *only = table::beside(path).unwrap_or_default();
        }
        let is_named = given.is_some() || tables.iter().any(|table| !table.labels().is_empty());
        let wanted = if tables.len() > 1 { (0..tables.len()).map(Some).collect() } else { vec![None] };
        let wanted = options.channel.map_or(wanted, |channel| vec![Some(channel)]);
        let layers: Result<Vec<_>, Error> = wanted
            .into_iter()
            .map(|channel| {
                let own = tables.get(channel.unwrap_or(0)).cloned().unwrap_or_default();
                let options = OpenOptions { channel, ..options.clone() };
                LabelLayer::open(path, &options, given.clone().unwrap_or(own), is_named)
            })
            .collect();
        Ok(Self { layers: layers?, surfaces: LabelSurfaces::default() })
    }

    /// Labels of numbers in memory, one layer, x fastest, in this machine's byte order. Ids without an entry in the table get a
    /// [default colour](LabelTable::default_color).
    ///
    /// ```
    /// use layersplat::glam::DVec3;
    /// use layersplat::volume::{Grid, LabelTable, Labels, ScalarType};
    ///
    /// let grid = Grid::new([2, 2, 1], DVec3::ONE)?;
    /// let labels = Labels::from_numbers("cells", grid, [0u8, 7, 7, 12], ScalarType::Uint8, LabelTable::default())?;
    /// assert_eq!(labels.layers()[0].voxels_of(7), 2);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Volume`] for another number of bytes than the grid's, for voxels that are not whole numbers from 0 to 4294967295, and for
    /// more than 65535 different ids.
    pub fn from_numbers(
        name: impl Into<PathBuf>,
        grid: Grid,
        numbers: impl AsRef<[u8]> + Send + Sync + 'static,
        scalar: ScalarType,
        table: LabelTable,
    ) -> Result<Self, Error> {
        let (path, found, expected) = (name.into(), numbers.as_ref().len(), grid.voxel_count() * scalar.bytes());
        if found != expected {
            return Err(Error::volume(&path, format!("its labels have {found} bytes, and its grid needs {expected}")));
        }
        let stored = Stored {
            bytes: Arc::new(numbers),
            scalar,
            endian: Endian::NATIVE,
            rescale: Rescale::default(),
            missing: MissingData::default(),
        };
        let (layer, _) = LabelLayer::new(path, grid, stored, Contents::default(), table)?;
        Ok(Self { layers: vec![layer], surfaces: LabelSurfaces::default() })
    }

    /// The labels with other names and looks, in all layers. Ids without an entry get a [default colour](LabelTable::default_color).
    pub fn with_table(mut self, table: &LabelTable) -> Self {
        for layer in &mut self.layers {
            layer.table = table.clone();
            layer.table.complete(layer.ids.iter().copied(), &layer.contents.palette);
        }
        self
    }

    /// Whether a file states that its voxels are ids of labels: `.seg.nrrd` files, binary segmentations and label maps of DICOM,
    /// OME-Zarr's `image-label`, and NIfTI's label intent.
    ///
    /// # Errors
    /// If the file cannot be read, or its table is malformed.
    pub fn are_declared(source: impl AsRef<Path>, options: &OpenOptions) -> Result<bool, Error> {
        let path = source.as_ref();
        let is_builtin = path.to_str().is_some_and(|name| name.starts_with("builtin:"));
        Ok(!is_builtin && format::labels(path, options)?.is_some())
    }

    /// The labels with other surfaces.
    pub fn with_surfaces(self, surfaces: LabelSurfaces) -> Self {
        Self { surfaces, ..self }
    }

    /// The surfaces with which they are drawn.
    pub fn surfaces(&self) -> LabelSurfaces {
        self.surfaces
    }

    /// Name of the file, for messages.
    pub(in crate::volume) fn name(&self) -> String {
        self.layers[0].path.display().to_string()
    }

    /// The layers, at least one.
    pub fn layers(&self) -> &[LabelLayer] {
        &self.layers
    }

    /// Changes the chosen labels of all layers.
    ///
    /// # Errors
    /// As [`LabelTable::change`], if no layer has a chosen name or id.
    pub fn change(&mut self, change: &LabelChange) -> Result<(), Error> {
        let mut tables: Vec<&mut LabelTable> = self.layers.iter_mut().map(|layer| &mut layer.table).collect();
        change_all(&mut tables, change)
    }

    /// The tables of all layers after further changes, for [`LabelLayer::palette_of`].
    ///
    /// # Errors
    /// As [`change`](Self::change).
    pub fn changed_tables(&self, changes: &[LabelChange]) -> Result<Vec<LabelTable>, Error> {
        let mut tables: Vec<LabelTable> = self.layers.iter().map(|layer| layer.table.clone()).collect();
        for change in changes {
            change_all(&mut tables.iter_mut().collect::<Vec<_>>(), change)?;
        }
        Ok(tables)
    }
}

impl LabelLayer {
    fn open(path: &Path, options: &OpenOptions, table: LabelTable, is_named: bool) -> Result<Self, Error> {
        let (header, bytes) = format::numbers(path, options)?;
        let format::Header { grid, scalar, endian, rescale, missing, contents, .. } = header;
        let stored = Stored { bytes: bytes.into(), scalar, endian, rescale, missing };
        let (layer, added) = Self::new(path.into(), grid, stored, contents, table)?;
        if is_named && !added.is_empty() {
            let listed: Vec<String> = added.iter().take(LISTED).map(u32::to_string).collect();
            let more = if added.len() > LISTED { ", …" } else { "" };
            let listed = listed.join(", ");
            tracing::warn!(
                "{}: {} of its ids have no entry in the table, and get colours by their number: {listed}{more}",
                path.display(),
                added.len()
            );
        }
        Ok(layer)
    }

    /// Counts the voxels of each id. Also returns the ids that the table lacked.
    fn new(
        path: PathBuf,
        grid: Grid,
        stored: Stored,
        contents: Contents,
        mut table: LabelTable,
    ) -> Result<(Self, Vec<u32>), Error> {
        let mut counts = stored.ids(&path, grid.dims()).counts()?;
        counts.entry(0).or_default();
        let (ids, voxels): (Vec<u32>, Vec<u64>) = counts.into_iter().unzip();
        let added = table.complete(ids.iter().copied(), &contents.palette);
        Ok((Self { path, grid, table, ids, voxels, stored, contents }, added))
    }

    /// Position of the voxels in the world.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Names and looks of all labels: those of the table, and those of voxels.
    pub fn table(&self) -> &LabelTable {
        &self.table
    }

    /// The ids that voxels have, ascending. The first is 0, the background, even if no voxel has it.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The labels that voxels have, as in [`ids`](Self::ids) without the background.
    pub fn present(&self) -> impl Iterator<Item = &Label> {
        self.present_in(&self.table)
    }

    /// The labels of a table that voxels have, as in [`ids`](Self::ids) without the background.
    pub fn present_in<'a>(&'a self, table: &'a LabelTable) -> impl Iterator<Item = &'a Label> {
        self.ids[1..].iter().filter_map(|&id| table.get(id))
    }

    /// Number of voxels of an id.
    pub fn voxels_of(&self, id: u32) -> u64 {
        self.ids.binary_search(&id).map_or(0, |at| self.voxels[at])
    }

    /// Volume of an id in cubic world units.
    pub fn volume_of(&self, id: u32) -> f64 {
        self.voxels_of(id) as f64 * self.grid.spacing().element_product()
    }

    /// The id of a voxel by its index.
    pub(super) fn id(&self, voxel: usize) -> u32 {
        self.stored.ids(&self.path, self.grid.dims()).id(voxel)
    }

    /// Red, green, blue and opacity, 0 to 1, of each of [`ids`](Self::ids). The background and hidden labels have the opacity 0.
    pub fn palette(&self) -> Vec<[f64; 4]> {
        self.palette_of(&self.table)
    }

    /// As [`palette`](Self::palette), with the looks of another table: the layer's own one after further changes.
    pub fn palette_of(&self, table: &LabelTable) -> Vec<[f64; 4]> {
        let of = |label: &Label| [label.color[0], label.color[1], label.color[2], label.drawn_opacity()];
        std::iter::once([0.0; 4]).chain(self.present_in(table).map(of)).collect()
    }

    /// A volume whose values are the positions of the voxels' ids in [`ids`](Self::ids): `uint8` for up to 255 labels, else `uint16`. It is
    /// in a temporary file if it exceeds `memory` bytes.
    ///
    /// # Errors
    /// If memory or the temporary folder is too small.
    pub fn indices(&self, memory: Option<u64>) -> Result<Volume<'static>, Error> {
        let storage = self.stored.ids(&self.path, self.grid.dims()).indices(&self.ids, memory)?;
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        // Beyond the grid there are no labels.
        let volume = Volume::new(name, self.grid.clone(), storage)?.with_background(0.0)?;
        Ok(volume.with_contents(self.contents.clone()))
    }
}

impl Stored {
    fn ids<'a>(&'a self, path: &'a Path, dims: [usize; 3]) -> Ids<'a> {
        let Self { scalar, endian, rescale, .. } = *self;
        let numbers = Numbers { bytes: (*self.bytes).as_ref(), scalar, endian, missing: self.missing.declared() };
        Ids { path, dims, numbers, rescale }
    }
}

impl fmt::Debug for LabelLayer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} labels of {}", self.ids.len() - 1, self.path.display())
    }
}
