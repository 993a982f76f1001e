//! Triangles.

use crate::error::Error;
use glam::{DVec3, Vec3};

/// Triangles between points in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangles {
    points: Vec<DVec3>,
    indices: Vec<[u32; 3]>,
    normals: Option<Vec<Vec3>>,
}

impl Triangles {
    /// Triangles, each given by three indices into `points`. Triangles without an area are kept, and show nothing.
    ///
    /// # Errors
    /// If a point is not finite, or an index is not that of a point.
    pub fn new(points: Vec<DVec3>, indices: Vec<[u32; 3]>) -> Result<Self, Error> {
        check_points(&points)?;
        if let Some(index) = indices.iter().flatten().find(|&&index| index as usize >= points.len()) {
            return Err(error(format!("a triangle has point {index} of {}: indices count from 0", points.len())));
        }
        Ok(Self { points, indices, normals: None })
    }

    /// A normal per point, of any length; where it is 0 or not finite, that of the triangle is used.
    ///
    /// # Errors
    /// If there are not as many as points.
    pub fn with_normals(self, normals: Vec<Vec3>) -> Result<Self, Error> {
        if normals.len() != self.points.len() {
            return Err(error(format!("{} normals for {} points", normals.len(), self.points.len())));
        }
        Ok(Self { normals: Some(normals), ..self })
    }

    /// Positions in the world.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Indices of each triangle's points.
    pub fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }

    /// Normals of the points, if they have any.
    pub fn normals(&self) -> Option<&[Vec3]> {
        self.normals.as_deref()
    }

    /// Whether every edge belongs to two triangles, in opposite directions.
    pub fn is_closed(&self) -> bool {
        is_closed(&self.indices)
    }
}

/// Whether every edge of some triangles belongs to two of them, in opposite directions.
pub(super) fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<(u32, u32)> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    !edges.is_empty()
        && edges.windows(2).all(|pair| pair[0] != pair[1])
        && edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok())
}

fn error(problem: String) -> Error {
    Error::Surface { name: "triangles".into(), problem }
}

/// Points that are not finite have no place.
pub(super) fn check_points(points: &[DVec3]) -> Result<(), Error> {
    let Some(n) = points.iter().position(|point| !point.is_finite()) else { return Ok(()) };
    Err(error(format!("point {n} is {}: remove it, or give it a place", points[n])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_closed() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mut indices = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        assert!(Triangles::new(points.clone(), indices.clone()).unwrap().is_closed());
        indices.pop();
        assert!(!Triangles::new(points, indices).unwrap().is_closed());
    }

    #[test]
    fn wrong_points_and_indices_are_refused() {
        let error = |points, indices| Triangles::new(points, indices).unwrap_err().to_string();
        assert!(error(vec![DVec3::X; 2], vec![[0, 1, 2]]).contains("point 2 of 2"));
        assert!(error(vec![DVec3::X, DVec3::NAN], vec![]).contains("point 1 is"));
    }
}
