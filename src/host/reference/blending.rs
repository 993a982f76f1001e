//! Reduction of values along rays, for blend modes other than compositing.

use super::field::Field;
use super::interval::Part;
use crate::settings::Blend;
use crate::transfer::TransferFunction;

/// Least fraction of a sample that maximum and minimum consider. Smaller fractions are rounding errors.
const LEAST_SHARE: f64 = 1e-3;

/// Accumulated values along a ray.
pub(super) struct Values {
    blend: Blend,
    smallest: f64,
    largest: f64,
    /// Integral of the value over the length, and the length.
    sum: f64,
    length: f64,
}

impl Values {
    pub fn new(blend: Blend) -> Self {
        Self { blend, smallest: f64::INFINITY, largest: f64::NEG_INFINITY, sum: 0.0, length: 0.0 }
    }

    /// Adds a segment over which the value changes linearly.
    pub fn add(&mut self, [from, to]: [f64; 2], length: f64) {
        self.smallest = self.smallest.min(from.min(to));
        self.largest = self.largest.max(from.max(to));
        self.sum += (from + to) / 2.0 * length;
        self.length += length;
    }

    /// Adds a part of a sample of constant value; `length` is that of the whole sample.
    pub fn add_sample(&mut self, value: f64, length: f64, part: Part) {
        if self.blend == Blend::Average || part.length() > LEAST_SHARE {
            self.add([value; 2], length * part.length());
        }
    }

    /// Colour of the ray: opaque if any value was added.
    pub fn rgba(&self, transfer: &TransferFunction, field: &Field) -> [f64; 4] {
        if self.length == 0.0 {
            return [0.0; 4];
        }
        let value = match self.blend {
            Blend::Maximum => self.largest,
            Blend::Minimum => self.smallest,
            Blend::Average => self.sum / self.length,
            other => panic!("{} does not reduce values", other.name()),
        };
        opaque(transfer.color(field.within_range(value)))
    }
}

/// RGBA of an opaque colour.
pub(super) fn opaque([r, g, b]: [f64; 3]) -> [f64; 4] {
    [r, g, b, 1.0]
}

/// Position, 0 … 1, at which a linear ramp crosses the iso-value.
pub(super) fn crossing([from, to]: [f64; 2], iso: f64) -> Option<f64> {
    ((from < iso) != (to < iso)).then(|| (iso - from) / (to - from))
}

/// Position, 0 … 1, at which `value` crosses the iso-value, by bisection. The ends must lie on different sides.
pub(super) fn refined_crossing(value: impl Fn(f64) -> f64, from: f64, iso: f64) -> f64 {
    /// Bisection steps, to the last bit.
    const STEPS: usize = 52;
    let (mut near, mut far) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = (near + far) / 2.0;
        if (value(middle) < iso) == (from < iso) {
            near = middle;
        } else {
            far = middle;
        }
    }
    (near + far) / 2.0
}
