//! Files of surfaces. Each format parses its file to a [`SurfaceFile`].

mod cells;
mod freesurfer;
#[cfg(feature = "vtk")]
mod gifti;
mod obj;
mod ply;
mod stl;
mod vtk;

use super::{Per, Space};
use crate::error::Error;
use crate::memory;
use crate::panics::caught;
use crate::progress::Task;
use crate::url;
use crate::volume::SurfaceFormat;
use glam::{DVec3, Vec3};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Cells of one kind, and the number of each among the cells of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells<T> {
    /// Indices of points.
    pub points: Vec<T>,
    /// Which entry of arrays of cells is theirs. Triangles of one polygon share one.
    pub numbers: Vec<u32>,
}

impl<T> Default for Cells<T> {
    fn default() -> Self {
        Self { points: Vec::new(), numbers: Vec::new() }
    }
}

/// Values of all points or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceArray {
    /// Its name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// The components of the first point or cell, those of the second, and so on.
    pub values: Per<f32>,
}

impl SurfaceArray {
    /// A value per point or cell: the only component, or the magnitude of several.
    pub fn scalars(&self) -> Per<f32> {
        let norm = |components: &[f32]| components.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt() as f32;
        let of = |values: &[f32]| match self.components {
            1 => values.to_vec(),
            several => values.chunks_exact(several).map(norm).collect(),
        };
        match &self.values {
            Per::Point(values) => Per::Point(of(values)),
            Per::Cell(values) => Per::Cell(of(values)),
        }
    }

    /// The smallest and the largest finite of [`scalars`](Self::scalars), if there are any.
    pub fn range(&self) -> Option<[f32; 2]> {
        self.scalars().range()
    }
}

/// Colour of points whose label has none in the file's table.
const NO_LABEL: [f32; 4] = [0.6, 0.6, 0.6, 1.0];

/// Values and colours of points, which files have without the points.
#[derive(Clone, Debug, PartialEq)]
pub struct PointData {
    /// Arrays of points.
    pub arrays: Vec<SurfaceArray>,
    /// Colours of points, such as those of their labels.
    pub colors: Option<Vec<[f32; 4]>>,
}

impl PointData {
    /// Reads a file of values or labels: GIFTI (`.func.gii`, `.shape.gii`, `.label.gii`; feature `vtk`) or FreeSurfer's (`lh.thickness`,
    /// `lh.aparc.annot`).
    ///
    /// # Errors
    /// If the file cannot be read, has another format, or is truncated or damaged.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = &*url::public(path.as_ref());
        caught(path, || {
            refuse_urls(path)?;
            let bytes = bytes_of(path)?;
            #[cfg(feature = "vtk")]
            if gifti::is_one(&bytes) {
                return gifti::point_data(path, &bytes).map_err(|problem| Error::volume(path, problem));
            }
            if freesurfer::has_point_data(path, &bytes) {
                return freesurfer::point_data(path, &bytes).map_err(|problem| Error::volume(path, problem));
            }
            let problem =
                "it holds no values or labels of points: give those of GIFTI (.func.gii, .shape.gii, .label.gii) or FreeSurfer";
            Err(Error::volume(path, problem))
        })
    }
}

/// What a file of surfaces holds, as it states it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFile {
    /// The file.
    pub path: PathBuf,
    /// Its format: `STL, binary`.
    pub format: String,
    /// Positions. Those of STL that are equal are one.
    pub points: Vec<DVec3>,
    /// Triangles: also those of polygons and strips. A polygon becomes a fan around its first point; of one that is concave there, parts of
    /// the fan lie outside.
    pub triangles: Cells<[u32; 3]>,
    /// Lines of two or more points.
    pub lines: Cells<Box<[u32]>>,
    /// Points that are shown by themselves.
    pub vertices: Cells<u32>,
    /// Normals of the points.
    pub normals: Option<Vec<Vec3>>,
    /// Colours of the points or of the file's cells: straight red, green, blue and alpha, 0 … 1.
    pub colors: Option<Per<[f32; 4]>>,
    /// All other arrays of points and of the file's cells.
    pub arrays: Vec<SurfaceArray>,
    /// What the header says: the title, or comments.
    pub header: String,
    /// The axes of a patient, if the file states them.
    pub space: Option<Space>,
}

impl SurfaceFile {
    /// Reads a file: STL, PLY, OBJ, VTK PolyData (`.vtp` with the feature `vtk`, and legacy `.vtk`), GIFTI (feature `vtk`) or FreeSurfer, as its
    /// content says.
    ///
    /// # Errors
    /// If the file cannot be read, has another format, or is truncated or damaged; if it has no points, points that are not finite, or cells
    /// of points that it does not have.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = &*url::public(path.as_ref());
        caught(path, || {
            refuse_urls(path)?;
            let file = match SurfaceFormat::of_file(path)? {
                Some(SurfaceFormat::Stl) => stl::read(path)?,
                Some(SurfaceFormat::Ply) => ply::read(path)?,
                #[cfg(feature = "vtk")]
                Some(SurfaceFormat::VtkXml) => vtk::xml(path)?,
                #[cfg(not(feature = "vtk"))]
                Some(SurfaceFormat::VtkXml) => {
                    return Err(Error::volume(path, "it is XML of VTK, which needs a build with the feature vtk"));
                }
                Some(SurfaceFormat::VtkLegacy) => vtk::legacy(path)?,
                Some(SurfaceFormat::Obj) => obj::read(path)?,
                Some(SurfaceFormat::FreeSurfer) => freesurfer::read(path)?,
                #[cfg(feature = "vtk")]
                Some(SurfaceFormat::Gifti) => gifti::read(path)?,
                #[cfg(not(feature = "vtk"))]
                Some(SurfaceFormat::Gifti) => {
                    return Err(Error::volume(path, "it is GIFTI, XML which needs a build with the feature vtk"));
                }
                None => {
                    let problem = "it holds no surface of a known format: these are STL, PLY, OBJ, VTK PolyData (.vtp, .vtk), GIFTI and FreeSurfer";
                    return Err(Error::volume(path, problem));
                }
            };
            file.checked(path)
        })
    }

    /// Adds values and colours of its points. Colours replace those of the file. Returns the name of the first array, if there are no colours.
    ///
    /// # Errors
    /// If it has another number of points.
    pub fn add(&mut self, data: PointData) -> Result<Option<String>, Error> {
        let count = self.points.len();
        let of_arrays = data.arrays.iter().map(|array| array.values.entries().len() / array.components);
        if let Some(found) = of_arrays.chain(data.colors.as_ref().map(Vec::len)).find(|found| *found != count) {
            return Err(Error::volume(
                &self.path,
                format!("it has {count} points, and its data are of {found}: give those of this surface"),
            ));
        }
        let first = data.arrays.first().filter(|_| data.colors.is_none()).map(|array| array.name.clone());
        self.arrays.extend(data.arrays);
        self.colors = data.colors.map(Per::Point).or(self.colors.take());
        Ok(first)
    }

    /// Whether a file holds a surface, by its first bytes, or its name.
    pub fn is_one(path: impl AsRef<Path>) -> bool {
        SurfaceFormat::of_file(path.as_ref()).is_ok_and(|format| format.is_some())
    }

    /// Checks what cells, arrays and points say of each other. Without cells, all points are shown.
    fn checked(mut self, path: &Path) -> Result<Self, Error> {
        let wrong = |problem: String| Err(Error::volume(path, problem));
        let count = self.points.len();
        if count == 0 {
            return wrong("it has no points: it is empty".into());
        }
        if count > u32::MAX as usize {
            return wrong(format!("{count} points are too many: cut it into parts"));
        }
        if let Some(n) = self.points.iter().position(|point| !point.is_finite()) {
            return wrong(format!("point {n} is {}: remove it, or give it a place", self.points[n]));
        }
        let of_cells = self.triangles.points.iter().flatten().chain(self.lines.points.iter().flat_map(|line| &line[..]));
        if let Some(index) = of_cells.chain(&self.vertices.points).find(|&&index| index as usize >= count) {
            return wrong(format!("a cell has point {index} of {count}, which count from 0: it is damaged"));
        }
        let numbers = self.triangles.numbers.iter().chain(&self.lines.numbers).chain(&self.vertices.numbers);
        let cells = numbers.max().map_or(0, |last| *last as usize + 1);
        let found = |name: &str, lengths: [Option<usize>; 2]| match lengths {
            [Some(points), _] if points != count => Some(format!("its {name} are {points} for {count} points: it is damaged")),
            [_, Some(own)] if own < cells => Some(format!("its {name} are {own} for {cells} cells: it is damaged")),
            _ => None,
        };
        let normals = self.normals.as_ref().and_then(|normals| found("normals", [Some(normals.len()), None]));
        let colors = self.colors.as_ref().and_then(|colors| found("colours", lengths(colors, 1)));
        let values = |array: &SurfaceArray| found(&format!("values of {}", array.name), lengths(&array.values, array.components));
        if let Some(problem) = normals.or(colors).or_else(|| self.arrays.iter().find_map(values)) {
            return wrong(problem);
        }
        if cells == 0 {
            let all: Vec<u32> = (0..count as u32).collect();
            // Arrays of cells that show nothing.
            self.arrays.retain(|array| matches!(array.values, Per::Point(_)));
            self.colors = self.colors.filter(|colors| matches!(colors, Per::Point(_)));
            self.vertices = Cells { points: all.clone(), numbers: all };
        }
        // Headers may have anything, also what terminals take as commands.
        self.header.retain(|letter| !letter.is_control());
        Ok(Self { path: path.into(), ..self })
    }
}

/// Numbers of points and of cells that have entries.
fn lengths<T>(per: &Per<T>, components: usize) -> [Option<usize>; 2] {
    let count = Some(per.entries().len() / components);
    if matches!(per, Per::Point(_)) { [count, None] } else { [None, count] }
}

/// Fails for addresses, which would be looked for as files.
fn refuse_urls(path: &Path) -> Result<(), Error> {
    if url::is_url(path) { Err(Error::volume(path, "surfaces are read from files only: download it")) } else { Ok(()) }
}

/// All bytes of a file.
fn bytes_of(path: &Path) -> Result<Vec<u8>, Error> {
    /// Bytes read at a time, between which the task can be cancelled.
    const PIECE: u64 = 1 << 24;
    let failed = |e| Error::read(path, e);
    let mut file = File::open(path).map_err(failed)?;
    let len = file.metadata().map_err(failed)?.len();
    memory::require(&path.display().to_string(), len)?;
    let task = Task::new(format!("reading {}", path.display()), len);
    let mut bytes = Vec::with_capacity(usize::try_from(len).unwrap_or(0));
    loop {
        task.check().map_err(failed)?;
        let found = file.by_ref().take(PIECE).read_to_end(&mut bytes).map_err(failed)? as u64;
        if found == 0 {
            return Ok(bytes);
        }
        task.add(found);
    }
}
