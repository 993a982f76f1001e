//! Surfaces in and around the volume: `--surface FILE,KEY=VALUE,…`.

use super::channels::{Pairs, read_transform, split};
use super::parse;
use crate::annotation::LegendEntry;
use crate::choice::Choice;
use crate::error::Error;
use crate::framing::Framing;
use crate::surface::{Bounds, Ends, Radius, Space, Surface, SurfaceFile, SurfaceOptions, SurfaceShading};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Volume};
use clap::Args;
use glam::{DMat4, DVec3};
use std::path::{Path, PathBuf};

/// Options of surfaces.
#[derive(Args)]
pub(super) struct SurfaceArguments {
    /// Draw the surfaces of an STL, PLY or VTK PolyData file, repeatable; see the guide for keys: color, opacity, values, transfer, radius, …
    #[arg(long = "surface", value_name = "FILE[,KEY=VALUE…]", value_parser = SurfaceSpec::from_text, help_heading = "Volume")]
    surfaces: Vec<SurfaceSpec>,
}

/// Keys, for messages.
const KEYS: &str = "color, opacity, values, transfer, radius, ends, at, space, shading, clip, visible and name";

/// Least extent of the empty volume around surfaces, as a fraction of the largest.
const THINNEST: f64 = 1e-3;

/// A file of surfaces, and how they look.
#[derive(Clone, Default)]
struct SurfaceSpec {
    file: PathBuf,
    name: Option<String>,
    color: Option<[f32; 3]>,
    opacity: Option<f32>,
    values: Option<String>,
    transfer: Option<String>,
    radius: Option<String>,
    ends: Ends,
    /// File of the transform to the world of the scene.
    at: Option<PathBuf>,
    space: Option<Space>,
    shading: SurfaceShading,
    is_uncut: bool,
    is_hidden: bool,
}

impl SurfaceSpec {
    /// Parses `FILE,KEY=VALUE,…`.
    fn from_text(text: &str) -> Result<Self, String> {
        let (file, pairs): (&str, Pairs) = split(text, KEYS)?;
        if file.is_empty() {
            return Err("it names no file; use FILE,KEY=VALUE".into());
        }
        let mut spec = Self { file: file.into(), ..Self::default() };
        pairs.iter().try_for_each(|(key, value)| spec.set(key, value).map_err(|problem| format!("{key}: {problem}")))?;
        Ok(spec)
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let named = |e: Error| e.to_string();
        match key {
            "name" => self.name = Some(value.into()),
            "color" => self.color = Some(parse::color(value)?.map(|c| c as f32)),
            "opacity" => {
                let expected = || format!("invalid opacity '{value}'; use a number from 0 to 1");
                let opacity = parse::finite(value).ok().filter(|opacity| (0.0..=1.0).contains(opacity));
                self.opacity = Some(opacity.ok_or_else(expected)? as f32);
            }
            "values" => self.values = Some(value.into()),
            "transfer" => self.transfer = Some(value.into()),
            "radius" => self.radius = Some(value.into()),
            "ends" => self.ends = Ends::from_name(value).map_err(named)?,
            "at" => self.at = Some(value.into()),
            "space" => self.space = Some(Space::from_name(value).map_err(named)?),
            "shading" => self.shading = SurfaceShading::from_name(value).map_err(named)?,
            "clip" => self.is_uncut = !parse::switch(value)?,
            "visible" => self.is_hidden = !parse::switch(value)?,
            _ => return Err(format!("unknown key; keys are {KEYS}")),
        }
        Ok(())
    }

    /// Reads the file. `volume`: that of the scene, if there is one.
    fn open(&self, volume: Option<&Volume>) -> Result<Vec<Surface>, Error> {
        if self.transfer.is_some() && self.values.is_none() {
            let problem = format!("{}: transfer needs values=NAME, the array whose values it colours", self.file.display());
            return Err(Error::Settings { field: "surface", problem });
        }
        let file = SurfaceFile::read(&self.file)?;
        let options = SurfaceOptions {
            name: self.name.clone(),
            color: self.color,
            values: self.values.clone(),
            transfer: self.transfer.as_deref().map(|source| self.transfer(&file, source, volume)).transpose()?,
            radius: self.radius.as_deref().map(Radius::from),
            ends: self.ends,
            space: self.space,
            is_anatomical: volume.is_none_or(|volume| volume.grid().has_anatomy()),
        };
        let matrix = self.at.as_deref().map(|path| read_transform(path).map(DMat4::from)).transpose()?;
        let looked = |mut surface: Surface| {
            surface.opacity = self.opacity.unwrap_or(surface.opacity);
            (surface.shading, surface.is_clipped, surface.is_visible) = (self.shading, !self.is_uncut, !self.is_hidden);
            match matrix {
                Some(matrix) => surface.with_matrix(matrix),
                None => Ok(surface),
            }
        };
        file.into_surfaces(&options)?.into_iter().map(looked).collect()
    }

    /// A built-in transfer function over the values, or that of a file.
    fn transfer(&self, file: &SurfaceFile, source: &str, volume: Option<&Volume>) -> Result<TransferFunction, Error> {
        let scalars = file.array(self.values.as_deref().unwrap_or_default())?.scalars();
        match (scalars.colored_by(source), volume) {
            (Err(_), Some(volume)) if Path::new(source).exists() => TransferFunction::open(source, volume),
            (transfer, _) => transfer,
        }
    }
}

impl SurfaceArguments {
    /// Whether there are any.
    pub fn are_given(&self) -> bool {
        !self.surfaces.is_empty()
    }

    /// Opens all surfaces around a volume.
    pub fn open(&self, volume: &Volume) -> Result<Vec<Surface>, Error> {
        self.open_specs(&self.surfaces, Some(volume))
    }

    /// Opens the surfaces of a file that stands in place of a volume, and all others.
    pub fn open_alone(&self, file: &Path) -> Result<Vec<Surface>, Error> {
        let first = SurfaceSpec { file: file.into(), ..SurfaceSpec::default() };
        let all: Vec<_> = std::iter::once(first).chain(self.surfaces.iter().cloned()).collect();
        self.open_specs(&all, None)
    }

    fn open_specs(&self, specs: &[SurfaceSpec], volume: Option<&Volume>) -> Result<Vec<Surface>, Error> {
        let mut all = Vec::new();
        for spec in specs {
            all.extend(spec.open(volume)?);
        }
        Ok(all)
    }
}

/// Whether a file that is named as a volume holds surfaces.
pub(super) fn is_surface_file(path: &Path) -> bool {
    path.is_file() && SurfaceFile::is_one(path)
}

/// A volume that shows nothing, around surfaces, and its transfer function.
pub(super) fn empty_volume(file: &Path, surfaces: &[Surface]) -> Result<(Volume<'static>, TransferFunction), Error> {
    let bounds = bounds(surfaces).unwrap_or(Bounds { lowest: DVec3::ZERO, highest: DVec3::ONE });
    let extent = bounds.highest - bounds.lowest;
    let least = if extent.max_element() > 0.0 { THINNEST * extent.max_element() } else { 1.0 };
    let spacing = extent.max(DVec3::splat(least));
    let origin = (bounds.lowest + bounds.highest - spacing) / 2.0;
    let grid = Grid::oriented([2; 3], spacing, origin, glam::DMat3::IDENTITY)?;
    let volume = Volume::new(file.to_string_lossy(), grid, vec![0u8; 8])?;
    let transfer = TransferFunction::new("nothing", vec![(0.0, [0.8; 3])], vec![(0.0, 0.0)])?;
    Ok((volume, transfer))
}

/// Bounds of the visible sets.
fn bounds(surfaces: &[Surface]) -> Option<Bounds> {
    surfaces.iter().filter(|surface| surface.is_visible).filter_map(Surface::bounds).reduce(Bounds::and)
}

/// Bounds for cameras: joined with those of a volume, if it shows anything.
pub(super) fn framing(surfaces: &[Surface]) -> Option<Framing> {
    bounds(surfaces).map(|bounds| Framing::of_box(bounds.lowest, bounds.highest))
}

/// Names and colours for a legend.
pub(super) fn entries(surfaces: &[Surface]) -> impl Iterator<Item = LegendEntry> {
    let visible = surfaces.iter().filter(|surface| surface.is_visible);
    visible.map(|surface| LegendEntry { name: surface.name.clone(), color: surface.color.map(f64::from) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specs_are_read() {
        let spec =
            SurfaceSpec::from_text("a.stl,color=#ff8000,opacity=0.25,ends=round,space=LPS,clip=off,name=hip, left").unwrap();
        assert_eq!((spec.opacity, spec.ends, spec.space), (Some(0.25), Ends::Round, Some(Space::Lps)));
        assert!(spec.is_uncut && !spec.is_hidden && spec.name.as_deref() == Some("hip, left"));
        assert_eq!(spec.color.map(|c| (c[1] * 255.0).round()), Some(128.0));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, problem) in [
            (",opacity=1", "names no file"),
            ("a.stl,opacity=2", "opacity: invalid opacity '2'"),
            ("a.stl,size=2", "size: unknown key"),
            ("a.stl,2", "no KEY=VALUE; keys are color"),
            ("a.stl,ends=square", "ends: unknown ends 'square'"),
        ] {
            let message = SurfaceSpec::from_text(text).err().unwrap();
            assert!(message.contains(problem), "{text}: {message}");
        }
    }

    #[test]
    fn flat_surfaces_have_a_volume_around_them() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let triangle = Surface::new("t", crate::surface::Triangles::new(points, vec![[0, 1, 2]]).unwrap());
        let (volume, transfer) = empty_volume(Path::new("t.stl"), &[triangle]).unwrap();
        assert_eq!(volume.grid().spacing(), DVec3::new(1.0, 1.0, THINNEST));
        assert_eq!(transfer.opacity(0.0), 0.0);
    }
}
