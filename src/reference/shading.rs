//! How a colour is lit.

use crate::renderer::Shading;
use crate::volume::Volume;
use glam::DVec3;

/// Blinn-Phong with the fade for weak gradients (math.md, "Conventions"). `gradient` in voxel differences; `to_eye` in the
/// grid's axes.
pub(super) fn shade(volume: &Volume, shading: Shading, color: [f64; 3], gradient: DVec3, to_eye: DVec3) -> [f64; 3] {
    let grid = volume.grid();
    let (lo, hi) = volume.range();
    let range = if hi > lo { hi - lo } else { 1.0 };
    let gradient = gradient * grid.spacing().min_element() / grid.spacing() / range;
    let Some(normal) = gradient.try_normalize() else {
        return color;
    };
    let light = shading.light.map_or(to_eye, |l| grid.world_to_grid_axes() * l.normalize());
    let half_way = (light + to_eye).normalize_or(to_eye);
    let fade = ((gradient.length() - 1e-3) * 1e3).clamp(0.0, 1.0);
    let fade = fade * fade * (3.0 - 2.0 * fade);
    let factor = shading.ambient + shading.diffuse * normal.dot(light).abs();
    let highlight = shading.specular * normal.dot(half_way).abs().powf(shading.power);
    color.map(|c| (c * (1.0 + fade * (factor - 1.0)) + fade * highlight).min(1.0))
}
