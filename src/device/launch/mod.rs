//! One typed launcher per kernel. All `unsafe` calls of kernels are here: what a kernel's arguments are is declared once, by
//! `kernel!`, and compared with the kernel itself by the test below.

mod blocks;
mod fields;
pub(crate) mod layered;
pub(crate) mod picture;
pub(crate) mod rays;
pub(crate) mod sheets;
#[cfg(test)]
mod signatures;
pub(crate) mod structs;
pub(crate) mod volume;

use super::{Buffer, Device, DeviceMemory, Tuning};
use crate::error::Error;
use crate::layers::Kernel;
use crate::volume::{Held, VoxelType};
use opencl3::device::Device as ClDevice;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt::Write;
use std::hash::Hash;

/// What `kernel!` declares of a kernel.
pub(crate) trait Declared {
    /// Its file in kernels/.
    const FILE: &'static str;
    /// Its name in there.
    const NAME: &'static str;
    /// The stage of a frame that it counts for.
    const STAGE: &'static str;
    /// What it reads and writes.
    type Arguments<'a>: Arguments;
}

/// How a kernel is built and started.
pub(crate) trait Launch: Declared {
    /// What it is built for, besides the device.
    type Variant: Copy + Eq + Hash;
    /// Its work-items are tiles, or small.
    const ITEMS: Items;
    /// `-D` options.
    fn defines(tuning: &Tuning, variant: Self::Variant) -> String;
    /// How many work-items it takes.
    fn items(arguments: &Self::Arguments<'_>, tuning: &Tuning) -> usize;
}

/// What a work-item does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Items {
    /// A tile, or as much work.
    Tiles,
    /// A pixel, or as little.
    Pixels,
}

/// The arguments of a kernel, in its order.
pub(crate) trait Arguments {
    /// Sets all of them.
    fn set(&self, kernel: &ClKernel) -> opencl3::Result<()>;
    /// Their names and OpenCL types.
    #[cfg(test)]
    fn signature() -> Vec<(&'static str, String)>;
}

/// A kernel, built for each variant when that is first needed.
pub(crate) struct Launcher<K: Launch> {
    built: HashMap<K::Variant, Built>,
}

/// A kernel that is built.
struct Built {
    kernel: ClKernel,
    /// Work-items that a group of it can have: of the device's most, what its registers leave.
    largest_group: usize,
}

impl<K: Launch> Default for Launcher<K> {
    fn default() -> Self {
        Self { built: HashMap::new() }
    }
}

impl<K: Launch> Launcher<K> {
    /// Starts the kernel.
    pub fn launch(&mut self, device: &Device, variant: K::Variant, arguments: &K::Arguments<'_>) -> Result<(), Error> {
        let tuning = device.tuning();
        let built = match self.built.entry(variant) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => {
                let kernel = device.kernel(K::FILE, K::NAME, &K::defines(tuning, variant))?;
                place.insert(Built { largest_group: largest_group(device, &kernel)?, kernel })
            }
        };
        let kernel = &built.kernel;
        arguments.set(kernel).map_err(|e| device.error("clSetKernelArg", e))?;
        let group = match K::ITEMS {
            Items::Tiles => tuning.tile_group,
            Items::Pixels => tuning.pixel_group,
        };
        device.start(K::STAGE, kernel, K::items(arguments, tuning), group.min(built.largest_group))
    }
}

/// Work-items that a group of a kernel can have on a device.
fn largest_group(device: &Device, kernel: &ClKernel) -> Result<usize, Error> {
    let id = device.id();
    let of_kernel = kernel.get_work_group_size(id).map_err(|e| device.error("clGetKernelWorkGroupInfo", e))?;
    let of_axes = ClDevice::new(id).max_work_item_sizes().map_err(|e| device.error("clGetDeviceInfo", e))?;
    // Some say 0 of a kernel that they have not compiled yet; one work-item always goes.
    Ok(of_axes.first().map_or(of_kernel, |&along_x| of_kernel.min(along_x)).max(1))
}

/// `kernel!`: a kernel, its file, name and stage, and its arguments with their types, in its own order.
macro_rules! kernel {
    (
        $(#[$doc:meta])*
        $kernel:ident = $file:literal, $name:ident, $stage:literal;
        $arguments:ident<$lifetime:lifetime> { $($(#[$field_doc:meta])* $field:ident: $type:ty),* $(,)? }
    ) => {
        $(#[$doc])*
        pub(crate) struct $kernel;

        #[doc = concat!("What [`", stringify!($kernel), "`] reads and writes.")]
        pub(crate) struct $arguments<$lifetime> { $($(#[$field_doc])* pub $field: $type),* }

        impl $crate::device::launch::Declared for $kernel {
            const FILE: &'static str = $file;
            const NAME: &'static str = stringify!($name);
            const STAGE: &'static str = $stage;
            type Arguments<'a> = $arguments<'a>;
        }

        impl<$lifetime> $crate::device::launch::Arguments for $arguments<$lifetime> {
            fn set(&self, kernel: &opencl3::kernel::Kernel) -> opencl3::Result<()> {
                let arguments: &[&dyn $crate::device::launch::Argument] = &[$(&self.$field),*];
                (0..).zip(arguments).try_for_each(|(index, argument)| argument.set(kernel, index))
            }

            #[cfg(test)]
            fn signature() -> Vec<(&'static str, String)> {
                vec![$((stringify!($field), <$type as $crate::device::launch::Typed>::name())),*]
            }
        }
    };
}
use kernel;

/// Something that can be an argument of a kernel.
trait Argument {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()>;
}

/// The OpenCL type of an argument.
#[cfg_attr(not(test), expect(dead_code, reason = "signatures are compared in tests"))]
trait Typed {
    fn name() -> String;
}

/// A plain type with a name in OpenCL C.
pub(crate) trait ClType: Copy {
    /// The name.
    const NAME: &'static str;
}

macro_rules! cl_types {
    ($($type:ty = $name:literal),*) => {$(
        impl ClType for $type {
            const NAME: &'static str = $name;
        }
    )*};
}
cl_types!(
    i32 = "int",
    u32 = "uint",
    i64 = "long",
    u64 = "ulong",
    f32 = "float",
    u8 = "uchar",
    [f32; 2] = "float2",
    structs::Float4 = "float4",
    [i32; 4] = "int4",
    [u8; 4] = "uchar4",
    [u16; 4] = "ushort4"
);

impl<T: ClType> Argument for T {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        // SAFETY: a plain value, of the type that the kernel declares at `index`.
        unsafe { kernel.set_arg(index, self) }
    }
}

impl<T: ClType> Typed for T {
    fn name() -> String {
        T::NAME.into()
    }
}

impl<T: ClType> Argument for &Buffer<T> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        // SAFETY: a live buffer of the type that the kernel declares at `index`.
        unsafe { kernel.set_arg(index, &self.handle()) }
    }
}

impl<T: ClType> Typed for &Buffer<T> {
    fn name() -> String {
        format!("{}*", T::NAME)
    }
}

/// Voxels on the device, in any type. Kernels that read them are built for it.
pub(crate) struct VoxelBuffer {
    bytes: Buffer<u8>,
    voxel_type: VoxelType,
    /// Nobody has looked at the voxels: floats may be anything.
    unchecked: bool,
}

impl VoxelBuffer {
    /// An uninitialised buffer of `len` voxels.
    pub fn new(device: &Device, len: usize, voxel_type: VoxelType, what: &str) -> Result<Self, Error> {
        Ok(Self { bytes: Buffer::new(device, len * voxel_type.bytes(), what)?, voxel_type, unchecked: false })
    }

    /// Uninitialised voxels as many and as `others` of another layout are.
    pub fn like(device: &Device, len: usize, others: &VoxelBuffer, what: &str) -> Result<Self, Error> {
        Ok(Self { unchecked: others.unchecked, ..Self::new(device, len, others.voxel_type, what)? })
    }

    /// All that a buffer of the caller's own holds.
    pub fn of_memory(device: &Device, memory: &DeviceMemory, bytes: usize, voxel_type: VoxelType) -> Result<Self, Error> {
        let bytes = Buffer::of_memory(device, memory, bytes)?;
        Ok(Self { bytes, voxel_type, unchecked: voxel_type == VoxelType::Float32 })
    }

    /// A copy of voxels, the background in place of invalid ones.
    pub fn upload(device: &Device, held: &Held) -> Result<Self, Error> {
        Self::upload_with_room(device, held, held.dims().iter().product())
    }

    /// The same with room for so many voxels.
    pub fn upload_with_room(device: &Device, held: &Held, room: usize) -> Result<Self, Error> {
        let description = held.description;
        let mut voxels = Self::new(device, room, description.voxel_type(), description.name())?;
        voxels.refill(device, held)?;
        Ok(voxels)
    }

    /// Copies other voxels into this buffer, no more than there is room for.
    pub fn refill(&mut self, device: &Device, held: &Held) -> Result<(), Error> {
        held.for_each_piece(|first, bytes| self.bytes.write_at(device, first, bytes))
    }

    /// Layers of bytes, `stride` bytes apart.
    #[cfg(test)]
    pub fn with_gaps<'a>(device: &Device, layers: impl ExactSizeIterator<Item = &'a [u8]>, stride: usize) -> Result<Self, Error> {
        let mut voxels = Self::new(device, layers.len() * stride, VoxelType::Uint8, "a volume with gaps")?;
        layers.enumerate().try_for_each(|(n, layer)| voxels.bytes.write_at(device, n * stride, layer))?;
        Ok(voxels)
    }

    /// Their type.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// How many bytes they take.
    pub fn bytes(&self) -> usize {
        self.bytes.bytes()
    }

    /// What kernels that read them are built for.
    pub fn kind(&self) -> VoxelKind {
        VoxelKind { voxel_type: self.voxel_type, far: is_far(self.bytes()), unchecked: self.unchecked }
    }
}

/// Voxels of floats, for kernels that take nothing else.
pub(crate) struct Floats<'a>(pub &'a VoxelBuffer);

impl Argument for Floats<'_> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        debug_assert_eq!(self.0.voxel_type(), VoxelType::Float32);
        self.0.set(kernel, index)
    }
}

impl Typed for Floats<'_> {
    fn name() -> String {
        "float*".into()
    }
}

/// What kernels that read voxels are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct VoxelKind {
    pub voxel_type: VoxelType,
    /// Two voxels can lie farther apart than an int counts in bytes.
    pub far: bool,
    /// Floats may be anything.
    pub unchecked: bool,
}

/// Whether voxels of so many bytes are far apart. A row of four is read at once.
fn is_far(bytes: usize) -> bool {
    bytes > i32::MAX as usize - 64
}

impl Argument for &VoxelBuffer {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        (&self.bytes).set(kernel, index)
    }
}

impl Typed for &VoxelBuffer {
    fn name() -> String {
        "VOXEL*".into()
    }
}

/// `-D` options.
struct Defines(String);

impl Defines {
    /// Of kernels that compute in vectors of `width`.
    fn new(width: u32) -> Self {
        Self(format!("-DVW={width}"))
    }

    /// Of those that read voxels of a type, too.
    fn of_voxels(voxel_type: VoxelType, width: u32) -> Self {
        let (name, signed) = match voxel_type {
            VoxelType::Uint8 => ("uchar", 0),
            VoxelType::Int8 => ("char", 1),
            VoxelType::Uint16 => ("ushort", 0),
            VoxelType::Int16 => ("short", 1),
            VoxelType::Float32 => ("float", 1),
        };
        Self::new(width).with("VOXEL", name).with("VOXEL_BYTES", voxel_type.bytes()).with("VOXEL_SIGNED", signed)
    }

    /// Of those that take their values, too.
    fn of_values(voxels: VoxelKind, width: u32) -> Self {
        Self::of_voxels(voxels.voxel_type, width).with_if(voxels.unchecked, "UNCHECKED")
    }

    /// Of those that sample between them, too.
    fn of_kind(voxels: VoxelKind, width: u32) -> Self {
        Self::of_values(voxels, width).with_if(voxels.far, "FAR_VOXELS")
    }

    fn with(mut self, name: &str, value: impl std::fmt::Display) -> Self {
        write!(self.0, " -D{name}={value}").expect("strings take anything");
        self
    }

    fn with_if(mut self, on: bool, name: &str) -> Self {
        if on {
            write!(self.0, " -D{name}").expect("strings take anything");
        }
        self
    }
}

/// How rays end, and whether they are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rendering {
    pub blend: BlendMode,
    /// Rays are cut to their intervals: something that shows lies beyond these.
    pub clipped: bool,
}

/// The accumulators of kernels/shared/accumulator.cl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BlendMode {
    Composite,
    Maximum,
    Minimum,
    Average,
    /// `refined` on the field itself.
    Iso {
        refined: bool,
    },
}

impl Defines {
    fn with_rendering(self, rendering: Rendering) -> Self {
        let (name, gathers_values) = match rendering.blend {
            BlendMode::Composite => ("COMPOSITE", false),
            BlendMode::Maximum => ("MAXIMUM", true),
            BlendMode::Minimum => ("MINIMUM", true),
            BlendMode::Average => ("AVERAGE", true),
            BlendMode::Iso { .. } => ("ISO", false),
        };
        self.with("BLEND", name)
            .with_if(rendering.clipped, "CLIPPED")
            .with_if(gathers_values, "EDGE_GOES_ON")
            .with_if(rendering.blend == BlendMode::Iso { refined: true }, "REFINED")
    }
}

impl Defines {
    /// Of programs that reconstruct the field.
    fn with_kernel(self, kernel: Kernel) -> Self {
        let name = match kernel {
            Kernel::Linear => "LINEAR",
            Kernel::Cubic => "CUBIC",
            Kernel::CatmullRom => "CATMULL_ROM",
            Kernel::BSpline => "BSPLINE",
            Kernel::Gaussian => "GAUSSIAN",
        };
        self.with("KERNEL", name).with_if(kernel == Kernel::BSpline, "MIRRORED")
    }
}

/// Tiles of a grid of them.
fn tiles(counts: [i32; 2]) -> usize {
    counts.iter().map(|&n| n as usize).product()
}
