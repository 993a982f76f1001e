//! The channels of a file that are red, green, blue and alpha.

use super::{ChannelDescription, OpenOptions, Volume, VoxelType, Voxels};
use crate::error::Error;
use std::path::Path;

/// Which channels of a file are red, green, blue and possibly alpha.
///
/// ```
/// use layersplat::volume::{ChannelDescription, ColorChannels};
///
/// let unnamed = vec![ChannelDescription::default(); 4];
/// let colors = ColorChannels::of(&unnamed).expect("three channels or more");
/// assert_eq!((colors.numbers(), colors.has_alpha()), (&[0, 1, 2, 3][..], true));
/// assert_eq!(ColorChannels::of(&unnamed[..2]), None);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ColorChannels {
    numbers: Vec<usize>,
    /// Whether the colours are multiplied by alpha.
    is_associated: bool,
}

impl ColorChannels {
    /// The first three channels, and as alpha the one that the file names so, else the fourth of four without names. `None` for fewer than
    /// three channels.
    pub fn of(channels: &[ChannelDescription]) -> Option<Self> {
        if channels.len() < 3 {
            return None;
        }
        let named = |name: &str| channels.iter().position(|channel| channel.name.as_deref() == Some(name));
        let are_named = channels.iter().take(3).all(|channel| channel.name.is_some());
        let straight = named("alpha").or((channels.len() == 4 && !are_named).then_some(3));
        let associated = named(ChannelDescription::ASSOCIATED_ALPHA).filter(|_| straight.is_none());
        let numbers = (0..3).chain(straight.or(associated)).collect();
        Some(Self { numbers, is_associated: associated.is_some() })
    }

    /// The channels of a file.
    ///
    /// # Errors
    /// [`Error::Settings`] for a file with fewer than three channels; as [`ChannelDescription::of_file`].
    pub fn of_file(source: impl AsRef<Path>, options: &OpenOptions) -> Result<Self, Error> {
        let source = source.as_ref();
        let channels = ChannelDescription::of_file(source, options)?;
        Self::of(&channels).ok_or_else(|| {
            let problem =
                format!("are 3 or 4 channels, and {} has {}: choose a file of colours", source.display(), channels.len());
            Error::Settings { field: "colors", problem }
        })
    }

    /// Numbers of the channels: red, green, blue, and possibly alpha.
    pub fn numbers(&self) -> &[usize] {
        &self.numbers
    }

    /// Whether one of the channels is alpha.
    pub fn has_alpha(&self) -> bool {
        self.numbers.len() > 3
    }

    /// Opens the channels of a file, for [`UploadedColors`](https://docs.rs/layersplat).
    ///
    /// # Errors
    /// As [`Volume::open`].
    pub fn open(&self, source: impl AsRef<Path>, options: &OpenOptions) -> Result<Vec<Volume<'static>>, Error> {
        let source = source.as_ref();
        let channel = |&number: &usize| Volume::open(source, &OpenOptions { channel: Some(number), ..options.clone() });
        self.straight(self.numbers.iter().map(channel).collect::<Result<_, _>>()?)
    }

    /// Colours that are not multiplied by alpha. `volumes`: those of the [channels](Self::numbers), of one grid and type.
    ///
    /// # Errors
    /// As [`Volume::new`].
    pub fn straight(&self, mut volumes: Vec<Volume<'static>>) -> Result<Vec<Volume<'static>>, Error> {
        if let ([colors @ .., alpha], true) = (&mut volumes[..], self.is_associated) {
            for color in colors {
                *color = divided(color, alpha)?;
            }
        }
        Ok(volumes)
    }
}

/// A colour by which an opacity has been multiplied, divided by it. Both have one type.
fn divided(color: &Volume, alpha: &Volume) -> Result<Volume<'static>, Error> {
    let full = match color.voxel_type() {
        VoxelType::Uint8 => f64::from(u8::MAX),
        VoxelType::Uint16 => f64::from(u16::MAX),
        VoxelType::Int8 | VoxelType::Int16 | VoxelType::Float32 => 1.0,
    };
    let count = color.grid().voxel_count();
    let all = |value: &(dyn Fn(usize) -> f64 + Sync)| (0..count).map(value).collect::<Vec<f64>>();
    let straight = color.look(all).into_iter().zip(alpha.look(all));
    let straight = straight.map(|(color, alpha)| if alpha > 0.0 { (color / alpha * full).min(full) } else { 0.0 });
    let voxels = match color.voxel_type() {
        VoxelType::Uint8 => Voxels::Uint8(straight.map(|value| value.round() as u8).collect()),
        VoxelType::Uint16 => Voxels::Uint16(straight.map(|value| value.round() as u16).collect()),
        _ => Voxels::Float32(straight.map(|value| value as f32).collect()),
    };
    Volume::new(color.name(), color.grid().clone(), voxels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Grid;
    use glam::DVec3;

    fn named(names: &[&str]) -> Vec<ChannelDescription> {
        let name = |name: &&str| Some(name.to_string()).filter(|name| !name.is_empty());
        names.iter().map(|one| ChannelDescription { name: name(one), ..ChannelDescription::default() }).collect()
    }

    #[test]
    fn only_what_is_an_opacity_is_one() {
        let alpha = |names: &[&str]| {
            let found = ColorChannels::of(&named(names)).unwrap();
            found.numbers().get(3).map(|&number| (number, found.is_associated))
        };
        assert_eq!(alpha(&["red", "green", "blue", "alpha"]), Some((3, false)));
        assert_eq!(alpha(&["red", "green", "blue", "", "associated alpha"]), Some((4, true)));
        assert_eq!((alpha(&["", "", "", ""]), alpha(&["", "", "", "", ""])), (Some((3, false)), None));
        assert_eq!((alpha(&["red", "green", "blue", ""]), alpha(&["red", "green", "blue"])), (None, None));
    }

    #[test]
    fn colours_are_divided_by_the_opacity_that_they_were_multiplied_by() {
        let volume = |values: Vec<u8>| Volume::new("v", Grid::new([4, 1, 1], DVec3::ONE).unwrap(), values).unwrap();
        let found = divided(&volume(vec![50, 0, 255, 9]), &volume(vec![100, 0, 255, 3])).unwrap();
        assert_eq!([0, 1, 2, 3].map(|i| found.value(i)), [128.0, 0.0, 255.0, 255.0]);
    }
}
