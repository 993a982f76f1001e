//! What of a convex region a view shows, and how large pixels are there.

use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::viewport::Viewport;
use glam::{DMat3, DVec3};

/// The side of a plane to which its normal points: a point, and the normal of any length above 0.
pub type HalfSpace = (DVec3, DVec3);

/// The part of a region that a view shows.
///
/// ```
/// use layersplat::framing::Sight;
/// use layersplat::glam::DVec3;
/// use layersplat::{Camera, Orbit, Projection, Viewport};
///
/// let camera = Camera::orbit(DVec3::ZERO, 10.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
/// let slab = [(DVec3::ZERO, DVec3::Z), (DVec3::Z, DVec3::NEG_Z)];
/// let sight = Sight::new(&camera, Viewport::new(200, 100)?, 1.0, &slab)?.expect("it is in view");
/// assert_eq!((sight.corners.len(), sight.pixel), (8, 0.02));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Its corners in the world.
    pub corners: Vec<DVec3>,
    /// Side of a pixel in world units, in perspectives at the corner that is nearest to the eye.
    pub pixel: f64,
}

/// Share of the region's size within which a corner is on the planes beside it.
const ROUNDING: f64 = 1e-9;
/// Volume of the box of three unit normals of which two count as parallel.
const PARALLEL: f64 = 1e-12;

impl Sight {
    /// What a view shows of the region that all of `sides` have in common; `None` if that is nothing. `pixel_aspect`: width of pixels by their
    /// height.
    ///
    /// # Errors
    /// For cameras that are not valid.
    pub fn new(camera: &Camera, viewport: Viewport, pixel_aspect: f64, sides: &[HalfSpace]) -> Result<Option<Self>, Error> {
        let basis = camera.basis()?;
        let eye = camera.position;
        let aspect = f64::from(viewport.width) / f64::from(viewport.height) * pixel_aspect;
        let across = |half: f64| [(basis.right, half * aspect), (basis.up, half)];
        let (half, of_view): (f64, Vec<HalfSpace>) = match camera.projection {
            Projection::Parallel { scale } => {
                let pair = |(axis, half): (DVec3, f64)| [(eye - axis * half, axis), (eye + axis * half, -axis)];
                (scale, across(scale).into_iter().flat_map(pair).collect())
            }
            Projection::Perspective { field_of_view } => {
                let slope = (field_of_view.to_radians() / 2.0).tan();
                let pair = |(axis, slope): (DVec3, f64)| [axis, -axis].map(|axis| (eye, basis.forward * slope + axis));
                (slope, across(slope).into_iter().flat_map(pair).collect())
            }
        };
        let sides: Vec<HalfSpace> = of_view.iter().chain(sides).map(|&(point, normal)| (point, normal.normalize())).collect();
        let corners = corners(&sides);
        let depths = corners.iter().map(|&corner| (corner - eye).dot(basis.forward));
        let nearest = depths.fold(f64::INFINITY, f64::min).max(0.0);
        let pixel = 2.0 * half / f64::from(viewport.height) * pixel_aspect.min(1.0);
        let pixel = if let Projection::Perspective { .. } = camera.projection { pixel * nearest } else { pixel };
        Ok((!corners.is_empty()).then_some(Self { corners, pixel }))
    }
}

/// The points that three planes have in common and that are in front of all others.
fn corners(sides: &[HalfSpace]) -> Vec<DVec3> {
    let size = sides.iter().map(|(point, _)| point.abs().max_element()).fold(0.0, f64::max);
    let is_inside = |corner: DVec3| sides.iter().all(|(point, normal)| (corner - point).dot(*normal) >= -ROUNDING * size);
    let mut found = Vec::new();
    for (k, c) in sides.iter().enumerate() {
        for (j, b) in sides[..k].iter().enumerate() {
            for a in &sides[..j] {
                let normals = DMat3::from_cols(a.1, b.1, c.1).transpose();
                if normals.determinant().abs() > PARALLEL {
                    found.push(normals.inverse() * DVec3::new(a.1.dot(a.0), b.1.dot(b.0), c.1.dot(c.0)));
                }
            }
        }
    }
    found.retain(|&corner| is_inside(corner));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;

    fn cube(half: f64) -> Vec<HalfSpace> {
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [(-axis * half, axis), (axis * half, -axis)]).collect()
    }

    fn bounds(sight: &Sight) -> [DVec3; 2] {
        let corners = || sight.corners.iter().copied();
        [corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max)]
    }

    #[test]
    fn a_column_is_seen_in_parallel() {
        let camera = Camera::orbit(DVec3::new(3.0, 1.0, 0.0), 50.0, Orbit::default(), Projection::Parallel { scale: 2.0 });
        let view = Viewport::new(300, 100).unwrap();
        let sight = Sight::new(&camera, view, 1.0, &cube(8.0)).unwrap().unwrap();
        let [lowest, highest] = bounds(&sight);
        assert!(lowest.abs_diff_eq(DVec3::new(-3.0, -1.0, -8.0), 1e-9), "{lowest}");
        assert!(highest.abs_diff_eq(DVec3::new(8.0, 3.0, 8.0), 1e-9) && sight.pixel == 0.04, "{highest}");
        // A plane that leaves a corner.
        let cut = [cube(8.0), vec![(DVec3::splat(2.0), DVec3::ONE)]].concat();
        let [lowest, _] = bounds(&Sight::new(&camera, view, 1.0, &cut).unwrap().unwrap());
        assert!(lowest.abs_diff_eq(DVec3::new(-3.0, -1.0, -5.0), 1e-9), "{lowest}");
        let away = Camera::orbit(DVec3::new(30.0, 0.0, 0.0), 50.0, Orbit::default(), Projection::Parallel { scale: 2.0 });
        assert_eq!(Sight::new(&away, view, 1.0, &cube(8.0)).unwrap(), None);
    }

    #[test]
    fn perspectives_have_the_pixels_of_the_nearest_corner() {
        let from = |distance| {
            let projection = Projection::Perspective { field_of_view: 90.0 };
            let camera = Camera::orbit(DVec3::ZERO, distance, Orbit::default(), projection);
            Sight::new(&camera, Viewport::new(100, 100).unwrap(), 1.0, &cube(8.0)).unwrap().unwrap()
        };
        // Four units in front of the cube, of whose front the view shows a square of that half width.
        let sight = from(12.0);
        assert!((sight.pixel - 0.08).abs() < 1e-12, "{}", sight.pixel);
        assert!(sight.corners.iter().any(|corner| corner.abs_diff_eq(DVec3::new(4.0, -4.0, 8.0), 1e-9)));
        // From inside, the eye is a corner, and what is behind it is not seen.
        let inside = from(5.0);
        let [_, highest] = bounds(&inside);
        assert!(inside.pixel < 1e-9 && (highest.z - 5.0).abs() < 1e-9, "{highest}");
    }
}
