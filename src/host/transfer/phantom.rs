//! Transfer function of the built-in Shepp–Logan phantom. A histogram cannot find its small features.

use super::TransferFunction;
use crate::volume::Volume;

/// Voxels along an axis to which [`OPACITIES`] apply; finer volumes get lower opacities per voxel.
const VOXELS: f64 = 64.0;
/// Opacities of densities 0 … 255: surfaces of the empty ventricles, brain at 51, tumours at 77, and a faint skull. The values at
/// the skull's surfaces pass through the whole range, so opaque ranges must be narrow.
const OPACITIES: [(f64, f64); 12] = [
    (0.0, 0.0),
    (5.0, 0.0),
    (14.0, 0.2),
    (28.0, 0.2),
    (38.0, 0.006),
    (64.0, 0.006),
    (72.0, 0.25),
    (81.0, 0.25),
    (88.0, 0.0),
    (200.0, 0.0),
    (235.0, 0.07),
    (255.0, 0.07),
];
const COLORS: [(f64, [f64; 3]); 7] = [
    (0.0, [0.25, 0.5, 0.9]),
    (30.0, [0.3, 0.55, 0.95]),
    (51.0, [0.5, 0.62, 0.75]),
    (66.0, [1.0, 0.6, 0.15]),
    (86.0, [1.0, 0.45, 0.15]),
    (130.0, [0.95, 0.9, 0.8]),
    (255.0, [1.0, 0.97, 0.9]),
];

/// The phantom's transfer function; `None` for other volumes.
pub(super) fn transfer(volume: &Volume) -> Option<TransferFunction> {
    if volume.name().split('@').next() != Some("builtin:shepp-logan") {
        return None;
    }
    let longest = volume.grid().dims().into_iter().max().unwrap_or(1) as f64;
    // The same optical depth along the head at any resolution.
    let opacity = |alpha: f64| -((-alpha).ln_1p() * VOXELS / longest).exp_m1();
    let opacities = OPACITIES.iter().map(|&(value, alpha)| (value, opacity(alpha))).collect();
    TransferFunction::new("shepp-logan", COLORS.to_vec(), opacities).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OpenOptions;

    #[test]
    fn finer_heads_are_as_opaque() {
        let open = |name: &str| Volume::open(name, &OpenOptions::default()).unwrap();
        let [coarse, fine] = ["builtin:shepp-logan@32", "builtin:shepp-logan@64"].map(|name| transfer(&open(name)).unwrap());
        for value in [20.0, 51.0, 77.0, 240.0] {
            let through = |transfer: &TransferFunction, n: i32| (1.0 - transfer.opacity(value)).powi(n);
            assert!((through(&coarse, 1) - through(&fine, 2)).abs() < 1e-9, "{value}");
        }
        assert!(transfer(&open("builtin:hydrogen@8")).is_none());
        assert_eq!(TransferFunction::automatic(&open("builtin:shepp-logan@8")).name(), "shepp-logan");
    }
}
