//! Data types of the API: their sizes and names.

use anari_sys::*;
use std::ffi::c_int;

/// A data type, by its number in `anari_enums.h`.
pub type DataType = c_int;

/// The scalar types of numbers, in the order of their constants: four each, with 1 to 4 components.
const SCALARS: [(&str, usize); 19] = [
    ("INT8", 1),
    ("UINT8", 1),
    ("INT16", 2),
    ("UINT16", 2),
    ("INT32", 4),
    ("UINT32", 4),
    ("INT64", 8),
    ("UINT64", 8),
    ("FIXED8", 1),
    ("UFIXED8", 1),
    ("FIXED16", 2),
    ("UFIXED16", 2),
    ("FIXED32", 4),
    ("UFIXED32", 4),
    ("FIXED64", 8),
    ("UFIXED64", 8),
    ("FLOAT16", 2),
    ("FLOAT32", 4),
    ("FLOAT64", 8),
];

/// All types that are not numbers with 1 to 4 components, with the bytes that a value takes.
const OTHERS: [(DataType, &str, usize); 50] = [
    (ANARI_DATA_TYPE, "DATA_TYPE", 4),
    (ANARI_STRING, "STRING", 8),
    (ANARI_VOID_POINTER, "VOID_POINTER", 8),
    (ANARI_BOOL, "BOOL", 4),
    (ANARI_STRING_LIST, "STRING_LIST", 8),
    (ANARI_DATA_TYPE_LIST, "DATA_TYPE_LIST", 8),
    (ANARI_PARAMETER_LIST, "PARAMETER_LIST", 8),
    (ANARI_FUNCTION_POINTER, "FUNCTION_POINTER", 8),
    (ANARI_MEMORY_DELETER, "MEMORY_DELETER", 8),
    (ANARI_STATUS_CALLBACK, "STATUS_CALLBACK", 8),
    (ANARI_FRAME_COMPLETION_CALLBACK, "FRAME_COMPLETION_CALLBACK", 8),
    (ANARI_LIBRARY, "LIBRARY", 8),
    (ANARI_DEVICE, "DEVICE", 8),
    (ANARI_OBJECT, "OBJECT", 8),
    (ANARI_ARRAY, "ARRAY", 8),
    (ANARI_ARRAY1D, "ARRAY1D", 8),
    (ANARI_ARRAY2D, "ARRAY2D", 8),
    (ANARI_ARRAY3D, "ARRAY3D", 8),
    (ANARI_CAMERA, "CAMERA", 8),
    (ANARI_FRAME, "FRAME", 8),
    (ANARI_GEOMETRY, "GEOMETRY", 8),
    (ANARI_GROUP, "GROUP", 8),
    (ANARI_INSTANCE, "INSTANCE", 8),
    (ANARI_LIGHT, "LIGHT", 8),
    (ANARI_MATERIAL, "MATERIAL", 8),
    (ANARI_RENDERER, "RENDERER", 8),
    (ANARI_SURFACE, "SURFACE", 8),
    (ANARI_SAMPLER, "SAMPLER", 8),
    (ANARI_SPATIAL_FIELD, "SPATIAL_FIELD", 8),
    (ANARI_VOLUME, "VOLUME", 8),
    (ANARI_WORLD, "WORLD", 8),
    (ANARI_UFIXED8_R_SRGB, "UFIXED8_R_SRGB", 1),
    (ANARI_UFIXED8_RA_SRGB, "UFIXED8_RA_SRGB", 2),
    (ANARI_UFIXED8_RGB_SRGB, "UFIXED8_RGB_SRGB", 3),
    (ANARI_UFIXED8_RGBA_SRGB, "UFIXED8_RGBA_SRGB", 4),
    (ANARI_FLOAT32_BOX1, "FLOAT32_BOX1", 8),
    (ANARI_FLOAT32_BOX2, "FLOAT32_BOX2", 16),
    (ANARI_FLOAT32_BOX3, "FLOAT32_BOX3", 24),
    (ANARI_FLOAT32_BOX4, "FLOAT32_BOX4", 32),
    (ANARI_FLOAT64_BOX1, "FLOAT64_BOX1", 16),
    (ANARI_INT32_BOX1, "INT32_BOX1", 8),
    (ANARI_INT32_BOX2, "INT32_BOX2", 16),
    (ANARI_INT32_BOX3, "INT32_BOX3", 24),
    (ANARI_UINT64_REGION1, "UINT64_REGION1", 16),
    (ANARI_FLOAT32_MAT2, "FLOAT32_MAT2", 16),
    (ANARI_FLOAT32_MAT3, "FLOAT32_MAT3", 36),
    (ANARI_FLOAT32_MAT4, "FLOAT32_MAT4", 64),
    (ANARI_FLOAT32_MAT2x3, "FLOAT32_MAT2x3", 24),
    (ANARI_FLOAT32_MAT3x4, "FLOAT32_MAT3x4", 48),
    (ANARI_FLOAT32_QUAT_IJKW, "FLOAT32_QUAT_IJKW", 16),
];

/// The scalar type of a number and its number of components.
fn scalar(data_type: DataType) -> Option<(&'static str, usize, usize)> {
    let index = usize::try_from(data_type.checked_sub(ANARI_INT8)?).ok()?;
    SCALARS.get(index / 4).map(|&(name, bytes)| (name, bytes, index % 4 + 1))
}

/// Bytes of a value; `None` for types that the API does not have.
pub fn bytes(data_type: DataType) -> Option<usize> {
    let other = || OTHERS.iter().find(|(other, ..)| *other == data_type).map(|&(.., bytes)| bytes);
    scalar(data_type).map(|(_, bytes, components)| bytes * components).or_else(other)
}

/// Name without the prefix `ANARI_`, for messages.
pub fn name(data_type: DataType) -> String {
    match scalar(data_type) {
        Some((name, _, 1)) => name.into(),
        Some((name, _, components)) => format!("{name}_VEC{components}"),
        None => {
            let other = OTHERS.iter().find(|(other, ..)| *other == data_type);
            other.map_or_else(|| format!("the unknown type {data_type}"), |(_, name, _)| (*name).into())
        }
    }
}

/// Whether values are handles of objects.
pub fn is_object(data_type: DataType) -> bool {
    (ANARI_DEVICE..=ANARI_WORLD).contains(&data_type)
}

/// Whether values are arrays.
pub fn is_array(data_type: DataType) -> bool {
    [ANARI_ARRAY1D, ANARI_ARRAY2D, ANARI_ARRAY3D].contains(&data_type)
}

/// Number of floats of a value that consists of floats.
pub fn floats(data_type: DataType) -> Option<usize> {
    let consists = match scalar(data_type) {
        Some((name, ..)) => name == "FLOAT32",
        None => OTHERS.iter().any(|(other, name, _)| *other == data_type && name.starts_with("FLOAT32")),
    };
    bytes(data_type).filter(|_| consists).map(|bytes| bytes / 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_names_follow_from_the_numbers() {
        let known = [
            (ANARI_UFIXED8, "UFIXED8", 1),
            (ANARI_FIXED16, "FIXED16", 2),
            (ANARI_UINT32_VEC2, "UINT32_VEC2", 8),
            (ANARI_FLOAT32_VEC4, "FLOAT32_VEC4", 16),
            (ANARI_FLOAT64, "FLOAT64", 8),
            (ANARI_FLOAT64_VEC4, "FLOAT64_VEC4", 32),
            (ANARI_FLOAT32_MAT4, "FLOAT32_MAT4", 64),
            (ANARI_VOLUME, "VOLUME", 8),
        ];
        for (data_type, expected, size) in known {
            assert_eq!((name(data_type).as_str(), bytes(data_type)), (expected, Some(size)));
        }
        for unknown in [0, -1, i32::MIN, i32::MAX, 999, 1076, 520] {
            assert_eq!((bytes(unknown), is_object(unknown)), (None, false), "{unknown}");
        }
        assert_eq!(floats(ANARI_FLOAT32_BOX2), Some(4));
        assert_eq!(floats(ANARI_UFIXED8), None);
    }
}
