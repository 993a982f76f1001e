//! `kernel_struct!`, and what may be a field of such a structure.

use super::ClType;
use super::structs::Float4;

/// A type of a field, as OpenCL declares it.
pub(super) trait Field {
    /// What arrays of it have as their elements.
    type Element: ClType;
    /// How many of these it has; none: it is no array.
    const ELEMENTS: Option<usize> = None;

    /// Arrays of arrays are declared flat, in one dimension: rusticl mis-sizes structures with any other.
    fn declared(name: &str) -> String {
        let element = <Self::Element as ClType>::NAME;
        match Self::ELEMENTS {
            None => format!("{element} {name}"),
            Some(elements) => format!("{element} {name}[{elements}]"),
        }
    }
}

macro_rules! scalar_fields {
    ($($type:ty),*) => {$(
        impl Field for $type {
            type Element = $type;
        }
    )*};
}
scalar_fields!(i32, u32, i64, f32, Float4);

impl<T: Field, const N: usize> Field for [T; N] {
    type Element = T::Element;
    const ELEMENTS: Option<usize> = Some(match T::ELEMENTS {
        None => N,
        Some(inner) => inner * N,
    });
}

/// `kernel_struct!`: a structure of Rust and of OpenCL. `name as [a, b]: T` is an array `[T; 2]` here, and two fields there; arrays of
/// arrays are flat there. Padding is a field of its own: implementations differ in what they make of any other.
macro_rules! kernel_struct {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident $(as [$($part:ident),+])? : $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $name { $($(#[$field_doc])* pub $field: kernel_struct!(@type $type $(, $($part),+)?)),* }

        // rusticl leaves padding at the end out of a structure's size, and refuses it as an argument.
        const _: () = assert!(
            size_of::<$name>() == 0 $(+ size_of::<kernel_struct!(@type $type $(, $($part),+)?)>())*,
            concat!(stringify!($name), " has implicit padding: make it a field")
        );

        impl ClType for $name {
            const NAME: &'static str = stringify!($name);
        }

        impl Field for $name {
            type Element = $name;
        }

        impl $name {
            /// Its definition in OpenCL C, which does not compile where the sizes differ.
            fn typedef() -> String {
                let fields: Vec<String> = [$(kernel_struct!(@declared $field, $type $(, $($part),+)?)),*].concat();
                let (name, bytes) = (stringify!($name), size_of::<$name>());
                format!(
                    "typedef struct {{ {}; }} {name};\ntypedef char {name}_size[sizeof({name}) == {bytes} ? 1 : -1];\n",
                    fields.join("; ")
                )
            }
        }
    };
    (@type $type:ty) => { $type };
    (@type $type:ty, $($part:ident),+) => { [$type; [$(stringify!($part)),+].len()] };
    (@declared $field:ident, $type:ty) => { vec![<$type as Field>::declared(stringify!($field))] };
    (@declared $field:ident, $type:ty, $($part:ident),+) => { vec![$(<$type as Field>::declared(stringify!($part))),+] };
}
pub(super) use kernel_struct;

#[cfg(test)]
mod tests {
    use crate::device::launch::structs;

    #[test]
    fn arrays_of_arrays_are_flat_in_opencl() {
        let definitions = structs::typedefs();
        assert!(definitions.contains("float planes[24];") && definitions.contains("int blocks[6];"), "{definitions}");
        assert!(!definitions.contains("]["), "{definitions}");
    }
}
