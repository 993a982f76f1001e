//! What rays gather by the blend modes that do not composite.

use super::field::Field;
use super::interval::Part;
use crate::settings::Blend;
use crate::transfer::TransferFunction;

/// Share of a sample without an extent of its own that a maximum or minimum takes notice of: less is rounding.
const LEAST_SHARE: f64 = 1e-3;

/// Values along a ray.
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

    /// Takes what lies between two values, over a length.
    pub fn add(&mut self, [from, to]: [f64; 2], length: f64) {
        self.smallest = self.smallest.min(from.min(to));
        self.largest = self.largest.max(from.max(to));
        self.sum += (from + to) / 2.0 * length;
        self.length += length;
    }

    /// Takes a part of a sample of one value, of a length as a whole.
    pub fn add_sample(&mut self, value: f64, length: f64, part: Part) {
        if self.blend == Blend::Average || part.length() > LEAST_SHARE {
            self.add([value; 2], length * part.length());
        }
    }

    /// The ray's colour: opaque where there was anything.
    pub fn rgba(&self, transfer: &TransferFunction, field: &Field) -> [f64; 4] {
        if self.length == 0.0 {
            return [0.0; 4];
        }
        let value = match self.blend {
            Blend::Maximum => self.largest,
            Blend::Minimum => self.smallest,
            Blend::Average => self.sum / self.length,
            other => panic!("{} gathers no values", other.name()),
        };
        opaque(transfer.color(field.within_range(value)))
    }
}

/// RGBA of what hides all behind it.
pub(super) fn opaque([r, g, b]: [f64; 3]) -> [f64; 4] {
    [r, g, b, 1.0]
}

/// Where, 0 … 1, a value that changes evenly from the one to the other crosses a surface's.
pub(super) fn crossing([from, to]: [f64; 2], iso: f64) -> Option<f64> {
    ((from < iso) != (to < iso)).then(|| (iso - from) / (to - from))
}

/// The same where the value in between is known; both ends must be on their sides.
pub(super) fn refined_crossing(value: impl Fn(f64) -> f64, from: f64, iso: f64) -> f64 {
    /// Halvings: to the last bit.
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
