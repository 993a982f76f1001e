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

/// What a ray has gathered.
pub(super) struct Gathered {
    pub color: [f64; 3],
    pub transmittance: f64,
}

impl Gathered {
    pub fn new() -> Self {
        Self { color: [0.0; 3], transmittance: 1.0 }
    }

    /// Composites a colour of an opacity behind it.
    pub fn add(&mut self, color: [f64; 3], opacity: f64) {
        for (sum, c) in self.color.iter_mut().zip(color) {
            *sum += self.transmittance * opacity * c;
        }
        self.transmittance *= 1.0 - opacity;
    }

    /// Premultiplied RGBA.
    pub fn rgba(&self) -> [f64; 4] {
        [self.color[0], self.color[1], self.color[2], 1.0 - self.transmittance]
    }
}
