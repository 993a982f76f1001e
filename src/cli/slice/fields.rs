//! Slices of several fields in one picture.

use super::labels::slice_of_labels;
use crate::cli::channels::Field;
use crate::device::Device;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::shown::Shown;
use crate::slice::{Slice, SliceColors};
use crate::viewport::Viewport;
use crate::volume::Labels;

/// Optical depth of opaque values.
const OPAQUE: f64 = 50.0;

/// What slices have in common.
pub(super) struct SliceView<'a> {
    pub device: &'a Device,
    pub slice: &'a Slice,
    pub size: Viewport,
    pub kernel: Kernel,
    /// Thickness of the layer whose opacity the fields have, in unit distances.
    pub thickness: f64,
}

impl SliceView<'_> {
    /// The colours of the field of a renderer, whose extinction is multiplied by a factor.
    pub fn colors(&self, renderer: &mut Renderer, factor: f64) -> Result<Frame, Error> {
        if factor == 0.0 {
            return Ok(Frame::new(self.size, vec![[0.0; 4]; self.size.pixels()]));
        }
        let colors = SliceColors::Transfer { thickness: self.thickness * factor };
        renderer.slice(self.slice, self.size, self.kernel, colors)
    }

    /// The colours of labels, whose extinction is multiplied by a factor.
    fn labels(&self, labels: &Labels, factor: f64) -> Result<Frame, Error> {
        let frame = slice_of_labels(labels, self.slice, self.size)?;
        let thick = |pixel: &[f32; 4]| {
            let opacity = 1.0 - (1.0 - f64::from(pixel[3])).powf(self.thickness * factor);
            pixel.map(|c| if pixel[3] > 0.0 { (f64::from(c) * opacity / f64::from(pixel[3])) as f32 } else { 0.0 })
        };
        Ok(Frame::new(self.size, frame.pixels().iter().map(thick).collect()))
    }

    /// The colours of all visible fields, each on its own grid: their extinctions add, as in pictures.
    pub fn together(&self, first: Option<Frame>, others: &[Field]) -> Result<Frame, Error> {
        let others = others.iter().filter(|field| field.is_visible());
        let others = others.map(|field| match &field.shown {
            None => self.colors(&mut Renderer::new(self.device, &field.volume, &field.transfer)?, field.look.factor),
            Some(Shown::Labels(all)) => self.labels(all.labels(), field.look.factor),
            Some(_) => {
                let problem = format!(
                    "{} has colours, which slices draw alone: slice it, hide it by visible=off, or choose a component by channel=N",
                    field.volume.name()
                );
                Err(Error::Settings { field: "channels", problem })
            }
        });
        let frames = first.into_iter().map(Ok).chain(others).collect::<Result<Vec<_>, _>>()?;
        let pixel = |n: usize| mixed(frames.iter().map(|frame| frame.pixels()[n]));
        Ok(Frame::new(self.size, (0..self.size.pixels()).map(pixel).collect()))
    }
}

/// Premultiplied colour of fields in one place: τ = Σ τ_c, C = Σ τ_c C_c / τ (docs/guide/channels.md).
fn mixed(fields: impl Iterator<Item = [f32; 4]>) -> [f32; 4] {
    let (mut depth, mut sum) = (0.0, [0.0; 3]);
    for [r, g, b, opacity] in fields.map(|pixel| pixel.map(f64::from)).filter(|pixel| pixel[3] > 0.0) {
        let own = (-(-opacity).ln_1p()).min(OPAQUE);
        depth += own;
        for (sum, color) in sum.iter_mut().zip([r, g, b]) {
            *sum += own * color / opacity;
        }
    }
    if depth == 0.0 {
        return [0.0; 4];
    }
    let opacity = -(-depth).exp_m1();
    [sum[0] / depth * opacity, sum[1] / depth * opacity, sum[2] / depth * opacity, opacity].map(|c| c as f32)
}

/// A frame over another.
pub(super) fn over(above: &Frame, below: &Frame) -> Frame {
    let on = |(above, below): (&[f32; 4], &[f32; 4])| std::array::from_fn(|i| above[i] + (1.0 - above[3]) * below[i]);
    let pixels = above.pixels().iter().zip(below.pixels()).map(on).collect();
    Frame::new(Viewport { width: below.width(), height: below.height() }, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two fields of one opacity are their mean colour, with the opacity of both; an opaque one hides what is thin.
    #[test]
    fn extinctions_add() {
        const TOLERANCE: f32 = 1e-6;
        let (red, blue) = ([0.5, 0.0, 0.0, 0.5], [0.0, 0.0, 0.5, 0.5]);
        let both = mixed([red, blue].into_iter());
        for (found, expected) in both.iter().zip([0.375, 0.0, 0.375, 0.75]) {
            assert!((found - expected).abs() < TOLERANCE, "{both:?}");
        }
        assert_eq!(mixed([red].into_iter()), red);
        assert_eq!(mixed([[0.0; 4]].into_iter()), [0.0; 4]);
        let hidden = mixed([[0.0, 1.0, 0.0, 1.0], red].into_iter());
        assert!(hidden[1] > 0.98 && hidden[0] < 0.02 && hidden[3] == 1.0, "{hidden:?}");
    }
}
