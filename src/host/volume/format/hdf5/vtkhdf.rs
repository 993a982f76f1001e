//! Images of VTKHDF (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html>).

use super::find::damaged;
use super::layers::Layers;
use super::numbers;
use crate::error::Error;
use crate::volume::format::conventions::Attributes;
use crate::volume::format::load::{Header, Opened};
use crate::volume::format::parts::Kept;
use crate::volume::format::vtk::arrays::{self, Array, Image};
use crate::volume::format::{OpenOptions, choice};
use crate::volume::{Endian, ScalarType};
use glam::{DAffine3, DMat3, DVec3};
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Hdf5File};
use std::path::Path;

/// The group that makes a file VTKHDF.
pub(super) const GROUP: &str = "VTKHDF";
/// Groups of arrays, and whether these belong to cells.
const KINDS: [(&str, bool); 2] = [("PointData", false), ("CellData", true)];

/// An array's numbers.
struct Stored {
    dataset: Dataset,
    scalar: ScalarType,
    endian: Endian,
    /// Times, if it has an axis of them.
    steps: Option<usize>,
}

/// Opens an array of the group.
pub(super) fn open(path: &Path, file: &Hdf5File, group: &Group, options: &OpenOptions) -> Result<Opened, Error> {
    let kind = group.text("Type").unwrap_or_default();
    if kind != "ImageData" {
        return Err(Error::volume(path, format!("it holds {kind}: expected ImageData; resample it")));
    }
    let image = image(path, group)?;
    let array = options.array.as_deref().map(|name| name.rsplit('/').next().unwrap_or(name).to_owned());
    let options = &OpenOptions { array, ..options.clone() };
    let mut all = Vec::new();
    for (kind, is_of_cells) in KINDS {
        let Ok(kind) = file.group(&format!("{GROUP}/{kind}")) else { continue };
        let active = ["Scalars", "Vectors", "Normals"].map(|attribute| kind.text(attribute));
        for dataset in kind.datasets().map_err(|e| damaged(path, &e))? {
            all.extend(array_of(dataset, &image, is_of_cells, &active));
        }
    }
    let array = arrays::chosen(path, &all, options)?;
    let Stored { dataset, scalar, endian, steps } = &array.place;
    let mut header = array.header(path, &image, *scalar, *endian, options)?;
    let frame = choice::chosen(path, "frame", options.frame, steps.unwrap_or(1))?;
    (header.contents.frames, header.contents.frame) = (steps.unwrap_or(1), frame);
    let before = usize::from(steps.is_some());
    let mut place = vec![0; dataset.ndim()];
    place[..before].fill(frame);
    let layers = Layers::new(dataset.clone(), scalar.bytes(), (before..dataset.ndim()).collect(), place);
    let header = Header { contents: header.contents.clone(), ..header };
    Ok(Opened { header, bytes: Box::new(Kept::new(layers)), exact: false })
}

/// Placement of the points.
fn image(path: &Path, group: &Group) -> Result<Image, Error> {
    let numbers = |name: &str| group.numbers(name).map(|(numbers, _)| numbers).unwrap_or_default();
    let extent: Option<[f64; 6]> = numbers("WholeExtent").try_into().ok();
    let points = extent
        .map(|e| [e[1] - e[0], e[3] - e[2], e[5] - e[4]].map(|n| n + 1.0))
        .filter(|points| points.iter().all(|n| *n >= 1.0));
    let (Some(extent), Some(points)) = (extent, points) else {
        return Err(Error::volume(path, "its WholeExtent is not six numbers of an image with points"));
    };
    let vector = |name: &str, missing: DVec3| numbers(name).try_into().map_or(missing, DVec3::from_array);
    // Row-major in the file.
    let direction =
        numbers("Direction").try_into().map_or(DMat3::IDENTITY, |rows: [f64; 9]| DMat3::from_cols_array(&rows).transpose());
    let matrix3 = direction * DMat3::from_diagonal(vector("Spacing", DVec3::ONE));
    let translation = vector("Origin", DVec3::ZERO) + matrix3 * DVec3::new(extent[0], extent[2], extent[4]);
    Ok(Image { points: points.map(|n| n as usize), index_to_world: DAffine3 { matrix3, translation } })
}

/// An array of numbers along z, y and x, with times before and components behind, if it has such.
fn array_of(dataset: Dataset, image: &Image, cell_data: bool, active: &[Option<String>; 3]) -> Option<Array<Stored>> {
    let (scalar, endian) = numbers::scalar(dataset.dtype())?;
    let name = super::find::last(dataset.name()).to_owned();
    let along = |n: usize| if cell_data { (n - 1).max(1) } else { n } as u64;
    let [x, y, z] = image.points.map(along);
    let (components, steps) = match *dataset.shape() {
        [a, b, c] if [a, b, c] == [z, y, x] => (1, None),
        [a, b, c, n] if [a, b, c] == [z, y, x] => (n, None),
        [n, a, b, c] if [a, b, c] == [z, y, x] => (1, Some(n)),
        [n, a, b, c, m] if [a, b, c] == [z, y, x] => (m, Some(n)),
        _ => return None,
    };
    let [scalars, vectors, normals] = active.each_ref().map(|active| active.as_deref() == Some(name.as_str()));
    let steps = steps.map(|n| usize::try_from(n).unwrap_or(usize::MAX));
    let (components, type_name) = (usize::try_from(components).ok().filter(|n| *n > 0)?, scalar.to_string());
    let place = Stored { dataset, scalar, endian, steps };
    Some(Array {
        name,
        type_name,
        components,
        cell_data,
        active: scalars,
        is_vector: vectors || normals,
        are_normals: false,
        are_colors: false,
        place,
    })
}
