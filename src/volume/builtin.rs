//! Built-in closed-form volumes, sampled at any size.

use super::{RawOptions, Volume};
use crate::error::Error;
use crate::memory;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

const NAMES: &str = "marschner-lobb, hydrogen or cube";
/// Largest built-in volume: 1024³ voxels.
const MAX_VOXELS: usize = 1 << 30;

/// The volume `NAME`, `NAME@N` or `NAME@XxYxZ`, 64³ by default, as uint8: densities in empty space, so the background is 0. Only the
/// spacing of `options` counts.
///
/// * `marschner-lobb`: the test signal of Marschner & Lobb (1994), f_M = 6, α = 0.25, on \[−1, 1\]³.
/// * `hydrogen`: the density of hydrogen's 3d_z² orbital, the square root of it so that both lobes and ring show.
/// * `cube`: one value, 255, everywhere: a homogeneous cube that fills its grid.
pub fn builtin_volume(source: &str, options: &RawOptions) -> Result<Volume<'static>, Error> {
    let (name, size) = source.split_once('@').unwrap_or((source, "64"));
    let sample: fn([usize; 3]) -> Vec<u8> = match name {
        "marschner-lobb" => marschner_lobb,
        "hydrogen" => hydrogen,
        "cube" => |dims| vec![255; dims.iter().product()],
        _ => {
            return Err(Error::UnknownName { what: "built-in volume", name: name.into(), known: NAMES.into() });
        }
    };
    let for_files = [
        ("dims", options.dims.is_some()),
        ("voxel_type", options.voxel_type.is_some()),
        ("endian", options.endian.is_some()),
        ("header_bytes", options.header_bytes.is_some()),
    ];
    if let Some(&(field, _)) = for_files.iter().find(|(_, given)| *given) {
        let problem = format!("this is for files, {name} is built-in: leave it out; builtin:{name}@XxYxZ tells the size");
        return Err(Error::Settings { field, problem });
    }
    let dims = parse_size(size).ok_or_else(|| Error::OutOfRange {
        name: "size of the built-in volume",
        value: size.into(),
        expected: "N or XxYxZ, at least 1 per axis and at most 2^30 voxels",
    })?;
    let grid = options.grid(dims)?;
    memory::require(&format!("builtin:{source}"), grid.voxel_count() as u64)?;
    Volume::new(format!("builtin:{source}"), grid, sample(dims))?.with_background(0.0)
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

/// Coordinates of the voxels of each axis.
fn coordinates(dims: [usize; 3]) -> [Vec<f64>; 3] {
    dims.map(|n| (0..n).map(|i| unit_coordinate(i, n)).collect())
}

/// Densities 0 … 1 of all voxels (i, j, k) in bytes, on all cores.
fn bytes(dims: [usize; 3], density: impl Fn(usize, usize, usize) -> f64 + Sync) -> Vec<u8> {
    let mut voxels = vec![0; dims.iter().product()];
    voxels.par_chunks_mut(dims[0]).enumerate().for_each(|(row, voxels)| {
        let (j, k) = (row % dims[1], row / dims[1]);
        for (i, voxel) in voxels.iter_mut().enumerate() {
            *voxel = (density(i, j, k).clamp(0.0, 1.0) * 255.0).round() as u8;
        }
    });
    voxels
}

/// ρ(x, y, z) = (1 − sin(πz/2) + α(1 + wave(x, y))) / (2(1 + α)).
fn marschner_lobb(dims: [usize; 3]) -> Vec<u8> {
    const FREQUENCY: f64 = 6.0;
    const AMPLITUDE: f64 = 0.25;
    /// Slices from which on the wave is kept for all of them: it takes eight bytes per column.
    const MANY: usize = 8;
    let [x, y, z] = coordinates(dims);
    let wave = |i: usize, j: usize| {
        let cosine = (2.0 * PI * FREQUENCY * (PI * DVec2::new(x[i], y[j]).length() / 2.0).cos()).cos();
        AMPLITUDE * (1.0 + cosine)
    };
    let kept: Option<Vec<f64>> =
        (dims[2] >= MANY).then(|| (0..dims[0] * dims[1]).into_par_iter().map(|c| wave(c % dims[0], c / dims[0])).collect());
    let ramps: Vec<f64> = z.iter().map(|z| 1.0 - (PI * z / 2.0).sin()).collect();
    bytes(dims, |i, j, k| {
        let wave = kept.as_ref().map_or_else(|| wave(i, j), |kept| kept[i + dims[0] * j]);
        (ramps[k] + wave) / (2.0 * (1.0 + AMPLITUDE))
    })
}

/// ψ₃₂₀ ∝ r² e^{−r/3} (3cos²θ − 1), r in Bohr radii over \[−22, 22\]; |ψ| scaled to its largest value, that on the z
/// axis at r = 6.
fn hydrogen(dims: [usize; 3]) -> Vec<u8> {
    const EXTENT: f64 = 22.0;
    let psi = |r: f64, angular: f64| angular * (-r / 3.0).exp();
    let largest = psi(6.0, 72.0);
    let [x, y, z] = coordinates(dims);
    bytes(dims, |i, j, k| {
        let q = DVec3::new(x[i], y[j], z[k]) * EXTENT;
        (psi(q.length(), 2.0 * q.z * q.z - q.x * q.x - q.y * q.y) / largest).abs()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::VoxelType;

    fn values(source: &str) -> (Volume<'static>, Vec<u8>) {
        let volume = builtin_volume(source, &RawOptions::default()).unwrap();
        assert_eq!(volume.voxel_type(), VoxelType::Uint8);
        let values = (0..volume.grid().voxel_count()).map(|i| volume.value(i) as u8).collect();
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

    /// Every voxel from its definition, one by one: what is kept for many voxels, and how they are shared out, changes no byte.
    #[test]
    fn closed_forms() {
        let marschner_lobb = |p: DVec3| {
            let wave = (12.0 * PI * (PI * p.truncate().length() / 2.0).cos()).cos();
            (1.0 - (PI * p.z / 2.0).sin() + 0.25 * (1.0 + wave)) / 2.5
        };
        let hydrogen = |p: DVec3| {
            let (q, psi) = (p * 22.0, |r: f64, angular: f64| angular * (-r / 3.0).exp());
            (psi(q.length(), 2.0 * q.z * q.z - q.x * q.x - q.y * q.y) / psi(6.0, 72.0)).abs()
        };
        for dims in [[45, 45, 45], [64, 64, 64], [31, 17, 7], [1, 9, 8], [70, 1, 33]] {
            let size = format!("{}x{}x{}", dims[0], dims[1], dims[2]);
            let expected = |density: &dyn Fn(DVec3) -> f64| -> Vec<u8> {
                let [x, y, z] = dims;
                let place = |n: usize| [n % x, n / x % y, n / x / y];
                let point = |n: usize| DVec3::from_array(std::array::from_fn(|a| unit_coordinate(place(n)[a], dims[a])));
                (0..x * y * z).map(|n| (density(point(n)).clamp(0.0, 1.0) * 255.0).round() as u8).collect()
            };
            assert!(values(&format!("marschner-lobb@{size}")).1 == expected(&marschner_lobb), "marschner-lobb, {size}");
            assert!(values(&format!("hydrogen@{size}")).1 == expected(&hydrogen), "hydrogen, {size}");
        }
        let (_, hydrogen) = values("hydrogen@45");
        let at = |i: usize, j: usize, k: usize| hydrogen[(k * 45 + j) * 45 + i];
        assert_eq!((at(22, 22, 22), at(22, 22, 28)), (0, 255));
        assert_eq!(at(28, 22, 22), at(22, 16, 22));
        let (_, signal) = values("marschner-lobb@41");
        assert_eq!(signal[20 * 41 * 41 + 20 * 41 + 20], (0.6f64 * 255.0).round() as u8);
    }
}
