//! Cells of files as triangles.

use super::Cells;

impl Cells<[u32; 3]> {
    /// Adds the triangles of a polygon, which is cell `number`: a fan around its first point.
    pub(super) fn add_polygon(&mut self, points: &[u32], number: u32) {
        if let [first, rest @ ..] = points {
            rest.windows(2).for_each(|edge| self.add([*first, edge[0], edge[1]], number));
        }
    }

    /// Adds the triangles of a strip, all turned alike.
    pub(super) fn add_strip(&mut self, points: &[u32], number: u32) {
        for (n, corner) in points.windows(3).enumerate() {
            let [a, b] = if n % 2 == 0 { [0, 1] } else { [1, 0] };
            self.add([corner[a], corner[b], corner[2]], number);
        }
    }
}

impl<T> Cells<T> {
    /// Adds a cell, or a part of cell `number`.
    pub(super) fn add(&mut self, points: T, number: u32) {
        self.points.push(points);
        self.numbers.push(number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_fans_and_strips_keep_their_winding() {
        let mut cells = Cells::default();
        cells.add_polygon(&[4, 5, 6, 7], 2);
        cells.add_strip(&[0, 1, 2, 3], 3);
        cells.add_polygon(&[1, 2], 4);
        cells.add_polygon(&[], 5);
        assert_eq!(cells.points, [[4, 5, 6], [4, 6, 7], [0, 1, 2], [2, 1, 3]]);
        assert_eq!(cells.numbers, [2, 2, 3, 3]);
    }
}
