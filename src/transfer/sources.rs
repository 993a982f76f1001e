//! Where transfer functions come from: files, names, histograms.

use super::{TransferFunction, automatic, builtin, format, phantom};
use crate::error::Error;
use crate::volume::Volume;
use std::path::Path;

impl TransferFunction {
    /// The name of those that are made from a volume's histogram.
    pub const AUTOMATIC: &str = "automatic";

    /// Reads a file, recognised by what is in it: a ParaView preset (of several the first, or the one called `preset`), a volume property
    /// of 3D Slicer (`.vp`, `.vp.json`), or lines of value,r,g,b,a (CSV). Curved functions and other colour spaces than RGB become
    /// straight pieces, nowhere off by more than 0.001; in `Lab/CIEDE2000`, ParaView's own are as rough as 1/32.
    ///
    /// # Errors
    /// If it cannot be read or is none of these; if values are not ascending, or anything is not from 0 to 1 that should be; if it is
    /// larger than 16 MiB, or has more than 65536 control points.
    pub fn from_file(path: &Path, preset: Option<&str>) -> Result<Self, Error> {
        format::read(path, preset)
    }

    /// A built-in transfer function, one of [`TransferFunction::names`] or one of these with `_r` behind it, which turns its colours
    /// round, stretched onto the volume's range of values. Its opacity rises slowly from a tenth of the range on, to a half.
    pub fn builtin(name: &str, volume: &Volume) -> Result<Self, Error> {
        let (lo, hi) = visible_range(volume);
        builtin::named(name).ok_or_else(|| builtin::unknown(name))?.stretched(lo, hi)
    }

    /// Names of the built-in transfer functions: this crate's own, and colour maps that other programs know by these names.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// assert!(["fire", "magma", "rdbu"].iter().all(|name| TransferFunction::names().any(|known| known == *name)));
    /// ```
    pub fn names() -> impl Iterator<Item = &'static str> {
        builtin::names()
    }

    /// A sensible first transfer function, from the volume's histogram; of the built-in Shepp–Logan phantom, one that shows what is in the
    /// head.
    pub fn automatic(volume: &Volume) -> Self {
        phantom::transfer(volume).unwrap_or_else(|| automatic::from_statistics(&volume.statistics(), volume))
    }

    /// A built-in name, `FILE` or `FILE#PRESET`.
    pub fn open(source: impl AsRef<Path>, volume: &Volume) -> Result<Self, Error> {
        let path = source.as_ref();
        if let Some(name) = path.to_str().filter(|name| builtin::named(name).is_some()) {
            return Self::builtin(name, volume);
        }
        if path.exists() {
            return Self::from_file(path, None);
        }
        match format::paraview::file_and_preset(path) {
            Some((file, preset)) => Self::from_file(file, Some(preset)),
            None if path.extension().is_none() && path.components().count() == 1 => Err(Error::UnknownName {
                what: "transfer function",
                name: path.display().to_string(),
                known: format!("{}; or a file", builtin::listed()),
            }),
            None => Self::from_file(path, None),
        }
    }
}

/// The range onto which functions without values of their own are stretched: the data's; where all voxels are alike, with the
/// background's; where that is the same too, from 0 to a value above it, so that it shows.
pub(super) fn visible_range(volume: &Volume) -> (f64, f64) {
    let (lo, hi) = volume.range();
    if lo < hi {
        return (lo, hi);
    }
    match volume.field_range() {
        (lo, hi) if lo < hi => (lo, hi),
        (lo, _) if lo > 0.0 => (0.0, lo),
        // Or up to 0, where 1 more is too little to be another number.
        (lo, _) => (lo, if lo + 1.0 > lo { lo + 1.0 } else { 0.0 }),
    }
}
