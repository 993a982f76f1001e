//! What all pages of a run share: the volume on the device, and what their first view is.

use super::drawn::{CurrentLook, Drawn, LastColors, PageRenderer, Uploaded};
use super::first::{First, Opening};
use super::host::Host;
use super::page_camera::{PageCamera, PageProjection};
use super::readiness::Readiness;
use super::requests::Kind;
use super::turns::Turns;
use crate::camera::OrbitFrame;
use crate::error::Error;
#[cfg(feature = "viewer")]
use crate::files::Scratch;
use crate::framing::Fixed;
use crate::renderer::{LabelColors, UploadedVolume};
use crate::settings::{FieldKind, Settings};
use crate::shown::Shown;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Statistics, Volume};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

/// What all pages of a run share.
pub struct SharedScene {
    /// Number of the scene within a run that opens several.
    pub(super) number: u32,
    pub(super) opening: Opening,
    pub(super) host: Box<dyn Host>,
    pub(super) uploaded: Uploaded,
    /// Colours of labels over the volume.
    pub(super) label_colors: LastColors<LabelColors>,
    /// Statistics of each field, counted for the first page.
    pub(super) statistics: OnceLock<Vec<Statistics>>,
    /// The folder of a dropped file, removed with the scene. After the volume, which may be mapped.
    #[cfg(feature = "viewer")]
    _held: Option<Scratch>,
    /// Whether programs without and with a light volume are built, or being built, in the background.
    pub(super) warming: [AtomicBool; 2],
    /// Whether these programs are ready.
    pub(super) ready: Readiness,
    /// Those of all pages of a run.
    pub(super) turns: Arc<Turns>,
}

impl SharedScene {
    /// Uploads the volume, unless it needs to be streamed.
    ///
    /// # Errors
    /// Insufficient memory of the device, and labels that do not fit the volume.
    pub fn new(mut opening: Opening, host: Box<dyn Host>) -> Result<Self, Error> {
        without_folders(&mut opening.transfer)?;
        if let Drawn::Several(fields) = &mut opening.drawn {
            fields.iter_mut().try_for_each(|field| without_folders(&mut field.transfer))?;
        }
        let Opening { volume, device, .. } = &opening;
        let bytes = volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
        let needs_all = opening.drawn.kind() == FieldKind::LabelColors;
        let is_streamed = !needs_all && (device.memory_budget().is_some() || bytes > device.largest_buffer_bytes());
        let is_shared = !is_streamed && opening.time.is_none();
        let uploaded = match opening.drawn.upload(device)? {
            Some(uploaded) => uploaded,
            None if is_shared => Uploaded::One(Box::new(UploadedVolume::new(device, volume)?)),
            None => Uploaded::Own,
        };
        let (statistics, warming, ready) = (OnceLock::new(), Default::default(), Readiness::default());
        let scene = Self {
            number: 0,
            opening,
            host,
            uploaded,
            label_colors: LastColors::default(),
            statistics,
            #[cfg(feature = "viewer")]
            _held: None,
            warming,
            ready,
            turns: Arc::default(),
        };
        if needs_all {
            // Labels that do not fit the volume fail now, not with the first page.
            scene.renderer(&scene.opening.transfer)?;
        }
        Ok(scene)
    }

    /// A scene of a run after an earlier one. It keeps the folder of its dropped file.
    #[cfg(feature = "viewer")]
    pub(super) fn after(self, earlier: &Self, number: u32, folder: Option<Scratch>) -> Self {
        Self { number, _held: folder, turns: earlier.turns.clone(), ..self }
    }

    /// A renderer of its own for a page, or for the program. All share the voxels, unless these are a step of a sequence: the first one.
    ///
    /// # Errors
    /// Insufficient memory of the device.
    pub fn renderer(&self, transfer: &TransferFunction) -> Result<Box<PageRenderer>, Error> {
        let first = First { transfer: transfer.clone(), ..self.opening.first() };
        let now = CurrentLook { look: &first.look, transfers: &first.transfers() };
        self.page_renderer(&self.opening.volume, now)
    }

    /// Bytes of the voxels on the device that all pages share.
    pub(super) fn voxel_bytes(&self) -> u64 {
        let bytes = |volume: &Volume| volume.grid().voxel_count() as u64 * volume.voxel_type().bytes() as u64;
        match self.opening.drawn.fields() {
            [] => bytes(&self.opening.volume),
            fields => {
                fields.iter().map(|field| field.shown.as_ref().map_or_else(|| bytes(&field.volume), Shown::voxel_bytes)).sum()
            }
        }
    }

    /// The frame in which angles of pages are counted.
    pub fn frame(&self) -> OrbitFrame {
        self.opening.orientation.frame()
    }

    /// Unit of length of the volume.
    pub fn length_units(&self) -> Option<&str> {
        self.opening.volume.length_unit()
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
        now: CurrentLook,
    ) -> Result<PageCamera, Error> {
        let framing = self.framing(settings, now)?;
        let orbit = self.frame().orbit(camera.orbit());
        let fitted = match camera.projection {
            PageProjection::ParallelScale(_) => framing.parallel(orbit, size, Fixed::default()),
            PageProjection::Perspective([field_of_view, _]) => framing.perspective(orbit, size, field_of_view, Fixed::default()),
        };
        Ok(PageCamera::new(&fitted, camera.orbit()))
    }

    /// A transfer function of a field by name.
    pub(super) fn named(&self, field: usize, kind: Kind, name: &str) -> Result<TransferFunction, Error> {
        let own = self.opening.drawn.fields().get(field);
        let (volume, initial) = match own {
            Some(own) => (&own.volume, &own.transfer),
            None => (self.values(), &self.opening.transfer),
        };
        match kind {
            Kind::Automatic => TransferFunction::automatic_in(volume, name),
            Kind::Preset => TransferFunction::preset(name, volume),
            Kind::Map => TransferFunction::builtin(name, volume),
            Kind::Initial => Ok(initial.clone()),
        }
    }
}

/// Leaves the folders out of the name of a transfer function.
fn without_folders(transfer: &mut TransferFunction) -> Result<(), Error> {
    *transfer = TransferFunction::new(file_name(transfer.name()), transfer.colors().to_vec(), transfer.opacities().to_vec())?;
    Ok(())
}

/// A name without folders: the page names no path of this machine.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or_default()
}
