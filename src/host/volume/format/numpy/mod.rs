//! NumPy arrays, `.npy`, and archives of them, `.npz`, with the feature `npz` (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).

mod header;
#[cfg(feature = "npz")]
mod npz;

#[cfg(feature = "npz")]
pub(super) use npz::Npz;

use super::bytes::{Bytes, Plain};
use super::load::{self, Header, Opened, upright};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::npy;
use crate::volume::Contents;
use glam::DVec3;
use header::Array;
use std::fs::File;
use std::path::Path;

/// NumPy array.
pub(super) struct Npy;

/// With four or more axes, the last axis holds channels if its size is at most this.
const MOST_CHANNELS: usize = 4;

impl Format for Npy {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.start.starts_with(npy::MARK)
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let failed = |e| Error::read(file.path, e);
        let bytes = Plain::new(File::open(file.path).map_err(failed)?, 0).map_err(failed)?;
        array(file.path, Box::new(bytes), options)
    }
}

/// Opens an array. Its last axes are z, y and x, possibly followed by an axis of up to four channels. All axes before are frames.
fn array(path: &Path, mut bytes: Box<dyn Bytes>, options: &OpenOptions) -> Result<Opened, Error> {
    let read = npy::Header::read(|at, into| bytes.read(at, into)).map_err(|e| Error::read(path, e))?;
    let found = read.and_then(Array::new).map_err(|problem| Error::volume(path, problem))?;
    let axes = found.shape.len();
    let behind = usize::from(axes > 3 && found.shape[axes - 1] <= MOST_CHANNELS);
    let space = (axes - behind).min(3);
    let frames = axes - behind - space;
    let axis = |i: usize| (i < space).then(|| frames + space - 1 - i);
    let dims = [0, 1, 2].map(|i| axis(i).map_or(1, |axis| found.shape[axis]));
    let grid = load::grid(path, dims, upright(DVec3::ONE, DVec3::ZERO), options)?;
    let mut header = Header { endian: found.endian, ..Header::new(grid, found.scalar) };
    let strides = found.strides();
    for i in 0..space {
        header.strides[i] = axis(i).map_or(0, |axis| strides[axis]);
    }
    let (mut first, mut contents) = (found.end, Contents { states_spacing: false, ..Contents::default() });
    if behind > 0 {
        first += strides[axes - 1] * contents.choose_component(path, options, found.shape[axes - 1], false)? as u64;
    }
    let mut frame = contents.choose_frame(path, options, found.shape[..frames].iter().product())?;
    for axis in (0..frames).rev() {
        first += strides[axis] * (frame % found.shape[axis]) as u64;
        frame /= found.shape[axis];
    }
    let header = Header { first, contents, ..header }.with_magnitude(strides.last().copied().unwrap_or(0));
    Ok(Opened { header, bytes, exact: false })
}
