//! Integrals of a transfer function over its values, for pre-integrated classification.

use super::table::TransferTable;

/// Optical depth of the thinnest segment at which extinction is clamped. e^−16 is below what any picture resolves. A small limit
/// keeps the unit of the table fine enough for low extinction.
const OPAQUE_DEPTH: f64 = 16.0;
/// Largest optical depth of the thinnest segment that one unit may represent, if the table is long enough to be shortened.
const FINE_UNIT: f64 = 4e-5;
/// Shortest table that shortening may produce.
const MIN_CELLS: usize = 4096;
/// Margin for rounding, in nodes.
const SLACK: f64 = 0.02;

/// Running integrals of extinction times colour, and of extinction, over the values of a [`TransferTable`].
///
/// The integrals are integers in multiples of one unit, so differences of nodes are exact at any distance from the first node.
/// Entry i of the [`TransferTable`] lies half-way between nodes i and i+1.
///
/// ```
/// use layersplat::TransferFunction;
/// use layersplat::transfer::{Extinction, TransferTable};
///
/// let transfer = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (255.0, 0.5)])?;
/// let table = TransferTable::new(&transfer, (0.0, 255.0), Extinction::Exponential);
/// assert!(table.integrals(1.0).spans((0.0, 255.0)));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct IntegralTable {
    /// Integrals of r, g, b times extinction and of extinction from the first node, in units times node distances. One node more than
    /// table entries.
    pub nodes: Vec<[i32; 4]>,
    /// The four integrands at each node, in units: those of the adjacent entry with the lower extinction.
    pub at_nodes: Vec<[f32; 4]>,
    /// Value of the first node.
    pub first: f64,
    /// Nodes per unit of value; 0 for a single value.
    pub per_value: f64,
    /// Extinction of one unit, per unit distance (or α, according to [`Extinction`](super::Extinction)).
    pub unit: f64,
}

/// Number of cells into which [`IntegralTable::extinction_cells`] divides the visible values.
pub const EXTINCTION_CELLS: usize = 32;

/// Extinction over the visible values, linear within each of [`EXTINCTION_CELLS`] cells.
///
/// 32 cells fit into the registers of a processor. They locate the light within a segment, which needs no finer cells: pictures
/// lose 0.01 dB, or half a decibel where a triangular opacity peak falls between two cell borders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtinctionCells {
    /// Value at the start of the first cell.
    pub first: f64,
    /// Cells per unit of value; 0 if nothing is visible or only a single value is.
    pub per_value: f64,
    /// Extinction at the start of each cell, in units of the table.
    pub at: [f32; EXTINCTION_CELLS],
    /// Difference of the extinction from the start to the end of each cell, in units of the table.
    pub to_next: [f32; EXTINCTION_CELLS],
}

impl TransferTable {
    /// Integrates this table by the midpoint rule: each entry is the mean between its two nodes. Extinction is clamped where a segment
    /// of `thinnest` unit distances is opaque.
    ///
    /// Long tables with many opaque entries are shortened. Otherwise the unit would be too coarse for low extinction.
    pub fn integrals(&self, thinnest: f64) -> IntegralTable {
        let mut per_value = self.per_value;
        let mut entries: Vec<[f64; 4]> = self.entries.iter().map(|&e| attenuated(e, OPAQUE_DEPTH / thinnest)).collect();
        let unit_of = |entries: &[[f64; 4]]| entries.iter().map(|e| e[3]).sum::<f64>() / f64::from(i32::MAX);
        while entries.len() > MIN_CELLS && unit_of(&entries) * thinnest > FINE_UNIT {
            entries = entries.chunks(2).map(|pair| std::array::from_fn(|c| 0.5 * (pair[0][c] + pair[1][c]))).collect();
            per_value /= 2.0;
        }
        let unit = unit_of(&entries);
        let mut sum = [0.0; 4];
        let mut nodes = vec![[0; 4]];
        for entry in &entries {
            sum = std::array::from_fn(|c| sum[c] + entry[c]);
            nodes.push(sum.map(|c| if unit > 0.0 { (c / unit).round() as i32 } else { 0 }));
        }
        let in_units = |entry: &[f64; 4]| entry.map(|c| if unit > 0.0 { (c / unit) as f32 } else { 0.0 });
        let at_nodes = (0..nodes.len())
            .map(|i| [i.saturating_sub(1), i.min(entries.len() - 1)].map(|i| entries[i]))
            .map(|[below, above]| in_units(if below[3] < above[3] { &below } else { &above }))
            .collect();
        let first = if self.per_value > 0.0 { self.first - 0.5 / self.per_value } else { self.first };
        IntegralTable { nodes, at_nodes, first, per_value, unit }
    }
}

/// Extinction times colour, and extinction, of an entry. Extinction is clamped to `limit`.
fn attenuated([r, g, b, w]: [f32; 4], limit: f64) -> [f64; 4] {
    let w = f64::from(w).min(limit);
    [f64::from(r) * w, f64::from(g) * w, f64::from(b) * w, w]
}

impl IntegralTable {
    /// Whether a range of values lies between the first and the last node.
    pub fn spans(&self, (lo, hi): (f64, f64)) -> bool {
        let last = self.first + (self.nodes.len() - 1) as f64 / self.per_value;
        self.per_value == 0.0 || (self.first <= lo && hi <= last)
    }

    /// First and last node of the visible values, with a margin for rounding; an empty range if nothing is visible.
    pub fn visible_nodes(&self) -> [f64; 2] {
        let last_cell = self.nodes.len() - 2;
        let visible = |pair: &[[i32; 4]]| pair[1][3] > pair[0][3];
        let ends = self.nodes.windows(2).position(visible).zip(self.nodes.windows(2).rposition(visible));
        // Values outside the table take its first or last entry.
        ends.map_or([f64::INFINITY, f64::NEG_INFINITY], |(first, last)| {
            let from = if first == 0 { f64::NEG_INFINITY } else { first as f64 - SLACK };
            let to = if last == last_cell { f64::INFINITY } else { last as f64 + 1.0 + SLACK };
            [from, to]
        })
    }

    /// Piecewise-linear approximation of the extinction.
    pub fn extinction_cells(&self) -> ExtinctionCells {
        let last = (self.nodes.len() - 1) as f64;
        let [from, to] = self.visible_nodes().map(|node| node.clamp(0.0, last));
        let per_cell = (to - from).max(0.0) / EXTINCTION_CELLS as f64;
        let border = |i: usize| self.at_nodes[(from + per_cell * i as f64).round() as usize][3];
        ExtinctionCells {
            first: if self.per_value > 0.0 { self.first + from / self.per_value } else { self.first },
            per_value: if per_cell > 0.0 { self.per_value / per_cell } else { 0.0 },
            at: std::array::from_fn(border),
            to_next: std::array::from_fn(|i| border(i + 1) - border(i)),
        }
    }

    /// First and last visible value; an empty range if nothing is visible.
    pub fn visible_values(&self) -> [f64; 2] {
        // A table of a single value has it at the first node, so all or nothing is visible.
        let value = |node: f64| if node.is_finite() { self.first + node / self.per_value } else { node };
        self.visible_nodes().map(value)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Extinction, TransferFunction};
    use super::*;
    use approx::assert_relative_eq;

    /// Half a unit on either side of a difference of sums, relative to the compared values.
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
    fn nodes_know_their_own_value() {
        let integrals = table(vec![(0.0, 0.0), (50.0, 0.0), (50.0, 0.5), (100.0, 0.5)]).integrals(1.0);
        let at = |value: f64| integrals.at_nodes[((value - integrals.first) * integrals.per_value).round() as usize];
        assert_relative_eq!(f64::from(at(75.0)[3]) * integrals.unit, 0.5, max_relative = ROUNDING);
        assert_relative_eq!(at(75.0)[1], at(75.0)[0] / 2.0, max_relative = 1e-6);
        // A step belongs to neither side of its node.
        let step = integrals.at_nodes.iter().position(|n| n[3] > 0.0).unwrap();
        assert!(integrals.nodes[step][3] > 0 && integrals.nodes[step - 1][3] == 0);
    }

    #[test]
    fn cells_follow_the_extinction_of_what_is_visible() {
        let integrals = table(vec![(0.0, 0.0), (40.0, 0.0), (60.0, 0.5), (100.0, 0.0)]).integrals(1.0);
        let cells = integrals.extinction_cells();
        let near = |value: f64| {
            let place = ((value - cells.first) * cells.per_value).clamp(0.0, EXTINCTION_CELLS as f64 - 1e-3);
            let cell = place as usize;
            (f64::from(cells.at[cell]) + place.fract() * f64::from(cells.to_next[cell])) * integrals.unit
        };
        for value in 40..=100 {
            let value = f64::from(value);
            let expected = if value < 60.0 { 0.025 * (value - 40.0) } else { 0.0125 * (100.0 - value) };
            // The peak lies within a cell.
            let tolerance = if (value - 60.0).abs() < 2.0 { 0.02 } else { 2e-3 };
            assert!((near(value) - expected).abs() < tolerance, "{value}: {} for {expected}", near(value));
        }
        let single = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(0.0, 0.5)]).unwrap();
        for (transfer, range) in
            [(single, (7.0, 7.0)), (TransferFunction::new("c", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0)]).unwrap(), (0.0, 9.0))]
        {
            let cells = TransferTable::new(&transfer, range, Extinction::Linear).integrals(1.0).extinction_cells();
            assert!(cells.first.is_finite() && cells.per_value.is_finite() && cells.to_next == [0.0; EXTINCTION_CELLS]);
        }
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
    fn a_long_table_with_an_opaque_half_keeps_what_is_thin() {
        let opacities = vec![(0.0, 2e-4), (30_000.0, 2e-4), (30_001.0, 1.0), (65_535.0, 1.0)];
        let transfer = TransferFunction::new("fog", vec![(0.0, [1.0; 3])], opacities).unwrap();
        let integrals = TransferTable::new(&transfer, (0.0, 65_535.0), Extinction::Exponential).integrals(1.0);
        let cells = integrals.nodes.len() - 1;
        assert!(cells < 1 << 16, "{cells}");
        // Half a unit on either side of a difference.
        assert!((0..100).all(|i| (mean(&integrals, 20 + i, 21 + i)[3] - 2e-4).abs() <= FINE_UNIT));
        assert!(integrals.spans((0.0, 65_535.0)) && !integrals.spans((-1.0, 3.0)));
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
        // Many voxels hold the smallest value: it must not take opacity from values just above it.
        let integrals = table(vec![(0.0, 0.0), (100.0, 0.5)]).integrals(1.0);
        assert_eq!(integrals.nodes[0], integrals.nodes[1]);
        assert!(integrals.visible_values()[0] > 0.0);
    }
}
