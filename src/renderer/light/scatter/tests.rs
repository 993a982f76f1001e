//! Light that scatters between cells, against closed forms and a computation in one dimension.

use super::*;
use crate::device::LatticeSchedule;
use crate::volume::Grid;

/// Blocks of 2³ voxels with this optical depth along an edge, albedo, and direct light.
fn blocks(grids: &ScatterGrids, medium: impl Fn([usize; 3]) -> (f64, f64, f64)) -> Vec<f32> {
    let [x, y, z] = grids.blocks;
    let count = x * y * z;
    let mut all = vec![0.0; MEDIUM_PLANES * count];
    for n in 0..count {
        let (depth, albedo, direct) = medium([n % x, n / x % y, n / x / y]);
        all[n] = depth as f32;
        for c in 0..3 {
            all[(1 + c) * count + n] = (depth * albedo) as f32;
            all[(4 + c) * count + n] = (depth * direct) as f32;
        }
    }
    all
}

/// Mean radiance of red in each cell, and the shares of its flux, of the light field.
fn field(packed: &[u8], cells: usize) -> Vec<(f64, DVec3)> {
    let word = |n: usize| u32::from_le_bytes(packed[4 * n..4 * n + 4].try_into().unwrap());
    let of_cell = |n: usize| {
        let radiance = word(4 * n);
        let red = f64::from(radiance & 511) * 2f64.powi((radiance >> 27) as i32 - 15 - 9);
        (red, DVec3::from_array([1, 2, 3].map(|axis| (f64::from(word(4 * n + axis) & 1023) - 511.0) / 511.0)))
    };
    (0..cells).map(of_cell).collect()
}

/// Levels of the light of some grids.
type Levels = fn(&ScatterGrids) -> Vec<(CellGrid, usize)>;
const BOTH: Levels = |grids| levels(grids, LightGrid::Full);
const COARSE: Levels = |grids| levels(grids, LightGrid::Quarter);
const CONVERGED: Levels = |grids| vec![(grids.fine, 60)];

fn solve(
    dims: [usize; 3],
    sky: impl Fn(DVec3) -> f64,
    levels: Levels,
    medium: impl Fn([usize; 3]) -> (f64, f64, f64),
) -> (CellGrid, Vec<(f64, DVec3)>) {
    solve_on(&Device::shared(), dims, sky, levels, medium)
}

fn solve_on(
    device: &Device,
    dims: [usize; 3],
    sky: impl Fn(DVec3) -> f64,
    levels: Levels,
    medium: impl Fn([usize; 3]) -> (f64, f64, f64),
) -> (CellGrid, Vec<(f64, DVec3)>) {
    let grids = ScatterGrids::new(&Grid::new(dims, DVec3::ONE).unwrap(), LightGrid::Full);
    let blocks = Buffer::from_slice(device, &blocks(&grids, medium), CELLS).unwrap();
    let levels = levels(&grids);
    let grid = levels.last().unwrap().0;
    let packed = Buffer::new(device, packed_bytes(grid), CELLS).unwrap();
    let pairs = OrdinatePair::all().into_iter();
    let entering = pairs.map(|pair| [-pair.direction(), pair.direction()].map(|from| DVec3::splat(sky(from)))).collect();
    let mut kernels = ScatterKernels::default();
    let mut scattering = Scattering { device, kernels: &mut kernels, grids, entering, scattering: 1.0 };
    scattering.solve(&blocks, &levels, &packed).unwrap();
    let mut bytes = vec![0; packed.len()];
    packed.read(device, &mut bytes).unwrap();
    (grid, field(&bytes, grid.cells()))
}

/// Nine bits of the radiance, and the quadrature's rounding.
const ROUNDED: f64 = 1e-3;

#[test]
fn in_a_furnace_light_is_everywhere_the_same() {
    let ball = |dims: [usize; 3]| {
        move |at: [usize; 3]| {
            let p = DVec3::from_array(at.map(|n| n as f64)) - DVec3::from_array(dims.map(|n| n as f64)) / 4.0;
            (if p.length() < 12.0 { 3.0 } else { 0.01 }, 1.0, 0.0)
        }
    };
    for dims in [[65, 63, 64], [7, 50, 31], [1, 1, 40], [90, 1, 1]] {
        for levels in [BOTH, COARSE] {
            let (_, light) = solve(dims, |_| 1.0, levels, ball(dims));
            for (radiance, share) in light {
                assert!((radiance - 1.0).abs() < ROUNDED && share.length() < 5e-3, "{dims:?}: {radiance}, {share}");
            }
        }
    }
}

/// The radiance that leaves layers of this optical depth and mean radiance at a cosine.
fn leaving(albedo: f64, depth: f64, cosine: f64, radiances: impl Iterator<Item = f64>) -> f64 {
    let kept = (-depth / cosine).exp();
    radiances.enumerate().map(|(k, radiance)| kept.powi(k as i32) * (1.0 - kept) * albedo * radiance).sum()
}

/// A half-space under a sky of 1, of cells of this optical depth along z: the radiance that leaves it at a cosine.
fn seen(albedo: f64, depth: f64, levels: Levels, cosines: [f64; 2]) -> [f64; 2] {
    let (grid, light) = solve([128; 3], |_| 1.0, levels, |_| (depth, albedo, 0.0));
    let [x, y, z] = grid.dims;
    let column = (0..z).map(|k| light[(k * y + y / 2) * x + x / 2].0);
    cosines.map(|cosine| leaving(albedo, depth * grid.edge / 2.0, cosine, column.clone()))
}

/// I = 1 - √(1 - ω) H(μ) (Chandrasekhar), with the mean of each cell for what is in it. 14 ordinates allow 0.015 at 1/√3.
#[test]
fn half_spaces_reflect_what_they_should() {
    // The deeper light comes from, the wider the volume must be: its sides are open.
    for (albedo, depth, expected) in [(0.5, 0.2, [0.1152, 0.1509]), (0.9, 0.25, [0.4149, 0.4907])] {
        for (levels, allowed) in [(CONVERGED, [0.01, 0.015]), (BOTH, [0.03, 0.03])] {
            let found = seen(albedo, depth, levels, [1.0, 3f64.sqrt().recip()]);
            println!("{albedo}: {found:?} {expected:?}");
            for n in 0..2 {
                assert!((found[n] - expected[n]).abs() < allowed[n], "{albedo}: {found:?}, not {expected:?}");
            }
        }
    }
}

/// After n plain iterations from no light on, a half-space has the radiance of n bounces: of 14 ordinates in one dimension, with f64.
#[test]
fn each_sweep_adds_a_bounce() {
    const ALBEDO: f64 = 0.9;
    const DEPTH: f64 = 0.5;
    // The table has three digits; the sides are open, 16 optical depths away.
    const ALLOWED: f64 = 1e-3;
    let device = Device::shared();
    let grids = ScatterGrids::new(&Grid::new([128; 3], DVec3::ONE).unwrap(), LightGrid::Full);
    let (grid, params) = (grids.fine, grids.fine.params());
    let blocks = Buffer::from_slice(&device, &blocks(&grids, |_| (DEPTH, ALBEDO, 0.0)), CELLS).unwrap();
    let packed = Buffer::new(&device, packed_bytes(grid), CELLS).unwrap();
    let mut kernels = ScatterKernels::default();
    let dark = vec![[DVec3::ZERO; 2]; OrdinatePair::all().len()];
    let mut scattering = Scattering { device: &device, kernels: &mut kernels, grids, entering: dark, scattering: 1.0 };
    let cells = scattering.cells(grid, &blocks, None).unwrap();
    let (mut radiance, mut older) = (scattering.radiance(grid).unwrap(), scattering.radiance(grid).unwrap());
    scattering.scatter(&cells, true, [&radiance, &older], (0.0, 0.0)).unwrap();
    scattering.entering.fill([DVec3::ONE; 2]);
    let pitch = params.plane(device.tuning()) / (grid.dims[1] * grid.dims[2]);
    let mut mean = vec![0.0f32; cells.mean.len()];
    let mut done = 0;
    for (bounces, expected) in [(1, 0.125), (2, 0.202), (4, 0.289), (8, 0.358), (16, 0.394), (60, 0.405)] {
        for _ in done..bounces {
            scattering.sweep(&cells, &packed).unwrap();
            scattering.scatter(&cells, false, [&radiance, &older], (1.0, 1.0)).unwrap();
            std::mem::swap(&mut radiance, &mut older);
        }
        done = bounces;
        cells.mean.read(&device, &mut mean).unwrap();
        let [x, y, z] = grid.dims;
        let column = (0..z).map(|k| f64::from(mean[(k * y + y / 2) * pitch + x / 2]));
        let found = leaving(ALBEDO, DEPTH, 1.0, column);
        assert!((found - expected).abs() < ALLOWED, "{bounces} bounces: {found}, not {expected}");
    }
}

/// Radiance falls exponentially in a medium that absorbs, and comes from the side of the sky; whatever the schedule, and however many blocks
/// of rows and groups of layers there are.
#[test]
fn absorbing_slabs_dim_the_light_of_each_ordinate() {
    const DEPTH: f64 = 0.05;
    let own = Device::shared();
    let samples = Tuning { lattice_schedule: LatticeSchedule::Samples, ..*own.tuning() };
    let devices = [own.clone(), own.with_tuning(samples).unwrap()];
    for step in OrdinatePair::all().into_iter().flat_map(|pair| [pair.step, pair.step.map(|n| -n)]) {
        let to_light = -DVec3::from_array(step.map(f64::from)).normalize();
        let weight = if step.iter().filter(|&&n| n != 0).count() == 1 { 1.0 / 15.0 } else { 3.0 / 40.0 };
        let length = DVec3::from_array(step.map(f64::from)).length() * DEPTH;
        for device in &devices {
            let sky = |from: DVec3| if from.dot(to_light) > 0.99 { 1.0 } else { 0.0 };
            let (grid, light) = solve_on(device, [40, 76, 24], sky, BOTH, |_| (DEPTH, 0.0, 0.0));
            let [x, y, _] = grid.dims;
            for (n, (radiance, share)) in light.into_iter().enumerate() {
                let cell = [n % x, n / x % y, n / (x * y)];
                // Cells that the light has crossed.
                let of_axis = |i: usize| match step[i] {
                    0 => usize::MAX,
                    1 => cell[i],
                    _ => grid.dims[i] - 1 - cell[i],
                };
                let crossed = (0..3).map(of_axis).min().unwrap() as f64;
                let expected = weight * (-length * crossed).exp() * (1.0 - (-length).exp()) / length;
                let apart = (share - to_light).length();
                assert!(
                    (radiance / expected - 1.0).abs() < 0.003 && apart < 0.01,
                    "{step:?} at {cell:?}: {radiance}, not {expected}; {share}"
                );
            }
        }
    }
}
