//! What all pages of a run share: the volume on the device, and what its first view is.

use super::look::Look;
use super::page_camera::{PageCamera, PageProjection};
use super::protocol::{Kind, NamedTransfer, Reply, SavedFormat};
use super::readiness::Readiness;
use super::slices;
use super::time::Time;
use crate::camera::OrbitFrame;
use crate::device::Device;
use crate::error::Error;
#[cfg(feature = "viewer")]
use crate::files::Scratch;
use crate::framing::{Fixed, Orientation, Side};
use crate::renderer::{Renderer, UploadedVolume, VolumeRenderer, volume_renderer};
use crate::settings::{Quality, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Statistics, Volume};
use serde::Serialize;
use serde_json::json;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What the program that shows the page knows: its options, and how they are written.
pub trait Host: Send + Sync {
    /// The settings of a look, with the program's own options. `quality` replaces that of the look.
    ///
    /// # Errors
    /// If the look does not go with the options.
    fn settings(&self, look: &Look, quality: Option<Quality>) -> Result<Settings, Error>;

    /// Fails if the device may not draw such pictures. May take seconds for the first picture of a kind.
    ///
    /// # Errors
    /// If the device check failed.
    fn require_checked(&self, camera: &crate::Camera, size: Viewport, settings: &Settings) -> Result<(), Error>;

    /// The command that makes a picture.
    fn command_line(&self, wanted: &Wanted) -> String;

    /// The same picture as a program in Python.
    fn python(&self, wanted: &Wanted) -> String;

    /// The command that makes a film, if the program has one.
    fn film_command_line(&self, _: &FilmWanted) -> Option<String> {
        None
    }

    /// Whether the page may open other volumes.
    fn opens_volumes(&self) -> bool {
        false
    }

    /// Volumes that the page may open by name.
    fn offered(&self) -> Vec<Offered> {
        Vec::new()
    }

    /// Opens another volume, with the program's options that go with any volume.
    ///
    /// # Errors
    /// If it is not offered or cannot be read.
    fn open(&self, _: &Source) -> Result<(Opening, Box<dyn Host>), Error> {
        Err(Error::Settings { field: "page", problem: "this program shows a single volume".into() })
    }

    /// Whether programs of usual frames are built in the background, with the first page.
    fn builds_ahead(&self) -> bool {
        true
    }

    /// A sentence for an error, with what the user can do.
    fn sentence(&self, error: &Error) -> String {
        error.to_string()
    }
}

/// A picture whose command is asked for.
#[derive(Clone, Copy)]
pub struct Wanted<'a> {
    /// Its look, with a quality.
    pub look: &'a Look,
    /// Its camera.
    pub camera: &'a PageCamera,
    /// The same camera in the world.
    pub view: crate::Camera,
    /// Its size.
    pub size: Viewport,
    /// N × N samples per pixel.
    pub samples: u32,
    /// Format of the file.
    pub format: SavedFormat,
    /// Name of the transfer function's file.
    pub transfer: &'a str,
    /// Unit of length, if it is known.
    pub length_units: Option<&'a str>,
}

/// A film whose command is asked for.
#[derive(Clone, Copy)]
pub struct FilmWanted<'a> {
    /// Its look, with a quality.
    pub look: &'a Look,
    /// Size of its pictures.
    pub size: Viewport,
    /// N × N samples per pixel.
    pub samples: u32,
    /// Pictures per second.
    pub rate: u32,
    /// Name of the film's file.
    pub output: &'a str,
    /// Name of the file with the key cameras.
    pub keys: &'a str,
    /// Name of the transfer function's file.
    pub transfer: &'a str,
    /// Unit of length, if it is known.
    pub length_units: Option<&'a str>,
}

/// A volume that the page may open.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Offered {
    /// Its name, without folders.
    pub name: String,
    /// Whether it is built in.
    pub is_builtin: bool,
}

/// What is opened.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// One of the offered volumes, by its name.
    Offered(&'a str),
    /// A temporary file, which exists as long as its volume.
    File(&'a Path),
}

/// How a volume is shown first.
pub struct Opening {
    /// The volume, or the first step of a sequence. Its name is that of the file, without folders.
    pub volume: Volume<'static>,
    /// The sequence, if the volume is one.
    pub time: Option<Time>,
    /// The first transfer function.
    pub transfer: TransferFunction,
    /// The device.
    pub device: Device,
    /// Which way is up.
    pub orientation: Orientation,
    /// The first camera.
    pub camera: PageCamera,
    /// Whether the camera is as the user gave it; otherwise it is fitted to each page.
    pub camera_is_given: bool,
    /// The first look.
    pub look: Look,
    /// Time limit per frame on the device.
    pub time_limit: Option<Duration>,
}

/// What a page begins with.
#[derive(Clone, Debug, PartialEq)]
pub struct First {
    /// The camera.
    pub camera: PageCamera,
    /// Whether it stays as it is; otherwise it is fitted to the page.
    pub camera_is_given: bool,
    /// The look.
    pub look: Look,
    /// The transfer function.
    pub transfer: TransferFunction,
}

impl Opening {
    /// What the first page begins with.
    pub fn first(&self) -> First {
        let Self { camera, camera_is_given, look, transfer, .. } = self;
        First { camera: *camera, camera_is_given: *camera_is_given, look: look.clone(), transfer: transfer.clone() }
    }
}

/// What all pages of a run share.
pub struct Scene {
    /// Number of the scene within a run that opens several.
    number: u32,
    pub(super) opening: Opening,
    pub(super) host: Box<dyn Host>,
    /// `None` if the volume is streamed, and for a sequence: each page has its own step on the device.
    uploaded: Option<UploadedVolume>,
    /// Counted for the first page.
    statistics: OnceLock<Statistics>,
    /// The folder of a dropped file, removed with the scene. After the volume, which may be mapped.
    #[cfg(feature = "viewer")]
    _held: Option<Scratch>,
    /// Whether programs without and with a light volume are built, or being built, in the background.
    pub(super) warming: [AtomicBool; 2],
    /// Whether these programs are ready.
    pub(super) ready: Readiness,
}

impl Scene {
    /// Uploads the volume, unless it needs to be streamed.
    ///
    /// # Errors
    /// Insufficient memory of the device.
    pub fn new(mut opening: Opening, host: Box<dyn Host>) -> Result<Self, Error> {
        let own = &opening.transfer;
        opening.transfer = TransferFunction::new(file_name(own.name()), own.colors().to_vec(), own.opacities().to_vec())?;
        let Opening { volume, device, .. } = &opening;
        let bytes = volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
        let is_streamed = device.memory_budget().is_some() || bytes > device.largest_buffer_bytes();
        let is_shared = !is_streamed && opening.time.is_none();
        let uploaded = if is_shared { Some(UploadedVolume::new(device, volume)?) } else { None };
        let (statistics, warming, ready) = (OnceLock::new(), Default::default(), Readiness::default());
        Ok(Self {
            number: 0,
            opening,
            host,
            uploaded,
            statistics,
            #[cfg(feature = "viewer")]
            _held: None,
            warming,
            ready,
        })
    }

    /// A later scene of a run, which keeps the folder of its dropped file.
    #[cfg(feature = "viewer")]
    pub(super) fn numbered(self, number: u32, folder: Option<Scratch>) -> Self {
        Self { number, _held: folder, ..self }
    }

    /// A renderer of its own for a page, or for the program. All share the voxels, unless these are a step of a sequence: the first one.
    ///
    /// # Errors
    /// Insufficient memory of the device.
    pub fn renderer(&self, transfer: &TransferFunction) -> Result<Box<dyn VolumeRenderer<'static> + Send>, Error> {
        self.renderer_of(&self.opening.volume, transfer)
    }

    /// A renderer for a step.
    pub(super) fn renderer_of(
        &self,
        volume: &Volume<'static>,
        transfer: &TransferFunction,
    ) -> Result<Box<dyn VolumeRenderer<'static> + Send>, Error> {
        let Opening { device, time_limit, .. } = &self.opening;
        let mut renderer: Box<dyn VolumeRenderer<'static> + Send> = match &self.uploaded {
            Some(uploaded) => Box::new(Renderer::from_uploaded(uploaded, transfer)?),
            None => volume_renderer(device, volume, transfer)?,
        };
        renderer.limit(*time_limit);
        Ok(renderer)
    }

    /// The frame in which angles of pages are counted.
    pub fn frame(&self) -> OrbitFrame {
        self.opening.orientation.frame()
    }

    /// Unit of length of the volume. Patients are measured in millimetres; other files name no unit.
    pub fn length_units(&self) -> Option<&'static str> {
        self.opening.volume.grid().has_anatomy().then_some("mm")
    }

    /// The camera of a page, and its check.
    ///
    /// # Errors
    /// If numbers are not finite or lie outside their ranges.
    pub fn camera(&self, camera: &PageCamera) -> Result<crate::Camera, Error> {
        camera.camera(self.frame(), self.opening.volume.grid())
    }

    /// The camera with these angles and this kind of projection that fits what is visible.
    ///
    /// # Errors
    /// Those of reading the steps of a sequence.
    pub(super) fn fitted(
        &self,
        camera: &PageCamera,
        size: Viewport,
        settings: &Settings,
        transfer: &TransferFunction,
    ) -> Result<PageCamera, Error> {
        let framing = self.framing(settings, transfer)?;
        let orbit = self.frame().orbit(camera.orbit());
        let fitted = match camera.projection {
            PageProjection::ParallelScale(_) => framing.parallel(orbit, size, Fixed::default()),
            PageProjection::Perspective([field_of_view, _]) => framing.perspective(orbit, size, field_of_view, Fixed::default()),
        };
        Ok(PageCamera::new(&fitted, camera.orbit()))
    }

    /// A transfer function by name.
    pub(super) fn named(&self, kind: Kind, name: &str) -> Result<TransferFunction, Error> {
        let volume = self.values();
        match kind {
            Kind::Automatic => TransferFunction::automatic_in(volume, name),
            Kind::Preset => TransferFunction::preset(name, volume),
            Kind::Map => TransferFunction::builtin(name, volume),
            Kind::Initial => Ok(self.opening.transfer.clone()),
        }
    }

    /// The first message to a page, JSON.
    pub fn hello(&self, first: &First) -> String {
        let Opening { volume, orientation, .. } = &self.opening;
        let First { camera, camera_is_given, look, transfer } = first;
        let (grid, frame) = (volume.grid(), self.frame());
        let values = self.values();
        let statistics = self.statistics.get_or_init(|| values.statistics());
        let sides = Side::ALL.map(|side| {
            let orbit = orientation.side(side);
            json!({ "name": side.name(), "seen_from": orientation.seen_from(orbit), "azimuth": orbit.azimuth, "elevation": orbit.elevation })
        });
        let is_layered = self.host.settings(look, None).is_ok_and(|settings| settings.layered().is_some());
        let presets = TransferFunction::presets().map(|(name, shows)| {
            let colors = TransferFunction::preset(name, values).map_or_else(|_| Vec::new(), |preset| strip(&preset));
            json!({ "name": name, "shows": shows, "colors": colors })
        });
        let maps = TransferFunction::names().map(|name| json!({ "name": name, "colors": self.preview(name) }));
        json!({
            "type": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "volume": {
                "name": volume.name(), "dims": grid.dims(), "spacing": grid.spacing().to_array(), "centre": grid.centre().to_array(),
                "diagonal": grid.diagonal(), "voxel_type": volume.voxel_type().to_string(), "length_units": self.length_units(),
                "origin": grid.origin().to_array(), "direction": grid.direction().to_cols_array(),
            },
            "frame": { "right": frame.right().to_array(), "up": frame.up().to_array(), "to_eye": frame.to_eye().to_array() },
            "sides": sides,
            "histogram": { "lowest": statistics.min, "highest": statistics.max, "counts": statistics.histogram },
            "camera": camera, "camera_is_given": camera_is_given, "look": look,
            "transfer": NamedTransfer::from(transfer),
            "palettes": TransferFunction::palette_colors().map(|(name, colors)| json!({ "name": name, "colors": colors })).collect::<Vec<_>>(),
            "presets": presets.collect::<Vec<_>>(),
            "maps": maps.collect::<Vec<_>>(),
            "slices": slices::described(grid, values),
            "steps": self.steps(),
            "is_layered": is_layered,
            "scene": self.number,
            "opens_volumes": self.host.opens_volumes(),
            "offered": self.host.offered(),
        })
        .to_string()
    }

    /// The message to a page that shows these from now on, JSON.
    pub fn given(&self, now: &First) -> String {
        let First { camera, look, transfer, .. } = now;
        serde_json::to_string(&Reply::Given { camera: *camera, look, transfer: transfer.into() }).expect("replies are plain data")
    }

    /// Colours of a map.
    fn preview(&self, name: &str) -> Vec<[f64; 3]> {
        TransferFunction::builtin(name, self.values()).map_or_else(|_| Vec::new(), |map| strip(&map))
    }
}

/// Colours of a transfer function at even distances.
fn strip(transfer: &TransferFunction) -> Vec<[f64; 3]> {
    /// Enough for a strip on the page.
    const COLORS: usize = 12;
    let (lo, hi) = transfer.range();
    let at = |n: usize| transfer.color(lo + (hi - lo) * n as f64 / (COLORS - 1) as f64);
    (0..COLORS).map(|n| at(n).map(|c| (c * 1e3).round() / 1e3)).collect()
}

/// A name without folders: the page names no path of this machine.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or_default()
}
