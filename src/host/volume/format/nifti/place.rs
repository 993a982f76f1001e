//! Placement of voxels: by the matrix if defined, else by the quaternion, else by the spacing alone.

use super::header::Fields;
use crate::volume::Grid;
use crate::volume::format::load::upright;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::path::Path;

/// Transform to RAS coordinates. A matrix that cannot be used gives way to the quaternion.
pub(super) fn index_to_world(path: &Path, fields: &Fields, dims: [usize; 3]) -> DAffine3 {
    let [sign, spacing @ ..] = fields.spacings();
    let spacing = DVec3::from_array(spacing.map(|h| if h == 0.0 || !h.is_finite() { 1.0 } else { h.abs() }));
    let [quaternion, rows] = fields.codes();
    let third = if sign < 0.0 { -1.0 } else { 1.0 };
    let by_quaternion = || from_quaternion(fields.quaternion(), spacing * DVec3::new(1.0, 1.0, third));
    if rows > 0 {
        let by_rows = with_lengths(from_rows(fields.rows()), dims);
        let unusable = Grid::from_affine(dims, by_rows).err().filter(|_| quaternion > 0);
        let Some(problem) = unusable.filter(|_| Grid::from_affine(dims, by_quaternion()).is_ok()) else { return by_rows };
        tracing::warn!("{}: its qform is used instead of its sform: {problem}", path.display());
        by_quaternion()
    } else if quaternion > 0 {
        by_quaternion()
    } else {
        upright(spacing, DVec3::ZERO)
    }
}

/// Whether the transform leads to a patient's coordinates. With neither matrix nor quaternion the format leaves the axes open.
pub(super) fn is_anatomical(fields: &Fields) -> bool {
    fields.codes().iter().any(|&code| code > 0)
}

fn from_rows(rows: [f64; 12]) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[i], rows[4 + i], rows[8 + i]);
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}

fn from_quaternion([b, c, d, x, y, z]: [f64; 6], spacing: DVec3) -> DAffine3 {
    let a = (1.0 - (b * b + c * c + d * d)).max(0.0).sqrt();
    let turn = DMat3::from_quat(DQuat::from_xyzw(b, c, d, a).normalize());
    DAffine3 { matrix3: turn * DMat3::from_diagonal(spacing), translation: DVec3::new(x, y, z) }
}

/// Completes a missing z axis: with a single slice, its length is irrelevant and may be 0.
fn with_lengths(mut affine: DAffine3, dims: [usize; 3]) -> DAffine3 {
    let [x, y, z] = [0, 1, 2].map(|i| affine.matrix3.col(i));
    if dims[2] == 1 && z == DVec3::ZERO {
        affine.matrix3.z_axis = x.cross(y).normalize_or(DVec3::Z) * x.length();
    }
    affine
}
