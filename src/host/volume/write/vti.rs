//! VTK XML image data, with raw appended data.

use super::Written;
use crate::volume::ScalarType;

/// End of the file, after the numbers.
pub(super) const FOOT: &[u8] = b"\n  </AppendedData>\n</VTKFile>\n";

pub(super) fn head(written: &Written) -> Result<Vec<u8>, String> {
    let scalar = match written.scalar {
        ScalarType::Float16 => return Err("the format does not support float16: choose .npy or .raw".into()),
        ScalarType::Float32 => "Float32".into(),
        ScalarType::Float64 => "Float64".into(),
        whole => whole.to_string().replace("uint", "UInt").replace("int", "Int"),
    };
    let [x, y, z] = written.grid.dims().map(|n| n - 1);
    let (origin, spacing, direction) = (written.grid.origin(), written.grid.spacing(), written.grid.direction());
    // Row-major in the file.
    let direction = direction.transpose().to_cols_array().map(|n| n.to_string()).join(" ");
    let three = |v: glam::DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let name: String = written.name.chars().filter(|c| c.is_ascii_alphanumeric() || "._-".contains(*c)).collect();
    let head = format!(
        r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <ImageData WholeExtent="0 {x} 0 {y} 0 {z}" Origin="{}" Spacing="{}" Direction="{direction}">
    <Piece Extent="0 {x} 0 {y} 0 {z}">
      <PointData Scalars="{name}">
        <DataArray type="{scalar}" Name="{name}" format="appended" offset="0"/>
      </PointData>
    </Piece>
  </ImageData>
  <AppendedData encoding="raw">
   _"#,
        three(origin),
        three(spacing)
    );
    let mut head = head.into_bytes();
    head.extend(written.bytes().to_le_bytes());
    Ok(head)
}
