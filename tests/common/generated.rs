//! Small volumes of bytes that stand for data sets that the tests do not have, each with a transfer function that suits it. They are computed
//! from seeds, so they are the same in every run.

use super::{Random, volume};
use glam::DVec3;
use layersplat::volume::Voxels;
use layersplat::{TransferFunction, Volume};

/// A name, a volume and its transfer function.
pub type Generated = (&'static str, Volume<'static>, TransferFunction);

pub fn all() -> [Generated; 3] {
    [noise(), walnut(), mr()]
}

/// Two smooth bodies that touch, under noise whose standard deviation is a tenth of their contrast.
pub fn noise() -> Generated {
    const DEVIATION: f64 = 18.0;
    let bodies = [(DVec3::new(-0.2, 0.1, 0.05), 0.75), (DVec3::new(0.45, -0.15, -0.1), 0.5)];
    let mut random = Random(51);
    let volume = voxels([64; 3], |p, _| {
        let smooth: f64 = bodies.iter().map(|&(centre, radius)| falling((p - centre).length() / radius)).sum();
        20.0 + 180.0 * smooth.min(1.0) + DEVIATION * normal(&mut random)
    });
    let colors = vec![(60.0, [0.2, 0.3, 0.8]), (130.0, [0.9, 0.7, 0.4]), (220.0, [0.95, 0.95, 0.9])];
    ("noise", volume, transfer("noise", colors, vec![(80.0, 0.0), (110.0, 0.15), (200.0, 0.6)]))
}

/// A wrinkled shell around a thin membrane around a folded kernel in two halves. Correlated noise, as a CT reconstruction has, and only every
/// fourth byte, as where a wide range of densities is stored in bytes.
pub fn walnut() -> Generated {
    const TERRACE: f64 = 4.0;
    const DEVIATION: f64 = 3.0;
    let mut random = Random(52);
    // Neighbours along x are correlated.
    let mut before = 0.0;
    let volume = voxels([80; 3], |p, voxel| {
        let radius = p.length();
        let d = p / radius.max(1e-6);
        let wrinkles = (9.0 * d.x + 2.0 * (5.0 * d.y).sin()).sin() * (8.0 * d.y + 1.7 * (6.0 * d.z).sin()).sin();
        let folds = (13.0 * d.z + 3.0 * (7.0 * d.x).sin()).sin() * (11.0 * d.y + 2.0 * (9.0 * d.z).cos()).cos();
        let inside = |surface: f64| ramp((surface - radius) / voxel);
        let hull = inside(0.88 + 0.035 * wrinkles) - inside(0.80 + 0.03 * wrinkles);
        let membrane = inside(0.74 + 0.03 * wrinkles) - inside(0.705 + 0.03 * wrinkles);
        let septum = ramp(((p.x + 0.06 * (5.0 * p.y).sin()).abs() - 0.05) / voxel);
        let kernel = (inside(0.58 + 0.07 * folds) - 0.35 * inside(0.46 + 0.09 * folds)) * septum;
        let fresh = normal(&mut random);
        let noise = DEVIATION * (0.8 * fresh + 0.6 * before);
        before = fresh;
        let density = 24.0 + 170.0 * hull + 90.0 * membrane + 130.0 * kernel + noise;
        (density / TERRACE).round() * TERRACE
    });
    let colors = vec![(50.0, [0.5, 0.3, 0.15]), (120.0, [0.9, 0.75, 0.5]), (200.0, [0.7, 0.5, 0.3])];
    ("walnut", volume, transfer("walnut", colors, vec![(55.0, 0.0), (90.0, 0.15), (130.0, 0.35), (180.0, 0.12), (255.0, 0.12)]))
}

/// A head of scalp, skull, fluid, grey and white matter, and ventricles, under a smooth bias field and the noise of magnitude images, which is
/// Rician.
pub fn mr() -> Generated {
    const DEVIATION: f64 = 5.0;
    let mut random = Random(53);
    let volume = voxels([72, 76, 80], |p, voxel| {
        let head = 1.0 - (p / DVec3::new(0.78, 0.9, 0.88)).length();
        let nose = 0.35 * (1.0 - ((p - DVec3::new(0.0, -0.1, 0.82)) / DVec3::new(0.14, 0.2, 0.16)).length());
        let folds = (11.0 * p.x + 2.0 * (6.0 * p.y).sin()).sin() * (10.0 * p.z + 2.0 * (7.0 * p.y).sin()).sin();
        let ventricle = 1.0 - ((p - DVec3::new(0.12 * p.x.signum(), 0.1, 0.0)) / DVec3::new(0.08, 0.14, 0.3)).length();
        let tissues = [
            (head.max(nose), 190.0),
            (head - 0.08, 22.0),
            (head - 0.16, 48.0),
            (head - 0.2 - 0.02 * folds, 112.0),
            (head - 0.32 - 0.05 * folds, 158.0),
            (0.2 * ventricle, 45.0),
        ];
        // Each tissue replaces the one around it across two voxels.
        let clean = tissues.iter().fold(0.0, |outer, &(depth, value)| outer + (value - outer) * ramp(0.5 * depth / voxel));
        let bias = 1.0 + 0.2 * p.x - 0.15 * p.z * p.z + 0.12 * p.y;
        let [real, imaginary] = [clean * bias, 0.0].map(|part| part + DEVIATION * normal(&mut random));
        real.hypot(imaginary)
    });
    let colors = vec![(30.0, [0.3, 0.2, 0.3]), (90.0, [0.8, 0.5, 0.4]), (150.0, [0.95, 0.85, 0.7]), (230.0, [1.0, 0.95, 0.9])];
    ("mr", volume, transfer("mr", colors, vec![(28.0, 0.0), (60.0, 0.02), (110.0, 0.2), (150.0, 0.3), (190.0, 0.15)]))
}

/// Bytes of values at points from −1 to 1 along each axis, and the size of a voxel of the longest axis there.
fn voxels(dims: [usize; 3], mut value: impl FnMut(DVec3, f64) -> f64) -> Volume<'static> {
    let voxel = 2.0 / dims.into_iter().max().expect("three axes") as f64;
    let at = |i: usize, n: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
    let [nx, ny, _] = dims;
    let place = |n: usize| DVec3::new(at(n % nx, dims[0]), at(n / nx % ny, dims[1]), at(n / (nx * ny), dims[2]));
    let bytes = (0..dims.iter().product()).map(|n| value(place(n), voxel).round().clamp(0.0, 255.0) as u8).collect();
    volume(dims, DVec3::ONE, Voxels::Uint8(bytes))
}

fn transfer(name: &str, colors: Vec<(f64, [f64; 3])>, opacities: Vec<(f64, f64)>) -> TransferFunction {
    TransferFunction::new(name, colors, opacities).expect("ascending values")
}

/// Nearly normal numbers of variance 1: the sum of twelve uniform ones.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

/// From 0 at −½ to 1 at ½, linear.
fn ramp(x: f64) -> f64 {
    (x + 0.5).clamp(0.0, 1.0)
}

/// From 1 in the centre to 0 at 1.
fn falling(radius: f64) -> f64 {
    let left = 1.0 - radius.min(1.0).powi(2);
    left * left
}
