//! Rays from a light: directions that stand for lights and for the sky, and their lattices.

use super::axis::{Axis, AxisFrame};
use super::lattice::LayerOffset;
use glam::DVec3;

/// Parallel rays from a light, one per voxel of a layer, sheared so that a ray keeps its (I, J) in all layers.
#[derive(Clone, Debug, PartialEq)]
pub struct LightRays {
    /// Axes of the layers.
    pub frame: AxisFrame,
    /// +1 or −1: from layer to layer in the direction in which the light shines.
    pub layer_step: i32,
    /// Offset of a ray in u and v per layer.
    pub shear: [f64; 2],
    /// Number of rays along u and v.
    pub size: [usize; 2],
    /// Where ray (0, 0) crosses the layers −1 … n, along u and v. Ray I lies at base + I + fraction.
    pub offsets: [Vec<LayerOffset>; 2],
}

impl LightRays {
    /// Rays for a grid of `dims` voxels. `to_light`: direction towards the light in voxels along x, y, z, of any length. Two rays lie on
    /// each side of each of the voxels −1 … n.
    pub fn new(dims: [usize; 3], to_light: DVec3, axis: Axis) -> Self {
        let frame = axis.frame();
        let shear = frame.shear(to_light);
        let [u, v, layers] = [frame.u, frame.v, frame.a].map(|i| dims[i] as i64);
        // In the middle layer rays meet voxels, so that they move as little as possible where the light turns. In the layer where ray 0 lies
        // farthest ahead, voxel −1 must still have two rays before it.
        let middle = (layers / 2) as f64;
        let first = |shear: f64| -3.0 - (shear.abs() * (middle + 1.0)).ceil();
        let offsets = shear.map(|shear| {
            let offset = |k: i64| {
                let position = first(shear) + (k as f64 - middle) * shear;
                let base = position.floor();
                LayerOffset { base: base as i32, fraction: (position - base) as f32 }
            };
            (-1..=layers).map(offset).collect::<Vec<_>>()
        });
        let size = [(u, &offsets[0]), (v, &offsets[1])].map(|(n, offsets)| {
            let lowest = offsets.iter().map(|offset| i64::from(offset.base)).min().unwrap_or(0);
            (n + 2 - lowest) as usize
        });
        Self { frame, layer_step: if to_light[frame.a] > 0.0 { -1 } else { 1 }, shear, size, offsets }
    }
}

/// Directions that stand for a light of this angular diameter in degrees, with equal weights: its centre and, unless the diameter is 0, a ring
/// of six around it, so that all seven have equal parts of the disc.
pub fn disc_directions(to_light: DVec3, diameter: f64) -> Vec<DVec3> {
    let centre = to_light.normalize();
    if diameter == 0.0 {
        return vec![centre];
    }
    // The root mean square radius of the outer six sevenths.
    let radius = (4.0f64 / 7.0).sqrt() * (diameter.to_radians() / 2.0).tan();
    let (right, up) = centre.any_orthonormal_pair();
    let on_ring = |n: u32| {
        let (sin, cos) = (f64::from(n) * std::f64::consts::FRAC_PI_3).sin_cos();
        (centre + radius * (cos * right + sin * up)).normalize()
    };
    std::iter::once(centre).chain((0..6).map(on_ring)).collect()
}

/// Directions that stand for the whole sky, with their weights, which sum to 1: the six axes and the eight diagonals. The weights integrate
/// polynomials up to degree 5 over the sphere exactly (Lebedev's rule of 14 points).
pub fn sky_directions() -> Vec<(DVec3, f64)> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [(axis, 1.0 / 15.0), (-axis, 1.0 / 15.0)]);
    let sign = |bit: u32, corner: u32| if corner >> bit & 1 == 0 { 1.0 } else { -1.0 };
    let diagonals = (0..8).map(|c| (DVec3::new(sign(0, c), sign(1, c), sign(2, c)).normalize(), 3.0 / 40.0));
    axes.chain(diagonals).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_surround_all_voxels_in_every_layer() {
        let dims = [7, 5, 9];
        for to_light in [DVec3::new(0.3, -0.9, 1.0), DVec3::new(-1.0, 0.2, -0.6), DVec3::Z, DVec3::new(1.0, 1.0, -1.0)] {
            let axis = Axis::most_parallel(to_light);
            let rays = LightRays::new(dims, to_light, axis);
            for (i, voxels) in [rays.frame.u, rays.frame.v].map(|i| dims[i] as f64).into_iter().enumerate() {
                assert_eq!(rays.offsets[i].len(), dims[rays.frame.a] + 2);
                for offset in &rays.offsets[i] {
                    let first = f64::from(offset.base) + f64::from(offset.fraction);
                    let last = first + (rays.size[i] - 1) as f64;
                    assert!(first < -2.0 && last >= voxels + 1.0 - 1e-6, "{to_light}: rays from {first} to {last}");
                    assert!((0.0..=1.0).contains(&offset.fraction));
                }
            }
            assert_eq!(f64::from(rays.layer_step), -to_light[rays.frame.a].signum(), "light shines away from the light");
        }
    }

    #[test]
    fn rays_are_parallel_to_the_light() {
        let to_light = DVec3::new(0.3, -0.5, 1.0);
        let rays = LightRays::new([8; 3], to_light, Axis::Z);
        let at = |i: usize, k: usize| f64::from(rays.offsets[i][k].base) + f64::from(rays.offsets[i][k].fraction);
        for k in 1..10 {
            assert!((at(0, k) - at(0, k - 1) - 0.3).abs() < 1e-6 && (at(1, k) - at(1, k - 1) + 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn the_sky_and_discs_have_the_right_moments() {
        let sky = sky_directions();
        let mean = |f: &dyn Fn(DVec3) -> f64| sky.iter().map(|&(d, weight)| weight * f(d)).sum::<f64>();
        for (moment, expected) in [
            (mean(&|_| 1.0), 1.0),
            (mean(&|d| d.x), 0.0),
            (mean(&|d| d.y * d.y), 1.0 / 3.0),
            (mean(&|d| d.z.powi(4)), 0.2),
            (mean(&|d| d.x * d.x * d.y * d.y), 1.0 / 15.0),
        ] {
            assert!((moment - expected).abs() < 1e-12, "{moment}, not {expected}");
        }
        // The mean square radius of a disc is half the square of its radius.
        let centre = DVec3::new(1.0, 2.0, -0.5).normalize();
        let disc = disc_directions(centre, 10.0);
        let tangents = disc.iter().map(|d| (1.0 / d.dot(centre).powi(2) - 1.0).max(0.0));
        let expected = 5f64.to_radians().tan().powi(2) / 2.0;
        assert!((tangents.sum::<f64>() / disc.len() as f64 - expected).abs() < 0.03 * expected);
        assert_eq!(disc_directions(centre, 0.0), [centre]);
    }
}
