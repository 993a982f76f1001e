//! Options for the volume.

use super::LabelOptions;
use crate::cache;
use crate::cli::values::{ChannelChoice, Component, LevelChoice};
use crate::cli::{parse, standard};
use crate::url;
use crate::viewport::Viewport;
use crate::volume::{
    ChannelDescription, Contents, Endian, Labels, Level, OpenOptions, Placement, ScalarType, Sequence, Volume, VoxelBox,
};
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::{Path, PathBuf};
use tracing::subscriber::{NoSubscriber, with_default};

/// Selection of the volume.
#[derive(Args, Clone)]
pub(in crate::cli) struct VolumeOptions {
    /// Volume: a file, a folder or NAME%d.EXT of slices, the URL of a Zarr, builtin:NAME, or - for standard input; see below
    #[arg(default_value = Self::DEFAULT)]
    pub volume: PathBuf,
    #[command(flatten)]
    file: FileOptions,
    /// Value outside the grid and of NaN or infinite voxels [default: the smallest valid value; built-in volumes: 0]
    #[arg(long, value_parser = parse::finite, value_name = "V", allow_hyphen_values = true, help_heading = "Volume")]
    background_value: Option<f64>,
    /// Whether the file may name others of its own folder only.
    #[arg(skip)]
    pub confined: bool,
}

/// Properties that a file does not state, and selection of one of several volumes in a file.
#[derive(Args, Clone)]
pub(in crate::cli) struct FileOptions {
    /// Dimensions in voxels, if the file does not state them
    #[arg(long, value_parser = parse::dims, value_name = "XxYxZ", help_heading = "Volume")]
    dims: Option<[usize; 3]>,
    /// Voxel type, if the file does not state it: uint or int with 8, 16, 32 or 64 (e.g. uint8), float16, float32, float64
    #[arg(long = "type", value_name = "TYPE", help_heading = "Volume")]
    voxel_type: Option<ScalarType>,
    /// Distances between voxels along x, y and z, also of other files that state none [default: those of the file, or 1,1,1]
    #[arg(long, value_parser = parse::spacing, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Volume")]
    spacing: Option<DVec3>,
    /// World position of the first voxel, also of other files that state no spacing [default: that of the file, or 0,0,0]
    #[arg(long, value_parser = parse::vector, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Volume")]
    origin: Option<DVec3>,
    /// Byte order of raw data [default: little]
    #[arg(long, value_name = "ORDER", help_heading = "Volume")]
    endian: Option<EndianName>,
    /// Bytes before the first voxel; in a .gz file after decompression [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    header_bytes: Option<u64>,
    /// Volume of a file with several, from 0 [default: 0]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    frame: Option<usize>,
    /// Component (channel) of a file with several values per voxel: its number from 0, its name, or their magnitude [default: magnitude of vectors, else 0]
    #[arg(long, value_parser = parse::channel, value_name = "N|NAME|magnitude", help_heading = "Volume")]
    channel: Option<ChannelChoice>,
    /// Array of a file with several [default: the one marked as active, or the first]
    #[arg(long, value_name = "NAME", help_heading = "Volume", visible_alias = "dataset")]
    array: Option<String>,
    /// DICOM series in a folder with several: its number, description or UID
    #[arg(long, value_name = "NAME", help_heading = "Volume")]
    series: Option<String>,
    /// Resolution level from 0 (finest), or auto: the coarsest with a voxel per pixel [default: auto; without pictures: the finest that fits into memory]
    #[arg(long, value_parser = parse::level, value_name = "N|auto", help_heading = "Volume")]
    level: Option<LevelChoice>,
    /// Read a level finer than pixels: voxels are at most 1/N of one [default: 1]
    #[arg(long, value_parser = parse::positive, value_name = "N", allow_hyphen_values = true, help_heading = "Volume")]
    oversample: Option<f64>,
    /// Part of a Zarr to read as if it were all, in voxels of level 0: from X0 to before X1, and so on; sides may be left out
    #[arg(long, value_parser = parse::region, value_name = "X0:X1,Y0:Y1,Z0:Z1", help_heading = "Volume")]
    region: Option<VoxelBox>,
    /// Most bytes of voxels, unpacked, that a URL may have, e.g. 800MB [default: 2GB]
    #[arg(long, value_parser = parse::bytes, value_name = "BYTES", allow_hyphen_values = true, help_heading = "Volume")]
    download: Option<u64>,
    /// Chunks of a URL that the server refuses (403): an error, or fill: not stored, as object stores that do not list mean it [default: refuse]
    #[arg(long, value_name = "refuse|fill", help_heading = "Volume", hide_possible_values = true)]
    missing: Option<MissingChunks>,
    /// Neither use nor keep on disk what is read of a URL (see `layersplat cache`)
    #[arg(long, help_heading = "Volume")]
    no_cache: bool,
}

/// A volume with what its file states about it.
pub(in crate::cli) struct Described {
    pub volume: Volume<'static>,
    /// Its labels, if the options or the file say that its voxels are some.
    pub labels: Option<Labels>,
    /// Its components, if there are several.
    pub channels: Result<Vec<ChannelDescription>, crate::Error>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum MissingChunks {
    Refuse,
    Fill,
}

#[derive(Clone, Copy, ValueEnum)]
enum EndianName {
    Little,
    Big,
}

impl VolumeOptions {
    /// The volume of a command that names none.
    pub const DEFAULT: &str = "builtin:hydrogen";

    /// Whether the volume is a raw file, which states no spacing, and none is given.
    pub fn assumes_spacing(&self) -> bool {
        let name = self.volume.to_string_lossy().to_lowercase();
        let is_raw = name.ends_with(".raw") || name.ends_with(".raw.gz") || self.file.dims.is_some();
        is_raw && self.file.spacing.is_none()
    }

    /// Whether the spacing is given.
    pub fn has_spacing(&self) -> bool {
        self.file.spacing.is_some()
    }

    /// The placement of further files that state none.
    pub fn placement(&self) -> Placement {
        Placement { spacing: self.file.spacing, origin: self.file.origin }
    }

    /// Whether a background value is given.
    pub fn has_background_value(&self) -> bool {
        self.background_value.is_some()
    }

    /// Whether one of several components is chosen.
    pub fn has_channel(&self) -> bool {
        self.file.channel.is_some()
    }

    /// Whether pictures choose the level and the part of the volume that are read.
    pub fn leaves_level(&self) -> bool {
        let FileOptions { level, region, origin, .. } = self.file;
        !matches!(level, Some(LevelChoice::Number(_)))
            && region.is_none()
            && origin.is_none()
            && !standard::is_input(&self.volume)
    }

    /// Voxels along a side of a pixel.
    pub fn oversampling(&self) -> f64 {
        self.file.oversample.unwrap_or(1.0)
    }

    /// Most bytes of voxels that are read from a server; `None` of files of this machine.
    pub fn most_downloaded(&self) -> Option<u64> {
        url::is_url(&self.volume).then(|| self.file.download.unwrap_or(OpenOptions::DOWNLOAD))
    }

    /// The library's options for opening a level that they do not choose.
    pub fn of_level(&self) -> Result<OpenOptions, crate::Error> {
        let file = FileOptions { level: None, ..self.file.clone() };
        Self { file, ..self.clone() }.opening(None)
    }

    /// Opens the level that stands for all.
    pub fn open_overview(&self, memory: Option<u64>) -> Result<Volume<'static>, crate::Error> {
        let options = OpenOptions { memory, level: Some(Level::Overview), ..self.of_level()? };
        self.with_background(Volume::open(&self.volume, &options)?)
    }

    /// Whether one of several frames is chosen.
    #[cfg(feature = "viewer")]
    pub fn has_frame(&self) -> bool {
        self.file.frame.is_some()
    }

    pub fn is_default(&self) -> bool {
        self.volume == Path::new(Self::DEFAULT)
    }

    /// Opens the volume. `size` is the picture size, if pictures are rendered. `memory` limits the bytes of the volume in host
    /// memory if it cannot be memory-mapped.
    pub fn open(&self, size: Option<Viewport>, memory: Option<u64>) -> Result<Volume<'static>, crate::Error> {
        let options = OpenOptions { memory, ..self.opening(size)? };
        self.with_background(standard::open_input(&self.volume, |path| Volume::open(path, &options))?)
    }

    /// What the volume's file states about its components.
    pub fn channel_descriptions(&self, size: Option<Viewport>) -> Result<Vec<ChannelDescription>, crate::Error> {
        ChannelDescription::of_file(&self.volume, &self.opening(size)?)
    }

    /// Opens the labels of the volume's file, if the options or the file say that its voxels are some.
    pub fn labels(&self, labels: &LabelOptions, size: Viewport) -> Result<Option<Labels>, crate::Error> {
        let are_values = self.volume.to_string_lossy().starts_with("builtin:");
        if standard::is_input(&self.volume) || (are_values && !labels.is_given()) {
            return Ok(None);
        }
        labels.open(&self.volume, &self.opening(Some(size))?)
    }

    /// Whether the file says that its components are colours, and none of them is chosen.
    pub fn declares_colors(&self, size: Viewport) -> bool {
        self.contents(size).is_some_and(|contents| contents.are_colors)
    }

    /// What the file holds, if it is a readable one and none of its channels is chosen.
    pub fn contents(&self, size: Viewport) -> Option<Contents> {
        if standard::is_input(&self.volume) || self.file.channel.is_some() {
            return None;
        }
        let options = self.opening(Some(size)).ok()?;
        // The reader says what is wrong with a file.
        Contents::of_file(&self.volume, &options).ok()
    }

    /// Whether the file says that its voxels are labels.
    pub fn declares_labels(&self, size: Viewport) -> bool {
        let options = self.opening(Some(size));
        options.and_then(|options| Labels::are_declared(&self.volume, &options)).unwrap_or(false)
    }

    /// Another file, or one of its frames, that is opened with the same options.
    pub fn at(&self, file: &Path, frame: Option<usize>) -> Self {
        Self { volume: file.into(), file: FileOptions { frame, ..self.file.clone() }, ..self.clone() }
    }

    /// The library's options for opening the file. `size` is the picture size, if pictures are rendered.
    pub fn opening(&self, size: Option<Viewport>) -> Result<OpenOptions, crate::Error> {
        let mut options = OpenOptions { confined: self.confined, ..self.file.raw(size)? };
        if let Some(size) = size.filter(|_| url::is_url(&self.volume) && options.level.is_none()) {
            options.level = Some(auto(size, self.oversampling()));
        }
        Ok(options)
    }

    /// Opens another component of the volume's file.
    pub fn open_component(&self, component: &Component, size: Option<Viewport>) -> Result<Volume<'static>, crate::Error> {
        if standard::is_input(&self.volume) {
            let problem = "are read one after the other, and standard input can be read once: name a file".into();
            return Err(crate::Error::Settings { field: "channels", problem });
        }
        let options = component.chosen(self.opening(size)?);
        self.with_background(Volume::open(&self.volume, &options)?)
    }

    /// Opens the volume with what its file states about it.
    pub fn open_described(&self, label_options: &LabelOptions) -> Result<Described, crate::Error> {
        let options = self.opening(None)?;
        let (volume, labels, channels) = standard::open_input(&self.volume, |path| {
            let labels = label_options.open(path, &options)?;
            let open = || Volume::open(path, &options);
            // Labels have said what was chosen by default, and their ids are exact, which the volume's floats need not be.
            let volume = if labels.is_some() { with_default(NoSubscriber::default(), open) } else { open() }?;
            let channels =
                if volume.contents().channels > 1 { ChannelDescription::of_file(path, &options) } else { Ok(Vec::new()) };
            Ok((volume, labels, channels))
        })?;
        // Those that colour the volume are listed, too.
        let labels = labels.map_or_else(|| label_options.label_colors(self.placement()), |labels| Ok(Some(labels)))?;
        Ok(Described { volume: self.with_background(volume)?, labels, channels })
    }

    /// Opens the volume and `more` of them as a sequence in time; otherwise as [`open`](Self::open).
    /// `channel`: another component than the options choose.
    pub fn sequence(
        &self,
        more: &[PathBuf],
        component: Option<&Component>,
        size: Option<Viewport>,
        memory: Option<u64>,
    ) -> Result<Sequence, crate::Error> {
        let sources: Vec<&Path> = std::iter::once(&self.volume).chain(more).map(PathBuf::as_path).collect();
        if sources.iter().any(|source| standard::is_input(source)) {
            let problem = "reads steps more than once, and standard input can be read once: name a file".into();
            return Err(crate::Error::Settings { field: "time", problem });
        }
        let options = OpenOptions { memory, ..self.opening(size)? };
        let options = match component {
            Some(component) => component.chosen(options),
            None => options,
        };
        let sequence = Sequence::open(&sources, &options)?;
        Ok(match self.background_value {
            Some(value) => sequence.with_background(value),
            None => sequence,
        })
    }

    /// Applies `--background-value`.
    pub fn with_background(&self, volume: Volume<'static>) -> Result<Volume<'static>, crate::Error> {
        match self.background_value {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

/// The level that a picture of a size shows.
fn auto(size: Viewport, oversampling: f64) -> Level {
    Level::Pixels((f64::from(size.width.max(size.height)) * oversampling) as usize)
}

impl FileOptions {
    /// The library's options for opening the file. `size` is the picture size, if pictures are rendered.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for `--level auto` without pictures.
    pub fn raw(&self, size: Option<Viewport>) -> Result<OpenOptions, crate::Error> {
        let endian = self.endian.map(|endian| match endian {
            EndianName::Little => Endian::Little,
            EndianName::Big => Endian::Big,
        });
        let Self { dims, voxel_type, spacing, origin, header_bytes, frame, region, download, missing, no_cache, .. } = *self;
        if no_cache {
            // Of this process: each command has one set of options for its volumes.
            cache::turn_off();
        }
        let (array, series) = (self.array.clone(), self.series.clone());
        let level = match (self.level, size) {
            (None, _) => None,
            (Some(LevelChoice::Number(n)), _) => Some(Level::Number(n)),
            (Some(LevelChoice::Auto), Some(size)) => Some(auto(size, self.oversample.unwrap_or(1.0))),
            (Some(LevelChoice::Auto), None) => {
                let problem = "auto needs a picture size, which this command does not have: use a number".into();
                return Err(crate::Error::Settings { field: "level", problem });
            }
        };
        let options = OpenOptions {
            dims,
            voxel_type,
            spacing,
            origin,
            unstated: Placement::default(),
            endian,
            header_bytes,
            frame,
            channel: None,
            channel_name: None,
            magnitude: matches!(self.channel, Some(ChannelChoice::Magnitude)),
            array,
            series,
            level,
            region,
            download,
            memory: None,
            fills_refused: missing == Some(MissingChunks::Fill),
            confined: false,
        };
        Ok(match &self.channel {
            Some(ChannelChoice::One(component)) => component.chosen(options),
            Some(ChannelChoice::Magnitude) | None => options,
        })
    }
}
