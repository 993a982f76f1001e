//! What all pages of a run share: the volume on the device, and what its first view is.

use super::look::Look;
use super::protocol::{Kind, PageCamera, PageProjection};
use crate::camera::OrbitFrame;
use crate::device::Device;
use crate::error::Error;
use crate::files::Scratch;
use crate::framing::{Fixed, Framing, Orientation, Side};
use crate::renderer::{Renderer, UploadedVolume, VolumeRenderer, volume_renderer};
use crate::settings::{Blend, CropBox, Quality, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Statistics, Volume};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use tokio::sync::watch;

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

    /// The command that makes a picture, with this name of the transfer function's file.
    fn command_line(&self, look: &Look, camera: &PageCamera, size: Viewport, samples: u32, transfer: &str) -> String;

    /// The command that makes a film along the key cameras of a file: N × N samples per pixel, pictures per second, and its file's name.
    fn film_command_line(&self, look: &Look, size: Viewport, made: (u32, u32, &str), keys: &str, transfer: &str) -> String;

    /// Volumes that the page may open by name.
    fn offered(&self) -> Vec<Offered> {
        Vec::new()
    }

    /// Opens another volume, with the program's options that go with any volume.
    ///
    /// # Errors
    /// If it is not offered or cannot be read.
    fn open(&self, source: &Source) -> Result<(Opening, Box<dyn Host>), Error>;

    /// A sentence for an error, with what the user can do.
    fn sentence(&self, error: &Error) -> String {
        error.to_string()
    }
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
    /// The volume. Its name is that of the file, without folders.
    pub volume: Volume<'static>,
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

/// A volume and how it is shown.
pub(super) struct Scene {
    /// Number of the scene within the run.
    number: u32,
    pub opening: Opening,
    pub host: Box<dyn Host>,
    /// `None` if the volume is streamed.
    uploaded: Option<UploadedVolume>,
    statistics: Statistics,
    /// The folder of a dropped file, removed with the scene. After the volume, which may be mapped.
    _held: Option<Scratch>,
    _alive: Arc<()>,
    /// Whether programs are built, or being built, in the background.
    pub warming: AtomicBool,
    /// Whether these programs are ready.
    pub ready: watch::Sender<bool>,
}

impl Scene {
    /// Uploads the volume, unless it needs to be streamed.
    pub fn new(mut opening: Opening, host: Box<dyn Host>, alive: Arc<()>, number: u32) -> Result<Self, Error> {
        let own = &opening.transfer;
        opening.transfer = TransferFunction::new(file_name(own.name()), own.colors().to_vec(), own.opacities().to_vec())?;
        let Opening { volume, device, .. } = &opening;
        let bytes = volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
        let is_streamed = device.memory_budget().is_some() || bytes > device.largest_buffer_bytes();
        let uploaded = if is_streamed { None } else { Some(UploadedVolume::new(device, volume)?) };
        let statistics = volume.statistics();
        let (warming, ready) = (AtomicBool::new(false), watch::Sender::new(false));
        Ok(Self { number, opening, host, uploaded, statistics, _held: None, _alive: alive, warming, ready })
    }

    /// Keeps a dropped file as long as the scene.
    pub fn holding(self, folder: Option<Scratch>) -> Self {
        Self { _held: folder, ..self }
    }

    /// A renderer of its own for a page. All share the voxels.
    pub fn renderer(&self) -> Result<Box<dyn VolumeRenderer<'static> + Send>, Error> {
        let Opening { volume, transfer, device, time_limit, .. } = &self.opening;
        let mut renderer: Box<dyn VolumeRenderer<'static> + Send> = match &self.uploaded {
            Some(uploaded) => Box::new(Renderer::from_uploaded(uploaded, transfer)?),
            None => volume_renderer(device, volume, transfer)?,
        };
        renderer.limit(*time_limit);
        Ok(renderer)
    }

    pub fn frame(&self) -> OrbitFrame {
        self.opening.orientation.frame()
    }

    /// The camera of a page, and its check.
    pub fn camera(&self, camera: &PageCamera) -> Result<crate::Camera, Error> {
        camera.camera(self.frame(), self.opening.volume.grid())
    }

    /// The camera with these angles and this kind of projection that fits what is visible.
    pub fn fitted(&self, camera: &PageCamera, size: Viewport, settings: &Settings, transfer: &TransferFunction) -> PageCamera {
        let volume = &self.opening.volume;
        let framing = match settings.blend {
            Blend::Composite => Framing::visible(volume, transfer, settings.unit_distance),
            Blend::Iso(value) => Framing::iso(volume, value),
            _ => Framing::whole(volume),
        };
        let framing = match settings.clipping.crop {
            Some(CropBox { lowest, highest }) => framing.cropped(volume.grid(), lowest, highest),
            None => framing,
        };
        let orbit = self.frame().orbit(camera.orbit());
        let fitted = match camera.projection {
            PageProjection::ParallelScale(_) => framing.parallel(orbit, size, Fixed::default()),
            PageProjection::Perspective([field_of_view, _]) => framing.perspective(orbit, size, field_of_view, Fixed::default()),
        };
        PageCamera::new(&fitted, camera.orbit())
    }

    /// A transfer function by name.
    pub fn named(&self, kind: Kind, name: &str) -> Result<TransferFunction, Error> {
        let volume = &self.opening.volume;
        match kind {
            Kind::Automatic => TransferFunction::automatic_in(volume, name),
            Kind::Preset => TransferFunction::preset(name, volume),
            Kind::Map => TransferFunction::builtin(name, volume),
            Kind::Initial => Ok(self.opening.transfer.clone()),
        }
    }

    /// The first message of a session.
    pub fn hello(&self) -> Value {
        let Opening { volume, transfer, orientation, camera, camera_is_given, look, .. } = &self.opening;
        let (grid, frame) = (volume.grid(), self.frame());
        let sides = Side::ALL.map(|side| {
            let orbit = orientation.side(side);
            json!({ "name": side.name(), "seen_from": orientation.seen_from(orbit), "azimuth": orbit.azimuth, "elevation": orbit.elevation })
        });
        let is_layered = self.host.settings(look, None).is_ok_and(|settings| settings.layered().is_some());
        let maps = TransferFunction::names().map(|name| json!({ "name": name, "colors": self.preview(name) }));
        json!({
            "type": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "volume": {
                "name": volume.name(), "dims": grid.dims(), "spacing": grid.spacing().to_array(), "centre": grid.centre().to_array(),
                "diagonal": grid.diagonal(), "voxel_type": volume.voxel_type().to_string(),
            },
            "frame": { "right": frame.right().to_array(), "up": frame.up().to_array(), "to_eye": frame.to_eye().to_array() },
            "sides": sides,
            "histogram": { "lowest": self.statistics.min, "highest": self.statistics.max, "counts": self.statistics.histogram },
            "camera": camera, "camera_is_given": camera_is_given, "look": look,
            "transfer": { "name": transfer.name(), "colors": transfer.colors(), "opacities": transfer.opacities() },
            "palettes": TransferFunction::palettes().collect::<Vec<_>>(),
            "presets": TransferFunction::presets().map(|(name, shows)| json!({ "name": name, "shows": shows })).collect::<Vec<_>>(),
            "maps": maps.collect::<Vec<_>>(),
            "is_layered": is_layered,
            "scene": self.number,
            "offered": self.host.offered(),
        })
    }

    /// Colours of a map at even distances.
    fn preview(&self, name: &str) -> Vec<[f64; 3]> {
        /// Enough for a strip on the page.
        const COLORS: usize = 12;
        let Ok(map) = TransferFunction::builtin(name, &self.opening.volume) else { return Vec::new() };
        let (lo, hi) = map.range();
        let at = |n: usize| map.color(lo + (hi - lo) * n as f64 / (COLORS - 1) as f64);
        (0..COLORS).map(|n| at(n).map(|c| (c * 1e3).round() / 1e3)).collect()
    }
}

/// A name without folders: the page names no path of this machine.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or_default()
}
