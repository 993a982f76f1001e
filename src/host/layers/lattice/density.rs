//! Sample density of lattices.

/// Sample density for voxels smaller than pixels, about as large, and much larger.
struct Rule {
    /// Samples per pixel while `per_voxel` is not reached. Hard edges need more than one.
    per_pixel: f64,
    /// Samples per voxel that suffice for the detail of the kernel, while they are at most `pixels` apart.
    per_voxel: f64,
    /// Largest distance between samples in pixels.
    pixels: f64,
}

/// Measured: aneurism (1.16 pixels per voxel) 33.1 dB with 1 sample per voxel, 34.4 dB with 1 per pixel, 38.5 dB with 1.6. Neghip
/// (4.7 pixels per voxel): 51.7 dB with samples 2 pixels apart, 52.1 dB with 1.6.
const RELAXED: Rule = Rule { per_pixel: 1.6, per_voxel: 1.86, pixels: 2.0 };
const FINE: Rule = Rule { per_pixel: 2.1, per_voxel: 2.35, pixels: 1.7 };

/// Samples per pixel of [`Density::Screen`] where they are not aligned with pixels. Measured: opaque surfaces with hard edges (neghip, 7 pixels
/// per voxel, rolled by 20°) 35.6 and 35.8 dB with samples 2 pixels apart, 43.5 and 46.4 dB with these and one sample per pixel along the rays.
const SCREEN_PER_PIXEL: f64 = 1.6;

/// Samples per pixel along one axis if samples are aligned with pixels along the other, which removes half of the error. Measured with
/// lighting: aneurism stays at 41 dB and improves from 45 to 46 dB, engine from 47.5 to 48.9 dB and from 52.5 to 54.9 dB.
const RELAXED_BESIDE_PIXELS: f64 = 1.4;
const FINE_BESIDE_PIXELS: f64 = 1.95;

/// Columns per pixel if they have samples where rows of pixels cross them at any angle, and the largest number in columns of a lattice without
/// such samples. Measured with lighting in a view from 60° above, rolled by 20°: lobster, engine and aneurism have 51.8, 47.6, 41.1 dB without
/// such samples, 51.8, 48.2, 40.4 with 1.4 columns (and at most 1), 52.1, 48.4, 41.2 with 1.6, 52.2, 48.5, 41.7 with 1.7.
const RELAXED_CROSSED_PER_PIXEL: f64 = 1.7;
const FINE_CROSSED_PER_PIXEL: f64 = 2.2;
pub(super) const MOST_CROSSED: f64 = 1.3;

/// Sample density of a lattice, in samples per voxel along either axis of a layer. This project's own; the paper samples per pixel.
///
/// ```
/// use layersplat::Density;
/// use layersplat::settings::{Evaluation, Layered, Settings};
///
/// // Two samples per voxel along either axis of a layer.
/// let layered = Layered { evaluation: Evaluation::Lattice(Density::Fixed(2)), ..Layered::default() };
/// assert!(Settings::from(layered).layered().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// At least the density of the screen, and at least this many samples per voxel.
    AtLeast(u32),
    /// Denser than the screen for small voxels, coarser for large ones: up to 1.6 samples per pixel, up to 1.86 per voxel, at most 2
    /// pixels apart. The kernel has no finer detail, and the warp interpolates. In views with little roll, with voxels of 1 to about
    /// 1.86 pixels, samples coincide with pixels instead along one or both axes.
    Relaxed,
    /// As [`Relaxed`](Self::Relaxed), with up to 2.1 samples per pixel, up to 2.35 per voxel, at most 1.7 pixels apart.
    Fine,
    /// Denser than the screen for voxels of any size: 1.6 samples per pixel, or samples that coincide with pixels. Layers get a sample per
    /// pixel, too. For opaque surfaces with hard edges: [`Relaxed`](Self::Relaxed) and [`Fine`](Self::Fine) become this where the transfer
    /// function is steep.
    Screen,
    /// Exactly this many samples per voxel, 1 … 16.
    Fixed(u32),
}

impl Rule {
    fn samples(&self, pixels: f64) -> f64 {
        (pixels * self.per_pixel).min((pixels / self.pixels).max(self.per_voxel))
    }
}

impl Density {
    /// Samples per voxel for voxels of `pixels` pixels; generally not an integer.
    pub(super) fn samples(self, pixels: f64) -> f64 {
        match self {
            Density::AtLeast(m) => pixels.max(f64::from(m)),
            Density::Relaxed => RELAXED.samples(pixels),
            Density::Fine => FINE.samples(pixels),
            Density::Screen => pixels * SCREEN_PER_PIXEL,
            Density::Fixed(m) => f64::from(m),
        }
    }

    /// Whether one sample per pixel satisfies this density for voxels of `pixels` pixels.
    pub(super) fn follows_pixels(self, pixels: f64) -> bool {
        match self {
            Density::AtLeast(m) => pixels >= f64::from(m),
            Density::Relaxed | Density::Fine | Density::Screen => true,
            Density::Fixed(_) => false,
        }
    }

    /// Samples per pixel along one axis if the other is aligned with pixels; `None` if this density is never aligned.
    pub(super) fn beside_aligned(self) -> Option<f64> {
        match self {
            Density::Relaxed | Density::Screen => Some(RELAXED_BESIDE_PIXELS),
            Density::Fine => Some(FINE_BESIDE_PIXELS),
            Density::AtLeast(_) | Density::Fixed(_) => None,
        }
    }

    /// Columns per pixel of a row if columns have samples where rows of pixels cross them; `None` if this density never has such columns.
    pub(super) fn crossed(self) -> Option<f64> {
        match self {
            Density::Relaxed | Density::Screen => Some(RELAXED_CROSSED_PER_PIXEL),
            Density::Fine => Some(FINE_CROSSED_PER_PIXEL),
            Density::AtLeast(_) | Density::Fixed(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn samples_per_voxel_follow_the_screen() {
        for (pixels, relaxed) in [(0.3, 0.48), (1.0, 1.6), (1.34, 1.86), (3.0, 1.86), (4.8, 2.4), (16.0, 8.0)] {
            assert_abs_diff_eq!(Density::Relaxed.samples(pixels), relaxed, epsilon = 1e-12);
            assert_abs_diff_eq!(Density::Screen.samples(pixels), 1.6 * pixels, epsilon = 1e-12);
            assert_eq!(Density::AtLeast(3).samples(pixels), pixels.max(3.0));
            assert_eq!(Density::Fixed(7).samples(pixels), 7.0);
        }
    }
}
