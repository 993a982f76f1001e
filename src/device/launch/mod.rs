//! One typed launcher per kernel. All `unsafe` kernel calls are here. `kernel!` declares the arguments of each kernel once; tests
//! compare these declarations with the kernels themselves (`signatures.rs`).

mod blocks;
pub(crate) mod colors;
mod defines;
mod fields;
pub(crate) mod layered;
pub(crate) mod light;
pub(crate) mod picture;
pub(crate) mod rays;
mod request;
pub(crate) mod sheets;
#[cfg(test)]
mod signatures;
pub(crate) mod slice;
pub(crate) mod structs;
pub(crate) mod tinted;
pub(crate) mod volume;
mod voxel_buffer;

use defines::Defines;
pub(crate) use defines::{BlendMode, Gradients, Rendering};
pub(crate) use request::KernelRequest;
pub(crate) use voxel_buffer::{Floats, VoxelBuffer, VoxelKind};

use super::bands::{self, BandSize};
use super::{Buffer, Device, Tuning, build_log};
use crate::error::Error;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::time::Instant;

/// A kernel as declared by `kernel!`.
pub(crate) trait Declared {
    /// File in kernels/.
    const FILE: &'static str;
    /// Name of the kernel function.
    const NAME: &'static str;
    /// Stage of the frame in time measurements.
    const STAGE: &'static str;
    /// Kernel arguments.
    type Arguments<'a>: Arguments;
}

/// How a kernel is built and launched.
pub(crate) trait Launch: Declared {
    /// Key of the program permutation, besides the device's tuning.
    type Variant: Copy + Eq + Hash;
    /// Work of one work-item.
    const ITEMS: Items;
    /// `-D` options of a variant.
    fn defines(tuning: &Tuning, variant: Self::Variant) -> String;
    /// Number of work-items of a launch.
    fn items(arguments: &Self::Arguments<'_>, tuning: &Tuning) -> usize;
    /// A more general variant, if any. With the same arguments, its results are equal up to rounding.
    fn general(_: Self::Variant) -> Option<Self::Variant> {
        None
    }
}

/// Work of one work-item.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Items {
    /// A tile, or similar work.
    Tiles,
    /// A pixel, or similar work.
    Pixels,
    /// A lattice sample; a work-group computes one tile.
    Samples,
    /// A ray; a work-group of this size computes one tile.
    Rays(usize),
    /// A contiguous part of a list; one work-group processes the whole list.
    Runs,
}

impl<K: Launch> Launcher<K> {
    /// The variant, or a more general one if only that is built and the frame may use it.
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
    /// Work-group size, unless the kernel allows less.
    fn group(self, tuning: &Tuning) -> usize {
        match self {
            Items::Tiles => tuning.tile_group,
            Items::Pixels => tuning.pixel_group,
            Items::Samples => tuning.sample_group(),
            Items::Rays(group) => group,
            Items::Runs => tuning.scan_group,
        }
    }
}

/// The arguments of a kernel, in order. Every kernel has one more at the end, `ulong first_item`: the work-items of a launch count from it, so
/// that a launch can be divided into bands.
pub(crate) trait Arguments {
    /// Index of the last argument.
    const FIRST_ITEM: u32;
    /// Sets all arguments but the last.
    fn set_own(&self, kernel: &ClKernel) -> opencl3::Result<()>;
    /// Size of each argument but the last in bytes; 0 for buffers.
    fn own_sizes() -> Vec<usize>;
    /// Names and OpenCL types of all arguments but the last.
    #[cfg(test)]
    fn own_signature() -> Vec<(String, String)>;

    /// Sets all arguments, the last one to 0.
    fn set(&self, kernel: &ClKernel) -> opencl3::Result<()> {
        self.set_own(kernel)?;
        Argument::set(&0u64, kernel, Self::FIRST_ITEM)
    }

    /// Size of each argument in bytes; 0 for buffers.
    fn sizes() -> Vec<usize> {
        [Self::own_sizes(), vec![size_of::<u64>()]].concat()
    }

    /// Names and OpenCL types.
    #[cfg(test)]
    fn signature() -> Vec<(String, String)> {
        Self::own_signature().into_iter().chain([("first_item".into(), "ulong".into())]).collect()
    }
}

/// A kernel whose variants are built on first use.
pub(crate) struct Launcher<K: Launch> {
    built: HashMap<K::Variant, Built>,
    /// Variants requested in the background.
    requested: HashSet<K::Variant>,
}

/// A built kernel.
struct Built {
    kernel: ClKernel,
    /// Maximum work-group size: the device limit, reduced by the kernel's register use.
    largest_group: usize,
    band: BandSize,
}

impl<K: Launch> Default for Launcher<K> {
    fn default() -> Self {
        Self { built: HashMap::new(), requested: HashSet::new() }
    }
}

impl<K: Launch> Launcher<K> {
    /// Launches the kernel, and builds the variant if necessary.
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
        let begun = Instant::now();
        let is_new = !self.built.contains_key(&variant);
        let built = match self.built.entry(variant) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(entry) => {
                let defines = K::defines(tuning, variant);
                let kernel = device.kernel(K::FILE, K::NAME, &defines)?;
                #[cfg(test)]
                device.record_started((K::FILE, K::NAME), &defines, group);
                let largest_group = device.shared.programs.largest_group(&kernel)?;
                entry.insert(Built { largest_group, kernel, band: BandSize::default() })
            }
        };
        let Built { kernel, band, largest_group } = built;
        let group = group.min(*largest_group);
        arguments.set(kernel).map_err(|e| device.error("clSetKernelArg", e))?;
        if !device.has_bands() || K::ITEMS == Items::Runs {
            device.start(K::STAGE, kernel, items, group)?;
            if is_new {
                build_log::record(K::NAME, &K::defines(tuning, variant), group, begun.elapsed());
            }
            return Ok(());
        }
        // PoCL compiles small launches separately. Those of pixels are large elsewhere, so their bands are, too.
        let is_wide = K::ITEMS == Items::Pixels && items > KernelRequest::SMALL_GRID;
        let least = if is_wide { KernelRequest::SMALL_GRID + 1 } else { 1 };
        let items = bands::Items { all: items, group, least };
        device.start_in_bands(K::STAGE, kernel, items, band, |first| first.set(kernel, K::Arguments::FIRST_ITEM))
    }
}

/// `kernel!`: declares a kernel with its file, name, stage and typed arguments in order.
macro_rules! kernel {
    (
        $(#[$doc:meta])*
        $kernel:ident = $file:literal, $name:ident, $stage:literal;
        $arguments:ident<$lifetime:lifetime> { $($(#[$field_doc:meta])* $field:ident: $type:ty),* $(,)? }
    ) => {
        $(#[$doc])*
        pub(crate) struct $kernel;

        #[doc = concat!("Arguments of [`", stringify!($kernel), "`].")]
        pub(crate) struct $arguments<$lifetime> { $($(#[$field_doc])* pub $field: $type),* }

        impl $crate::device::launch::Declared for $kernel {
            const FILE: &'static str = $file;
            const NAME: &'static str = stringify!($name);
            const STAGE: &'static str = $stage;
            type Arguments<'a> = $arguments<'a>;
        }

        impl<$lifetime> $crate::device::launch::Arguments for $arguments<$lifetime> {
            const FIRST_ITEM: u32 = 0 $(+ <$type as $crate::device::launch::Typed>::COUNT)*;

            fn set_own(&self, kernel: &opencl3::kernel::Kernel) -> opencl3::Result<()> {
                let mut index = 0;
                $(
                    $crate::device::launch::Argument::set(&self.$field, kernel, index)?;
                    index += <$type as $crate::device::launch::Typed>::COUNT;
                )*
                debug_assert_eq!(index, Self::FIRST_ITEM);
                Ok(())
            }

            fn own_sizes() -> Vec<usize> {
                let sizes = [$((<$type as $crate::device::launch::Typed>::BYTES, <$type as $crate::device::launch::Typed>::COUNT)),*];
                sizes.into_iter().flat_map(|(bytes, count)| std::iter::repeat_n(bytes, count as usize)).collect()
            }

            #[cfg(test)]
            fn own_signature() -> Vec<(String, String)> {
                let mut signature = Vec::new();
                $(
                    let (name, kind) = (stringify!($field), <$type as $crate::device::launch::Typed>::name());
                    match <$type as $crate::device::launch::Typed>::COUNT {
                        1 => signature.push((name.into(), kind)),
                        count => signature.extend((0..count).map(|i| (format!("{name}_{i}"), kind.clone()))),
                    }
                )*
                signature
            }
        }
    };
}
use kernel;

/// A type that can be passed as a kernel argument.
pub(crate) trait Argument {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()>;
}

/// The OpenCL type of a kernel argument.
trait Typed {
    /// Size in bytes; 0 for buffers, whose handles differ between devices.
    const BYTES: usize;
    /// Number of arguments of the kernel.
    const COUNT: u32 = 1;

    #[cfg_attr(not(test), allow(dead_code, reason = "signatures are compared in tests"))]
    fn name() -> String;
}

/// A plain type that OpenCL C has, too.
pub(crate) trait ClType: Copy {
    /// Name in OpenCL C.
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
    u16 = "ushort",
    [f32; 2] = "float2",
    structs::Float4 = "float4",
    [i32; 4] = "int4",
    [u8; 4] = "uchar4",
    [u16; 4] = "ushort4"
);

impl<T: ClType> Argument for T {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        // SAFETY: a plain value of the type that the kernel declares at `index`.
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

/// One argument of each channel; the kernel numbers them `name_0`, `name_1` … Those beyond the channels of a scene are not read.
#[derive(Clone, Copy)]
pub(crate) struct PerChannel<T>(pub [T; MAX_CHANNELS]);

/// Most fields that a scene draws together: MAX_CHANNELS of kernels/shared/channel.cl.
pub(crate) const MAX_CHANNELS: usize = 8;

impl<T: Copy> PerChannel<T> {
    /// The arguments of 1 to [`MAX_CHANNELS`] channels.
    pub fn new(channels: &[T]) -> Self {
        Self(std::array::from_fn(|i| *channels.get(i).unwrap_or(&channels[0])))
    }
}

impl<T: Argument> Argument for PerChannel<T> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<()> {
        (index..).zip(&self.0).try_for_each(|(index, argument)| argument.set(kernel, index))
    }
}

impl<T: Typed> Typed for PerChannel<T> {
    const BYTES: usize = T::BYTES;
    const COUNT: u32 = MAX_CHANNELS as u32;

    fn name() -> String {
        T::name()
    }
}

/// Rounds a number of work-items up to 65,536, since PoCL builds a separate kernel for smaller launches. The device check thus
/// runs the same kernel as large volumes and pictures. Excess work-items return at once.
fn large_grid(items: usize) -> usize {
    items.max(1 << 16)
}

/// Number of tiles in a grid.
fn tiles(counts: [i32; 2]) -> usize {
    counts.iter().map(|&n| n as usize).product()
}
