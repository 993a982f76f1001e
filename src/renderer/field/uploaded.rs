//! Voxels on a device, shared by renderers.

use super::super::check_whole;
use super::{Field, FieldKernels, Placement};
use crate::device::Device;
use crate::device::launch::VoxelBuffer;
use crate::error::Error;
use crate::volume::{Description, Grid, Held, Volume, VolumePart, VoxelBox};
use glam::DAffine3;

/// The voxels of a volume, or of a part of one, on a device: uploaded, or in the caller's memory ([`in_place`](Self::in_place)).
/// Cheap to clone. Clones and all renderers created from it share the voxels and the data derived from them alone: the layout of
/// layer axis x, the B-spline coefficients, the min-max blocks.
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
/// let renderers = [Renderer::from_uploaded(&uploaded, &transfer)?, Renderer::from_uploaded(&uploaded, &transfer.faded(0.5)?)?];
/// assert_eq!(renderers[0].grid(), renderers[1].grid());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone)]
pub struct UploadedVolume {
    pub(in crate::renderer) device: Device,
    pub(in crate::renderer) field: Field,
}

impl UploadedVolume {
    /// Uploads a volume.
    pub fn new(device: &Device, volume: &Volume) -> Result<Self, Error> {
        let held = &volume.held();
        let voxels = held.dims().iter().product();
        // Unpacked voxels may already take most of a CPU device's memory.
        device.require(volume.name(), voxels as u64 * volume.voxel_type().bytes() as u64, 0)?;
        Self::with_capacity(device, held, voxels)
    }

    /// Uploads a part of a volume, for [`PartRenderer::from_uploaded`](crate::renderer::PartRenderer::from_uploaded).
    pub fn part(device: &Device, part: &VolumePart) -> Result<Self, Error> {
        let held = &part.held();
        Self::with_capacity(device, held, held.dims().iter().product())
    }

    /// Uploads into a buffer with a capacity of this many voxels, for later parts.
    pub(in crate::renderer) fn with_capacity(device: &Device, held: &Held, capacity: usize) -> Result<Self, Error> {
        let voxels = VoxelBuffer::upload_with_capacity(device, held, capacity)?;
        let held_box = VoxelBox { first: held.first, dims: held.dims() };
        let field = Field::new(held.description, held_box, voxels, Placement::dense(held_box.dims), false);
        Ok(Self { device: device.clone(), field })
    }

    /// The same voxels elsewhere in the world, also on sheared axes: (i, j, k) lies at `index_to_world · (i, j, k)`. They are resampled as
    /// floats (Catmull-Rom) onto the grid at right angles that [covers](Grid::covering) them. Its corners beyond the voxels hold the
    /// [background](Description::background), so where that is visible, set one that the transfer function hides. Opacities are per
    /// smallest distance of adjacent voxels. A transform without shear needs no resampling: see
    /// [`Volume::with_grid`](crate::Volume::with_grid).
    ///
    /// Costs one pass over the new voxels, of which there are more than before by one at each side and with the shear, each of four
    /// bytes. Smooth fields change little; details of about a voxel become weaker.
    ///
    /// # Errors
    /// Those of [`Grid::covering`]; if this is a part of a volume; and if the new voxels do not fit into a buffer of the device.
    pub fn with_placement(&self, index_to_world: DAffine3) -> Result<Self, Error> {
        check_whole(self)?;
        let own = self.description().grid();
        let grid = Grid::covering(own.dims(), index_to_world)?;
        let grid = if own.has_anatomy() { grid.with_anatomy() } else { grid };
        let device = self.device.with_own_sequence();
        device.begin(&[])?;
        let field = self.field.resampled(&mut FieldKernels::default(), &device, index_to_world, &grid, false)?;
        // Renderers have sequences of their own, which do not wait for this one.
        device.finish()?;
        Ok(Self { device: self.device.clone(), field })
    }

    /// Description of the whole volume.
    pub fn description(&self) -> &Description {
        self.field.description()
    }

    /// Whether all voxels are on the device.
    pub fn is_whole(&self) -> bool {
        self.field.held().dims == self.description().grid().dims()
    }
}
