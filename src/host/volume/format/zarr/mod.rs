//! Zarr versions 2 and 3, and OME-Zarr (<https://zarr.dev>, <https://ngff.openmicroscopy.org>): folders of compressed chunks.

mod array;
mod blosc;
mod codec;
mod multiscales;
mod node;
mod omero;
mod pieces;

use super::load::{self, Header, Opened, upright};
use super::parts::Kept;
use super::{Format, Found, OpenOptions, choice};
use crate::error::Error;
use crate::memory;
use crate::volume::labels::{self, Declared};
use crate::volume::{ChannelDescription, Contents, FrameSpacing, Level};
use array::Array;
use glam::DVec3;
use multiscales::{Axis, Multiscales};
use node::Node;
use std::path::{Path, PathBuf};

/// Zarr.
pub(super) struct Zarr;

/// A default level may take 1/`SHARE` of the available memory, because rendering needs as much again.
const SHARE: u64 = 2;
/// Without names, the last of four or more axes holds channels if its size is at most this.
const MOST_CHANNELS: usize = 4;

impl Format for Zarr {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.folder && node::is_node(file.path)
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array", "level"]
    }

    fn labels(&self, file: &Found, options: &OpenOptions) -> Result<Option<Declared>, Error> {
        let path = chosen_quietly(file.path, options)?;
        let metadata = node::ome(&path, "image-label")?;
        if metadata.is_null() {
            return Ok(None);
        }
        let table = labels::image_label(&metadata).map_err(|problem| Error::volume(&path, problem))?;
        Ok(Some(Declared { layers: vec![table] }))
    }

    fn channels(&self, file: &Found, options: &OpenOptions, _: usize) -> Result<Vec<ChannelDescription>, Error> {
        let path = chosen_quietly(file.path, options)?;
        omero::channels(&node::ome(&path, "omero")?).map_err(|problem| Error::volume(&path, problem))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let (path, node) = chosen(file.path, options)?;
        let mut contents = Contents::default();
        let Placed { array, axes, scale, translation } = match node {
            Node::Image(image) => level(&path, image, options, &mut contents)?,
            Node::Array(_) if options.level.is_some_and(Level::is_demanded) => {
                let problem = format!("{} is an array with one resolution: omit it", path.display());
                return Err(Error::Settings { field: "level", problem });
            }
            Node::Array(array) => {
                contents.states_spacing = false;
                let axes = named(&array);
                let count = array.shape.len();
                Placed { array: *array, axes, scale: vec![1.0; count], translation: vec![0.0; count] }
            }
            Node::Group => return Err(Error::volume(&path, "it is a group of arrays: select one of them")),
        };
        let roles = Roles::new(&axes, array.shape.len());
        let mut place = vec![0; array.shape.len()];
        let frame = contents.choose_frame(&path, options, array.product(&roles.frames))?;
        array.place(&roles.frames, frame, &mut place);
        let channel = contents.choose_channel(&path, options, array.product(&roles.channels))?;
        array.place(&roles.channels, channel, &mut place);
        contents.frame_spacing = roles.frame_spacing(&axes, &scale);
        let along =
            |from: &[f64], missing: f64| DVec3::from_array(roles.space.map(|axis| axis.map_or(missing, |axis| from[axis])));
        let dims = roles.space.map(|axis| axis.map_or(1, |axis| array.shape[axis]));
        let grid = load::grid(&path, dims, upright(along(&scale, 1.0), along(&translation, 0.0)), options)?;
        let header = Header { endian: array.endian, contents, ..Header::new(grid, array.scalar) };
        let bytes = pieces::Pieces::new(array, roles.space, place);
        Ok(Opened { header, bytes: Box::new(Kept::new(bytes)), exact: false })
    }
}

/// The folder of [`chosen`], without a warning: opening the file gives it.
fn chosen_quietly(path: &Path, options: &OpenOptions) -> Result<PathBuf, Error> {
    let array = match options.array {
        None if matches!(node::node(path)?, Node::Group) => node::below(path)?.into_iter().next(),
        ref given => given.clone(),
    };
    chosen(path, &OpenOptions { array, ..options.clone() }).map(|(path, _)| path)
}

/// The array or image of a folder, or the selected one inside.
fn chosen(path: &Path, options: &OpenOptions) -> Result<(PathBuf, Node), Error> {
    let node = node::node(path)?;
    let wanted = options.array.as_deref();
    if !matches!(node, Node::Group) && wanted.is_none() {
        return Ok((path.into(), node));
    }
    let names = node::below(path)?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let first = names.first().ok_or_else(|| Error::volume(path, "it is a Zarr group without arrays"))?;
    let index = choice::named(path, wanted, &names, first)?.unwrap_or(0);
    let below = path.join(names[index]);
    let node = node::node(&below)?;
    Ok((below, node))
}

/// An array, its axes, and its scale and translation per axis.
struct Placed {
    array: Array,
    axes: Vec<Axis>,
    scale: Vec<f64>,
    translation: Vec<f64>,
}

/// The array of the selected resolution. Adds the resolutions to `contents`.
fn level(path: &Path, image: Multiscales, options: &OpenOptions, contents: &mut Contents) -> Result<Placed, Error> {
    let mut arrays = Vec::new();
    for level in &image.levels {
        let folder = path.join(&level.path);
        match node::leads_below(&level.path).then(|| node::node(&folder)).transpose()? {
            Some(Node::Array(array)) if array.shape.len() == level.scale.len() => arrays.push(*array),
            Some(Node::Array(array)) => {
                let problem =
                    format!("it has {} axes, but its multiscales metadata have {}", array.shape.len(), level.scale.len());
                return Err(Error::volume(&folder, problem));
            }
            _ => return Err(Error::volume(path, format!("its resolution level {} is not an array below it", level.path))),
        }
    }
    let roles = Roles::new(&image.axes, image.axes.len());
    let sizes = |array: &Array| roles.space.map(|axis| axis.map_or(1, |axis| array.shape[axis]));
    let coarsest = |fits: &dyn Fn(&Array) -> bool| arrays.iter().rposition(fits).unwrap_or(0);
    let count = arrays.len();
    let index = match options.level {
        Some(Level::Number(n)) if n < count => n,
        Some(Level::Number(n)) => {
            let problem = format!("{n} is not in {}, whose levels are 0 to {}", path.display(), count - 1);
            return Err(Error::Settings { field: "level", problem });
        }
        Some(Level::Pixels(pixels)) => {
            let scale = roles.space.map(|axis| axis.map_or(1.0, |axis| image.levels[0].scale[axis]));
            let wanted = wanted(sizes(&arrays[0]), scale, pixels);
            coarsest(&|array| sizes(array).iter().zip(wanted).all(|(&size, wanted)| size >= wanted))
        }
        Some(Level::Bytes(_)) | None => {
            let bytes =
                |array: &Array| sizes(array).iter().fold(array.scalar.bytes() as u64, |n, &size| n.saturating_mul(size as u64));
            let most = match options.level {
                Some(Level::Bytes(most)) => most,
                _ => memory::available() / SHARE,
            };
            arrays.iter().position(|array| bytes(array) <= most).unwrap_or(count - 1)
        }
    };
    if !options.level.is_some_and(Level::is_demanded) && index > 0 {
        tracing::warn!(
            "{}: using level {index} of {count}, the finest that fits into memory; select another with level",
            path.display()
        );
    } else {
        tracing::info!("{}: level {index} of {count}", path.display());
    }
    contents.levels = arrays.iter().map(sizes).collect();
    contents.level = index;
    let level = &image.levels[index];
    let array = arrays.swap_remove(index);
    Ok(Placed { array, scale: level.scale.clone(), translation: level.translation.clone(), axes: image.axes })
}

/// Voxels along each axis that a picture of `pixels` along the longest side can show, at most those of the finest level.
fn wanted(finest: [usize; 3], scale: [f64; 3], pixels: usize) -> [usize; 3] {
    let extents = [0, 1, 2].map(|i| finest[i] as f64 * scale[i].abs());
    let longest = extents.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    [0, 1, 2].map(|i| finest[i].min((pixels as f64 * extents[i] / longest).ceil() as usize))
}

/// Axes named in the array metadata. Without names, a last axis of up to four numbers holds channels, as for NumPy.
fn named(array: &Array) -> Vec<Axis> {
    let shape = &array.shape;
    if array.names.is_empty() && shape.len() > 3 && shape.last().is_some_and(|&size| size <= MOST_CHANNELS) {
        let mut axes = vec![Axis::default(); shape.len()];
        axes.iter_mut().last().into_iter().for_each(|axis| axis.kind = "channel".into());
        return axes;
    }
    array.names.iter().map(|name| Axis { name: name.clone(), ..Axis::default() }).collect()
}

/// Roles of the axes of an array.
struct Roles {
    /// Axes of x, y and z.
    space: [Option<usize>; 3],
    frames: Vec<usize>,
    channels: Vec<usize>,
}

impl Roles {
    /// Roles by type or name. By default the last three axes are z, y and x, and those before them frames.
    fn new(axes: &[Axis], count: usize) -> Self {
        let is = |i: usize, kind: &str, names: &[&str]| {
            let axis = axes.get(i);
            axis.is_some_and(|axis| axis.kind == kind || names.contains(&axis.name.to_ascii_lowercase().as_str()))
        };
        let channels: Vec<usize> = (0..count).filter(|&i| is(i, "channel", &["c", "channel"])).collect();
        let mut frames: Vec<usize> = (0..count).filter(|&i| is(i, "time", &["t", "time"])).collect();
        let rest: Vec<usize> = (0..count).filter(|i| !channels.contains(i) && !frames.contains(i)).collect();
        let (before, last) = rest.split_at(rest.len().saturating_sub(3));
        frames.extend(before);
        frames.sort_unstable();
        let is_called = |i: usize, name: &str| axes.get(i).is_some_and(|axis| axis.name.eq_ignore_ascii_case(name));
        let by_name = |name: &str| last.iter().copied().find(|&i| is_called(i, name));
        let named = ["x", "y", "z"].map(by_name);
        let by_order = [0, 1, 2].map(|n| last.len().checked_sub(n + 1).map(|i| last[i]));
        let space = if named.iter().flatten().count() == last.len() { named } else { by_order };
        Self { space, frames, channels }
    }

    /// Distance between frames, if they have one axis that is called time and whose unit is stated.
    fn frame_spacing(&self, axes: &[Axis], scale: &[f64]) -> Option<FrameSpacing> {
        let [axis] = self.frames[..] else { return None };
        let unit = axes.get(axis).map(|axis| axis.unit.as_str()).filter(|unit| !unit.is_empty())?;
        FrameSpacing::new(scale[axis], Some(if unit == "second" { "s" } else { unit }))
    }
}

impl Array {
    /// Number of positions along `axes`.
    fn product(&self, axes: &[usize]) -> usize {
        axes.iter().fold(1usize, |n, &axis| n.saturating_mul(self.shape[axis]))
    }

    /// Sets position `number` along `axes`, counted with the last axis fastest.
    fn place(&self, axes: &[usize], mut number: usize, place: &mut [usize]) {
        for &axis in axes.iter().rev() {
            place[axis] = number % self.shape[axis];
            number /= self.shape[axis];
        }
    }
}

/// Strides in bytes, last axis fastest.
fn strides(shape: &[usize], size: usize) -> Vec<usize> {
    let mut strides = vec![size; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis];
    }
    strides
}

/// Position of item `n` in a grid of `counts` items, last axis fastest.
fn place(mut n: usize, counts: &[usize]) -> Vec<usize> {
    let mut place = vec![0; counts.len()];
    for axis in (0..counts.len()).rev() {
        place[axis] = n % counts[axis];
        n /= counts[axis];
    }
    place
}

/// Copies a box of numbers of `size` bytes between two strided layouts.
fn copy(from: &[u8], from_strides: &[usize], to: &mut [u8], to_strides: &[usize], shape: &[usize], size: usize) {
    let ([count, shape @ ..], [step, from_strides @ ..], [stride, to_strides @ ..]) = (shape, from_strides, to_strides) else {
        to[..size].copy_from_slice(&from[..size]);
        return;
    };
    if shape.is_empty() && *step == size && *stride == size {
        to[..count * size].copy_from_slice(&from[..count * size]);
        return;
    }
    for n in 0..*count {
        copy(&from[n * step..], from_strides, &mut to[n * stride..], to_strides, shape, size);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roles(names: &[&str]) -> ([Option<usize>; 3], Vec<usize>, Vec<usize>) {
        let axes: Vec<Axis> = names.iter().map(|name| Axis { name: (*name).into(), ..Axis::default() }).collect();
        let found = Roles::new(&axes, names.len());
        (found.space, found.frames, found.channels)
    }

    #[test]
    fn axes_are_told_by_their_names_or_their_order() {
        assert_eq!(roles(&["t", "c", "z", "y", "x"]), ([Some(4), Some(3), Some(2)], vec![0], vec![1]));
        assert_eq!(roles(&["x", "y", "z", "c"]), ([Some(0), Some(1), Some(2)], vec![], vec![3]));
        assert_eq!(roles(&["", "", "", ""]), ([Some(3), Some(2), Some(1)], vec![0], vec![]));
        assert_eq!(roles(&["lat", "lon"]), ([Some(1), Some(0), None], vec![], vec![]));
    }

    #[test]
    fn times_are_apart_where_a_unit_says_so() {
        let axis = |name: &str, unit: &str| Axis { name: name.into(), unit: unit.into(), ..Axis::default() };
        let apart = |unit: &str| {
            let axes = [axis("t", unit), axis("z", ""), axis("y", ""), axis("x", "")];
            Roles::new(&axes, 4).frame_spacing(&axes, &[0.5, 1.0, 1.0, 1.0])
        };
        assert_eq!(apart("second"), FrameSpacing::new(0.5, Some("s")));
        assert_eq!(apart("hour"), FrameSpacing::new(0.5, Some("hour")));
        assert_eq!(apart(""), None);
    }

    #[test]
    fn pictures_want_voxels_along_every_axis() {
        // An axis never gets finer than the finest level.
        assert_eq!(wanted([256, 256, 128], [1.0, 1.0, 1.0], 100), [100, 100, 50]);
        assert_eq!(wanted([5, 4, 3], [0.5, 0.5, 2.0], 5), [3, 2, 3]);
        assert_eq!(wanted([8, 8, 1], [1.0, 1.0, 0.0], 4), [4, 4, 0]);
    }

    #[test]
    fn boxes_are_copied_between_orders() {
        let from: Vec<u8> = (0..24).collect();
        let mut to = vec![0; 24];
        copy(&from, &[12, 4, 1], &mut to, &[1, 2, 6], &[2, 3, 4], 1);
        assert_eq!(to[..8], [0, 12, 4, 16, 8, 20, 1, 13]);
    }
}
