//! What points and cells of shapes have.

/// An entry per point, or per cell: a triangle, a sphere or a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Per<T> {
    /// Interpolated between points.
    Point(Vec<T>),
    /// Constant within a cell.
    Cell(Vec<T>),
}

impl<T> Per<T> {
    /// All entries.
    pub fn entries(&self) -> &[T] {
        match self {
            Per::Point(entries) | Per::Cell(entries) => entries,
        }
    }
}
