//! Streaming plans: division into parts, memory, and display.

use super::super::PartRenderer;
use super::super::frame::Bytes;
use super::needs::{MemoryLimits, Needs};
use crate::device::Device;
use crate::error::Error;
use crate::layers::{Axis, Lattice};
use crate::settings::{Blend, LightGrid, Settings};
use serde::Serialize;
use std::fmt;
use std::ops::Range;

/// Streaming plan of a view.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::renderer::StreamedRenderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// match StreamedRenderer::new(&device, &volume, &transfer).plan(&camera, viewport, &Settings::default())? {
///     Some(plan) => println!("{plan}"),
///     None => println!("it fits as a whole"),
/// }
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StreamPlan {
    /// The lattices, rendered in sequence: one, or near 45° those of two or three layer axes.
    pub lattices: Vec<StreamedLattice>,
    /// Bytes of voxels that are read and uploaded for these lattices; layers shared by neighbouring parts count each time. Behind surfaces,
    /// parts are read again, as often as rays need them.
    pub voxel_bytes: u64,
    /// Bytes of voxels that are read and uploaded before, to sweep light through them; 0 if the light is kept from an earlier frame.
    pub light_bytes: u64,
    /// Bytes of the voxels of the volume.
    pub volume_bytes: u64,
    /// Peak bytes of buffers on the device.
    pub device_bytes: u64,
    /// Bytes available for these buffers: the budget minus what other objects hold.
    pub memory: u64,
}

/// Streaming of one lattice of a view.
///
/// ```
/// use layersplat::Settings;
/// use layersplat::renderer::StreamedRenderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// let plan = StreamedRenderer::new(&device, &volume, &transfer).plan(&camera, viewport, &Settings::default())?;
/// for lattice in plan.iter().flat_map(|plan| &plan.lattices) {
///     println!("{} parts along {:?}", lattice.parts, lattice.axis);
/// }
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StreamedLattice {
    /// The layer axis.
    pub axis: Axis,
    /// Number of parts.
    pub parts: usize,
    /// Largest number of layers held at once, including the neighbouring layers of a part.
    pub held_layers: usize,
}

impl fmt::Display for StreamPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for StreamedLattice { axis, parts, held_layers } in &self.lattices {
            let along = format!("{axis:?}").to_lowercase();
            match parts {
                1 => write!(f, "all {held_layers} layers along {along} at once; ")?,
                _ => write!(f, "{parts} parts of up to {held_layers} layers along {along}; ")?,
            }
        }
        let passes = self.voxel_bytes as f64 / self.volume_bytes as f64;
        write!(f, "{} bytes of voxels are read, {passes:.2} passes over the volume; ", self.voxel_bytes)?;
        if self.light_bytes > 0 {
            let passes = self.light_bytes as f64 / self.volume_bytes as f64;
            write!(f, "for light {} before, {passes:.2} passes; ", self.light_bytes)?;
        }
        write!(f, "at most {} bytes on the device, of {}", self.device_bytes, self.memory)
    }
}

/// Parts of a lattice, in view order.
pub(super) struct Parts {
    /// Layers composited by each part.
    pub ranges: Vec<Range<usize>>,
    /// Largest number of layers held at once, including neighbouring layers.
    pub held: usize,
    /// Memory on the device.
    pub bytes: Bytes,
    /// Bytes of voxels that are read.
    pub read: u64,
}

impl Parts {
    /// Divides into as few parts as the limits allow, as equal as possible.
    ///
    /// # Errors
    /// If not even a single layer fits; the error contains the memory that it needs.
    pub fn new(
        device: &Device,
        lattice: &Lattice,
        settings: &Settings,
        needs: &Needs,
        limits: MemoryLimits,
    ) -> Result<Self, Error> {
        let (all, around) = (needs.layer_count(), PartRenderer::around(settings));
        let held = |layers: usize| (layers + 2 * around).min(all);
        let numbers: Vec<usize> = (1..=all).collect();
        let most = numbers.partition_point(|&layers| limits.fits(needs.bytes(held(layers))));
        if most == 0 {
            return Err(out_of_memory(
                device,
                settings,
                "this view of the volume, one layer at a time,",
                needs.bytes(held(1)),
                limits,
            ));
        }
        let parts = if limits.fits(needs.bytes(all)) { 1 } else { all.div_ceil(most) };
        let mut ranges: Vec<_> = (0..parts).map(|n| n * all / parts..(n + 1) * all / parts).collect();
        if lattice.layer_step < 0 {
            ranges.reverse();
        }
        let lengths = || ranges.iter().map(|layers| PartRenderer::needed(layers, all, settings).len());
        let (held, sum) = (lengths().max().unwrap_or(all), lengths().sum::<usize>());
        Ok(Self { held, bytes: needs.bytes(held), read: sum as u64 * needs.layer_bytes(), ranges })
    }
}

/// Builds the out-of-memory error.
pub(super) fn out_of_memory(device: &Device, settings: &Settings, what: &str, bytes: Bytes, limits: MemoryLimits) -> Error {
    let what = what.to_owned();
    if bytes.sum > limits.free() && settings.sweeps_light() {
        let can_be_coarser = settings.swept_grid() == LightGrid::Full && settings.blend == Blend::Composite;
        return Error::LightMemory { what, needed: bytes.sum, taken: limits.taken, budget: limits.budget, can_be_coarser };
    }
    if bytes.sum > limits.free() {
        return Error::MemoryBudget { what, needed: bytes.sum, taken: limits.taken, budget: limits.budget };
    }
    let (needed, available) = (bytes.largest, limits.largest);
    Error::DeviceMemory { what, device: device.info().name.clone(), needed, available }
}
