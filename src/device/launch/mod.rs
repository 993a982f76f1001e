//! One typed launcher per kernel. All `unsafe` kernel calls are here. `kernel!` declares each kernel and its arguments once; builds with debug
//! assertions compare these declarations with the kernels themselves (`signatures.rs`).

mod arguments;
mod blocks;
mod cl_type;
pub(crate) mod colors;
mod defines;
mod groups;
mod kernel_struct;
pub(crate) mod layered;
pub(crate) mod light;
#[cfg(feature = "paper")]
pub(crate) mod paper;
pub(crate) mod picture;
pub(crate) mod rays;
mod request;
pub(crate) mod scatter;
#[cfg(debug_assertions)]
mod signatures;
pub(crate) mod slice;
pub(crate) mod structs;
pub(crate) mod surfaces;
pub(crate) mod volume;
mod voxel_buffer;

pub(crate) use arguments::{Argument, Extras, MAX_CHANNELS, PerChannel};
use arguments::{Optional, Parameter, arguments};
use defines::Defines;
pub(crate) use defines::{BlendMode, Gradients, Rendering};
pub(crate) use groups::{ChannelColors, ChannelFields, Cuts, LightBuffers, Output, ShadedField, Tint};
pub(crate) use request::KernelRequest;
pub(crate) use voxel_buffer::{Floats, VoxelBuffer, VoxelKind};

use super::bands::{self, BandSize};
use super::{Device, Tuning, build_log};
use crate::error::Error;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::time::Instant;

/// A kernel, and how it is built and launched: declared by `kernel!`.
pub(crate) trait Launch {
    /// File in kernels/.
    const FILE: &'static str;
    /// Name of the kernel function.
    const NAME: &'static str;
    /// Stage of the frame in time measurements.
    const STAGE: &'static str;
    /// Work of one work-item.
    const ITEMS: Items;
    /// Kernel arguments. Every kernel has one more at the end, `ulong first_item`: the work-items of a launch count from it, so that a
    /// launch can be divided into bands.
    type Arguments<'a>: Argument;
    /// Key of the program permutation, besides the device's tuning and the optional arguments.
    type Variant: Copy + Eq + Hash;

    /// `-D` options of a variant, without those of optional arguments.
    fn defines(tuning: &Tuning, variant: Self::Variant) -> Defines;
    /// Number of work-items of a launch.
    fn items(arguments: &Self::Arguments<'_>, tuning: &Tuning) -> usize;
    /// A more general variant, if any. With the same arguments, its results are equal up to rounding.
    fn general(_: Self::Variant) -> Option<Self::Variant> {
        None
    }
}

/// A variant of a kernel, and its optional arguments.
type Permutation<K> = (<K as Launch>::Variant, Extras);

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

/// A kernel whose variants are built on first use.
pub(crate) struct Launcher<K: Launch> {
    built: HashMap<Permutation<K>, Built>,
    /// Variants requested in the background.
    requested: HashSet<Permutation<K>>,
}

/// A built kernel.
struct Built {
    kernel: ClKernel,
    /// Maximum work-group size: the device limit, reduced by the kernel's register use.
    largest_group: usize,
    band: BandSize,
    /// When its build began, until its first launch is logged.
    begun: Option<Instant>,
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
        let best = (variant, arguments.extras());
        if let Some(rehearsal) = device.rehearsal() {
            let request = |permutation| KernelRequest::new::<K>(tuning, permutation, items);
            let general = Self::general(best).filter(|_| device.may_use_general_programs());
            rehearsal.add(request(best), general.map(request));
            return Ok(());
        }
        let permutation = self.available(device, best, items);
        let built = match self.built.entry(permutation) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(entry) => {
                let begun = Some(Instant::now());
                let defines = Self::defines(tuning, permutation);
                let kernel = device.kernel(K::FILE, K::NAME, &defines)?;
                #[cfg(debug_assertions)]
                signatures::compare::<K>(&kernel, permutation.1, &defines);
                #[cfg(test)]
                device.record_started((K::FILE, K::NAME), &defines, group);
                #[cfg(test)]
                device.launch_without_work(&KernelRequest::new::<K>(tuning, permutation, items))?;
                let largest_group = device.shared.programs.largest_group(&kernel)?;
                entry.insert(Built { begun, largest_group, kernel, band: BandSize::default() })
            }
        };
        let Built { begun, kernel, band, largest_group } = built;
        let group = group.min(*largest_group);
        let set = arguments.set(kernel, 0).and_then(|first_item| 0u64.set(kernel, first_item).map(|_| first_item));
        let first_item = set.map_err(|e| device.error("clSetKernelArg", e))?;
        if !device.has_bands() || K::ITEMS == Items::Runs {
            device.start(K::STAGE, kernel, items, group)?;
            if let Some(begun) = begun.take() {
                build_log::record(K::NAME, &Self::defines(tuning, permutation), group, begun.elapsed());
            }
            return Ok(());
        }
        // PoCL compiles small launches separately. Those of pixels are large elsewhere, so their bands are, too.
        let is_wide = K::ITEMS == Items::Pixels && items > KernelRequest::SMALL_GRID;
        let least = if is_wide { KernelRequest::SMALL_GRID + 1 } else { 1 };
        let items = bands::Items { all: items, group, least };
        device.start_in_bands(K::STAGE, kernel, items, band, |first| first.set(kernel, first_item).map(drop))
    }

    /// The permutation, or a more general one if only that is built and the frame may use it.
    fn available(&mut self, device: &Device, best: Permutation<K>, items: usize) -> Permutation<K> {
        let general = Self::general(best).filter(|general| *general != best && device.may_use_general_programs());
        let Some(general) = general.filter(|_| !self.built.contains_key(&best)) else { return best };
        let request = |permutation| KernelRequest::new::<K>(device.tuning(), permutation, items);
        let best_request = request(best);
        if device.is_ready(&best_request) || !(self.built.contains_key(&general) || device.is_ready(&request(general))) {
            return best;
        }
        device.use_general_program(best_request, self.requested.insert(best));
        general
    }

    fn general((variant, extras): Permutation<K>) -> Option<Permutation<K>> {
        K::general(variant).map(|general| (general, extras))
    }

    /// `-D` options of a permutation.
    fn defines(tuning: &Tuning, (variant, extras): Permutation<K>) -> String {
        K::defines(tuning, variant).with_if(extras.tinted, "TINTED").with_if(extras.cut, "CUT_RAYS").0
    }
}

/// `kernel!`: declares a kernel with its file, name, stage and work-items, the `-D` options of its variants, the number of its work-items, and
/// its typed arguments in order, or those of another kernel.
macro_rules! kernel {
    (
        $(#[$doc:meta])*
        $kernel:ident = $file:literal, $name:ident, $stage:literal, $items:expr;
        defines |$define_tuning:tt, $variant:tt: $variant_type:ty| $defines:expr;
        items |$arguments_of:tt, $items_tuning:tt| $count:expr;
        $(general |$special:tt| $general:expr;)?
        arguments $arguments:ident<$lifetime:lifetime> { $($fields:tt)* }
    ) => {
        $crate::device::launch::kernel! {
            $(#[$doc])*
            $kernel = $file, $name, $stage, $items;
            defines |$define_tuning, $variant: $variant_type| $defines;
            items |$arguments_of, $items_tuning| $count;
            $(general |$special| $general;)?
            arguments $arguments
        }
        $crate::device::launch::arguments! {
            #[doc = concat!("Arguments of [`", stringify!($kernel), "`].")]
            $arguments<$lifetime> { $($fields)* }
        }
    };
    (
        $(#[$doc:meta])*
        $kernel:ident = $file:literal, $name:ident, $stage:literal, $items:expr;
        defines |$define_tuning:tt, $variant:tt: $variant_type:ty| $defines:expr;
        items |$arguments_of:tt, $items_tuning:tt| $count:expr;
        $(general |$special:tt| $general:expr;)?
        arguments $arguments:ident
    ) => {
        $(#[$doc])*
        pub(crate) enum $kernel {}

        impl $crate::device::launch::Launch for $kernel {
            const FILE: &'static str = $file;
            const NAME: &'static str = stringify!($name);
            const STAGE: &'static str = $stage;
            const ITEMS: $crate::device::launch::Items = $items;
            type Arguments<'a> = $arguments<'a>;
            type Variant = $variant_type;

            fn defines($define_tuning: &$crate::device::Tuning, $variant: $variant_type) -> $crate::device::launch::Defines {
                $defines
            }

            fn items($arguments_of: &$arguments<'_>, $items_tuning: &$crate::device::Tuning) -> usize {
                $count
            }

            $(fn general($special: $variant_type) -> Option<$variant_type> {
                $general
            })?
        }
    };
}
use kernel;

/// Rounds a number of work-items up to 65,536, since PoCL builds a separate kernel for smaller launches. The device check thus
/// runs the same kernel as large volumes and pictures. Excess work-items return at once.
fn large_grid(items: usize) -> usize {
    items.max(1 << 16)
}

/// Number of tiles in a grid.
fn tiles(counts: [i32; 2]) -> usize {
    counts.iter().map(|&n| n as usize).product()
}
