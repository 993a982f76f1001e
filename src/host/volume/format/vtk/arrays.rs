//! Point and cell arrays of an image.

use crate::error::Error;
use crate::volume::format::load::{self, Header};
use crate::volume::format::{OpenOptions, choice};
use crate::volume::{Contents, Endian, ScalarType};
use glam::{DAffine3, DVec3};
use std::path::Path;

/// An array and the location of its numbers.
pub(crate) struct Array<Place> {
    pub name: String,
    /// Type name as in the file.
    pub type_name: String,
    pub components: usize,
    /// Whether the array belongs to cells, not points.
    pub cell_data: bool,
    /// Whether the file marks it as active.
    pub active: bool,
    /// Whether the file declares its components as a vector.
    pub is_vector: bool,
    /// Whether these vectors are normals of a surface.
    pub are_normals: bool,
    /// Whether the file declares its components as colours.
    pub are_colors: bool,
    pub place: Place,
}

/// Placement of an image.
pub(in crate::volume::format) struct Image {
    /// Number of points along x, y, z.
    pub points: [usize; 3],
    pub index_to_world: DAffine3,
}

/// The requested array; else the active one, else a point array, else the first.
pub(in crate::volume::format) fn chosen<'a, P>(
    path: &Path,
    arrays: &'a [Array<P>],
    options: &OpenOptions,
) -> Result<&'a Array<P>, Error> {
    let best = |array: &&Array<P>| (!array.active, array.cell_data);
    let default = arrays.iter().min_by_key(best);
    let default = default.ok_or_else(|| Error::volume(path, "it has no numeric point or cell array"))?;
    let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
    match choice::named(path, options.array.as_deref(), &names, &default.name)? {
        None => Ok(default),
        Some(index) => Ok(&arrays[index]),
    }
}

impl<P> Array<P> {
    /// Header for one component of the array, placed at points or at cell centres.
    pub(in crate::volume::format) fn header(
        &self,
        path: &Path,
        image: &Image,
        scalar: ScalarType,
        endian: Endian,
        options: &OpenOptions,
    ) -> Result<Header, Error> {
        let (mut dims, mut place) = (image.points, image.index_to_world);
        if self.cell_data {
            let half = DVec3::from_array(dims.map(|n| if n > 1 { 0.5 } else { 0.0 }));
            place.translation = place.transform_point3(half);
            dims = dims.map(|n| (n - 1).max(1));
        }
        let grid = load::grid(path, dims, place, options)?;
        let mut contents = Contents::default();
        let channel = contents.choose_component(path, options, self.components, self.is_vector)?;
        contents.are_colors = self.are_colors && self.components > 2;
        let header = Header { endian, contents, ..Header::new(grid, scalar) }.with_magnitude(scalar.bytes() as u64);
        Ok(header.with_channels_inside(channel, self.components))
    }

    /// Whether it is the same array of another piece.
    #[cfg(feature = "vtk")]
    pub fn is_like(&self, other: &Self) -> bool {
        (&self.name, self.cell_data, self.components, &self.type_name)
            == (&other.name, other.cell_data, other.components, &other.type_name)
    }

    /// Count of all numbers.
    pub(in crate::volume::format) fn numbers(&self, image: &Image) -> u64 {
        let along = |n: usize| if self.cell_data { (n - 1).max(1) } else { n } as u64;
        image.points.iter().fold(self.components as u64, |all, &n| all.saturating_mul(along(n)))
    }
}
