//! Arguments of kernels: values, buffers, and groups of them.

use super::cl_type::ClType;
use crate::device::Buffer;
use opencl3::kernel::Kernel as ClKernel;

/// One or several arguments of a kernel.
pub(crate) trait Argument {
    /// Sets them, from this index on. Returns the next index.
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32>;

    /// Describes each. `name`: of a single one. `extras`: which of the optional ones are there.
    fn parameters(name: &str, extras: Extras) -> Vec<Parameter>;

    /// Which of the optional ones are among them.
    fn extras(&self) -> Extras {
        Extras::default()
    }
}

/// Optional arguments of a launch; programs with them are built with their defines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Extras {
    /// TINTED: colours of voxels.
    pub tinted: bool,
    /// CUT_RAYS: parts of rays.
    pub cut: bool,
}

impl Extras {
    /// Those of both.
    pub fn and(self, other: Self) -> Self {
        Self { tinted: self.tinted || other.tinted, cut: self.cut || other.cut }
    }
}

/// Arguments that some launches of a kernel have, and others not.
pub(crate) trait Optional: Argument {
    /// Which of them these are.
    const EXTRA: Extras;
}

impl<T: Optional> Argument for Option<T> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        self.as_ref().map_or(Ok(index), |extra| extra.set(kernel, index))
    }

    fn parameters(name: &str, extras: Extras) -> Vec<Parameter> {
        if extras.and(T::EXTRA) == extras { T::parameters(name, extras) } else { Vec::new() }
    }

    fn extras(&self) -> Extras {
        if self.is_some() { T::EXTRA } else { Extras::default() }
    }
}

/// An argument as a kernel declares it.
pub(crate) struct Parameter {
    #[cfg_attr(not(debug_assertions), expect(dead_code, reason = "signatures are compared with debug assertions"))]
    pub name: String,
    /// OpenCL type; `VOXEL` is that of the voxels.
    #[cfg_attr(not(debug_assertions), expect(dead_code, reason = "signatures are compared with debug assertions"))]
    pub kind: String,
    /// Size in bytes; 0 for buffers, whose handles differ between devices.
    pub bytes: usize,
}

impl Parameter {
    fn value<T: ClType>(name: &str) -> Vec<Self> {
        vec![Self { name: name.into(), kind: T::NAME.into(), bytes: size_of::<T>() }]
    }

    /// A buffer of elements of an OpenCL type.
    pub fn buffer(name: &str, element: &str) -> Vec<Self> {
        vec![Self { name: name.into(), kind: format!("{element}*"), bytes: 0 }]
    }
}

/// `arguments!`: declares arguments that follow each other in kernels, in their order. Groups can be fields of others.
macro_rules! arguments {
    (
        $(#[$doc:meta])*
        $group:ident<$lifetime:lifetime> { $($(#[$field_doc:meta])* $field:ident: $type:ty),* $(,)? }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $group<$lifetime> { $($(#[$field_doc])* pub $field: $type),* }

        impl<$lifetime> $crate::device::launch::Argument for $group<$lifetime> {
            fn set(&self, kernel: &opencl3::kernel::Kernel, index: u32) -> opencl3::Result<u32> {
                $(let index = $crate::device::launch::Argument::set(&self.$field, kernel, index)?;)*
                Ok(index)
            }

            fn parameters(_: &str, extras: $crate::device::launch::Extras) -> Vec<$crate::device::launch::Parameter> {
                let mut all = Vec::new();
                $(all.extend(<$type as $crate::device::launch::Argument>::parameters(stringify!($field), extras));)*
                all
            }

            fn extras(&self) -> $crate::device::launch::Extras {
                let all = [$($crate::device::launch::Argument::extras(&self.$field)),*];
                all.into_iter().fold(Default::default(), $crate::device::launch::Extras::and)
            }
        }
    };
}
pub(super) use arguments;

impl<T: ClType> Argument for T {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        // SAFETY: a plain value of the type that the kernel declares at `index`.
        unsafe { kernel.set_arg(index, self)? };
        Ok(index + 1)
    }

    fn parameters(name: &str, _: Extras) -> Vec<Parameter> {
        Parameter::value::<T>(name)
    }
}

impl<T: ClType> Argument for &Buffer<T> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        // SAFETY: a live buffer of the type that the kernel declares at `index`.
        unsafe { kernel.set_arg(index, &self.handle())? };
        Ok(index + 1)
    }

    fn parameters(name: &str, _: Extras) -> Vec<Parameter> {
        Parameter::buffer(name, T::NAME)
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
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        self.0.iter().try_fold(index, |index, argument| argument.set(kernel, index))
    }

    fn parameters(name: &str, extras: Extras) -> Vec<Parameter> {
        (0..MAX_CHANNELS).flat_map(|i| T::parameters(&format!("{name}_{i}"), extras)).collect()
    }
}
