//! The kinds of shapes.

use super::{Spheres, Triangles, Tubes};
use glam::{DMat4, DVec3};

/// What a set consists of.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Triangles.
    Triangles(Triangles),
    /// Spheres.
    Spheres(Spheres),
    /// Tubes.
    Tubes(Tubes),
}

impl From<Triangles> for Shape {
    fn from(triangles: Triangles) -> Self {
        Shape::Triangles(triangles)
    }
}

impl From<Spheres> for Shape {
    fn from(spheres: Spheres) -> Self {
        Shape::Spheres(spheres)
    }
}

impl From<Tubes> for Shape {
    fn from(tubes: Tubes) -> Self {
        Shape::Tubes(tubes)
    }
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Its lowest corner.
    pub lowest: DVec3,
    /// Its highest corner.
    pub highest: DVec3,
}

impl Bounds {
    /// The smallest box around two.
    pub fn and(self, other: Self) -> Self {
        Self { lowest: self.lowest.min(other.lowest), highest: self.highest.max(other.highest) }
    }

    /// The lowest and the highest corner.
    pub fn corners(self) -> [[f64; 3]; 2] {
        [self.lowest.to_array(), self.highest.to_array()]
    }

    /// Whether they have a point in common.
    pub fn meets(self, other: Self) -> bool {
        self.lowest.cmple(other.highest).all() && other.lowest.cmple(self.highest).all()
    }

    /// The smallest box around balls: centres and radii.
    pub(super) fn around(balls: impl Iterator<Item = (DVec3, f64)>) -> Option<Self> {
        balls.map(|(centre, radius)| Self { lowest: centre - radius, highest: centre + radius }).reduce(Self::and)
    }
}

impl Shape {
    /// Vertices of triangles, centres of spheres, points of lines, in the coordinates of the shape.
    pub fn places(&self) -> &[DVec3] {
        match self {
            Shape::Triangles(triangles) => triangles.points(),
            Shape::Spheres(spheres) => spheres.centres(),
            Shape::Tubes(tubes) => tubes.points(),
        }
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.places().len()
    }

    /// Number of cells: triangles, spheres or lines.
    pub fn cells(&self) -> usize {
        match self {
            Shape::Triangles(triangles) => triangles.indices().len(),
            Shape::Spheres(spheres) => spheres.centres().len(),
            Shape::Tubes(tubes) => tubes.lines().count(),
        }
    }

    /// Bounds in the world, by a matrix that scales radii by `scale`.
    pub(super) fn bounds(&self, matrix: DMat4, scale: f64) -> Option<Bounds> {
        let placed = |point: &DVec3| matrix.transform_point3(*point);
        match self {
            Shape::Triangles(triangles) => Bounds::around(triangles.points().iter().map(|p| (placed(p), 0.0))),
            Shape::Spheres(spheres) => {
                let balls = spheres.centres().iter().zip(spheres.radii());
                Bounds::around(balls.map(|(centre, radius)| (placed(centre), scale * radius)))
            }
            Shape::Tubes(tubes) => {
                let balls = tubes.points().iter().zip(tubes.radii());
                Bounds::around(balls.map(|(point, radius)| (placed(point), scale * radius)))
            }
        }
    }
}
