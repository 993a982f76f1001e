//! MINC 2 (<https://en.wikibooks.org/wiki/MINC>): axes of a patient, and slices whose numbers are scaled each by a range of its own.

use super::attributes::texts;
use super::find::damaged;
use super::{Declared, number_list};
use crate::error::Error;
use crate::volume::format::axes::Roles;
use crate::volume::format::conventions::Attributes;
use crate::volume::format::parts::Parts;
use crate::volume::format::strided;
use crate::volume::missing_data::MissingData;
use crate::volume::wide::Numbers;
use crate::volume::{Contents, Endian, FrameSpacing, Rescale, ScalarType};
use glam::{DAffine3, DVec3};
use hdf5_reader::{Dataset, Hdf5File};
use std::io;
use std::path::Path;

/// The group that makes a file MINC 2.
pub(super) const GROUP: &str = "minc-2.0";
/// The image of full resolution.
pub(super) const IMAGE: &str = "minc-2.0/image/0/image";
/// Axes in order of x, y and z: those of space, and of its Fourier transform.
const SPACE: [[&str; 2]; 3] = [["xspace", "xfrequency"], ["yspace", "yfrequency"], ["zspace", "zfrequency"]];
const TIME: [&str; 2] = ["time", "tfrequency"];

/// What the file declares about its voxels.
///
/// # Errors
/// If axes have no names, or are not evenly spaced.
pub(super) fn declared(path: &Path, file: &Hdf5File, dataset: &Dataset) -> Result<Declared, Error> {
    let names = names(dataset);
    if names.len() != dataset.ndim() {
        let problem = format!("its dimorder names {} axes, and its image has {}: it is damaged", names.len(), dataset.ndim());
        return Err(Error::volume(path, problem));
    }
    let find = |known: [&str; 2]| names.iter().position(|name| known.contains(&name.as_str()));
    let (space, time) = (SPACE.map(find), find(TIME));
    let channels = (0..names.len()).filter(|axis| !space.contains(&Some(*axis)) && time != Some(*axis)).collect();
    let dimension = |axis: usize| file.dataset(&format!("{GROUP}/dimensions/{}", names[axis])).ok();
    let number = |axis: usize, name: &str| dimension(axis)?.numbers(name)?.0.first().copied().filter(|n| n.is_finite());
    let mut index_to_world = DAffine3::IDENTITY;
    for (n, axis) in space.into_iter().enumerate() {
        let Some(axis) = axis else { continue };
        let found = dimension(axis);
        if found.as_ref().and_then(|found| found.text("spacing")).is_some_and(|spacing| spacing.starts_with("irregular")) {
            let problem = format!("its slices along {} are unevenly spaced: resample it (mincresample)", names[axis]);
            return Err(Error::volume(path, problem));
        }
        let cosines = found.and_then(|found| found.numbers("direction_cosines")).and_then(|(cosines, _)| cosines.try_into().ok());
        let direction = cosines.map_or(DVec3::AXES[n], DVec3::from_array).normalize_or(DVec3::AXES[n]);
        *index_to_world.matrix3.col_mut(n) = direction * number(axis, "step").filter(|step| *step != 0.0).unwrap_or(1.0);
        index_to_world.translation += direction * number(axis, "start").unwrap_or(0.0);
    }
    let mut contents = Contents { length_unit: Some("mm".into()), ..Contents::default() };
    contents.frame_spacing = time.and_then(|axis| FrameSpacing::new(number(axis, "step")?, Some("s")));
    let roles = Roles { space, frames: time.into_iter().collect(), channels };
    Ok(Declared { roles, index_to_world, is_anatomical: true, contents })
}

/// Names of the axes of a data set.
fn names(dataset: &Dataset) -> Vec<String> {
    let order = texts(dataset, "dimorder").join(",");
    order.split(',').map(str::trim).filter(|name| !name.is_empty()).map(Into::into).collect()
}

/// How stored numbers become values: from their valid range to the range of their slice. Floats are values.
pub(super) enum Scaling {
    /// The same in all slices.
    One(Rescale, MissingData),
    /// Those of slices.
    Each(Scales),
}

/// A slope and an intercept for each position along the first axes.
pub(super) struct Scales {
    scales: Vec<[f64; 2]>,
    /// Positions along these axes.
    counts: Vec<usize>,
    missing: MissingData,
}

/// How the numbers of a data set are scaled.
///
/// # Errors
/// If ranges are missing, or belong to other axes.
pub(super) fn scaling(path: &Path, file: &Hdf5File, dataset: &Dataset, scalar: ScalarType) -> Result<Scaling, Error> {
    let Some(type_range) = range_of(scalar) else { return Ok(Scaling::One(Rescale::default(), MissingData::default())) };
    let wrong = |problem: String| Error::volume(path, problem);
    let valid = dataset.numbers("valid_range").map(|(numbers, _)| numbers).unwrap_or_default();
    let (lo, hi) = match valid[..] {
        [a, b] if a != b => (a.min(b), a.max(b)),
        _ => type_range,
    };
    let ranges = |name: &str| -> Result<(Vec<f64>, Vec<usize>), Error> {
        let found = file.dataset(&format!("{GROUP}/image/0/{name}")).map_err(|e| damaged(path, &e))?;
        let shape: Vec<usize> = found.shape().iter().map(|&n| n as usize).collect();
        let is_of_slices = shape.len() < dataset.ndim() && shape.iter().zip(dataset.shape()).all(|(a, b)| *a as u64 == *b);
        let has_order = shape.is_empty() || names(&found).is_empty() || names(dataset).starts_with(&names(&found));
        let numbers = number_list(&found).filter(|_| is_of_slices && has_order);
        let numbers =
            numbers.ok_or_else(|| wrong(format!("its {name} is not one number for each of its slices: it is damaged")))?;
        Ok((numbers, shape))
    };
    let ((least, counts), (most, other)) = (ranges("image-min")?, ranges("image-max")?);
    if counts != other {
        return Err(wrong("its image-min and image-max have different sizes: it is damaged".into()));
    }
    let missing = MissingData::new(Vec::new(), (lo, hi));
    let scale = |(least, most): (&f64, &f64)| {
        let slope = (most - least) / (hi - lo);
        [slope, least - slope * lo]
    };
    let scales: Vec<[f64; 2]> = least.iter().zip(&most).map(scale).collect();
    match scales[..] {
        // Slices of one value have no slope, which a rescale needs.
        [first @ [slope, intercept], ref rest @ ..] if slope != 0.0 && rest.iter().all(|other| *other == first) => {
            let rescale = Rescale::new(slope, intercept).map_err(|e| wrong(e.to_string()))?;
            Ok(Scaling::One(rescale, missing))
        }
        [] => Err(wrong("its image-min and image-max are empty: it is damaged".into())),
        _ => Ok(Scaling::Each(Scales { scales, counts, missing })),
    }
}

/// The range of a whole number's type; `None` for floats.
fn range_of(scalar: ScalarType) -> Option<(f64, f64)> {
    use ScalarType::*;
    let bits = 8 * scalar.bytes() as i32;
    match scalar {
        Uint8 | Uint16 | Uint32 | Uint64 => Some((0.0, 2f64.powi(bits) - 1.0)),
        Int8 | Int16 | Int32 | Int64 => Some((-(2f64.powi(bits - 1)), 2f64.powi(bits - 1) - 1.0)),
        Float16 | Float32 | Float64 => None,
    }
}

/// Numbers along z, y and x as values: 32-bit floats in this machine's byte order.
pub(super) struct Scaled<P> {
    stored: P,
    scalar: ScalarType,
    endian: Endian,
    scales: Scales,
    /// Of the scales: the first one, and strides along x, y and z.
    first: usize,
    strides: [usize; 3],
    /// Voxels along x, y and z.
    dims: [usize; 3],
}

impl<P> Scaled<P> {
    /// The values of voxels at `place` along the axes that are not of space.
    pub fn new(
        stored: P,
        (scalar, endian): (ScalarType, Endian),
        scales: Scales,
        roles: &Roles,
        place: &[usize],
        dims: [usize; 3],
    ) -> Self {
        let along = strided::strides(&scales.counts, 1);
        let stride = |axis: Option<usize>| axis.and_then(|axis| along.get(axis)).copied().unwrap_or(0);
        let first = along.iter().zip(place).map(|(stride, place)| stride * place).sum();
        Self { stored, scalar, endian, scales, first, strides: roles.space.map(stride), dims }
    }

    /// The scale of voxel `n`.
    fn scale(&self, n: usize) -> [f64; 2] {
        let [x, y, _] = self.dims;
        let at = [n % x, n / x % y, n / (x * y)];
        self.scales.scales[self.first + (0..3).map(|i| at[i] * self.strides[i]).sum::<usize>()]
    }
}

impl<P: Parts> Parts for Scaled<P> {
    fn most(&self) -> u64 {
        self.whole()
    }

    fn whole(&self) -> u64 {
        self.stored.whole() / self.scalar.bytes() as u64 * size_of::<f32>() as u64
    }

    fn each(&self) -> u64 {
        self.stored.each() / self.scalar.bytes() as u64 * size_of::<f32>() as u64
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        let first = index * (self.stored.each() / self.scalar.bytes() as u64) as usize;
        let bytes = self.stored.part(index)?;
        let numbers = Numbers { bytes: &bytes, scalar: self.scalar, endian: self.endian, missing: Some(&self.scales.missing) };
        let value = |n: usize| {
            let [slope, intercept] = self.scale(first + n);
            (slope * numbers.get(n) + intercept) as f32
        };
        Ok((0..numbers.count()).flat_map(|n| value(n).to_ne_bytes()).collect())
    }
}
