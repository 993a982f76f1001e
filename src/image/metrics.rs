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

#[cfg(test)]
mod tests {
    use super::*;

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
