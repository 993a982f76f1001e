//! Built-in closed-form volumes, sampled at any size.

use super::{RawOptions, Volume, Voxels};
use crate::error::Error;
use glam::DVec3;
use std::f64::consts::PI;

const NAMES: &str = "marschner-lobb, hydrogen or cube";
/// Largest built-in volume: 1024³ voxels.
const MAX_VOXELS: usize = 1 << 30;

/// The volume `NAME`, `NAME@N` or `NAME@XxYxZ`, 64³ by default, as uint8. Only the spacing of `options` counts.
///
/// * `marschner-lobb`: the test signal of Marschner & Lobb (1994), f_M = 6, α = 0.25, on \[−1, 1\]³.
/// * `hydrogen`: the density of hydrogen's 3d_z² orbital, the square root of it so that both lobes and ring show.
/// * `cube`: one value, 255, everywhere: a homogeneous cube that fills its grid.
pub fn builtin_volume(source: &str, options: &RawOptions) -> Result<Volume, Error> {
    let (name, size) = source.split_once('@').unwrap_or((source, "64"));
    let density: fn(DVec3) -> f64 = match name {
        "marschner-lobb" => marschner_lobb,
        "hydrogen" => hydrogen,
        "cube" => |_| 1.0,
        _ => {
            return Err(Error::UnknownName { what: "built-in volume", name: name.into(), known: NAMES.into() });
        }
    };
    if options.dims.is_some() || options.voxel_type.is_some() {
        let problem = format!("dimensions and types are for files: write builtin:{name}@N or builtin:{name}@XxYxZ");
        return Err(Error::Settings { field: "dims", problem });
    }
    let dims = parse_size(size).ok_or_else(|| Error::OutOfRange {
        name: "size of the built-in volume",
        value: size.into(),
        expected: "N or XxYxZ, at least 1 per axis and at most 2^30 voxels",
    })?;
    let grid = options.grid(dims)?;
    let mut voxels = Vec::with_capacity(grid.voxel_count());
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            for i in 0..dims[0] {
                let p = DVec3::from_array(std::array::from_fn(|a| unit_coordinate([i, j, k][a], dims[a])));
                voxels.push((density(p).clamp(0.0, 1.0) * 255.0).round() as u8);
            }
        }
    }
    Volume::new(format!("builtin:{source}"), grid, Voxels::Uint8(voxels))
}

fn parse_size(text: &str) -> Option<[usize; 3]> {
    let numbers: Vec<usize> = text.split('x').map(|n| n.parse().ok()).collect::<Option<_>>()?;
    let dims = match numbers[..] {
        [n] => [n; 3],
        [x, y, z] => [x, y, z],
        _ => return None,
    };
    let count = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d))?;
    (1..=MAX_VOXELS).contains(&count).then_some(dims)
}

/// Position of voxel `i` of `n` in \[−1, 1\]; a single voxel sits in the middle.
fn unit_coordinate(i: usize, n: usize) -> f64 {
    if n == 1 { 0.0 } else { 2.0 * i as f64 / (n as f64 - 1.0) - 1.0 }
}

fn marschner_lobb(p: DVec3) -> f64 {
    const FREQUENCY: f64 = 6.0;
    const AMPLITUDE: f64 = 0.25;
    let wave = (2.0 * PI * FREQUENCY * (PI * p.truncate().length() / 2.0).cos()).cos();
    (1.0 - (PI * p.z / 2.0).sin() + AMPLITUDE * (1.0 + wave)) / (2.0 * (1.0 + AMPLITUDE))
}

/// ψ₃₂₀ ∝ r² e^{−r/3} (3cos²θ − 1), r in Bohr radii over \[−22, 22\]; |ψ| scaled to its largest value, that on the z
/// axis at r = 6.
fn hydrogen(p: DVec3) -> f64 {
    const EXTENT: f64 = 22.0;
    let q = p * EXTENT;
    let psi = |r: f64, angular: f64| angular * (-r / 3.0).exp();
    let amplitude = psi(q.length(), 2.0 * q.z * q.z - q.x * q.x - q.y * q.y);
    (amplitude / psi(6.0, 72.0)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(source: &str) -> (Volume, Vec<u8>) {
        let volume = builtin_volume(source, &RawOptions::default()).unwrap();
        let Voxels::Uint8(values) = volume.voxels().clone() else { panic!("built-in volumes are uint8") };
        (volume, values)
    }

    #[test]
    fn sizes() {
        assert_eq!(values("cube@3x4x5").0.grid().dims(), [3, 4, 5]);
        assert_eq!(values("cube@2").1, vec![255; 8]);
        assert_eq!(values("hydrogen").0.grid().dims(), [64; 3]);
        assert_eq!(values("marschner-lobb@1").1.len(), 1);
        for bad in ["cube@0", "cube@2x2", "cube@", "cube@-1", "cube@100000x100000x1", "sphere"] {
            assert!(builtin_volume(bad, &RawOptions::default()).is_err(), "{bad}");
        }
    }

    #[test]
    fn closed_forms() {
        let (_, hydrogen) = values("hydrogen@45");
        let at = |i: usize, j: usize, k: usize| hydrogen[(k * 45 + j) * 45 + i];
        assert_eq!(at(22, 22, 22), 0);
        assert_eq!(at(22, 22, 28), 255);
        assert_eq!(at(28, 22, 22), at(22, 16, 22));
        let (_, signal) = values("marschner-lobb@41");
        assert_eq!(signal[20 * 41 * 41 + 20 * 41 + 20], (0.6f64 * 255.0).round() as u8);
    }
}
