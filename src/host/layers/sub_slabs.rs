//! Layer samples from the splat sums of three layers: κ, and its refinement by sub-slabs.

use super::kernel_function::kernel_integral;
use crate::choice::choices;

/// Correction for the overlap of kernels with adjacent layers.
///
/// ```
/// use layersplat::Correction;
/// use layersplat::settings::{Classification, Layered, Settings};
///
/// // The paper's method: splatted layers with the constant factors 3/32, 13/16, 3/32.
/// let classification = Classification::Post(Correction::Constant);
/// let settings = Settings::from(Layered { classification, ..layersplat::Quality::Paper.layered() });
/// assert!(settings.layered().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// No correction: the splat sum of the layer alone (paper, Fig. 2 right).
    None,
    /// The paper's constant κ = 3/32, 13/16, 3/32 (§3.2): one sample per layer.
    Constant,
    /// This many sub-slabs per layer (1 … 16), each with its own weights. This project's own; κ is the case of one.
    SubLayers(u32),
}

choices! { Correction, "correction"; None = "none", Constant = "constant", SubLayers(2) = "sublayers" }

impl Correction {
    /// Largest number of sub-slabs per layer.
    pub const MAX_SUB_LAYERS: u32 = 16;

    /// Samples per layer.
    pub fn samples_per_layer(self) -> u32 {
        match self {
            Correction::None | Correction::Constant => 1,
            Correction::SubLayers(n) => n,
        }
    }
}

/// A sample of a layer: weights of the splat sums of the previous, this and the next layer along the ray, which sum to 1, and its
/// thickness. Thickness is relative to 1/N, for which the opacity table is made: 1, or ½ if the support ends inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubSlab {
    /// Weight of the previous layer along the ray.
    pub before: f64,
    /// Weight of this layer.
    pub own: f64,
    /// Weight of the next layer along the ray.
    pub after: f64,
    /// Thickness relative to 1/N layers.
    pub share: f64,
}

/// Sub-slabs of inner layers and of the two outer layers, front to back.
///
/// The reconstructed field ends one voxel beyond the first and the last voxel, in the middle of layers −1 and n. Only the inner halves of
/// these two layers count.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerSlabs {
    /// Layers 0 … n−1.
    pub inner: Vec<SubSlab>,
    /// First outer layer along the ray.
    pub front: Vec<SubSlab>,
    /// Last outer layer along the ray.
    pub back: Vec<SubSlab>,
}

impl LayerSlabs {
    /// Sub-slabs of a correction.
    pub fn new(correction: Correction) -> Self {
        Self { inner: slabs(correction, -0.5, 0.5), front: slabs(correction, 0.0, 0.5), back: slabs(correction, -0.5, 0.0) }
    }
}

/// Sub-slabs of one layer, clipped to `[lo, hi]`, in the order of a ray towards +z.
fn slabs(correction: Correction, lo: f64, hi: f64) -> Vec<SubSlab> {
    let n = correction.samples_per_layer();
    let edge = |i: u32| f64::from(i) / f64::from(n) - 0.5;
    (0..n)
        .map(|i| (edge(i).max(lo), edge(i + 1).min(hi)))
        .filter(|(z0, z1)| z1 - z0 > 1e-9)
        .map(|(z0, z1)| {
            let share = (z1 - z0) * f64::from(n);
            let mean = |shift: f64| (kernel_integral(z1 + shift) - kernel_integral(z0 + shift)) / (z1 - z0);
            match correction {
                Correction::None => SubSlab { before: 0.0, own: 1.0, after: 0.0, share },
                _ => SubSlab { before: mean(1.0), own: mean(0.0), after: mean(-1.0), share },
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn one_slab_is_the_papers_kappa() {
        let slab = LayerSlabs::new(Correction::Constant).inner[0];
        assert_abs_diff_eq!(slab.before, 3.0 / 32.0, epsilon = 1e-15);
        assert_abs_diff_eq!(slab.own, 13.0 / 16.0, epsilon = 1e-15);
        assert_abs_diff_eq!(slab.after, 3.0 / 32.0, epsilon = 1e-15);
        assert_eq!(LayerSlabs::new(Correction::SubLayers(1)), LayerSlabs::new(Correction::Constant));
    }

    #[test]
    fn weights_of_two_and_four_slabs() {
        let two = LayerSlabs::new(Correction::SubLayers(2)).inner;
        assert_abs_diff_eq!(two[0].before, 0.1875, epsilon = 1e-12);
        assert_abs_diff_eq!(two[0].own, 0.8125, epsilon = 1e-12);
        let four = LayerSlabs::new(Correction::SubLayers(4)).inner;
        for (slab, own) in four.iter().zip([0.6797, 0.9453, 0.9453, 0.6797]) {
            assert_abs_diff_eq!(slab.own, own, epsilon = 5e-5);
        }
    }

    #[test]
    fn every_layer_spreads_its_splat_sum_with_total_weight_one() {
        for n in 1..=Correction::MAX_SUB_LAYERS {
            let slabs = LayerSlabs::new(Correction::SubLayers(n));
            let thickness = |s: &SubSlab| s.share / f64::from(n);
            for s in slabs.inner.iter().chain(&slabs.front).chain(&slabs.back) {
                assert_abs_diff_eq!(s.before + s.own + s.after, 1.0, epsilon = 1e-12);
            }
            let own: f64 = slabs.inner.iter().map(|s| s.own * thickness(s)).sum();
            let before: f64 = slabs.inner.iter().map(|s| s.before * thickness(s)).sum();
            let after: f64 = slabs.inner.iter().map(|s| s.after * thickness(s)).sum();
            assert_abs_diff_eq!(own + before + after, 1.0, epsilon = 1e-12);
            // Voxel layer 0 contributes to the outer layer in front of it as much as to an inner one.
            let outer: f64 = slabs.front.iter().map(|s| s.after * thickness(s)).sum();
            assert_abs_diff_eq!(outer, after, epsilon = 1e-12);
            let total: f64 = slabs.back.iter().map(thickness).sum();
            assert_abs_diff_eq!(total, 0.5, epsilon = 1e-12);
        }
    }
}
