//! Voxels that are on a device.

use super::prepared::Placement;
use crate::device::Device;
use crate::device::launch::VoxelBuffer;
use crate::error::Error;
use crate::volume::{Description, Held, Volume, VolumePart};
use std::sync::Arc;

/// The voxels of a volume, or of a part of one, on a device: uploaded, or where the caller has them
/// ([`in_place`](Self::in_place)). Cheap to clone: clones, and all renderers that are made from it, share them.
///
/// ```
/// use layersplat::renderer::UploadedVolume;
/// use layersplat::Renderer;
/// # let volume = layersplat::Volume::open("builtin:hydrogen@16", &layersplat::OpenOptions::default())?;
/// # let transfer = layersplat::TransferFunction::automatic(&volume);
/// # let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
/// # let viewport = layersplat::Viewport::new(32, 24)?;
/// # let orbit = layersplat::Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
/// # let camera = layersplat::Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, orbit);
///
/// // Two transfer functions for voxels that are on the device once.
/// let uploaded = UploadedVolume::new(&device, &volume)?;
/// let renderers = [Renderer::of(&uploaded, &transfer)?, Renderer::of(&uploaded, &transfer.faded(0.5)?)?];
/// assert_eq!(renderers[0].grid(), renderers[1].grid());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone)]
pub struct UploadedVolume {
    pub(super) device: Device,
    pub(super) description: Description,
    /// The lowest voxel that is held, and how many are, along x, y, z.
    pub(super) first: [usize; 3],
    pub(super) dims: [usize; 3],
    pub(super) voxels: Arc<VoxelBuffer>,
    pub(super) placed: Placement,
    /// Voxels may leave the range of the description.
    pub(super) promised: bool,
}

impl UploadedVolume {
    /// Uploads a volume.
    pub fn new(device: &Device, volume: &Volume) -> Result<Self, Error> {
        Self::holding(device, &volume.held())
    }

    /// Uploads a part of a volume, for [`PartRenderer::of`](super::PartRenderer::of).
    pub fn part(device: &Device, part: &VolumePart) -> Result<Self, Error> {
        Self::holding(device, &part.held())
    }

    /// The same in a buffer with room for so many voxels: parts to come.
    pub(super) fn part_with_room(device: &Device, part: &VolumePart, room: usize) -> Result<Self, Error> {
        let held = &part.held();
        Self::of(device, held, VoxelBuffer::upload_with_room(device, held, room)?)
    }

    fn holding(device: &Device, held: &Held) -> Result<Self, Error> {
        Self::of(device, held, VoxelBuffer::upload(device, held)?)
    }

    fn of(device: &Device, held: &Held, voxels: VoxelBuffer) -> Result<Self, Error> {
        let (first, dims) = (held.first, held.dims());
        let (device, description) = (device.clone(), held.description.clone());
        Ok(Self { device, description, first, dims, voxels: Arc::new(voxels), placed: Placement::dense(dims), promised: false })
    }

    /// What is known of the whole volume.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Whether all voxels are held.
    pub fn is_whole(&self) -> bool {
        self.dims == self.description.grid().dims()
    }
}
