//! Zarr versions 2 and 3, and OME-Zarr (<https://zarr.dev>, <https://ngff.openmicroscopy.org>): compressed chunks in folders, of this
//! machine or of web servers.

mod array;
mod blosc;
mod codec;
mod coordinates;
mod crc32c;
#[cfg(feature = "http")]
mod http;
mod multiscales;
mod node;
mod omero;
mod pieces;
mod shards;
mod store;

use super::axes::{Axis, Roles};
use super::conventions::Packed;
use super::load::{self, Header, Opened};
use super::parts::Kept;
use super::{Format, Found, OpenOptions, choice, numbered};
use crate::error::Error;
use crate::memory;
use crate::panics::caught;
use crate::url;
use crate::volume::labels::{self, Declared};
use crate::volume::{ChannelDescription, Contents, Level, LevelLattice, VoxelBox};
use array::Array;
use glam::{DAffine3, DVec3};
use multiscales::Multiscales;
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
        url::is_url(file.path) || file.folder && node::is_node(file.path)
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array", "level", "region"]
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
        let (array, axes) = match node {
            Node::Image(image) => level(&path, image, options, &mut contents)?,
            Node::Array(_) if options.level.is_some_and(Level::is_demanded) => {
                let problem = format!("{} is an array with one resolution: omit it", path.display());
                return Err(Error::Settings { field: "level", problem });
            }
            Node::Array(array) => {
                let axes = named(&path, &array);
                contents.chunks = vec![Roles::new(&axes, array.shape.len()).dims(&array.chunks)];
                (*array, axes)
            }
            Node::Group => return Err(Error::volume(&path, "it is a group of arrays: select one of them")),
        };
        let roles = Roles::new(&axes, array.shape.len());
        let at = roles.choose(&path, options, &array.shape, &mut contents)?;
        let window = |described: Vec<ChannelDescription>| described.into_iter().nth(contents.channel)?.window;
        contents.window = omero::channels(&node::ome(&path, "omero")?).ok().and_then(window);
        let place = roles.place(&path, &axes, &array.shape, &mut contents);
        let dims = roles.dims(&array.shape);
        let part = part_of(options, contents.levels.first().copied().unwrap_or(dims), dims)?;
        let bytes = part.dims.iter().fold(array.scalar.bytes() as u64, |n, &size| n.saturating_mul(size as u64));
        if let Some(most) = most_downloaded(&path, options).filter(|&most| bytes > most) {
            let level = contents.level;
            let which = if contents.levels.is_empty() { String::new() } else { format!(" of level {level}") };
            let problem =
                format!("is {most} bytes, but the voxels{which} of {} are {bytes}: raise it, or choose a region", path.display());
            return Err(Error::Settings { field: "download", problem });
        }
        let place = place * DAffine3::from_translation(DVec3::from_array(part.first.map(|n| n as f64)));
        // A spacing that is given is that of the finest level.
        let coarser = contents.lattices.get(contents.level).map_or(DVec3::ONE, |lattice| lattice.step);
        let options = &OpenOptions { spacing: options.spacing.map(|spacing| spacing * coarser), ..options.clone() };
        let grid = load::grid(&path, part.dims, place, options)?;
        let is_known = contents.states_spacing || options.spacing.is_some();
        let finest = grid.spacing() / if is_known { coarser } else { DVec3::ONE };
        let grid = grid.with_unit(finest.min_element());
        let Packed { scalar, rescale, missing } = array.packed().map_err(|e| Error::volume(&path, e.to_string()))?;
        let header = Header { endian: array.endian, rescale, missing, contents, ..Header::new(grid, scalar) };
        let bytes = pieces::Pieces::new(array, roles.space, at).filling_refused(options.fills_refused);
        let (bytes, before) = bytes.of_part(part);
        let header = Header { first: before * scalar.bytes() as u64, ..header };
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
    if let Some(wanted) = wanted.filter(|wanted| url::is_url(path) && numbered::leads_below(wanted)) {
        // Without lists, it is looked for.
        let below = path.join(wanted);
        match node::found(&below) {
            Err(e) if node::is_refused(&e) && node::below(path).is_ok() => {}
            found => {
                if let Some(node) = found? {
                    return Ok((below, node));
                }
            }
        }
    }
    let names = node::below(path)?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let first = names.first().ok_or_else(|| Error::volume(path, "it is a Zarr group without arrays"))?;
    let index = choice::named(path, wanted, &names, first)?.unwrap_or(0);
    let below = path.join(names[index]);
    let node = node::node(&below)?;
    Ok((below, node))
}

/// The array of the selected resolution, and its axes. Adds the resolutions to `contents`.
fn level(path: &Path, image: Multiscales, options: &OpenOptions, contents: &mut Contents) -> Result<(Array, Vec<Axis>), Error> {
    let mut arrays = Vec::new();
    for (level, node) in image.levels.iter().zip(nodes_of(path, &image)) {
        let folder = path.join(&level.path);
        match node? {
            Some(Node::Array(array)) if array.shape.len() == level.axes.len() => arrays.push(*array),
            Some(Node::Array(array)) => {
                let problem =
                    format!("it has {} axes, but its multiscales metadata have {}", array.shape.len(), level.axes.len());
                return Err(Error::volume(&folder, problem));
            }
            _ => return Err(Error::volume(path, format!("its resolution level {} is not an array below it", level.path))),
        }
    }
    let finest = &image.levels[0].axes;
    let roles = Roles::new(finest, finest.len());
    let sizes = |array: &Array| roles.dims(&array.shape);
    let parts: Vec<[usize; 3]> =
        arrays.iter().map(|array| Ok(part_of(options, sizes(&arrays[0]), sizes(array))?.dims)).collect::<Result<_, Error>>()?;
    let bytes = |n: usize| parts[n].iter().fold(arrays[n].scalar.bytes() as u64, |n, &size| n.saturating_mul(size as u64));
    let download = most_downloaded(path, options).unwrap_or(u64::MAX);
    let count = arrays.len();
    contents.levels = arrays.iter().map(sizes).collect();
    contents.lattices = image.levels.iter().map(|level| lattice(roles.space, &level.axes, finest)).collect();
    let finest_within = |most: u64| (0..count).find(|&n| bytes(n) <= most).unwrap_or(count - 1);
    let index = match options.level {
        Some(Level::Number(n)) if n < count => n,
        Some(Level::Number(n)) => {
            let problem = format!("{n} is not in {}, whose levels are 0 to {}", path.display(), count - 1);
            return Err(Error::Settings { field: "level", problem });
        }
        Some(Level::Pixels(pixels)) => {
            let scale = roles.space.map(|axis| axis.map_or(1.0, |axis| finest[axis].step));
            let wanted = wanted(parts[0], scale, pixels);
            parts.iter().rposition(|part| part.iter().zip(wanted).all(|(&size, wanted)| size >= wanted)).unwrap_or(0)
        }
        Some(Level::Bytes(most)) => finest_within(most.min(download)),
        Some(Level::Overview) => contents.overview_level().unwrap_or(count - 1).max(finest_within(download)),
        None => finest_within(download.min(memory::available() / SHARE)),
    };
    let name = path.display();
    let index = match options.level {
        Some(Level::Pixels(_)) if bytes(index) > download => {
            let coarser = finest_within(download).max(index);
            tracing::warn!(
                "{name}: using level {coarser} of {count}: level {index}, which pictures of this size show, has more bytes than download"
            );
            coarser
        }
        None | Some(Level::Bytes(_)) if index > 0 => {
            let limit = if download < u64::MAX { "memory and into download" } else { "memory" };
            tracing::warn!(
                "{name}: using level {index} of {count}, the finest that fits into {limit}; select another with level"
            );
            index
        }
        _ => {
            tracing::info!("{name}: level {index} of {count}");
            index
        }
    };
    if image.moved && index > 0 {
        tracing::info!("{name}: its metadata move no level: level {index} is moved so that its voxels cover those of level 0");
    }
    contents.chunks = arrays.iter().map(|array| roles.dims(&array.chunks)).collect();
    contents.level = index;
    Ok((arrays.swap_remove(index), image.levels[index].axes.clone()))
}

/// Where the voxels of a level lie among those of the finest, along x, y and z.
fn lattice(space: [Option<usize>; 3], axes: &[Axis], finest: &[Axis]) -> LevelLattice {
    let along = |of: &dyn Fn(&Axis, &Axis) -> f64, otherwise: f64| {
        let of_axis = |axis: usize| Some(of(&axes[axis], &finest[axis])).filter(|number| number.is_finite()).unwrap_or(otherwise);
        DVec3::from_array(space.map(|axis| axis.map_or(otherwise, of_axis)))
    };
    let step = along(&|axis, finest| axis.step / finest.step, 1.0);
    LevelLattice { first: along(&|axis, finest| (axis.first - finest.first) / finest.step, 0.0), step }
}

/// The voxels of a level of `dims` that cover the region of the options, which is in voxels of the finest level.
fn part_of(options: &OpenOptions, finest: [usize; 3], dims: [usize; 3]) -> Result<VoxelBox, Error> {
    let Some(region) = options.region else { return Ok(VoxelBox::whole(dims)) };
    let mut part = VoxelBox::whole(dims);
    for i in 0..3 {
        if region.first[i] >= finest[i] || region.dims[i] == 0 {
            let (axis, first, last) = (["x", "y", "z"][i], region.first[i], finest[i] - 1);
            let problem = format!("begins at {first} along {axis}, where the finest level has voxels 0 to {last}, or has none");
            return Err(Error::Settings { field: "region", problem });
        }
        let scaled = |n: usize| n as u128 * dims[i] as u128;
        let end = scaled(region.end(i).min(finest[i])).div_ceil(finest[i] as u128) as usize;
        part.first[i] = ((scaled(region.first[i]) / finest[i] as u128) as usize).min(dims[i] - 1);
        part.dims[i] = end.min(dims[i]) - part.first[i];
    }
    Ok(part)
}

/// Most bytes of voxels that are read; `None` of files of this machine.
fn most_downloaded(path: &Path, options: &OpenOptions) -> Option<u64> {
    url::is_url(path).then(|| options.download.unwrap_or(OpenOptions::DOWNLOAD))
}

/// The nodes of all levels, asked for at once where that takes long; `None` of those that lead elsewhere.
fn nodes_of(path: &Path, image: &Multiscales) -> Vec<Result<Option<Node>, Error>> {
    let node = |level: &multiscales::Level| {
        let folder = path.join(&level.path);
        if numbered::leads_below(&level.path) { caught(&folder, || node::node(&folder).map(Some)) } else { Ok(None) }
    };
    if !url::is_url(path) {
        return image.levels.iter().map(node).collect();
    }
    std::thread::scope(|scope| {
        let asked: Vec<_> = image.levels.iter().map(|level| scope.spawn(move || node(level))).collect();
        asked.into_iter().map(|thread| thread.join().expect("panics are caught")).collect()
    })
}

/// Voxels along each axis that a picture of `pixels` along the longest side can show, at most those of the finest level.
fn wanted(finest: [usize; 3], scale: [f64; 3], pixels: usize) -> [usize; 3] {
    let extents = [0, 1, 2].map(|i| finest[i] as f64 * scale[i].abs());
    let longest = extents.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    [0, 1, 2].map(|i| finest[i].min((pixels as f64 * extents[i] / longest).ceil() as usize))
}

/// Axes named in the array metadata, at the coordinates of the arrays of the same names beside it. Without names, a last axis of up to
/// four numbers holds channels, as for NumPy.
fn named(path: &Path, array: &Array) -> Vec<Axis> {
    let shape = &array.shape;
    if array.names.is_empty() && shape.len() > 3 && shape.last().is_some_and(|&size| size <= MOST_CHANNELS) {
        let mut axes = vec![Axis::default(); shape.len()];
        axes.iter_mut().last().into_iter().for_each(|axis| axis.kind = "channel".into());
        return axes;
    }
    array.names.iter().map(|name| coordinates::axis(path, name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_covered_at_every_level() {
        let part = |first: [usize; 3], dims: [usize; 3], of: [usize; 3]| {
            let options = OpenOptions { region: Some(VoxelBox { first, dims }), ..OpenOptions::default() };
            part_of(&options, [100, 80, 7], of).map(|part| (part.first, part.dims))
        };
        assert_eq!(part([10, 20, 2], [30, usize::MAX, 3], [100, 80, 7]).unwrap(), ([10, 20, 2], [30, 60, 3]));
        assert_eq!(part([11, 20, 2], [30, 1, 3], [50, 40, 4]).unwrap(), ([5, 10, 1], [16, 1, 2]));
        assert_eq!(part([99, 79, 6], [1, 1, 1], [1, 1, 1]).unwrap(), ([0; 3], [1; 3]));
        for (first, dims) in [([100, 0, 0], [1; 3]), ([0; 3], [1, 0, 1])] {
            assert!(part(first, dims, [50, 40, 4]).unwrap_err().to_string().contains("region"));
        }
    }

    #[test]
    fn pictures_want_voxels_along_every_axis() {
        // An axis never gets finer than the finest level.
        assert_eq!(wanted([256, 256, 128], [1.0, 1.0, 1.0], 100), [100, 100, 50]);
        assert_eq!(wanted([5, 4, 3], [0.5, 0.5, 2.0], 5), [3, 2, 3]);
        assert_eq!(wanted([8, 8, 1], [1.0, 1.0, 0.0], 4), [4, 4, 0]);
    }
}
