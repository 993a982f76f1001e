//! Surfaces of files.

use super::triangles::is_closed;
use super::{Cells, DEFAULT_COLORS, Ends, Per, Space, Spheres, Surface, SurfaceArray, SurfaceFile, Triangles, Tubes};
use crate::error::Error;
use crate::transfer::TransferFunction;
use glam::{DVec3, Vec3};
use std::path::Path;

/// Radii of spheres and tubes.
#[derive(Clone, Debug, PartialEq)]
pub enum Radius {
    /// Of all, in the units of the file.
    All(f64),
    /// Of each point, by an array of the points.
    Array(String),
}

/// The part of the diagonal of the points' bounds that a radius is by default.
const DEFAULT_RADIUS: f64 = 1.0 / 200.0;

/// The radius of spheres and tubes at these points where none is given.
pub fn default_radius(points: &[DVec3]) -> f64 {
    let [lowest, highest] = corners(points);
    let diagonal = (highest - lowest).length();
    // A single point has no extent.
    if diagonal > 0.0 && diagonal.is_finite() { diagonal * DEFAULT_RADIUS } else { 1.0 }
}

fn corners(points: &[DVec3]) -> [DVec3; 2] {
    let [lowest, highest] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points.iter().fold([lowest, highest], |[lowest, highest], point| [lowest.min(*point), highest.max(*point)])
}

impl From<&str> for Radius {
    /// A number, or the name of an array.
    fn from(text: &str) -> Self {
        text.parse().map_or_else(|_| Radius::Array(text.into()), Radius::All)
    }
}

/// What a file does not state about its surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceOptions {
    /// Name of the surfaces; without it that of the file.
    pub name: Option<String>,
    /// Colour in place of the colours of the file.
    pub color: Option<[f32; 3]>,
    /// Name of the array whose values are shown as colours; of several components, their magnitude.
    pub values: Option<String>,
    /// Colours of these values; without them, a colour map over their range.
    pub transfer: Option<TransferFunction>,
    /// Radii of spheres and tubes; without them, 1/200 of the diagonal of the file's bounds.
    pub radius: Option<Radius>,
    /// How tubes end.
    pub ends: Ends,
    /// The axes that coordinates run along, if the file does not state them.
    pub space: Option<Space>,
    /// Whether the world is that of a patient, as of volumes that state one ([`Grid::has_anatomy`](crate::volume::Grid::has_anatomy)).
    /// Coordinates that are known to be LPS are then changed to the world's, RAS; others remain as they are.
    pub is_anatomical: bool,
}

/// Opens the surfaces of a file: its triangles, its lines as tubes, and its single points as spheres, each if the file has them.
///
/// # Errors
/// As [`SurfaceFile::read`] and [`SurfaceFile::into_surfaces`].
pub fn open(path: impl AsRef<Path>, options: &SurfaceOptions) -> Result<Vec<Surface>, Error> {
    SurfaceFile::read(path)?.into_surfaces(options)
}

impl SurfaceFile {
    /// The array of a name.
    ///
    /// # Errors
    /// If there is none; the error names those that there are.
    pub fn array(&self, name: &str) -> Result<&SurfaceArray, Error> {
        let names = || match self.arrays.iter().map(|array| array.name.as_str()).collect::<Vec<_>>().as_slice() {
            [] => "it has none".into(),
            names => format!("use {}", names.join(", ")),
        };
        let found = self.arrays.iter().find(|array| array.name == name);
        found.ok_or_else(|| self.wrong(format!("it has no array '{name}': {}", names())))
    }

    /// The axes that the coordinates run along, as far as known.
    ///
    /// # Errors
    /// If the file states others than `options`.
    pub fn space_with(&self, options: &SurfaceOptions) -> Result<Option<Space>, Error> {
        match (self.space, options.space) {
            (Some(own), Some(given)) if own != given => Err(Error::Settings {
                field: "space",
                problem: format!("is {}, but {} states {}: omit it", given.name(), self.path.display(), own.name()),
            }),
            (own, given) => Ok(own.or(given)),
        }
    }

    /// Its surfaces: triangles, tubes and spheres, each if it has them.
    ///
    /// # Errors
    /// If it has no array that `options` name, states another space, or has a radius that is negative or not finite.
    pub fn into_surfaces(mut self, options: &SurfaceOptions) -> Result<Vec<Surface>, Error> {
        let is_turned = self.space_with(options)? == Some(Space::Lps) && options.is_anatomical;
        if is_turned {
            self.points.iter_mut().for_each(|point| *point *= DVec3::new(-1.0, -1.0, 1.0));
            self.normals.iter_mut().flatten().for_each(|normal| *normal *= Vec3::new(-1.0, -1.0, 1.0));
        }
        let values = options.values.as_ref().map(|name| self.values(name, options.transfer.as_ref())).transpose()?;
        let radii = Radii::new(&self, options.radius.as_ref())?;
        let colors = self.colors.take().filter(|_| options.color.is_none());
        let file = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let name = options.name.clone().unwrap_or(file);
        let path = self.path;
        let of_file = |e: Error| Error::volume(&path, e.to_string());
        let finished = |surface: Surface, points: &[u32], cells: &[u32]| {
            let mut surface = surface;
            surface.color = options.color.unwrap_or(surface.color);
            match (&values, &colors) {
                (Some((values, transfer)), _) => surface.with_values(values.gathered(points, cells), transfer.clone()),
                (_, Some(colors)) => surface.with_colors(colors.gathered(points, cells)),
                _ => Ok(surface),
            }
        };
        let mut kinds = Vec::new();
        let Cells { points: mut indices, numbers } = self.triangles;
        if !indices.is_empty() {
            let used = used(&mut indices, self.points.len());
            let points: Vec<DVec3> = used.iter().map(|n| self.points[*n as usize]).collect();
            let mut triangles = Triangles::new(points, indices).map_err(of_file)?;
            if let Some(normals) = self.normals {
                triangles = triangles.with_normals(used.iter().map(|n| normals[*n as usize]).collect()).map_err(of_file)?;
            }
            kinds.push(("triangles", finished(Surface::new("triangles", triangles), &used, &numbers).map_err(of_file)?));
        }
        let placed = |n: &u32| self.points[*n as usize];
        let Cells { points: lines, numbers } = self.lines;
        if !lines.is_empty() {
            let (used, lengths) = (lines.concat(), lines.iter().map(|line| line.len()).collect::<Vec<_>>());
            let points = used.iter().map(placed).collect();
            let single = lines.iter().filter(|line| line.iter().all(|n| placed(n) == placed(&line[0]))).count();
            if single > 0 && options.ends != Ends::Round {
                tracing::warn!(
                    "{}: {single} of {} lines have no length and are not drawn: ends=round draws them as balls",
                    path.display(),
                    lines.len()
                );
            }
            let tubes = Tubes::new(points, radii.of(&used), &lengths, options.ends).map_err(of_file)?;
            kinds.push(("tubes", finished(Surface::new("tubes", tubes), &used, &numbers).map_err(of_file)?));
        }
        let Cells { points: used, numbers } = self.vertices;
        if !used.is_empty() {
            let spheres = Spheres::new(used.iter().map(placed).collect(), radii.of(&used)).map_err(of_file)?;
            kinds.push(("spheres", finished(Surface::new("spheres", spheres), &used, &numbers).map_err(of_file)?));
        }
        let is_one = kinds.len() == 1;
        let named = |(kind, surface)| Surface { name: if is_one { name.clone() } else { format!("{name}, {kind}") }, ..surface };
        Ok(kinds.into_iter().map(named).collect())
    }

    /// Values of an array, and their colours.
    fn values(&self, name: &str, transfer: Option<&TransferFunction>) -> Result<(Per<f32>, TransferFunction), Error> {
        let array = self.array(name)?;
        let scalars = array.scalars();
        let transfer = transfer.map_or_else(|| scalars.colored_by(DEFAULT_COLORS), |transfer| Ok(transfer.clone()))?;
        Ok((scalars, transfer))
    }

    /// Whether every edge of its triangles belongs to two of them, in opposite directions; `None` without triangles.
    pub fn is_closed(&self) -> Option<bool> {
        let triangles = &self.triangles.points;
        (!triangles.is_empty()).then(|| is_closed(triangles))
    }

    /// The lowest and the highest corner of the box around all points.
    pub fn bounds(&self) -> [DVec3; 2] {
        corners(&self.points)
    }

    fn wrong(&self, problem: String) -> Error {
        Error::volume(&self.path, problem)
    }
}

/// A radius for each point.
enum Radii {
    All(f64),
    Each(Vec<f32>),
}

impl Radii {
    fn new(file: &SurfaceFile, radius: Option<&Radius>) -> Result<Self, Error> {
        Ok(match radius {
            Some(Radius::All(radius)) => Self::All(*radius),
            Some(Radius::Array(name)) => match file.array(name)?.scalars() {
                Per::Point(radii) => Self::Each(radii),
                Per::Cell(_) => return Err(file.wrong(format!("its array '{name}' is one of cells: radii are those of points"))),
            },
            None => Self::All(default_radius(&file.points)),
        })
    }

    fn of(&self, points: &[u32]) -> Vec<f64> {
        match self {
            Self::All(radius) => vec![*radius; points.len()],
            Self::Each(radii) => points.iter().map(|n| f64::from(radii[*n as usize])).collect(),
        }
    }
}

impl<T: Copy> Per<T> {
    /// The entries of some points or cells.
    fn gathered(&self, points: &[u32], cells: &[u32]) -> Self {
        let of = |entries: &[T], indices: &[u32]| indices.iter().map(|n| entries[*n as usize]).collect();
        match self {
            Per::Point(entries) => Per::Point(of(entries, points)),
            Per::Cell(entries) => Per::Cell(of(entries, cells)),
        }
    }
}

/// The points that triangles have, in their order, and the triangles with the places of these as indices.
fn used(triangles: &mut [[u32; 3]], count: usize) -> Vec<u32> {
    let mut places = vec![u32::MAX; count];
    triangles.iter().flatten().for_each(|n| places[*n as usize] = 0);
    let used: Vec<u32> = (0..count as u32).filter(|n| places[*n as usize] == 0).collect();
    if used.len() < count {
        used.iter().zip(0..).for_each(|(n, place)| places[*n as usize] = place);
        triangles.iter_mut().flatten().for_each(|n| *n = places[*n as usize]);
    }
    used
}
