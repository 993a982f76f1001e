//! PolyData of VTK, XML and legacy.

mod legacy;
#[cfg(feature = "vtk")]
mod xml;

pub(super) use legacy::read as legacy;
#[cfg(feature = "vtk")]
pub(super) use xml::read as xml;

use super::{Per, SurfaceArray, SurfaceFile};
use crate::volume::vtk::arrays::Array;
use crate::volume::{Endian, Numbers, ScalarType};
use glam::{DVec3, Vec3};

/// Kinds of cells in the order in which arrays of cells have them: their tags in XML, and their keywords in legacy files.
const KINDS: [[&str; 2]; 4] = [["Verts", "VERTICES"], ["Lines", "LINES"], ["Polys", "POLYGONS"], ["Strips", "TRIANGLE_STRIPS"]];

/// Numbers of an array.
struct Stored {
    bytes: Vec<u8>,
    scalar: ScalarType,
    endian: Endian,
}

impl Stored {
    fn iter(&self) -> impl ExactSizeIterator<Item = f64> {
        let numbers = Numbers::new(&self.bytes, self.scalar, self.endian);
        (0..numbers.count()).map(move |n| numbers.stored(n))
    }

    fn points(&self) -> Vec<DVec3> {
        let numbers: Vec<f64> = self.iter().collect();
        numbers.as_chunks().0.iter().map(|point| DVec3::from_array(*point)).collect()
    }

    /// Indices or offsets, of which `first` are before them in the file as a whole.
    fn whole(&self, first: usize) -> Result<Vec<u32>, String> {
        let index = |number: f64| {
            let is_one = number >= 0.0 && number.fract() == 0.0 && number + (first as f64) < f64::from(u32::MAX);
            if is_one { Ok((number as usize + first) as u32) } else { Err(format!("a cell has point {number}: it is damaged")) }
        };
        self.iter().map(index).collect()
    }
}

/// Cells of a kind: where the points of each end, and their points.
struct Declared {
    ends: Vec<u32>,
    points: Vec<u32>,
}

impl Declared {
    /// From lists of points behind their counts.
    fn counted(numbers: &[u32], count: u64) -> Result<Self, String> {
        let (mut ends, mut points) = (Vec::new(), Vec::with_capacity(numbers.len()));
        let mut rest = numbers;
        while let [length, more @ ..] = rest {
            let Some((own, others)) = more.split_at_checked(*length as usize) else {
                return Err(format!("cell {} has {length} points, more than there are: it is damaged", ends.len()));
            };
            points.extend(own);
            ends.push(points.len() as u32);
            rest = others;
        }
        if ends.len() as u64 != count {
            return Err(format!("it has {} cells of a kind of which it declares {count}: it is damaged", ends.len()));
        }
        Ok(Self { ends, points })
    }

    /// Adds the cells to a file. The first has this number among those of the file; returns that behind the last.
    fn add(&self, kind: usize, file: &mut SurfaceFile, mut number: u32) -> Result<u32, String> {
        let mut start = 0;
        for end in self.ends.iter().map(|end| *end as usize) {
            let Some(points) = self.points.get(start..end) else {
                return Err(format!("a cell has the points {start} to {end} of {}: it is damaged", self.points.len()));
            };
            match kind {
                0 => points.iter().for_each(|point| file.vertices.add(*point, number)),
                1 if points.len() > 1 => file.lines.add(points.into(), number),
                1 => {}
                2 => file.triangles.add_polygon(points, number),
                _ => file.triangles.add_strip(points, number),
            }
            (start, number) = (end, number.saturating_add(1));
        }
        Ok(number)
    }
}

/// Adds an array of all points or cells as what it is: normals, colours or values.
fn add_array<P>(file: &mut SurfaceFile, array: &Array<P>, stored: &Stored) {
    let per = |values| if array.cell_data { Per::Cell(values) } else { Per::Point(values) };
    let values: Vec<f32> = stored.iter().map(|number| number as f32).collect();
    let are_normals = array.are_normals || array.name == "Normals";
    if are_normals && !array.cell_data && array.components == 3 && file.normals.is_none() {
        file.normals = Some(values.as_chunks().0.iter().map(|normal| Vec3::from_array(*normal)).collect());
        return;
    }
    let are_colors = stored.scalar == ScalarType::Uint8 && matches!(array.components, 3 | 4);
    if are_colors && (file.colors.is_none() || array.active) {
        let color = |bytes: &[f32]| [0, 1, 2, 3].map(|i| bytes.get(i).map_or(1.0, |byte| byte / 255.0));
        let colors = values.chunks_exact(array.components).map(color).collect();
        file.colors = Some(if array.cell_data { Per::Cell(colors) } else { Per::Point(colors) });
        return;
    }
    file.arrays.push(SurfaceArray { name: array.name.clone(), components: array.components, values: per(values) });
}
