//! `kernel_struct!`, and the types of its fields.

use super::cl_type::{ClType, Float4};

/// A field type, with its declaration in OpenCL C.
pub(super) trait Field {
    /// The innermost element type; the type itself unless it is an array.
    type Element: ClType;
    /// Number of elements of an array, otherwise `None`.
    const ELEMENTS: Option<usize> = None;

    /// The declaration. Nested arrays become one-dimensional: rusticl computes wrong sizes for others.
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

/// `kernel_struct!`: declares a structure in Rust and in OpenCL C. `name as [a, b]: T` is an array `[T; 2]` in Rust and two
/// fields in OpenCL C, where nested arrays are flattened. Padding must be an explicit field: implementations differ in implicit
/// padding.
macro_rules! kernel_struct {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident $(as [$($part:ident),+])? : $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $name { $($(#[$field_doc])* pub $field: kernel_struct!(@type $type $(, $($part),+)?)),* }

        // rusticl omits trailing padding from the size of a structure, and then rejects it as an argument.
        const _: () = assert!(
            size_of::<$name>() == 0 $(+ size_of::<kernel_struct!(@type $type $(, $($part),+)?)>())*,
            concat!(stringify!($name), " has implicit padding: declare it as a field")
        );

        impl ClType for $name {
            const NAME: &'static str = stringify!($name);
        }

        impl Field for $name {
            type Element = $name;
        }

        impl $name {
            /// The definition in OpenCL C. It does not compile if the sizes differ.
            pub(in crate::device::launch) fn typedef() -> String {
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
    fn nested_arrays_are_flattened_in_opencl() {
        let definitions = structs::typedefs();
        assert!(definitions.contains("float planes[24];") && definitions.contains("int blocks[6];"), "{definitions}");
        assert!(!definitions.contains("]["), "{definitions}");
    }
}
