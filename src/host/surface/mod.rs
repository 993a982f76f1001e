//! Surfaces in the world: triangles, spheres and tubes, which are drawn in and around volumes.

mod attributes;
mod format;
mod open;
mod shapes;
mod space;
mod spheres;
mod triangles;
mod tubes;

pub use attributes::{DEFAULT_COLORS, Per};
pub use format::{Cells, PointData, SurfaceArray, SurfaceFile};
pub use open::{Radius, SurfaceOptions, default_radius, open};
pub use shapes::{Bounds, Shape};
pub use space::Space;
pub use spheres::Spheres;
pub use triangles::Triangles;
pub use tubes::{Ends, Tubes};

use crate::choice::choices;
use crate::error::Error;
use crate::transfer::TransferFunction;
use glam::DMat4;
use std::sync::Arc;

/// How the lights shade a surface. Both of its sides are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceShading {
    /// By normals that are interpolated: between the points of triangles, where these have normals, and along tubes from joint to joint.
    #[default]
    Smooth,
    /// By the normals of each triangle and of each piece of a tube.
    Flat,
    /// Its colours, without light.
    Off,
}

choices! { SurfaceShading, "shading"; Smooth = "smooth", Flat = "flat", Off = "off" }

/// A set of triangles, spheres or tubes, and how it looks. Clones share its points, cells and attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    shape: Arc<Shape>,
    colors: Option<Arc<Per<[f32; 4]>>>,
    values: Option<(Arc<Per<f32>>, TransferFunction)>,
    matrix: DMat4,
    /// Its name in legends and messages.
    pub name: String,
    /// Colour without `colors` and `values`: red, green and blue, as those of transfer functions.
    pub color: [f32; 3],
    /// Opacity of a fragment, 0 … 1. It multiplies that of `colors`.
    pub opacity: f32,
    /// Whether it is drawn.
    pub is_visible: bool,
    /// How lights shade it.
    pub shading: SurfaceShading,
    /// Whether the crop box and the clip planes cut it.
    pub is_clipped: bool,
}

impl Surface {
    /// An opaque, light grey set.
    pub fn new(name: impl Into<String>, shape: impl Into<Shape>) -> Self {
        Self {
            shape: Arc::new(shape.into()),
            colors: None,
            values: None,
            matrix: DMat4::IDENTITY,
            name: name.into(),
            color: [0.8; 3],
            opacity: 1.0,
            is_visible: true,
            shading: SurfaceShading::default(),
            is_clipped: true,
        }
    }

    /// Straight red, green, blue and alpha, 0 … 1, of each point or cell.
    ///
    /// # Errors
    /// If their number differs from that of the points or cells, or one is outside its range.
    pub fn with_colors(self, colors: Per<[f32; 4]>) -> Result<Self, Error> {
        self.check_count("colours", &colors)?;
        if let Some(color) = colors.entries().iter().find(|color| !color.iter().all(|c| (0.0..=1.0).contains(c))) {
            return Err(self.error(format!("a colour is {color:?}: red, green, blue and alpha are between 0 and 1")));
        }
        Ok(Self { colors: Some(Arc::new(colors)), ..self })
    }

    /// A value of each point or cell, whose colour is that of a transfer function. Opacities of the transfer function are not used.
    /// Values that are not finite have the colour of the set.
    ///
    /// # Errors
    /// If their number differs from that of the points or cells.
    pub fn with_values(self, values: Per<f32>, transfer: TransferFunction) -> Result<Self, Error> {
        self.check_count("values", &values)?;
        Ok(Self { values: Some((Arc::new(values), transfer)), ..self })
    }

    /// Places the set in the world by a matrix: an affine one with an inverse. Spheres and tubes stay round, so for these it may only move,
    /// turn, mirror and scale alike along all axes.
    ///
    /// # Errors
    /// Other matrices.
    pub fn with_matrix(self, matrix: DMat4) -> Result<Self, Error> {
        if !matrix.is_finite() || matrix.row(3) != glam::DVec4::W || matrix.determinant() == 0.0 {
            return Err(self.error("its matrix is not affine, or has no inverse: give 12 numbers, row by row".into()));
        }
        if !matches!(*self.shape, Shape::Triangles(_)) && uniform_scale(matrix).is_none() {
            return Err(self.error("its matrix deforms spheres or tubes: scale alike along all axes".into()));
        }
        Ok(Self { matrix, ..self })
    }

    /// What it consists of.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Colours of points or cells.
    pub fn colors(&self) -> Option<&Per<[f32; 4]>> {
        self.colors.as_deref()
    }

    /// Values of points or cells, and their colours.
    pub fn values(&self) -> Option<(&Per<f32>, &TransferFunction)> {
        self.values.as_ref().map(|(values, transfer)| (&**values, transfer))
    }

    /// From the coordinates of the shape to the world.
    pub fn matrix(&self) -> DMat4 {
        self.matrix
    }

    /// Factor of radii: by how much the matrix scales spheres and tubes.
    pub fn scale(&self) -> f64 {
        uniform_scale(self.matrix).unwrap_or(1.0)
    }

    /// Its bounds in the world, whether it is visible or not; `None` if it has no points.
    pub fn bounds(&self) -> Option<Bounds> {
        self.shape.bounds(self.matrix, self.scale())
    }

    /// Whether it can have fragments: it is visible, and neither empty nor wholly transparent.
    pub fn is_drawn(&self) -> bool {
        self.is_visible && self.opacity > 0.0 && self.shape.cells() > 0
    }

    /// Whether any fragment of it can be translucent.
    pub fn is_translucent(&self) -> bool {
        self.opacity < 1.0 || self.colors.as_ref().is_some_and(|colors| colors.entries().iter().any(|c| c[3] < 1.0))
    }

    fn check_count<T>(&self, what: &str, entries: &Per<T>) -> Result<(), Error> {
        let (expected, element) = match entries {
            Per::Point(_) => (self.shape.points(), "points"),
            Per::Cell(_) => (self.shape.cells(), "cells"),
        };
        let found = entries.entries().len();
        if found == expected { Ok(()) } else { Err(self.error(format!("{found} {what} for {expected} {element}"))) }
    }

    fn error(&self, problem: String) -> Error {
        Error::Surface { name: self.name.clone(), problem }
    }
}

/// The factor by which a matrix scales all lengths, if there is one.
fn uniform_scale(matrix: DMat4) -> Option<f64> {
    /// Rounding of matrices in files.
    const TOLERANCE: f64 = 1e-4;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(glam::DVec4::truncate);
    let squares = axes.map(glam::DVec3::length_squared);
    let scale = (squares.iter().sum::<f64>() / 3.0).sqrt();
    let is_uniform = (0..3).all(|i| {
        let product = axes[i].dot(axes[(i + 1) % 3]);
        (squares[i] - scale * scale).abs() <= TOLERANCE * scale * scale && product.abs() <= TOLERANCE * scale * scale
    });
    is_uniform.then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn matrices_that_deform_spheres_are_refused() {
        let spheres = Surface::new("s", Spheres::new(vec![DVec3::X], vec![2.0]).unwrap());
        let turned = DMat4::from_scale(DVec3::splat(3.0)) * DMat4::from_rotation_z(0.3);
        let placed = spheres.clone().with_matrix(turned).unwrap();
        assert!((placed.scale() - 3.0).abs() < 1e-12);
        let bounds = placed.bounds().unwrap();
        assert!(((bounds.highest - bounds.lowest) - DVec3::splat(12.0)).length() < 1e-9, "{bounds:?}");
        let message = spheres.with_matrix(DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0))).unwrap_err().to_string();
        assert!(message.contains("scale alike"), "{message}");
    }

    #[test]
    fn counts_are_compared() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let triangle = Surface::new("t", Triangles::new(points, vec![[0, 1, 2]]).unwrap());
        assert!(triangle.clone().with_colors(Per::Point(vec![[1.0; 4]; 3])).is_ok());
        assert!(triangle.clone().with_colors(Per::Cell(vec![[1.0; 4]; 1])).is_ok());
        let message = triangle.with_colors(Per::Point(vec![[1.0; 4]; 2])).unwrap_err().to_string();
        assert_eq!(message, "surface t: 2 colours for 3 points");
    }
}
