//! How strongly the colour of a segment depends on attenuation within the segment.

use super::table::TransferTable;

/// Number of values sampled; segments between all pairs of them are evaluated.
const VALUES: usize = 13;
/// Integration steps per segment.
const PARTS: usize = 64;

impl TransferTable {
    /// Upper bound of the error of ignoring attenuation within a segment of `length` unit distances, over which the value changes
    /// linearly.
    ///
    /// The error is the largest difference in any channel, 0 … 1, between the premultiplied colour of the segment and its
    /// extinction-weighted mean colour at the same opacity. It is near 0 for transfer functions of one hue or of low extinction.
    pub fn dimming(&self, length: f64) -> f64 {
        let last = self.entries.len() - 1;
        let at = |n: usize| (n * last) as f64 / (VALUES - 1) as f64;
        let pairs = (0..VALUES).flat_map(|a| (0..VALUES).map(move |b| (a, b))).filter(|(a, b)| a != b);
        pairs.map(|(a, b)| self.dimming_between(at(a), at(b), length)).fold(0.0, f64::max)
    }

    /// The same for two fields that are drawn together: of a segment with this one's extinction in its front half and the other's in its
    /// back half.
    pub fn dimming_with(&self, other: &Self, length: f64) -> f64 {
        let sampled = |table: &Self| {
            let last = table.entries.len() - 1;
            (0..VALUES).map(|n| table.entries[n * last / (VALUES - 1)].map(f64::from)).collect::<Vec<_>>()
        };
        let backs = sampled(other);
        let half = |[r, g, b, extinction]: [f64; 4]| ([r, g, b], (0.5 * length * extinction).min(f64::from(f32::MAX)));
        let error = |front: [f64; 4], back: [f64; 4]| {
            let ((front, front_depth), (back, back_depth)) = (half(front), half(back));
            let depth = front_depth + back_depth;
            if depth == 0.0 {
                return 0.0;
            }
            let [one, both] = [front_depth, depth].map(|depth| -(-depth).exp_m1());
            let channel = |c: usize| {
                let seen = one * front[c] + (both - one) * back[c];
                (seen - both * (front_depth * front[c] + back_depth * back[c]) / depth).abs()
            };
            (0..3).map(channel).fold(0.0, f64::max)
        };
        sampled(self).into_iter().flat_map(|front| backs.iter().map(move |&back| error(front, back))).fold(0.0, f64::max)
    }

    fn dimming_between(&self, from: f64, to: f64, length: f64) -> f64 {
        let (mut seen, mut sum, mut depth, mut transmittance) = ([0.0; 3], [0.0; 3], 0.0, 1.0);
        for n in 0..PARTS {
            let entry = (from + (to - from) * (n as f64 + 0.5) / PARTS as f64).round() as usize;
            let [r, g, b, extinction] = self.entries[entry].map(f64::from);
            let part = (extinction * length / PARTS as f64).min(f64::from(f32::MAX));
            let opacity = -(-part).exp_m1();
            for (c, color) in [r, g, b].into_iter().enumerate() {
                seen[c] += transmittance * opacity * color;
                sum[c] += part * color;
            }
            transmittance *= 1.0 - opacity;
            depth += part;
        }
        if depth == 0.0 {
            return 0.0;
        }
        let opacity = 1.0 - transmittance;
        seen.iter().zip(sum).map(|(seen, sum)| (seen - opacity * sum / depth).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Extinction, TransferFunction};
    use super::*;
    use approx::assert_abs_diff_eq;

    fn dimming(colors: Vec<(f64, [f64; 3])>, opacity: f64) -> f64 {
        let transfer = TransferFunction::new("t", colors, vec![(0.0, opacity), (100.0, opacity)]).unwrap();
        TransferTable::new(&transfer, (0.0, 100.0), Extinction::Exponential).dimming(1.0)
    }

    #[test]
    fn one_hue_has_none_and_two_have_the_closed_form() {
        assert_abs_diff_eq!(dimming(vec![(0.0, [0.3, 0.6, 0.9])], 0.99), 0.0, epsilon = 1e-6);
        // Red falls from 1 to 0: seen is ∫ e^(-dt) d (1 − t) dt = 1 − a/d, half of a is the mean's; a = 0.9, d = ln 10.
        let two = dimming(vec![(0.0, [1.0, 0.0, 0.0]), (100.0, [0.0, 1.0, 0.0])], 0.9);
        assert_abs_diff_eq!(two, 1.0 - 0.9 / 10f64.ln() - 0.45, epsilon = 5e-3);
        assert!(dimming(vec![(0.0, [1.0, 0.0, 0.0]), (100.0, [0.0, 1.0, 0.0])], 0.1) < 2e-3);
    }

    #[test]
    fn two_fields_of_one_hue_do_not_dim_each_other_and_two_hues_have_the_closed_form() {
        let table = |color, opacity| {
            let transfer = TransferFunction::new("t", vec![(0.0, color)], vec![(0.0, opacity), (100.0, opacity)]).unwrap();
            TransferTable::new(&transfer, (0.0, 100.0), Extinction::Exponential)
        };
        let (red, green) = (table([1.0, 0.0, 0.0], 0.75), table([0.0, 1.0, 0.0], 0.75));
        // Each half has the optical depth ln 4 / 2: half of the light passes it. Of the opacity 3/4, red is 1/2 instead of 3/8.
        assert_abs_diff_eq!(red.dimming_with(&green, 1.0), 0.125, epsilon = 1e-6);
        assert_abs_diff_eq!(red.dimming_with(&red, 1.0), 0.0, epsilon = 1e-6);
    }
}
