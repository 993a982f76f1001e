//! Built-in volumes: closed-form densities, sampled on grids of any size.

mod phantom;
mod surfaces;

use super::storage::{Made, Storage};
use super::{Grid, OpenOptions, Volume, VoxelType};
use crate::error::Error;
use crate::memory;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Names of the built-in volumes.
#[doc(hidden)]
pub const BUILTIN: [&str; 6] = ["marschner-lobb", "hydrogen", "shepp-logan", "gyroid", "torus-knot", "cube"];
const NAMES: &str = "marschner-lobb, hydrogen, shepp-logan, gyroid, torus-knot or cube";
/// Largest size of a built-in volume, equal to 2048³ voxels.
const MAX_VOXELS: usize = 1 << 33;
/// Volumes of up to this many voxels are stored; voxels of larger ones are computed on access.
const MOST_KEPT: usize = 1 << 28;

/// Opens the built-in volume `NAME`, `NAME@N` or `NAME@XxYxZ`, by default with 64³ voxels. Voxels are uint8 densities and the
/// background is 0. Of `options`, only the spacing applies. Volumes of more than 2^28 voxels are computed on access, not stored.
///
/// * `marschner-lobb`: the test signal of Marschner & Lobb (1994), f_M = 6, α = 0.25, on \[−1, 1\]³.
/// * `hydrogen`: density of hydrogen's 3d_z² orbital. Its square root is stored, so that both lobes and the ring are visible.
/// * `shepp-logan`: ellipsoids of the head phantom on \[−1, 1\]³ (Kak & Slaney 1988), with Toft's (1996) contrasts: skull 1, brain 0.2.
/// * `gyroid`: the surface sin x cos y + sin y cos z + sin z cos x = 0 with a thickness, two and a half periods per axis, in a ball.
/// * `torus-knot`: a trefoil: a tube around a line that winds three times around a torus in two revolutions.
/// * `cube`: the constant 255, a homogeneous cube.
///
/// # Errors
/// If the name is unknown, the size is invalid, or `options` has fields that apply to files only.
pub fn builtin_volume(source: &str, options: &OpenOptions) -> Result<Volume<'static>, Error> {
    let (name, grid, voxels) = sampled(source, options)?;
    let storage = if voxels.len() > MOST_KEPT {
        Storage::made(voxels, VoxelType::Uint8)
    } else {
        layers(&name, &*voxels, grid.dims(), &(0..grid.dims()[2]))?.into()
    };
    Volume::new(name, grid, storage)?.with_background(0.0)
}

/// Name, grid and voxel generator of a built-in volume.
pub(super) fn sampled(source: &str, options: &OpenOptions) -> Result<(String, Grid, Arc<dyn Made>), Error> {
    let (name, size) = source.split_once('@').unwrap_or((source, "64"));
    let sampled: fn([usize; 3]) -> Arc<dyn Made> = match name {
        "marschner-lobb" => marschner_lobb,
        "hydrogen" => hydrogen,
        "shepp-logan" => phantom::shepp_logan,
        "gyroid" => surfaces::gyroid,
        "torus-knot" => surfaces::torus_knot,
        "cube" => |dims| made(dims, |_, _, _| 1.0),
        _ => {
            return Err(Error::UnknownName { what: "built-in volume", name: name.into(), known: NAMES.into() });
        }
    };
    let for_files = [
        ("dims", options.dims.is_some()),
        ("voxel_type", options.voxel_type.is_some()),
        ("endian", options.endian.is_some()),
        ("header_bytes", options.header_bytes.is_some()),
        ("frame", options.frame.is_some()),
        ("channel", options.channel.is_some() || options.channel_name.is_some() || options.magnitude),
        ("array", options.array.is_some()),
        ("region", options.region.is_some()),
    ];
    if let Some(&(field, _)) = for_files.iter().find(|(_, given)| *given) {
        let problem = format!("applies to files only, and {name} is built-in: omit it; builtin:{name}@XxYxZ sets the size");
        return Err(Error::Settings { field, problem });
    }
    let dims = parse_size(size).ok_or_else(|| Error::OutOfRange {
        name: "size of the built-in volume",
        value: size.into(),
        expected: "N or XxYxZ, at least 1 per axis and at most 2^33 voxels",
    })?;
    Ok((format!("builtin:{source}"), options.grid(dims)?, sampled(dims)))
}

/// Voxels of a range of z layers, computed on all cores.
pub(super) fn layers(name: &str, voxels: &dyn Made, [x, y, _]: [usize; 3], layers: &Range<usize>) -> Result<Vec<u8>, Error> {
    const PIECE: usize = 1 << 16;
    let first = x * y * layers.start;
    let mut bytes = memory::zeroed(name, x * y * layers.len())?;
    bytes.par_chunks_mut(PIECE).enumerate().for_each(|(n, piece)| voxels.make(first + n * PIECE, piece));
    Ok(bytes)
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

/// Coordinate of voxel `i` of `n` in \[−1, 1\]; 0 if there is only one voxel.
fn unit_coordinate(i: usize, n: usize) -> f64 {
    if n == 1 { 0.0 } else { 2.0 * i as f64 / (n as f64 - 1.0) - 1.0 }
}

/// Coordinates of the voxels along each axis.
fn coordinates(dims: [usize; 3]) -> [Vec<f64>; 3] {
    dims.map(|n| (0..n).map(|i| unit_coordinate(i, n)).collect())
}

/// A generator of uint8 voxels from a density 0 … 1 at voxel (i, j, k).
struct Sampled<D> {
    dims: [usize; 3],
    density: D,
}

fn made(dims: [usize; 3], density: impl Fn(usize, usize, usize) -> f64 + Send + Sync + 'static) -> Arc<dyn Made> {
    Arc::new(Sampled { dims, density })
}

impl<D: Fn(usize, usize, usize) -> f64 + Send + Sync> Made for Sampled<D> {
    fn len(&self) -> usize {
        self.dims.iter().product()
    }

    fn make(&self, first: usize, bytes: &mut [u8]) {
        let [x, y, _] = self.dims;
        let (mut at, mut bytes) = (first, bytes);
        while !bytes.is_empty() {
            let (i, row) = (at % x, at / x);
            let (here, rest) = bytes.split_at_mut((x - i).min(bytes.len()));
            for (i, voxel) in (i..).zip(here.iter_mut()) {
                *voxel = ((self.density)(i, row % y, row / y).clamp(0.0, 1.0) * 255.0).round() as u8;
            }
            (at, bytes) = (at + here.len(), rest);
        }
    }
}

/// A function of the voxel's column (i, j), computed once per column where that saves time.
fn kept_columns<T: Copy + Send + Sync>(
    dims: [usize; 3],
    column: impl Fn(usize, usize) -> T + Send + Sync,
) -> impl Fn(usize, usize) -> T + Send + Sync {
    /// Fewest slices for which columns are kept, and most columns: each takes up to 24 bytes.
    const MANY: usize = 8;
    const MOST_COLUMNS: usize = 1 << 24;
    let columns = dims[0] * dims[1];
    let kept: Option<Vec<T>> = (dims[2] >= MANY && columns <= MOST_COLUMNS)
        .then(|| (0..columns).into_par_iter().map(|c| column(c % dims[0], c / dims[0])).collect());
    move |i, j| kept.as_ref().map_or_else(|| column(i, j), |kept| kept[i + dims[0] * j])
}

/// ρ(x, y, z) = (1 − sin(πz/2) + α(1 + wave(x, y))) / (2(1 + α)).
fn marschner_lobb(dims: [usize; 3]) -> Arc<dyn Made> {
    const FREQUENCY: f64 = 6.0;
    const AMPLITUDE: f64 = 0.25;
    let [x, y, z] = coordinates(dims);
    let wave = move |i: usize, j: usize| {
        let cosine = (2.0 * PI * FREQUENCY * (PI * DVec2::new(x[i], y[j]).length() / 2.0).cos()).cos();
        AMPLITUDE * (1.0 + cosine)
    };
    let wave = kept_columns(dims, wave);
    let ramps: Vec<f64> = z.iter().map(|z| 1.0 - (PI * z / 2.0).sin()).collect();
    made(dims, move |i, j, k| (ramps[k] + wave(i, j)) / (2.0 * (1.0 + AMPLITUDE)))
}

/// ψ₃₂₀ ∝ r² e^{−r/3} (3cos²θ − 1) with r in Bohr radii over \[−22, 22\]. |ψ| is scaled by its maximum, which lies on the z axis at
/// r = 6.
fn hydrogen(dims: [usize; 3]) -> Arc<dyn Made> {
    const EXTENT: f64 = 22.0;
    let psi = |r: f64, angular: f64| angular * (-r / 3.0).exp();
    let largest = psi(6.0, 72.0);
    let [x, y, z] = coordinates(dims);
    made(dims, move |i, j, k| {
        let q = DVec3::new(x[i], y[j], z[k]) * EXTENT;
        (psi(q.length(), 2.0 * q.z * q.z - q.x * q.x - q.y * q.y) / largest).abs()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(source: &str) -> (Volume<'static>, Vec<u8>) {
        let volume = builtin_volume(source, &OpenOptions::default()).unwrap();
        assert_eq!(volume.voxel_type(), VoxelType::Uint8);
        let values = (0..volume.grid().voxel_count()).map(|i| volume.value(i) as u8).collect();
        (volume, values)
    }

    #[test]
    fn sizes() {
        assert!(BUILTIN.iter().all(|name| NAMES.contains(name) && values(&format!("{name}@2")).1.len() == 8));
        assert_eq!(values("cube@3x4x5").0.grid().dims(), [3, 4, 5]);
        assert_eq!(values("cube@2").1, vec![255; 8]);
        assert_eq!(values("hydrogen").0.grid().dims(), [64; 3]);
        assert_eq!(values("marschner-lobb@1").1.len(), 1);
        for bad in ["cube@0", "cube@2x2", "cube@", "cube@-1", "cube@100000x100000x1", "sphere"] {
            assert!(builtin_volume(bad, &OpenOptions::default()).is_err(), "{bad}");
        }
    }

    /// Computed and stored volumes are equal: as a whole, in rows from any voxel, and in boxes.
    #[test]
    fn made_or_kept() {
        let dims = [31, 17, 20];
        let grid = Grid::new(dims, DVec3::ONE).unwrap();
        for sampled in [marschner_lobb, hydrogen, phantom::shepp_logan, surfaces::gyroid, surfaces::torus_knot] {
            let bytes = layers("kept", &*sampled(dims), dims, &(0..dims[2])).unwrap();
            let made = Volume::new("made", grid.clone(), Storage::made(sampled(dims), VoxelType::Uint8)).unwrap();
            let kept = Volume::new("kept", grid.clone(), bytes.as_slice()).unwrap();
            assert_eq!((made.range(), made.statistics()), (kept.range(), kept.statistics()));
            for (first, len) in [(0, 1), (30, 2), (500, 1700), (bytes.len() - 40, 40)] {
                let mut some = vec![0; len];
                sampled(dims).make(first, &mut some);
                assert_eq!(some, bytes[first..first + len], "{len} from {first} on");
            }
            let (first, box_dims) = ([3, 5, 2], [11, 9, 16]);
            let voxels = |volume: &Volume| {
                let mut found = Vec::new();
                volume.part(first, box_dims).unwrap().held().for_each_piece(|at, piece| {
                    assert_eq!(at, found.len());
                    found.extend_from_slice(piece);
                    Ok::<(), Error>(())
                })?;
                Ok::<_, Error>(found)
            };
            assert!(voxels(&made).unwrap() == voxels(&kept).unwrap());
            assert_eq!(made.column_ranges([5, 2], [9, 9]), kept.column_ranges([5, 2], [9, 9]));
            assert!((0..bytes.len()).step_by(37).all(|n| made.value(n) == f64::from(bytes[n])));
        }
    }

    /// Evaluates the definition at every voxel: precomputation and threads must not change a byte.
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
