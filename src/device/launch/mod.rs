//! One typed launcher per kernel. All `unsafe` calls of kernels are here: a launcher's types are its kernel's signature.

mod direct;
mod footprints;
mod lattice;
mod layout;
mod march;
pub(crate) mod params;
mod picture;
mod points;
mod sheets;
mod splats;
mod table;

pub(crate) use direct::{DirectArguments, DirectKernel, PointDirectArguments, PointDirectKernel};
pub(crate) use footprints::{FootprintSetKernel, FootprintsKernel};
pub(crate) use lattice::{LatticeArguments, LatticeKernel, PerspectiveArguments, PerspectiveKernel};
pub(crate) use layout::{Occupancy, OccupancyKernel, Reach, SlabVisibilityKernel, TransposeKernel, Visibility, VisibilityKernel};
pub(crate) use march::{MarchArguments, MarchKernel, MarchTable, PreintegratedTableArguments, PreintegratedTableKernel};
pub(crate) use picture::{PresentKernel, WarpArguments, WarpKernel};
pub(crate) use points::{PointLatticeArguments, PointLatticeKernel, Stretches};
pub(crate) use sheets::{AxisSheetsKernel, SheetArguments, ViewSheetsKernel};
pub(crate) use splats::{
    Pass, Place, ScanKernel, SortedSplatsArguments, SortedSplatsKernel, Splat, SplatsArguments, SplatsKernel,
    TiledSplatsArguments, TiledSplatsKernel,
};
pub(crate) use table::TableKernel;

use super::{Buffer, Device};
use crate::error::Error;
use crate::volume::{VoxelType, Voxels, for_voxels};
use opencl3::kernel::Kernel;

/// Something that can be an argument of a kernel.
trait Argument {
    fn set(&self, kernel: &Kernel, index: u32) -> opencl3::Result<()>;
}

macro_rules! by_value {
    ($($type:ty),*) => {$(
        impl Argument for $type {
            fn set(&self, kernel: &Kernel, index: u32) -> opencl3::Result<()> {
                // SAFETY: a plain value, of the type that the launcher's kernel declares at `index`.
                unsafe { kernel.set_arg(index, self) }
            }
        }
    )*};
}
by_value!(
    i32,
    f32,
    params::Float4,
    params::VolumeView,
    params::SampleParams,
    params::LatticeParams,
    params::RayLatticeParams,
    params::DirectParams,
    params::WarpParams,
    params::ScreenParams,
    params::MarchParams,
    params::SplatParams
);

impl<T: Copy> Argument for Buffer<T> {
    fn set(&self, kernel: &Kernel, index: u32) -> opencl3::Result<()> {
        // SAFETY: a live buffer of the type that the launcher's kernel declares at `index`.
        unsafe { kernel.set_arg(index, &self.handle()) }
    }
}

/// Sets all arguments of a kernel and starts it.
fn launch(
    device: &Device,
    stage: &'static str,
    kernel: &Kernel,
    items: usize,
    group: usize,
    arguments: &[&dyn Argument],
) -> Result<(), Error> {
    for (index, argument) in arguments.iter().enumerate() {
        argument.set(kernel, index as u32).map_err(|e| device.error("clSetKernelArg", e))?;
    }
    device.start(stage, kernel, items, group)
}

/// Voxels on the device, in any type. Kernels that read them are built for it.
pub(crate) struct VoxelBuffer {
    bytes: Buffer<u8>,
    voxel_type: VoxelType,
}

impl VoxelBuffer {
    /// An uninitialised buffer of `len` voxels.
    pub fn new(device: &Device, len: usize, voxel_type: VoxelType, what: &str) -> Result<Self, Error> {
        Ok(Self { bytes: Buffer::new(device, len * voxel_type.bytes(), what)?, voxel_type })
    }

    /// A copy of a volume's voxels.
    pub fn upload(device: &Device, voxels: &Voxels, what: &str) -> Result<Self, Error> {
        let bytes = for_voxels!(voxels, values => {
            // SAFETY: the values are plain numbers; the slice covers exactly their bytes.
            let bytes = unsafe { std::slice::from_raw_parts(values.as_ptr().cast::<u8>(), size_of_val(values.as_slice())) };
            Buffer::from_slice(device, bytes, what)?
        });
        Ok(Self { bytes, voxel_type: voxels.voxel_type() })
    }

    /// Their type.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }
}

impl Argument for VoxelBuffer {
    fn set(&self, kernel: &Kernel, index: u32) -> opencl3::Result<()> {
        self.bytes.set(kernel, index)
    }
}

/// `-D` options for kernels that draw tiles of screen pixels.
fn screen_defines(device: &Device) -> String {
    format!("-DTILE_ROWS={}", device.tuning().screen_tile_rows)
}

/// `-D` options for kernels that read voxels of a type, in vectors of `width`.
fn voxel_defines(voxel_type: VoxelType, width: u32) -> String {
    let (name, bytes, signed) = match voxel_type {
        VoxelType::Uint8 => ("uchar", 1, 0),
        VoxelType::Int8 => ("char", 1, 1),
        VoxelType::Uint16 => ("ushort", 2, 0),
        VoxelType::Int16 => ("short", 2, 1),
        VoxelType::Float32 | VoxelType::Float64 => ("float", 4, 1),
    };
    format!("-DVOXEL={name} -DVOXEL_BYTES={bytes} -DVOXEL_SIGNED={signed} -DVW={width}")
}
