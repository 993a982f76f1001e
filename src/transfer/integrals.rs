//! A transfer function integrated over its values, for pre-integrated classification.

use super::table::TransferTable;

/// Optical depth of the thinnest stretch of an opaque value: e^−16 is below what any picture shows, and small enough to
/// leave the unit fine for what is thin.
const OPAQUE_DEPTH: f64 = 16.0;
/// Room for rounding, in nodes.
const SLACK: f64 = 0.02;

/// Running integrals of extinction times colour, and of extinction, over the values of a [`TransferTable`], in whole
/// numbers of one unit: differences of nodes are exact, however far from the first node. Entry i lies in the middle
/// between nodes i and i+1.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralTable {
    /// r, g, b, extinction: integrals from the first node, in units times node distances. One more than entries.
    pub nodes: Vec<[i32; 4]>,
    /// Value of the first node.
    pub first: f64,
    /// Nodes per unit of value; 0 for a single value.
    pub per_value: f64,
    /// Extinction (or α, by the table's kind) of one unit.
    pub unit: f64,
}

impl TransferTable {
    /// The integrals of this table by the midpoint rule: the mean between two neighbouring nodes is the entry between them.
    /// Extinctions are cut off where a stretch of `thinnest` unit distances is opaque.
    pub fn integrals(&self, thinnest: f64) -> IntegralTable {
        let mut sums = vec![[0.0; 4]];
        for &[r, g, b, w] in &self.entries {
            let w = f64::from(w).min(OPAQUE_DEPTH / thinnest);
            let entry = [f64::from(r) * w, f64::from(g) * w, f64::from(b) * w, w];
            let last = sums[sums.len() - 1];
            sums.push(std::array::from_fn(|c| last[c] + entry[c]));
        }
        let total = sums[sums.len() - 1][3];
        let unit = if total > 0.0 { total / f64::from(i32::MAX) } else { 0.0 };
        let nodes = sums.iter().map(|s| s.map(|c| if unit > 0.0 { (c / unit).round() as i32 } else { 0 })).collect();
        let first = if self.per_value > 0.0 { self.first - 0.5 / self.per_value } else { self.first };
        IntegralTable { nodes, first, per_value: self.per_value, unit }
    }
}

impl IntegralTable {
    /// The nodes between which lies all opacity, with room for rounding; an empty range if there is none.
    pub fn visible_nodes(&self) -> [f64; 2] {
        let last_cell = self.nodes.len() - 2;
        let visible = |pair: &[[i32; 4]]| pair[1][3] > pair[0][3];
        let ends = self.nodes.windows(2).position(visible).zip(self.nodes.windows(2).rposition(visible));
        // Values beyond the table count as its first and its last entry.
        ends.map_or([f64::INFINITY, f64::NEG_INFINITY], |(first, last)| {
            let from = if first == 0 { f64::NEG_INFINITY } else { first as f64 - SLACK };
            let to = if last == last_cell { f64::INFINITY } else { last as f64 + 1.0 + SLACK };
            [from, to]
        })
    }

    /// The values between which lies all opacity.
    pub fn visible_values(&self) -> [f64; 2] {
        // A single value lies at the first node: all or nothing is visible.
        let value = |node: f64| if node.is_finite() { self.first + node / self.per_value } else { node };
        self.visible_nodes().map(value)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Extinction, TransferFunction};
    use super::*;
    use approx::assert_relative_eq;

    /// Half a unit of the sums on either side of a difference, relative to what the tests compare.
    const ROUNDING: f64 = 1e-4;

    fn table(opacities: Vec<(f64, f64)>) -> TransferTable {
        let transfer = TransferFunction::new("t", vec![(0.0, [1.0, 0.5, 0.0])], opacities).unwrap();
        TransferTable::new(&transfer, (0.0, 100.0), Extinction::Linear)
    }

    fn mean(table: &IntegralTable, from: usize, to: usize) -> [f64; 4] {
        std::array::from_fn(|c| f64::from(table.nodes[to][c] - table.nodes[from][c]) * table.unit / (to - from) as f64)
    }

    #[test]
    fn differences_are_means_over_the_values_between() {
        let integrals = table(vec![(0.0, 0.0), (100.0, 0.5)]).integrals(1.0);
        let node = |value: f64| ((value - integrals.first) * integrals.per_value).floor() as usize;
        let [r, g, b, w] = mean(&integrals, node(20.0), node(60.0));
        assert_relative_eq!(w, 0.2, max_relative = 1e-3);
        assert_relative_eq!(r, w, max_relative = ROUNDING);
        assert_relative_eq!(g, w / 2.0, max_relative = ROUNDING);
        assert_eq!(b, 0.0);
    }

    #[test]
    fn what_is_thin_stays_beside_what_is_opaque() {
        let integrals = table(vec![(0.0, 0.01), (50.0, 0.01), (50.0, 1.0), (100.0, 1.0)]).integrals(0.5);
        assert_relative_eq!(mean(&integrals, 100, 101)[3], 0.01, max_relative = ROUNDING);
        assert_eq!(integrals.nodes[integrals.nodes.len() - 1][3], i32::MAX);
    }

    #[test]
    fn values_beyond_the_table_find_its_ends() {
        let integrals = table(vec![(20.0, 0.25), (20.0, 0.5), (80.0, 0.5)]).integrals(1.0);
        let last = integrals.nodes.len() - 1;
        assert_relative_eq!(mean(&integrals, 0, 1)[3], 0.25, max_relative = ROUNDING);
        assert_relative_eq!(mean(&integrals, last - 1, last)[3], 0.5, max_relative = ROUNDING);
    }

    #[test]
    fn visible_nodes_enclose_all_opacity() {
        let integrals = table(vec![(0.0, 0.0), (50.0, 0.0), (60.0, 1.0), (70.0, 0.0), (100.0, 0.0)]).integrals(1.0);
        let [first, last] = integrals.visible_values();
        assert!(49.9 < first && first < 50.1 && 69.9 < last && last < 70.1, "{first} {last}");
        assert_eq!(table(vec![(0.0, 0.5), (100.0, 0.5)]).integrals(1.0).visible_values(), [f64::NEG_INFINITY, f64::INFINITY]);
        let [first, last] = table(vec![(0.0, 0.0)]).integrals(1.0).visible_values();
        assert!(first > last);
    }

    #[test]
    fn what_is_invisible_at_the_first_value_stays_so() {
        // Volumes are full of their smallest value: it must not pick up what is just above.
        let integrals = table(vec![(0.0, 0.0), (100.0, 0.5)]).integrals(1.0);
        assert_eq!(integrals.nodes[0], integrals.nodes[1]);
        assert!(integrals.visible_values()[0] > 0.0);
    }
}
