//! Downsampling of frames by averaging, for supersampling.

use super::Frame;
use crate::error::Error;
use crate::memory;
use crate::viewport::Viewport;
use rayon::prelude::*;

impl Frame {
    /// Averages blocks of `n` × `n` pixels. Pixels are premultiplied, so their mean is correct over any background. The curve is kept.
    ///
    /// ```
    /// use layersplat::{Frame, Viewport};
    ///
    /// let fine = Frame::new(Viewport::new(2, 2)?, vec![[0.0; 4], [1.0; 4], [0.0; 4], [0.0; 4]]);
    /// assert_eq!(fine.averaged(2)?.pixels(), [[0.25; 4]]);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    ///
    /// # Errors
    /// If `n` is 0 or does not divide width and height, or memory is insufficient.
    pub fn averaged(&self, n: u32) -> Result<Frame, Error> {
        if n == 0 || !self.width().is_multiple_of(n) || !self.height().is_multiple_of(n) {
            let expected = "a whole number above 0 that divides the frame's width and height";
            return Err(Error::OutOfRange { name: "samples", value: n.to_string(), expected });
        }
        let small = Viewport::new(self.width() / n, self.height() / n)?;
        let mut pixels: Vec<[f32; 4]> = memory::zeroed("the averaged picture", small.pixels())?;
        let (width, side) = (self.width() as usize, n as usize);
        pixels.par_chunks_mut(small.width as usize).enumerate().for_each(|(row, averages)| {
            for (column, average) in averages.iter_mut().enumerate() {
                let first = row * side * width + column * side;
                *average = mean((0..side).flat_map(|y| &self.pixels()[first + y * width..][..side]), side * side);
            }
        });
        Ok(Frame::new(small, pixels).with_curve(self.curve))
    }
}

/// Mean of `count` pixels, summed in `f64` in a fixed order.
fn mean<'a>(pixels: impl Iterator<Item = &'a [f32; 4]>, count: usize) -> [f32; 4] {
    let mut sum = [0.0; 4];
    for pixel in pixels {
        for (sum, &channel) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(channel);
        }
    }
    sum.map(|sum| (sum / count as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged_by_hand() {
        // Numbers with exact sums.
        let value = |x: u32, y: u32, channel: u32| (x * 7 + y * 31 + channel * 3) as f32 / 256.0;
        let viewport = Viewport::new(6, 9).unwrap();
        let place = |n: u32| (n % 6, n / 6);
        let pixel = |n| [0, 1, 2, 3].map(|c| value(place(n).0, place(n).1, c));
        let fine = Frame::new(viewport, (0..54).map(pixel).collect());
        let coarse = fine.averaged(3).unwrap();
        assert_eq!((coarse.width(), coarse.height()), (2, 3));
        for (row, column) in (0..3).flat_map(|row| [(row, 0), (row, 1)]) {
            for channel in 0..4 {
                // The mean of a linear function is its value at the centre.
                let expected = value(3 * column + 1, 3 * row + 1, channel);
                assert_eq!(coarse.pixel(column, row)[channel as usize], expected, "{row}, {column}, {channel}");
            }
        }
        assert_eq!(fine.averaged(1).unwrap(), fine);
        for bad in [0, 2, 4, 5, 9] {
            assert!(fine.averaged(bad).unwrap_err().fields() == ["samples"], "{bad}");
        }
    }

    #[test]
    fn opacity_weighs_colours() {
        let pixels = vec![[1.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0; 4]];
        let average = Frame::new(Viewport::new(2, 2).unwrap(), pixels).averaged(2).unwrap();
        // Opacity becomes a quarter; the colour stays pure red.
        assert_eq!(average.to_rgba8(crate::Background::Transparent), [255, 0, 0, 64]);
    }
}
