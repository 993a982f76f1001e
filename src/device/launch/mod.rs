//! One typed launcher per kernel. All `unsafe` calls of kernels are here: what a kernel's arguments are is declared once, by
//! `kernel!`, and compared with the kernel itself by the test below.

mod blocks;
mod defines;
mod fields;
pub(crate) mod layered;
pub(crate) mod picture;
pub(crate) mod rays;
mod request;
pub(crate) mod sheets;
#[cfg(test)]
mod signatures;
pub(crate) mod structs;
pub(crate) mod volume;
mod voxel_buffer;

use defines::Defines;
pub(crate) use defines::{BlendMode, Rendering};
pub(crate) use request::KernelRequest;
pub(crate) use voxel_buffer::{Floats, VoxelBuffer, VoxelKind};

use super::{Buffer, Device, Tuning};
use crate::error::Error;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
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
    /// What draws the same with the same arguments, up to rounding, and much else: where there is such a program.
    fn general(_: Self::Variant) -> Option<Self::Variant> {
        None
    }
}

/// What a work-item does.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Items {
    /// A tile, or as much work.
    Tiles,
    /// A pixel, or as little.
    Pixels,
    /// A sample of a lattice; a group takes a tile of them.
    Samples,
    /// A run of a list; one group takes all of it.
    Runs,
}

impl<K: Launch> Launcher<K> {
    /// The variant, or a more general one that is built while it is not, where the frame may use that.
    fn available(&mut self, device: &Device, variant: K::Variant, items: usize) -> K::Variant {
        let general = K::general(variant).filter(|general| *general != variant && device.may_use_general_programs());
        let Some(general) = general.filter(|_| !self.built.contains_key(&variant)) else { return variant };
        let request = |variant| KernelRequest::new::<K>(device.tuning(), variant, items);
        let best = request(variant);
        if device.is_ready(&best) || !(self.built.contains_key(&general) || device.is_ready(&request(general))) {
            return variant;
        }
        device.use_general_program(best, self.requested.insert(variant));
        general
    }
}

impl Items {
    /// Work-items of a group, where the kernel leaves as many.
    fn group(self, tuning: &Tuning) -> usize {
        match self {
            Items::Tiles => tuning.tile_group,
            Items::Pixels => tuning.pixel_group,
            Items::Samples => tuning.sample_group(),
            Items::Runs => tuning.scan_group,
        }
    }
}

/// The arguments of a kernel, in its order.
pub(crate) trait Arguments {
    /// Sets all of them.
    fn set(&self, kernel: &ClKernel) -> opencl3::Result<()>;
    /// The bytes of each value, and 0 of each buffer.
    fn sizes() -> Vec<usize>;
    /// Their names and OpenCL types.
    #[cfg(test)]
    fn signature() -> Vec<(&'static str, String)>;
}

/// A kernel, built for each variant when that is first needed.
pub(crate) struct Launcher<K: Launch> {
    built: HashMap<K::Variant, Built>,
    /// Variants that are being built in the background.
    requested: HashSet<K::Variant>,
}

/// A kernel that is built.
struct Built {
    kernel: ClKernel,
    /// Work-items that a group of it can have: of the device's most, what its registers leave.
    largest_group: usize,
}

impl<K: Launch> Default for Launcher<K> {
    fn default() -> Self {
        Self { built: HashMap::new(), requested: HashSet::new() }
    }
}

impl<K: Launch> Launcher<K> {
    /// Starts the kernel.
    pub fn launch(&mut self, device: &Device, variant: K::Variant, arguments: &K::Arguments<'_>) -> Result<(), Error> {
        let tuning = device.tuning();
        let (group, items) = (K::ITEMS.group(tuning), K::items(arguments, tuning));
        if let Some(rehearsal) = device.rehearsal() {
            let request = |variant| KernelRequest::new::<K>(tuning, variant, items);
            let general = K::general(variant).filter(|_| device.may_use_general_programs());
            rehearsal.add(request(variant), general.map(request));
            return Ok(());
        }
        let variant = self.available(device, variant, items);
        let built = match self.built.entry(variant) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => {
                let defines = K::defines(tuning, variant);
                let kernel = device.kernel(K::FILE, K::NAME, &defines)?;
                #[cfg(test)]
                device.note_started((K::FILE, K::NAME), &defines, group);
                place.insert(Built { largest_group: device.shared.programs.largest_group(&kernel)?, kernel })
            }
        };
        let kernel = &built.kernel;
        arguments.set(kernel).map_err(|e| device.error("clSetKernelArg", e))?;
        device.start(K::STAGE, kernel, items, group.min(built.largest_group))
    }
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

            fn sizes() -> Vec<usize> {
                vec![$(<$type as $crate::device::launch::Typed>::BYTES),*]
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
trait Typed {
    /// Size of a value; 0 of buffers, which every device has handles of its own for.
    const BYTES: usize;

    #[cfg_attr(not(test), expect(dead_code, reason = "signatures are compared in tests"))]
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
    const BYTES: usize = size_of::<T>();

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
    const BYTES: usize = 0;

    fn name() -> String {
        format!("{}*", T::NAME)
    }
}

/// No fewer work-items than PoCL needs to build a kernel for many: for fewer than 65,536 it builds the same kernel again, so that the device's
/// check would run another one than large volumes and pictures do. Those beyond `items` end at once.
fn many(items: usize) -> usize {
    items.max(1 << 16)
}

/// Tiles of a grid of them.
fn tiles(counts: [i32; 2]) -> usize {
    counts.iter().map(|&n| n as usize).product()
}
