//! How volumes are streamed: which layers are held together, what that takes, and how it is told.

use super::super::PartRenderer;
use super::super::frame::Bytes;
use super::needs::{Needs, Room};
use crate::device::Device;
use crate::error::Error;
use crate::layers::{Axis, Lattice};
use crate::settings::Settings;
use serde::Serialize;
use std::fmt;
use std::ops::Range;

/// How a view of a volume is streamed.
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
    /// What is drawn, one after the other: one lattice, or near 45° those of two or three layer axes.
    pub lattices: Vec<StreamedLattice>,
    /// Bytes of voxels that are read and go to the device, layers that neighbours need too each time.
    pub voxel_bytes: u64,
    /// Bytes of the volume's voxels.
    pub volume_bytes: u64,
    /// Most bytes of buffers on the device at once.
    pub device_bytes: u64,
    /// Bytes that these may have: of a budget, what others have not taken.
    pub memory: u64,
}

/// How a lattice of a streamed view is drawn.
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
    /// Parts that are held one after the other.
    pub parts: usize,
    /// Most layers that are held at once, those around the part's own included.
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
        write!(f, "at most {} bytes on the device, of {}", self.device_bytes, self.memory)
    }
}

/// The parts of a lattice, in the order of the view.
pub(super) struct Parts {
    /// Layers that are composited together.
    pub ranges: Vec<Range<usize>>,
    /// Layers that they need, of which the most are held at once.
    pub held: usize,
    /// On the device.
    pub bytes: Bytes,
    /// Of voxels that are read.
    pub read: u64,
}

impl Parts {
    /// As few as there is room for, as even as they come.
    ///
    /// # Errors
    /// Not even a single layer fits; what it needs is told.
    pub fn new(device: &Device, lattice: &Lattice, settings: &Settings, needs: &Needs, room: Room) -> Result<Self, Error> {
        let (all, around) = (needs.layers(), PartRenderer::around(settings));
        let held = |layers: usize| (layers + 2 * around).min(all);
        let numbers: Vec<usize> = (1..=all).collect();
        let most = numbers.partition_point(|&layers| room.fits(needs.holding(held(layers))));
        if most == 0 {
            return Err(refused(device, "this view of the volume, a layer at a time,", needs.holding(held(1)), room));
        }
        let parts = if room.fits(needs.holding(all)) { 1 } else { all.div_ceil(most) };
        let mut ranges: Vec<_> = (0..parts).map(|n| n * all / parts..(n + 1) * all / parts).collect();
        if lattice.layer_step < 0 {
            ranges.reverse();
        }
        let lengths = || ranges.iter().map(|layers| PartRenderer::needed(layers, all, settings).len());
        let (held, sum) = (lengths().max().unwrap_or(all), lengths().sum::<usize>());
        Ok(Self { held, bytes: needs.holding(held), read: sum as u64 * needs.layer(), ranges })
    }
}

/// Why bytes have no room.
pub(super) fn refused(device: &Device, what: &str, bytes: Bytes, room: Room) -> Error {
    let what = what.to_owned();
    if bytes.sum > room.free() {
        return Error::MemoryBudget { what, needed: bytes.sum, taken: room.taken, budget: room.budget };
    }
    let (needed, available) = (bytes.largest, room.largest);
    Error::DeviceMemory { what, device: device.info().name.clone(), needed, available }
}
