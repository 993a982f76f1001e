//! Pictures, and compositing along a ray.

use crate::image::Frame;
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use rayon::prelude::*;

/// Evaluates `rgba` (premultiplied) at the pixel centres.
pub(super) fn picture(viewport: Viewport, rgba: impl Fn(f64, f64) -> [f64; 4] + Sync) -> Frame {
    let width = viewport.width as usize;
    let pixels = (0..viewport.pixels()).into_par_iter();
    let pixels = pixels.map(|i| rgba((i % width) as f64 + 0.5, (i / width) as f64 + 0.5).map(|c| c as f32));
    Frame::new(viewport, pixels.collect())
}

/// Opacity of an optical depth; with linear extinction, of α times length.
pub(super) fn opacity_of_depth(depth: f64, extinction: Extinction) -> f64 {
    match extinction {
        Extinction::Exponential => -(-depth).exp_m1(),
        Extinction::Linear => depth.min(1.0),
    }
}

/// Opacity of a value over a length in unit distances.
pub(super) fn opacity_over(transfer: &TransferFunction, value: f64, length: f64, extinction: Extinction) -> f64 {
    let per_unit = match extinction {
        Extinction::Exponential => transfer.extinction(value),
        Extinction::Linear => transfer.opacity(value),
    };
    opacity_of_depth(per_unit * length, extinction)
}

/// Accumulated colour and transmittance of a ray.
pub(super) struct Gathered {
    pub color: [f64; 3],
    pub transmittance: f64,
}

impl Gathered {
    pub fn new() -> Self {
        Self { color: [0.0; 3], transmittance: 1.0 }
    }

    /// Composites a colour behind the accumulated ones.
    pub fn add(&mut self, color: [f64; 3], opacity: f64) {
        for (sum, c) in self.color.iter_mut().zip(color) {
            *sum += self.transmittance * opacity * c;
        }
        self.transmittance *= 1.0 - opacity;
    }

    /// Premultiplied RGBA.
    pub fn rgba(&self) -> [f64; 4] {
        [self.color[0], self.color[1], self.color[2], 1.0 - self.transmittance]
    }
}
