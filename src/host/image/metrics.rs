//! Comparison of pictures.

use serde::Serialize;

/// Differences of two pictures, in premultiplied values 0 … 1.
///
/// ```
/// use layersplat::{Frame, Viewport};
///
/// let [black, grey] = [0.0, 0.1].map(|c| Frame::new(Viewport { width: 1, height: 1 }, vec![[c, c, c, 1.0]]));
/// let comparison = black.compare(&grey).expect("as large");
/// assert!((comparison.max_difference - 0.1).abs() < 1e-6);
/// assert!((comparison.psnr.expect("they differ") - 20.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// Peak signal-to-noise ratio over red, green and blue in dB; `None` if they are identical.
    pub psnr: Option<f64>,
    /// Peak signal-to-noise ratio over red, green, blue and alpha in dB; `None` if they are identical.
    pub psnr_rgba: Option<f64>,
    /// Largest absolute difference of any channel.
    pub max_difference: f64,
}

impl Comparison {
    /// Compares pixels of equally large pictures. NaN counts as an infinite difference.
    pub(super) fn new(a: &[[f32; 4]], b: &[[f32; 4]]) -> Self {
        let mut squares = [0.0; 4];
        let mut max_difference: f64 = 0.0;
        for (p, q) in a.iter().zip(b) {
            for channel in 0..4 {
                let difference = (f64::from(p[channel]) - f64::from(q[channel])).abs();
                let difference = if difference.is_nan() { f64::INFINITY } else { difference };
                squares[channel] += difference * difference;
                max_difference = max_difference.max(difference);
            }
        }
        let psnr = |channels: usize| {
            let mean = squares[..channels].iter().sum::<f64>() / (a.len() * channels) as f64;
            // Adding 0 turns −0 into 0, for pictures that differ by 1 everywhere.
            (mean > 0.0).then(|| -10.0 * mean.log10() + 0.0)
        };
        Self { psnr: psnr(3), psnr_rgba: psnr(4), max_difference }
    }
}

/// Distance from the silhouette, in pixels, from which the roughness is measured.
const FROM_SILHOUETTE: usize = 2;
/// Opacity above which a pixel is covered.
const COVERED: f32 = 0.5;

/// Luminance of red, green and blue (Rec. ITU-R BT.709).
fn luminance([r, g, b, _]: [f32; 4]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// Roughness of a picture `width` pixels wide; see [`Frame::roughness`](super::Frame::roughness).
pub(super) fn roughness(pixels: &[[f32; 4]], width: usize) -> Option<f64> {
    let height = pixels.len() / width;
    let at = |x: usize, y: usize| pixels[y * width + x];
    let is_inside = |x: usize, y: usize| {
        let (columns, rows) = (x - FROM_SILHOUETTE..=x + FROM_SILHOUETTE, y - FROM_SILHOUETTE..=y + FROM_SILHOUETTE);
        rows.into_iter().all(|y| columns.clone().all(|x| at(x, y)[3] > COVERED))
    };
    let (mut sum, mut count) = (0.0, 0u32);
    for y in FROM_SILHOUETTE..height.saturating_sub(FROM_SILHOUETTE) {
        for x in (FROM_SILHOUETTE..width.saturating_sub(FROM_SILHOUETTE)).filter(|&x| is_inside(x, y)) {
            let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)].map(luminance);
            sum += (4.0 * luminance(at(x, y)) - around.iter().sum::<f64>()).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| 1e3 * (sum / f64::from(count)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of 9 × 8 opaque grey pixels, and 3 columns that are not covered.
    fn grey(shade: impl Fn(usize, usize) -> f32) -> Vec<[f32; 4]> {
        let pixel = |n: usize| {
            let shade = shade(n % 12, n / 12);
            if n % 12 < 9 { [shade, shade, shade, 1.0] } else { [0.9, 0.0, 0.9, 0.4] }
        };
        (0..96).map(pixel).collect()
    }

    #[test]
    fn roughness_of_known_pictures() {
        let found = |shade: fn(usize, usize) -> f32| roughness(&grey(shade), 12);
        assert!(found(|x, y| 0.01 * x as f32 + 0.02 * y as f32).unwrap() < 1e-3, "a gradient is smooth");
        let board = found(|x, y| 0.25 * ((x + y) % 2) as f32).unwrap();
        assert!((board - 1000.0).abs() < 1e-3, "every pixel differs from four others by a quarter: {board}");
        let edge = found(|x, _| if x < 4 { 0.0 } else { 0.5 }).unwrap();
        assert!((edge - 500.0 * (2.0f64 / 5.0).sqrt()).abs() < 1e-3, "two of the five columns two pixels from all edges: {edge}");
        assert_eq!(roughness(&[[1.0; 4]; 16], 4), None, "no pixel is that far from the border");
    }

    #[test]
    fn closed_forms() {
        let same = Comparison::new(&[[0.5; 4]; 3], &[[0.5; 4]; 3]);
        assert_eq!(same, Comparison { psnr: None, psnr_rgba: None, max_difference: 0.0 });
        let off = Comparison::new(&[[0.5, 0.5, 0.5, 1.0]; 4], &[[0.6, 0.6, 0.6, 1.0]; 4]);
        assert!((off.psnr.unwrap() - 20.0).abs() < 1e-5);
        assert!((off.psnr_rgba.unwrap() - 20.0 - 10.0 * (4.0f64 / 3.0).log10()).abs() < 1e-5);
        assert!((off.max_difference - 0.1).abs() < 1e-7);
        let most = Comparison::new(&[[0.0; 4]], &[[1.0; 4]]).psnr.unwrap();
        assert!(most == 0.0 && most.is_sign_positive());
        assert_eq!(Comparison::new(&[[f32::NAN; 4]], &[[0.0; 4]]).max_difference, f64::INFINITY);
    }
}
