//! Properties of objects, as queries read them.

use crate::frame::{Phase, Task};
use crate::introspection;
use crate::objects::{Object, Objects};
use crate::types::DataType;
use crate::world;
use anari_sys::*;
use std::ffi::{CStr, CString, c_char};
use std::sync::Arc;

/// Major, minor and patch version.
fn version() -> [i32; 3] {
    let mut parts = env!("CARGO_PKG_VERSION").split('.').map(|part| part.parse().unwrap_or(0));
    std::array::from_fn(|_| parts.next().unwrap_or(0))
}

/// The bytes of a property in memory; `None` if the object does not have it with this type.
pub fn property(
    objects: &Objects,
    object: &Object,
    task: Option<&Arc<Task>>,
    name: &CStr,
    data_type: DataType,
) -> Option<Vec<u8>> {
    let name = name.to_bytes();
    match object.data_type {
        ANARI_DEVICE => device(name, data_type),
        ANARI_RENDERER => extensions(name, data_type),
        ANARI_FRAME => frame(task, name, data_type),
        ANARI_WORLD | ANARI_GROUP | ANARI_INSTANCE if (name, data_type) == (b"bounds", ANARI_FLOAT32_BOX3) => {
            let [low, high] = world::bounds(objects, object)?;
            Some(
                [low.as_vec3().to_array(), high.as_vec3().to_array()]
                    .as_flattened()
                    .iter()
                    .flat_map(|x| x.to_ne_bytes())
                    .collect(),
            )
        }
        _ => None,
    }
}

fn device(name: &[u8], data_type: DataType) -> Option<Vec<u8>> {
    let [major, minor, patch] = version();
    let text = CString::new(format!("layersplat {}", env!("CARGO_PKG_VERSION"))).ok()?.into_bytes_with_nul();
    let integer = |value: i32| Some(value.to_ne_bytes().to_vec());
    match (name, data_type) {
        (b"version", ANARI_INT32) => integer(major * 10_000 + minor * 100 + patch),
        (b"version.major", ANARI_INT32) => integer(major),
        (b"version.minor", ANARI_INT32) => integer(minor),
        (b"version.patch", ANARI_INT32) => integer(patch),
        (b"version.name", ANARI_STRING) => Some(text),
        (b"version.name.size", ANARI_UINT64) => Some((text.len() as u64).to_ne_bytes().to_vec()),
        // There are no geometries.
        (b"geometryMaxIndex", ANARI_UINT64) => Some(0u64.to_ne_bytes().to_vec()),
        _ => extensions(name, data_type),
    }
}

fn extensions(name: &[u8], data_type: DataType) -> Option<Vec<u8>> {
    let list: *const *const c_char = introspection::extensions();
    ((name, data_type) == (b"extension", ANARI_STRING_LIST)).then(|| (list as usize).to_ne_bytes().to_vec())
}

fn frame(task: Option<&Arc<Task>>, name: &[u8], data_type: DataType) -> Option<Vec<u8>> {
    let float = |value: f32| Some(value.to_ne_bytes().to_vec());
    let is_drawn = task.is_some_and(|task| task.has_reached(Phase::Drawn));
    match (name, data_type) {
        (b"duration", ANARI_FLOAT32) => task.filter(|_| is_drawn).and_then(|task| float(task.duration())),
        (b"renderProgress", ANARI_FLOAT32) => float(if is_drawn { 1.0 } else { 0.0 }),
        (b"refinementProgress", ANARI_FLOAT32) => {
            float(task.and_then(|task| task.channels()).map_or(0.0, |channels| channels.refinement))
        }
        _ => None,
    }
}
