//! Types that OpenCL C has, too.

use bytemuck::{Pod, Zeroable};

/// `float4`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Float4(pub [f32; 4]);

/// A plain type of OpenCL C.
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
    Float4 = "float4",
    [i32; 2] = "int2",
    [i32; 4] = "int4",
    [u8; 4] = "uchar4",
    [u16; 4] = "ushort4"
);
