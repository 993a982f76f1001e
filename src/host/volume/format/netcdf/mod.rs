//! Classic NetCDF, before NetCDF-4 (<https://docs.unidata.ucar.edu/nug/current/file_format_specifications.html>): CDF-1, CDF-2 and CDF-5.

mod header;

use super::axes::{Axis, Roles};
use super::bytes::{self, Plain};
use super::conventions::{self, Attributes, Packed};
use super::load::{self, Header, Opened};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::wide::Numbers;
use crate::volume::{Contents, Endian};
use header::{Dataset, Variable};
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::Path;

/// Classic NetCDF.
pub(super) struct NetCdf;

/// What files begin with.
const MARKS: [&[u8; 4]; 3] = [b"CDF\x01", b"CDF\x02", b"CDF\x05"];
/// Limit of the positions along an axis that has coordinates.
const MOST: u64 = 1 << 20;
/// What is wrong with MINC 1.
const MINC: &str =
    "it is MINC 1, whose slices are scaled each by its own range, which is not read: convert it (mincconvert -2 IN OUT)";

impl Format for NetCdf {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        MARKS.iter().any(|mark| file.start.starts_with(*mark))
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array"]
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let dataset = Dataset::read(path)?;
        if dataset.variables.iter().any(|variable| variable.name == "image-max") {
            return Err(Error::volume(path, MINC));
        }
        let variable = chosen(path, &dataset, options)?;
        let wrong = |problem: String| Error::volume(path, format!("'{}' {problem}", variable.name));
        let stored = variable.scalar.ok_or_else(|| wrong("holds text: choose an array of numbers".into()))?;
        let shape: Option<Vec<usize>> =
            dataset.shape(variable).iter().map(|&n| usize::try_from(n).ok().filter(|&n| n > 0)).collect();
        let shape = shape.filter(|shape| !shape.is_empty()).ok_or_else(|| wrong("holds no voxels".into()))?;
        let axes: Vec<Axis> = variable.dimensions.iter().map(|&dimension| axis(path, &dataset, dimension)).collect();
        let roles = Roles::new(&axes, shape.len());
        let mut contents = Contents::default();
        let place = roles.choose(path, options, &shape, &mut contents)?;
        let to_world = roles.place(path, &axes, &shape, &mut contents);
        let dims = roles.dims(&shape);
        let grid = load::grid(path, dims, to_world, options)?;
        let packed = conventions::packed(stored, variable, conventions::netcdf_fill(stored));
        let Packed { scalar, rescale, missing } = packed.map_err(|e| Error::volume(path, e.to_string()))?;
        let along = dataset.strides(variable);
        let mut header = Header { endian: Endian::Big, rescale, missing, contents, ..Header::new(grid, scalar) };
        let moved = along.iter().zip(&place).map(|(stride, &at)| stride.saturating_mul(at as u64));
        header.first = moved.fold(variable.first, u64::saturating_add);
        // Axes that there are not have one position: any stride serves.
        header.strides = roles.space.map(|axis| axis.map_or(scalar.bytes() as u64, |axis| along[axis]));
        let bytes = File::open(path).and_then(|file| Plain::new(file, 0)).map_err(|e| Error::read(path, e))?;
        Ok(Opened { header, bytes: Box::new(bytes), exact: false })
    }
}

/// The variable that is asked for; else the only one of numbers along three axes or more, or along two if there is none.
fn chosen<'a>(path: &Path, dataset: &'a Dataset, options: &OpenOptions) -> Result<&'a Variable, Error> {
    let with_axes = |least: usize| {
        let is_one = move |variable: &&Variable| variable.scalar.is_some() && variable.dimensions.len() >= least;
        dataset.variables.iter().filter(is_one).collect::<Vec<_>>()
    };
    let volumes = Some(with_axes(3)).filter(|found| !found.is_empty()).unwrap_or_else(|| with_axes(2));
    let names = || volumes.iter().map(|variable| variable.name.as_str()).collect::<Vec<_>>().join(", ");
    let refuse = |problem: String| Err(Error::Settings { field: "array", problem });
    match (&options.array, &volumes[..]) {
        (Some(name), _) => match dataset.variables.iter().find(|variable| variable.name == name.trim_start_matches('/')) {
            Some(found) => Ok(found),
            None => refuse(format!("'{name}' is not in {}, whose arrays are {}", path.display(), names())),
        },
        (None, [only]) => Ok(only),
        (None, []) => Err(Error::volume(path, "it has no array of numbers along two axes or more")),
        (None, _) => refuse(format!("{} has several arrays: {}; choose one", path.display(), names())),
    }
}

/// An axis at the coordinates of the variable of its name, if there is such.
fn axis(path: &Path, dataset: &Dataset, dimension: usize) -> Axis {
    let name = &dataset.dimensions[dimension].name;
    let named = Axis::named(name.clone());
    let Some(variable) = dataset.variables.iter().find(|other| other.name == *name && other.dimensions == [dimension]) else {
        return named;
    };
    let axis = named.with_role(variable.text("axis").as_deref());
    match coordinates(path, dataset, variable) {
        Some(coordinates) => axis.at(&coordinates, variable.text("units").unwrap_or_default()),
        None => axis,
    }
}

/// The values of a variable along one axis.
fn coordinates(path: &Path, dataset: &Dataset, variable: &Variable) -> Option<Vec<f64>> {
    let ([count @ 1..=MOST], [stride]) = (&dataset.shape(variable)[..], &dataset.strides(variable)[..]) else { return None };
    let Packed { scalar, rescale, .. } = conventions::packed(variable.scalar?, variable, None).ok()?;
    let mut file = File::open(path).ok()?;
    let mut number = vec![0; scalar.bytes()];
    let mut all = Vec::new();
    for n in 0..*count {
        file.seek(SeekFrom::Start(variable.first.checked_add(n.checked_mul(*stride)?)?)).ok()?;
        if bytes::fill(&mut file, &mut number).ok()? < number.len() {
            return None;
        }
        let numbers = Numbers { bytes: &number, scalar, endian: Endian::Big, missing: None };
        all.push(rescale.value(numbers.stored(0)));
    }
    Some(all)
}
