//! Transfer functions from files, built-in names and histograms.

use super::palettes::{self, Palette};
use super::visible_range::visible_range;
use super::{TransferFunction, automatic, builtin, format, phantom, presets, test_signal};
use crate::error::Error;
use crate::volume::Volume;
use std::path::Path;

impl TransferFunction {
    /// Name of transfer functions made by [`TransferFunction::automatic`].
    pub const AUTOMATIC: &str = "automatic";

    /// Reads a transfer function file; its content determines the format.
    ///
    /// Formats: ParaView preset (the one called `preset`, or the first), 3D Slicer volume property (`.vp`, `.vp.json`), or CSV lines of
    /// value,r,g,b,a. Curves and colour spaces other than RGB become linear pieces with an error of at most 0.001. The paths of
    /// `Lab/CIEDE2000` are as coarse as ParaView's own, with steps of 1/32.
    /// # Errors
    /// If the file cannot be read or has another format, values are not ascending, colours or opacities lie outside 0 … 1, the file is
    /// larger than 16 MiB, or it has more than 65536 control points.
    pub fn from_file(path: &Path, preset: Option<&str>) -> Result<Self, Error> {
        format::read(path, preset)
    }

    /// Reads the text of a transfer function file, as [`TransferFunction::from_file`]. `name` is that of the function and stands in errors.
    ///
    /// # Errors
    /// As [`TransferFunction::from_file`].
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// let red = TransferFunction::from_text("0,1,0,0,0\n9,1,0,0,0.5\n", "red.csv")?;
    /// assert_eq!(red.opacity(9.0), 0.5);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn from_text(text: &str, name: &str) -> Result<Self, Error> {
        format::parse(text, name, None)
    }

    /// A built-in transfer function: one of [`TransferFunction::names`], or one with `_r` appended, which reverses its colours. It is
    /// stretched over the volume's range of values. Its opacity is 0 up to a tenth of the range and then rises slowly to a half.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if the name does not exist.
    pub fn builtin(name: &str, volume: &Volume) -> Result<Self, Error> {
        let (lo, hi) = visible_range(volume);
        Self::builtin_over(name, lo, hi)
    }

    /// As [`TransferFunction::builtin`], over a range of values.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if the name does not exist, [`Error::OutOfRange`] if `lo` is not below `hi`.
    pub fn builtin_over(name: &str, lo: f64, hi: f64) -> Result<Self, Error> {
        builtin::named(name).ok_or_else(|| builtin::unknown(name))?.stretched(lo, hi)
    }

    /// Names of the built-in transfer functions: those defined by this crate, and colour maps of plotting libraries.
    ///
    /// ```
    /// use layersplat::TransferFunction;
    ///
    /// assert!(["fire", "magma", "rdbu"].iter().all(|name| TransferFunction::names().any(|known| known == *name)));
    /// ```
    pub fn names() -> impl Iterator<Item = &'static str> {
        builtin::names()
    }

    /// Derives a transfer function from a sample of the volume's voxels. Each material, a mode among voxels of weak gradient, gets a colour
    /// of its own; materials in front of others are translucent shells. A field without materials becomes nested shells. Air and noise are
    /// transparent. CT in Hounsfield units shows skin, soft tissue and bone.
    ///
    /// Two built-in volumes have fixed ones: the Shepp–Logan phantom shows the interior of the head, the Marschner–Lobb signal a surface.
    /// Values that are indices of a palette ([`Contents::palette`](crate::volume::Contents::palette)) have its colours.
    pub fn automatic(volume: &Volume) -> Self {
        let found = of_volume(volume, Palette::default());
        let palette = &volume.contents().palette;
        let colors = palette.iter().enumerate().map(|(index, color)| (index as f64, *color)).collect();
        let opacities = found.opacities().to_vec();
        if palette.is_empty() { found } else { Self::new(Self::AUTOMATIC, colors, opacities).unwrap_or(found) }
    }

    /// As [`TransferFunction::automatic`], in the colours of a palette: one of [`TransferFunction::palettes`]. CT in Hounsfield units and the
    /// phantom keep their own.
    ///
    /// ```
    /// use layersplat::{OpenOptions, TransferFunction, Volume};
    ///
    /// let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default())?;
    /// let [calm, vivid] = ["calm", "vivid"].map(|name| TransferFunction::automatic_in(&volume, name));
    /// assert_eq!(calm?.opacities(), vivid?.opacities());
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::UnknownName`] if the palette does not exist.
    pub fn automatic_in(volume: &Volume, palette: &str) -> Result<Self, Error> {
        Ok(of_volume(volume, Palette::named(palette)?))
    }

    /// Names of the palettes of automatic transfer functions; the first is the default.
    pub fn palettes() -> impl Iterator<Item = &'static str> {
        palettes::names()
    }

    /// The palettes with their colours of materials.
    #[doc(hidden)]
    pub fn palette_colors() -> impl Iterator<Item = (&'static str, [[f64; 3]; 6])> {
        palettes::colors()
    }

    /// Opens a built-in transfer function or a preset by name, a file, or a preset of a file as `FILE#PRESET`.
    ///
    /// # Errors
    /// As [`TransferFunction::from_file`], [`TransferFunction::builtin`] and [`TransferFunction::preset`].
    pub fn open(source: impl AsRef<Path>, volume: &Volume) -> Result<Self, Error> {
        let path = source.as_ref();
        if let Some(name) = path.to_str().filter(|name| builtin::named(name).is_some()) {
            return Self::builtin(name, volume);
        }
        if let Some(name) = path.to_str().filter(|name| Self::is_preset(name)) {
            return Self::preset(name, volume);
        }
        if path.exists() {
            return Self::from_file(path, None);
        }
        match format::paraview::file_and_preset(path) {
            Some((file, preset)) => Self::from_file(file, Some(preset)),
            None if path.extension().is_none() && path.components().count() == 1 => Err(Error::UnknownName {
                what: "transfer function",
                name: path.display().to_string(),
                known: builtin::nearest_first(
                    &path.display().to_string(),
                    builtin::names().chain(Self::presets().map(|(name, _)| name)),
                    &format!("{}, a preset ({}), or a file", builtin::listed(), presets::listed()),
                ),
            }),
            None => Self::from_file(path, None),
        }
    }
}

/// The transfer function that a built-in volume has, or one derived from the voxels.
fn of_volume(volume: &Volume, palette: Palette) -> TransferFunction {
    let volume = volume.overview();
    let fixed = phantom::transfer(volume).or_else(|| test_signal::transfer(volume, palette));
    fixed.unwrap_or_else(|| automatic::derived(volume, palette))
}
