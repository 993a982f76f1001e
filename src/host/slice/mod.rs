//! Slices: rectangles of planes through a volume, on which its field is drawn.

mod axis;
mod patient;

pub use axis::SliceAxis;
pub use patient::{Convention, patient_letters};

use crate::error::Error;
use crate::files::write_whole;
use crate::npy;
use crate::viewport::Viewport;
use crate::volume::Grid;
use glam::DVec3;
use std::path::Path;

/// A rectangle of any plane, in world coordinates. Pixels are square.
///
/// Drawn by `Renderer::slice`.
///
/// ```
/// use layersplat::slice::{Slice, SliceAxis};
/// use layersplat::{Viewport, glam::DVec3, volume::Grid};
///
/// let (grid, viewport) = (Grid::new([64, 64, 32], DVec3::new(1.0, 1.0, 2.0))?, Viewport::new(200, 100)?);
/// let slice = Slice::at(&grid, SliceAxis::Z, 10.0, viewport)?;
/// assert_eq!(slice.centre, DVec3::new(31.5, 31.5, 20.0));
/// // 64 rows of voxels fit.
/// assert_eq!(slice.scale, 32.0);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// World point at the centre of the picture.
    pub centre: DVec3,
    /// World direction that points rightwards in the picture. Its length does not matter.
    pub right: DVec3,
    /// A vector that points upwards in the picture; it need not be orthogonal to `right`.
    pub up: DVec3,
    /// Half the height of the picture in world units, > 0.
    pub scale: f64,
}

/// Colours of a slice.
///
/// ```
/// use layersplat::slice::SliceColors;
///
/// // Soft tissue, for a CT in Hounsfield units.
/// let tissue = SliceColors::Window { level: 40.0, width: 400.0 };
/// assert_ne!(tissue, SliceColors::TRANSFER);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SliceColors {
    /// Grey: black at `level - width / 2` and below, white at `level + width / 2` and above, linear between.
    Window {
        /// Value shown as middle grey.
        level: f64,
        /// Width of the window in data values, > 0.
        width: f64,
    },
    /// Colours of the transfer function, with the opacity of a homogeneous layer of each value.
    Transfer {
        /// Thickness of the layer in unit distances (the smallest spacing), > 0. If infinite, all values with an opacity are opaque.
        thickness: f64,
    },
}

impl SliceColors {
    /// Opaque colours of the transfer function, where it has any opacity.
    pub const TRANSFER: Self = SliceColors::Transfer { thickness: f64::INFINITY };

    /// Rejects windows and layers that have no width.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] of the window or the thickness.
    pub fn check(&self) -> Result<(), Error> {
        match *self {
            SliceColors::Window { level, width } => {
                let (lo, hi) = (level - width / 2.0, level + width / 2.0);
                if lo.is_finite() && hi.is_finite() && lo < hi {
                    return Ok(());
                }
                let value = format!("{level},{width}");
                Err(Error::OutOfRange { name: "window", value, expected: "LEVEL,WIDTH with WIDTH above 0" })
            }
            SliceColors::Transfer { thickness } if thickness > 0.0 => Ok(()),
            SliceColors::Transfer { thickness } => {
                let expected = "a number of unit distances above 0, or infinity";
                Err(Error::OutOfRange { name: "thickness", value: thickness.to_string(), expected })
            }
        }
    }
}

/// The points of a slice's pixels, affine in the pixel coordinates (x, y), with pixel centres at half-integers:
/// `corner + x·right + y·down`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePixels {
    /// World point of the upper left corner of the picture.
    pub corner: DVec3,
    /// World vector to the next pixel on the right.
    pub right: DVec3,
    /// World vector to the next pixel below.
    pub down: DVec3,
}

impl SlicePixels {
    /// World point at pixel coordinates.
    pub fn point(&self, x: f64, y: f64) -> DVec3 {
        self.corner + x * self.right + y * self.down
    }

    /// Pixel coordinates of the point of the plane that is nearest to a world point.
    pub fn pixel(&self, point: DVec3) -> [f64; 2] {
        [self.right, self.down].map(|step| (point - self.corner).dot(step) / step.length_squared())
    }
}

impl Slice {
    /// The slice perpendicular to an axis at a coordinate along it: the number of a slice of voxels, or any number between two; for
    /// axial, coronal and sagittal slices a world coordinate ([`SliceAxis::range`]). It shows the whole volume.
    ///
    /// # Errors
    /// [`Error::Settings`] if the coordinate lies outside the volume, or the axis is that of a patient and the grid has none.
    pub fn at(grid: &Grid, axis: SliceAxis, at: f64, viewport: Viewport) -> Result<Self, Error> {
        let (lo, hi) = axis.range(grid)?;
        if !(lo..=hi).contains(&at) {
            let problem =
                format!("a slice at {at} along {} lies outside the volume, which is from {lo} to {hi} there", axis.name());
            return Err(Error::Settings { field: "at", problem });
        }
        Self::through(grid, axis, axis.point(grid, at)?, viewport)
    }

    /// The slice perpendicular to an axis through a world point. It shows the whole volume.
    ///
    /// # Errors
    /// [`Error::Settings`] if the axis is that of a patient and the grid has none.
    pub fn through(grid: &Grid, axis: SliceAxis, point: DVec3, viewport: Viewport) -> Result<Self, Error> {
        let [right, up] = axis.directions(grid)?;
        Ok(Self { centre: point, right, up, scale: 1.0 }.fitted(grid, viewport))
    }

    /// The slice through a world point that is seen from where `normal` points; `up` points upwards as far as possible. It shows the
    /// whole section through the volume.
    ///
    /// # Errors
    /// [`Error::Settings`] if a vector is not finite, or `up` is 0 or parallel to `normal`.
    pub fn facing(grid: &Grid, point: DVec3, normal: DVec3, up: DVec3, viewport: Viewport) -> Result<Self, Error> {
        let slice = Self { centre: point, right: up.cross(normal), up: normal.cross(up.cross(normal)), scale: 1.0 };
        slice.basis()?;
        Ok(slice.fitted_to_section(grid, viewport))
    }

    /// The same plane, centred and scaled so that the whole volume fits into the picture, projected onto the plane.
    pub fn fitted(self, grid: &Grid, viewport: Viewport) -> Self {
        self.fitted_to(&corners(grid), viewport)
    }

    /// The same plane, centred and scaled so that its section through the volume fits into the picture; the whole volume if there is none.
    pub fn fitted_to_section(self, grid: &Grid, viewport: Viewport) -> Self {
        let Ok(normal) = self.normal() else { return self };
        let corners = corners(grid);
        let height = |n: usize| (corners[n] - self.centre).dot(normal);
        // Edges lead from each corner to those with one more upper side.
        let edges = (0..8).flat_map(|n| (0..3).filter(move |i| n >> i & 1 == 0).map(move |i| (n, n | 1 << i)));
        let crossings: Vec<DVec3> = edges
            .filter(|&(a, b)| height(a).min(height(b)) <= 0.0 && height(a).max(height(b)) >= 0.0 && height(a) != height(b))
            .map(|(a, b)| corners[a].lerp(corners[b], height(a) / (height(a) - height(b))))
            .collect();
        let fitted = self.fitted_to(&crossings, viewport);
        // A plane may touch a corner only.
        if crossings.len() < 3 || fitted.basis().is_err() { self.fitted_to(&corners, viewport) } else { fitted }
    }

    fn fitted_to(self, points: &[DVec3], viewport: Viewport) -> Self {
        let Ok([right, up]) = self.basis() else { return self };
        let (mut lowest, mut highest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points.iter().map(|point| point - self.centre) {
            for (n, at) in [point.dot(right), point.dot(up)].into_iter().enumerate() {
                (lowest[n], highest[n]) = (lowest[n].min(at), highest[n].max(at));
            }
        }
        let [half_width, half_height] = [0, 1].map(|n| (highest[n] - lowest[n]) / 2.0);
        let centre = self.centre + right * (lowest[0] + half_width) + up * (lowest[1] + half_height);
        let scale = half_height.max(half_width * f64::from(viewport.height) / f64::from(viewport.width));
        Self { centre, scale, ..self }
    }

    /// Unit vectors rightwards and upwards.
    ///
    /// # Errors
    /// [`Error::Settings`] if they are not finite, 0 or parallel, or if centre or scale are not finite or the scale is not above 0.
    pub fn basis(&self) -> Result<[DVec3; 2], Error> {
        let refused = |problem: String| Err(Error::Settings { field: "plane", problem });
        let Self { centre, right, up, scale } = *self;
        if !centre.is_finite() {
            return refused(format!("the centre of the slice, {centre}, is not finite"));
        }
        if !(scale > 0.0 && scale.is_finite()) {
            return refused(format!("half the height of the slice is {scale}: it must be a number above 0"));
        }
        let unit_right = right.try_normalize();
        let Some([unit_right, unit_up]) = unit_right
            .zip(up.try_normalize())
            .and_then(|(right, up)| Some([right, (up - right * up.dot(right)).try_normalize()?]))
            .filter(|[right, up]| right.dot(*up).abs() < 1e-6)
        else {
            return refused(format!("{right} and {up} span no plane: they must be finite, not 0 and not parallel"));
        };
        Ok([unit_right, unit_up])
    }

    /// Direction from the plane to the viewer, of unit length.
    ///
    /// # Errors
    /// Those of [`basis`](Self::basis).
    pub fn normal(&self) -> Result<DVec3, Error> {
        let [right, up] = self.basis()?;
        Ok(right.cross(up))
    }

    /// The points of the pixels of a picture.
    ///
    /// # Errors
    /// Those of [`basis`](Self::basis).
    pub fn pixels(&self, viewport: Viewport) -> Result<SlicePixels, Error> {
        let [right, up] = self.basis()?;
        let [width, height] = [viewport.width, viewport.height].map(f64::from);
        let side = 2.0 * self.scale / height;
        let corner = self.centre - right * (side * width / 2.0) + up * self.scale;
        Ok(SlicePixels { corner, right: right * side, down: up * -side })
    }
}

/// World points of the corners of a volume, half a voxel beyond its outermost voxels. Bit i of the index: at the upper side of axis i.
fn corners(grid: &Grid) -> [DVec3; 8] {
    let last = DVec3::from_array(grid.dims().map(|n| n as f64 - 0.5));
    std::array::from_fn(|n| {
        let corner = DVec3::from_array(std::array::from_fn(|i| if n >> i & 1 == 1 { last[i] } else { -0.5 }));
        grid.index_to_world().transform_point3(corner)
    })
}

/// Values of the field on the pixels of a slice, row by row, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceValues {
    viewport: Viewport,
    values: Vec<f32>,
}

impl SliceValues {
    /// One value per pixel; NaN outside the volume.
    #[doc(hidden)]
    pub fn new(viewport: Viewport, values: Vec<f32>) -> Self {
        assert_eq!(values.len(), viewport.pixels());
        Self { viewport, values }
    }

    /// Size of the picture.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Writes a NumPy array, float32, of shape (height, width), atomically.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let shape = [self.viewport.height, self.viewport.width].map(|side| side as usize);
        write_whole(path.as_ref(), |out| npy::write(out, &shape, &self.values))
    }

    /// Data value of each pixel, NaN outside the volume.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    const ROUNDING: f64 = 1e-12;

    fn grid() -> Grid {
        let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(-0.4);
        Grid::oriented([20, 30, 10], DVec3::new(0.5, 0.7, 2.0), DVec3::new(3.0, -5.0, 11.0), turn).unwrap()
    }

    /// Pixels of a slice of voxels are those voxels, in rows and columns.
    #[test]
    fn pixels_meet_voxels() {
        let grid = Grid::new([20, 30, 10], DVec3::splat(0.5)).unwrap();
        let viewport = Viewport::new(20, 30).unwrap();
        let pixels = Slice::at(&grid, SliceAxis::Z, 4.0, viewport).unwrap().pixels(viewport).unwrap();
        for (x, y) in [(0, 0), (19, 29), (7, 11)] {
            let voxel = grid.world_to_voxel(pixels.point(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let expected = DVec3::new(f64::from(x), f64::from(29 - y), 4.0);
            assert!(voxel.distance(expected) < ROUNDING, "{voxel} at {x} {y}");
        }
    }

    #[test]
    fn points_have_pixels() {
        let viewport = Viewport::new(40, 30).unwrap();
        let slice = Slice::facing(&grid(), grid().centre(), DVec3::new(1.0, 2.0, -0.5), DVec3::Z, viewport).unwrap();
        let pixels = slice.pixels(viewport).unwrap();
        let [x, y] = pixels.pixel(pixels.point(3.25, 17.5) + slice.normal().unwrap() * 2.0);
        assert!((x - 3.25).abs() < ROUNDING && (y - 17.5).abs() < ROUNDING, "{x} {y}");
        assert!(slice.normal().unwrap().dot(DVec3::new(1.0, 2.0, -0.5)) > 0.0, "seen from where the normal points");
        assert!(pixels.down.z < 0.0, "up is up");
    }

    /// The largest share of the picture's width or height that points take, which must lie in it.
    fn share(slice: Slice, viewport: Viewport, points: &[DVec3]) -> f64 {
        let pixels = slice.pixels(viewport).unwrap();
        let sides = [f64::from(viewport.width), f64::from(viewport.height)];
        let shares = [0, 1].map(|n| {
            let at = points.iter().map(|&point| pixels.pixel(point)[n]);
            let (lo, hi) = at.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), at| (lo.min(at), hi.max(at)));
            assert!(lo > -1e-9 && hi < sides[n] + 1e-9, "{lo} to {hi} of {}", sides[n]);
            (hi - lo) / sides[n]
        });
        shares[0].max(shares[1])
    }

    /// The picture contains the whole volume, or the whole section, and no more.
    #[test]
    fn volumes_and_sections_fit() {
        let grid = grid();
        let normal = DVec3::new(0.3, -0.8, 0.5).normalize();
        for viewport in [Viewport::new(100, 20).unwrap(), Viewport::new(20, 100).unwrap()] {
            let section = Slice::facing(&grid, grid.centre(), normal, DVec3::Y, viewport).unwrap();
            let whole = section.fitted(&grid, viewport);
            assert!((share(whole, viewport, &corners(&grid)) - 1.0).abs() < 1e-9);
            assert!(section.scale < whole.scale && (section.centre - grid.centre()).dot(normal).abs() < 1e-9);
            // Points of the plane on the surface of the volume.
            let pixels = section.pixels(viewport).unwrap();
            let inside = |point: DVec3| {
                let voxel = grid.world_to_voxel(point);
                (0..3).all(|i| (-0.5..=grid.dims()[i] as f64 - 0.5).contains(&voxel[i]))
            };
            let [w, h] = [f64::from(viewport.width), f64::from(viewport.height)];
            let rim = (0..=400).flat_map(|n| {
                let t = f64::from(n) / 400.0;
                [(t * w, -0.01 * h), (t * w, 1.01 * h), (-0.01 * w, t * h), (1.01 * w, t * h)]
            });
            assert!(rim.clone().all(|(x, y)| !inside(pixels.point(x, y))), "nothing of the section lies outside the picture");
            let smaller = Slice { scale: 0.9 * section.scale, ..section }.pixels(viewport).unwrap();
            assert!(rim.clone().any(|(x, y)| inside(smaller.point(x, y))), "a smaller picture is noticed");
        }
        // A plane beside the volume.
        let viewport = Viewport::new(20, 20).unwrap();
        let beside = Slice::facing(&grid, grid.centre() + 100.0 * normal, normal, DVec3::Y, viewport).unwrap();
        assert!(beside.basis().is_ok());
    }

    #[test]
    fn what_spans_no_plane_is_refused() {
        let good = Slice { centre: DVec3::ZERO, right: DVec3::X, up: DVec3::new(1.0, 1.0, 0.0), scale: 2.0 };
        assert!(good.basis().unwrap()[1].distance(DVec3::Y) < ROUNDING);
        for bad in [
            Slice { right: DVec3::ZERO, ..good },
            Slice { up: DVec3::X, ..good },
            Slice { up: DVec3::NAN, ..good },
            Slice { scale: 0.0, ..good },
            Slice { scale: f64::INFINITY, ..good },
            Slice { centre: DVec3::INFINITY, ..good },
        ] {
            assert_eq!(bad.basis().unwrap_err().fields(), ["plane"], "{bad:?}");
        }
        let grid = grid();
        let viewport = Viewport::new(8, 8).unwrap();
        assert!(Slice::facing(&grid, DVec3::ZERO, DVec3::Z, DVec3::Z, viewport).is_err());
        let message = Slice::at(&grid, SliceAxis::X, 20.0, viewport).unwrap_err().to_string();
        assert!(message.contains("from -0.5 to 19.5"), "{message}");
        for colors in [
            SliceColors::Window { level: 0.0, width: 0.0 },
            SliceColors::Window { level: f64::NAN, width: 1.0 },
            SliceColors::Transfer { thickness: 0.0 },
            SliceColors::Transfer { thickness: f64::NAN },
        ] {
            assert!(colors.check().is_err(), "{colors:?}");
        }
        assert!(SliceColors::TRANSFER.check().is_ok());
    }
}
