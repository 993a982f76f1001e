//! Kernels with the colours of labels: the same files with TINTED.

use super::structs::TintParams;
use super::{Argument, Arguments, Declared, Defines, Items, Launch, Launcher};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use opencl3::kernel::Kernel as ClKernel;
use std::marker::PhantomData;

/// A kernel whose arguments end with TINT_ARGUMENTS of kernels/shared/tint.cl.
pub(crate) struct Tinted<K>(PhantomData<K>);

/// Arguments of [`Tinted`].
pub(crate) struct TintedArguments<'a, A> {
    plain: A,
    tint: Tint<'a>,
}

/// Colours of labels, and where they lie.
#[derive(Clone, Copy)]
pub(crate) struct Tint<'a> {
    /// Indices of colours, of one or two bytes, and three bytes more.
    pub label_voxels: &'a Buffer<u8>,
    /// Red, green and blue times their weight, and the weight.
    pub label_colors: &'a Buffer<u8>,
    pub params: TintParams,
}

impl<A: Arguments> Arguments for TintedArguments<'_, A> {
    const FIRST_ITEM: u32 = A::FIRST_ITEM + 3;

    fn set_own(&self, kernel: &ClKernel) -> opencl3::Result<()> {
        self.plain.set_own(kernel)?;
        Argument::set(&self.tint.label_voxels, kernel, A::FIRST_ITEM)?;
        Argument::set(&self.tint.label_colors, kernel, A::FIRST_ITEM + 1)?;
        Argument::set(&self.tint.params, kernel, A::FIRST_ITEM + 2)
    }

    fn own_sizes() -> Vec<usize> {
        [A::own_sizes(), vec![0, 0, size_of::<TintParams>()]].concat()
    }

    #[cfg(test)]
    fn own_signature() -> Vec<(String, String)> {
        let own = [("label_voxels", "uchar*"), ("label_colors", "uchar*"), ("tint_params", "TintParams")];
        A::own_signature().into_iter().chain(own.map(|(name, kind)| (name.into(), kind.into()))).collect()
    }
}

impl<K: Launch> Declared for Tinted<K> {
    const FILE: &'static str = K::FILE;
    const NAME: &'static str = K::NAME;
    const STAGE: &'static str = K::STAGE;
    type Arguments<'a> = TintedArguments<'a, K::Arguments<'a>>;
}

impl<K: Launch> Launch for Tinted<K> {
    type Variant = K::Variant;
    const ITEMS: Items = K::ITEMS;

    fn defines(tuning: &Tuning, variant: Self::Variant) -> String {
        Defines(K::defines(tuning, variant)).with_if(true, "TINTED").0
    }

    fn items(arguments: &Self::Arguments<'_>, tuning: &Tuning) -> usize {
        K::items(&arguments.plain, tuning)
    }

    fn general(variant: Self::Variant) -> Option<Self::Variant> {
        K::general(variant)
    }
}

/// Launches a kernel with or without the colours of labels.
pub(crate) struct TintLauncher<K: Launch> {
    plain: Launcher<K>,
    tinted: Launcher<Tinted<K>>,
}

impl<K: Launch> Default for TintLauncher<K> {
    fn default() -> Self {
        Self { plain: Launcher::default(), tinted: Launcher::default() }
    }
}

impl<K: Launch> TintLauncher<K> {
    /// As [`Launcher::launch`].
    pub fn launch<'a>(
        &mut self,
        device: &Device,
        variant: K::Variant,
        arguments: K::Arguments<'a>,
        tint: Option<Tint<'a>>,
    ) -> Result<(), Error> {
        match tint {
            Some(tint) => self.tinted.launch(device, variant, &TintedArguments { plain: arguments, tint }),
            None => self.plain.launch(device, variant, &arguments),
        }
    }
}
