//! Surfaces in and around the volume: `--surface FILE,KEY=VALUE,…`.

use super::channels::{Pairs, SceneSurface, read_transform, split};
use super::numbers::shortened;
use super::parse;
use crate::annotation::LegendEntry;
use crate::choice::Choice;
use crate::error::Error;
use crate::framing::Framing;
use crate::surface::{
    Bounds, Ends, Per, PointData, Radius, Space, Surface, SurfaceArray, SurfaceFile, SurfaceOptions, SurfaceShading,
};
use crate::transfer::TransferFunction;
use crate::volume::{Grid, Volume};
use clap::Args;
use glam::{DMat4, DVec3};
use std::fmt;
use std::path::{Path, PathBuf};

/// Options of surfaces.
#[derive(Args)]
pub(super) struct SurfaceArguments {
    /// Draw the surfaces of a file (STL, PLY, OBJ, VTK, GIFTI, FreeSurfer), repeatable; see the guide for keys: color, opacity, data, values, …
    #[arg(long = "surface", value_name = "FILE[,KEY=VALUE…]", value_parser = SurfaceSpec::from_text, help_heading = "Volume")]
    surfaces: Vec<SurfaceSpec>,
}

/// Keys, for messages.
const KEYS: &str = "color, opacity, data, values, transfer, radius, ends, at, space, shading, clip, visible and name";

/// Coordinates and extents that cameras can frame, in world units.
const LARGEST: f64 = 1e25;
const SMALLEST: f64 = 1e-25;
/// Coordinates beside a volume, in its voxels: floats hold products of three.
const LARGEST_IN_VOXELS: f64 = 1e12;
/// Floats place sets that are as many voxels large to a tenth of a voxel.
const PRECISE_VOXELS: f64 = 1e6;

/// A file of surfaces, and how they look.
#[derive(Clone, Default)]
struct SurfaceSpec {
    file: PathBuf,
    name: Option<String>,
    color: Option<[f32; 3]>,
    opacity: Option<f32>,
    /// File with values or labels of the points.
    data: Option<PathBuf>,
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
        Self { file: file.into(), ..Self::default() }.with(&pairs)
    }

    /// A surface of a scene. Names of files are relative to that of the scene.
    fn of_scene(surface: &SceneSurface) -> Result<Self, Error> {
        let is_file = |(key, _): &&(String, String)| key == "file";
        let Some((_, file)) = surface.keys.iter().find(is_file) else {
            return Err(surface.error(r#"it names no file: add "file": "…""#));
        };
        let looks: Pairs = surface.keys.iter().filter(|pair| !is_file(pair)).cloned().collect();
        let spec = Self { file: surface.path(Path::new(file)), ..Self::default() };
        let spec = spec.with(&looks).map_err(|problem| surface.error(&problem))?;
        let transfer = spec.transfer.map(|name| {
            let beside = surface.path(Path::new(&name));
            if beside.exists() { beside.to_string_lossy().into_owned() } else { name }
        });
        let beside = |path: PathBuf| surface.path(&path);
        Ok(Self { at: spec.at.map(beside), data: spec.data.map(beside), transfer, ..spec })
    }

    fn with(mut self, pairs: &Pairs) -> Result<Self, String> {
        pairs.iter().try_for_each(|(key, value)| self.set(key, value).map_err(|problem| format!("{key}: {problem}")))?;
        Ok(self)
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
            "data" => self.data = Some(value.into()),
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
        if self.transfer.is_some() && self.values.is_none() && self.data.is_none() {
            let problem =
                format!("{}: transfer needs values=NAME, the array whose values it colours, or data=FILE", self.file.display());
            return Err(Error::Settings { field: "surface", problem });
        }
        let mut file = SurfaceFile::read(&self.file)?;
        let data = self.data.as_ref().map(|data| file.add(PointData::read(data)?)).transpose()?;
        let values = self.values.clone().or(data.flatten());
        let scalars = || file.array(values.as_deref().unwrap_or_default()).map(SurfaceArray::scalars);
        let transfer = self.transfer.as_deref().map(|source| transfer_of(&scalars()?, source, volume));
        let options = SurfaceOptions {
            name: self.name.clone(),
            color: self.color,
            values,
            transfer: transfer.transpose()?,
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
}

/// A built-in transfer function over values, or that of a file.
fn transfer_of(scalars: &Per<f32>, source: &str, volume: Option<&Volume>) -> Result<TransferFunction, Error> {
    match (scalars.colored_by(source), volume) {
        (Err(_), Some(volume)) if Path::new(source).exists() => TransferFunction::open(source, volume),
        (transfer, _) => transfer,
    }
}

impl SurfaceArguments {
    /// Whether there are any.
    pub fn are_given(&self) -> bool {
        !self.surfaces.is_empty()
    }

    /// Opens all surfaces around a volume.
    pub fn open(&self, volume: &Volume) -> Result<Vec<Surface>, Error> {
        open_all(&self.surfaces, Some(volume))
    }

    /// Opens the surfaces of a file that stands in place of a volume, and all others. If the file is one of these, they say how it looks.
    pub fn open_alone(&self, file: &Path) -> Result<SurfacesAlone, Error> {
        let first = (!self.surfaces.iter().any(|surface| surface.file == file))
            .then(|| SurfaceSpec { file: file.into(), ..SurfaceSpec::default() });
        let all: Vec<_> = first.into_iter().chain(self.surfaces.iter().cloned()).collect();
        let surfaces = open_all(&all, None)?;
        let (volume, transfer) = empty_volume(file, &surfaces)?;
        Ok(SurfacesAlone { volume, transfer, surfaces })
    }
}

/// Surfaces without a volume.
pub(super) struct SurfacesAlone {
    /// Shows nothing.
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
    pub surfaces: Vec<Surface>,
}

/// Opens the surfaces of a scene file. `volume`: that of the scene, if there is one.
pub(super) fn open_scene(surfaces: &[SceneSurface], volume: Option<&Volume>) -> Result<Vec<Surface>, Error> {
    let specs = surfaces.iter().map(SurfaceSpec::of_scene).collect::<Result<Vec<_>, _>>()?;
    open_all(&specs, volume)
}

fn open_all(specs: &[SurfaceSpec], volume: Option<&Volume>) -> Result<Vec<Surface>, Error> {
    let opened: Vec<_> = specs.iter().map(|spec| spec.open(volume)).collect::<Result<_, Error>>()?;
    let all = opened.concat();
    all.iter().try_for_each(|surface| check_size(surface, volume))?;
    Ok(all)
}

/// Fails for sets that cannot be drawn for their size, alone or beside a volume.
fn check_size(surface: &Surface, volume: Option<&Volume>) -> Result<(), Error> {
    let Some(Bounds { lowest, highest }) = surface.bounds() else { return Ok(()) };
    let (farthest, extent) = (lowest.abs().max(highest.abs()).max_element(), (highest - lowest).max_element());
    let largest = volume.map_or(LARGEST, |volume| LARGEST_IN_VOXELS * volume.grid().spacing().min_element());
    if farthest <= largest && (extent == 0.0 || extent >= SMALLEST) {
        return Ok(());
    }
    let problem = format!(
        "it reaches from {} to {}: coordinates up to {largest:e} and extents from {SMALLEST:e} are drawn{}; scale it by at=FILE, a matrix",
        position(lowest.to_array()),
        position(highest.to_array()),
        if volume.is_some() { " beside this volume" } else { "" }
    );
    Err(Error::Surface { name: surface.name.clone(), problem })
}

/// Says which surfaces lie wholly outside a volume, and which are too large for precise depths.
pub(super) fn warn_of_places(surfaces: &[Surface], grid: &Grid) {
    for surface in surfaces.iter().filter(|surface| surface.is_visible) {
        let Some(place) = Place::of(surface, grid) else { continue };
        if !place.meets {
            tracing::warn!("surface {} {place}", surface.name);
        }
        let voxels = (place.bounds.highest - place.bounds.lowest).max_element() / grid.spacing().min_element();
        if voxels > PRECISE_VOXELS {
            let error = shortened(voxels * f64::from(f32::EPSILON));
            tracing::warn!("surface {} is {voxels:.1e} voxels large: it is placed to about {error} voxels", surface.name);
        }
    }
}

/// Where a surface lies beside a volume.
pub(super) struct Place {
    pub bounds: Bounds,
    /// Whether its bounds meet those of the volume.
    pub meets: bool,
    of_volume: Bounds,
}

impl Place {
    /// The place of a surface; `None` if it has no points.
    pub fn of(surface: &Surface, grid: &Grid) -> Option<Self> {
        let (bounds, of_volume) = (surface.bounds()?, bounds_of(grid));
        Some(Self { bounds, meets: bounds.meets(of_volume), of_volume })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [from, to] = self.bounds.corners().map(position);
        if self.meets {
            return write!(f, "meets the volume: {from} to {to}");
        }
        let [first, last] = self.of_volume.corners().map(position);
        write!(
            f,
            "lies outside the volume: {from} to {to}, and the volume {first} to {last}; give its axes by space=LPS or RAS, or a matrix by at=FILE"
        )
    }
}

/// Lowest and highest world coordinates of the voxels' centres.
pub(super) fn bounds_of(grid: &Grid) -> Bounds {
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0));
    let corner = |n: u32| last * DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2 & 1));
    let corners = (0..8).map(|n| grid.index_to_world().transform_point3(corner(n)));
    let [lowest, highest] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    corners.fold(Bounds { lowest, highest }, |box_, point| box_.and(Bounds { lowest: point, highest: point }))
}

/// A point, as text.
pub(super) fn position(point: [f64; 3]) -> String {
    point.map(shortened).join(",")
}

/// The surfaces that some names choose, which are shown or hidden.
///
/// # Errors
/// A description of the problem for a name that none has.
pub(super) fn shown(surfaces: &[Surface], names: &[(String, bool)]) -> Result<Vec<Surface>, String> {
    let mut chosen = surfaces.to_vec();
    for (name, is_visible) in names {
        let mut named = chosen.iter_mut().filter(|surface| surface.name == *name).peekable();
        if named.peek().is_none() {
            let known: Vec<&str> = surfaces.iter().map(|surface| surface.name.as_str()).collect();
            return Err(match known.as_slice() {
                [] => format!("there is no surface '{name}': give surfaces by --surface or --scene"),
                known => format!("there is no surface '{name}': use {}", known.join(", ")),
            });
        }
        named.for_each(|surface| surface.is_visible = *is_visible);
    }
    Ok(chosen)
}

/// Whether a file that is named as a volume holds surfaces.
pub(super) fn is_surface_file(path: &Path) -> bool {
    path.is_file() && SurfaceFile::is_one(path)
}

/// A volume that shows nothing, around surfaces, and its transfer function.
fn empty_volume(file: &Path, surfaces: &[Surface]) -> Result<(Volume<'static>, TransferFunction), Error> {
    let bounds = bounds(surfaces).unwrap_or(Bounds { lowest: DVec3::ZERO, highest: DVec3::ONE });
    let grid = Grid::around(bounds.lowest, bounds.highest)?;
    let voxels = vec![0u8; grid.voxel_count()];
    let volume = Volume::new(file.to_string_lossy(), grid, voxels)?;
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

/// Names and colours for a legend. Of values, the colours from the lowest to the highest, and these; of points or cells with colours, the mean.
pub(super) fn entries(surfaces: &[Surface]) -> impl Iterator<Item = LegendEntry> {
    /// Colours of values.
    const COLORS: usize = 6;
    let of = |surface: &Surface| {
        let name = surface.name.clone();
        if let Some((_, transfer)) = surface.values() {
            let [first, last] = [transfer.colors().first(), transfer.colors().last()].map(|end| end.map_or(0.0, |end| end.0));
            let value = |n: usize| first + (last - first) * n as f64 / (COLORS - 1) as f64;
            let name = format!("{name}, {} to {}", shortened(first), shortened(last));
            return LegendEntry { name, colors: (0..COLORS).map(|n| transfer.color(value(n))).collect() };
        }
        let mean = |colors: &[[f32; 4]]| {
            let sum = |i: usize| colors.iter().map(|color| f64::from(color[i])).sum::<f64>();
            [0, 1, 2].map(|i| sum(i) / colors.len().max(1) as f64)
        };
        LegendEntry::new(name, surface.colors().map_or(surface.color.map(f64::from), |colors| mean(colors.entries())))
    };
    surfaces.iter().filter(|surface| surface.is_visible).map(of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Per, Triangles};

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
    fn legends_have_the_colours_of_values() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let plain = Surface::new("t", Triangles::new(points, vec![[0, 1, 2]]).unwrap());
        let red = |n: f32| [n, 0.0, 0.0, 1.0];
        let colored = plain.clone().with_colors(Per::Point([0.0, 0.5, 1.0].map(red).to_vec())).unwrap();
        let grey = TransferFunction::new("grey", vec![(2.0, [0.0; 3]), (4.5, [1.0; 3])], vec![(2.0, 1.0)]).unwrap();
        let valued = plain.clone().with_values(Per::Cell(vec![3.0]), grey).unwrap();
        let entries: Vec<_> = entries(&[plain, colored, valued]).collect();
        assert_eq!(entries[0].colors, [[0.8_f32; 3].map(f64::from)]);
        assert_eq!(entries[1].colors, [[0.5, 0.0, 0.0]]);
        assert_eq!((entries[2].name.as_str(), entries[2].colors[0], entries[2].colors[5]), ("t, 2 to 4.5", [0.0; 3], [1.0; 3]));
    }

    #[test]
    fn flat_surfaces_have_a_volume_around_them() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let triangle = Surface::new("t", Triangles::new(points, vec![[0, 1, 2]]).unwrap());
        let (volume, transfer) = empty_volume(Path::new("t.stl"), &[triangle]).unwrap();
        assert_eq!((volume.grid().dims(), volume.grid().spacing()), ([17, 17, 2], DVec3::splat(1.0 / 16.0)));
        assert_eq!(transfer.opacity(0.0), 0.0);
    }
}
