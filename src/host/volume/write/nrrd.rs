//! Attached, uncompressed NRRD.

use super::Written;
use crate::volume::ScalarType;
use std::fmt::Write;

pub(super) fn head(written: &Written) -> Result<Vec<u8>, String> {
    if written.scalar == ScalarType::Float16 {
        return Err("the format does not support float16: choose .npy or .raw".into());
    }
    let [x, y, z] = written.grid.dims();
    let place = written.grid.index_to_world();
    let vector = |v: glam::DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let axes = [0, 1, 2].map(|i| vector(place.matrix3.col(i))).join(" ");
    let scalar = match written.scalar {
        ScalarType::Float32 => "float".into(),
        ScalarType::Float64 => "double".into(),
        whole => whole.to_string(),
    };
    let space = if written.grid.has_anatomy() { "space: right-anterior-superior" } else { "space dimension: 3" };
    let mut head = format!("NRRD0005\ntype: {scalar}\ndimension: 3\n{space}\nsizes: {x} {y} {z}\n");
    let _ = write!(head, "space directions: {axes}\nkinds: domain domain domain\n");
    if let Some(unit) = written.length_unit {
        let _ = writeln!(head, "space units: \"{unit}\" \"{unit}\" \"{unit}\"");
    }
    if written.scalar.bytes() > 1 {
        head += "endian: little\n";
    }
    let _ = write!(head, "encoding: raw\nspace origin: {}\n\n", vector(place.translation));
    Ok(head.into_bytes())
}
