//! Cameras.

use crate::objects::Object;
use crate::status::Problem;
use layersplat::glam::DVec3;
use layersplat::settings::{ClipPlane, Clipping};
use layersplat::{Basis, Camera, Projection, Settings, Viewport};
use std::ops::Range;

/// A view of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    pub camera: Camera,
    /// The part of a larger picture that the frame shows, if it does.
    pub part: Option<Part>,
    /// Width of a pixel in heights of a pixel.
    pub pixel_aspect: f64,
    pub clipping: Clipping,
}

/// A part of a picture: columns and rows from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub whole: Viewport,
    pub columns: Range<u32>,
    pub rows: Range<u32>,
}

/// Largest relative difference of a part's size from whole pixels that is not told.
const ROUNDING: f64 = 1e-3;

/// Aspects of pixels that differ less from 1 are rounding of a float: pixels are square.
const SQUARE: f64 = 1e-5;

/// The whole view in normalised screen coordinates.
const WHOLE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];

impl View {
    /// The view of a camera. Problems are what is drawn otherwise than it was asked for.
    ///
    /// # Errors
    /// Cameras that show nothing: without a direction, or looking upwards.
    pub fn from_object(object: &Object, viewport: Viewport, problems: &mut Vec<Problem>) -> Result<Self, Problem> {
        let vector = |name| object.floats::<3>(name).map_or(DVec3::ZERO, |v| DVec3::from_array(v.map(f64::from)));
        let position = vector(c"position");
        let [direction, view_up] = [vector(c"direction"), vector(c"up")];
        let focal_point = position + direction.try_normalize().unwrap_or(DVec3::ZERO);
        let projection = match object.float(c"height") {
            Some(height) => Projection::Parallel { scale: f64::from(height) / 2.0 },
            None => {
                let angle = f64::from(object.float(c"fovy").unwrap_or(std::f32::consts::FRAC_PI_3));
                Projection::Perspective { field_of_view: angle.to_degrees() }
            }
        };
        let camera = Camera { position, focal_point, view_up, projection };
        let basis = camera.basis().map_err(|error| Problem::argument(error.to_string()))?;
        let asked = object.floats::<4>(c"imageRegion").map_or(WHOLE, |region| region.map(f64::from));
        let region = if asked[0] < asked[2] && asked[1] < asked[3] {
            asked
        } else {
            problems
                .push(Problem::argument(format!("imageRegion is {asked:?}: mirrored and empty regions are drawn as the whole")));
            WHOLE
        };
        let pixel_aspect = pixel_aspect(object, region, viewport, problems);
        let clipping = clipping(object, position, basis);
        let whole = Self { camera, part: None, pixel_aspect, clipping };
        if region == WHOLE {
            return Ok(whole);
        }
        Ok(match projection {
            Projection::Parallel { scale } => {
                Self { camera: shifted(camera, basis, scale, region, viewport, pixel_aspect), ..whole }
            }
            Projection::Perspective { .. } => Self { part: part(region, viewport, problems), ..whole },
        })
    }

    /// Factors from depths along the view direction to distances from the eye, per pixel of the whole picture, rows from the top.
    pub fn stretch(&self, whole: Viewport) -> impl Fn(u32, u32) -> f64 + use<> {
        let tangent = match self.camera.projection {
            Projection::Perspective { field_of_view } => (field_of_view.to_radians() / 2.0).tan(),
            Projection::Parallel { .. } => 0.0,
        };
        let pixel = 2.0 * tangent / f64::from(whole.height);
        let [width, height] = [whole.width, whole.height].map(f64::from);
        let pixel_aspect = self.pixel_aspect;
        move |column, row| {
            let x = (f64::from(column) + 0.5 - width / 2.0) * pixel * pixel_aspect;
            let y = (f64::from(row) + 0.5 - height / 2.0) * pixel;
            (1.0 + x * x + y * y).sqrt()
        }
    }
}

/// Width of a pixel in heights of a pixel, of a frame that shows a region of a view that is `aspect` times as wide as high. Without an
/// `aspect`, pixels are square.
fn pixel_aspect(object: &Object, [x0, y0, x1, y1]: [f64; 4], viewport: Viewport, problems: &mut Vec<Problem>) -> f64 {
    let Some(aspect) = object.float(c"aspect").map(f64::from) else { return 1.0 };
    let pixel = aspect * (x1 - x0) * f64::from(viewport.height) / ((y1 - y0) * f64::from(viewport.width));
    if (pixel - 1.0).abs() < SQUARE {
        return 1.0;
    }
    if !Settings::PIXEL_ASPECT.contains(pixel) {
        let text =
            format!("aspect is {aspect}: pixels would be {pixel} times as wide as high (1/16 to 16 is possible), and are square");
        problems.push(Problem::argument(text));
        return 1.0;
    }
    pixel
}

/// The clip planes of a camera.
fn clipping(object: &Object, position: DVec3, basis: Basis) -> Clipping {
    let plane = |distance: f32, side: f64| ClipPlane {
        point: position + basis.forward * f64::from(distance),
        normal: basis.forward * side,
    };
    let near = object.float(c"near").filter(|&near| near > 0.0).map(|near| plane(near, 1.0));
    let far = object.float(c"far").map(|far| plane(far, -1.0));
    Clipping::default().with_planes(near.into_iter().chain(far))
}

/// A parallel camera that shows a region of another's view.
fn shifted(
    camera: Camera,
    basis: Basis,
    scale: f64,
    [x0, y0, x1, y1]: [f64; 4],
    viewport: Viewport,
    pixel_aspect: f64,
) -> Camera {
    let pixel = 2.0 * scale * (y1 - y0) / f64::from(viewport.height) * pixel_aspect;
    let width = pixel * f64::from(viewport.width) / (x1 - x0);
    let shift = basis.right * ((x0 + x1) / 2.0 - 0.5) * width + basis.up * ((y0 + y1) / 2.0 - 0.5) * 2.0 * scale;
    let projection = Projection::Parallel { scale: scale * (y1 - y0) };
    Camera { position: camera.position + shift, focal_point: camera.focal_point + shift, projection, ..camera }
}

/// The part of a perspective: whole pixels of a larger picture.
fn part([x0, y0, x1, y1]: [f64; 4], viewport: Viewport, problems: &mut Vec<Problem>) -> Option<Part> {
    let along = |from: f64, to: f64, pixels: u32| {
        let whole = f64::from(pixels) / (to - from);
        let first = from * whole;
        let is_exact = (whole - whole.round()).abs() < ROUNDING && (first - first.round()).abs() < ROUNDING;
        (whole.round(), first.round(), is_exact)
    };
    let (width, column, exact_columns) = along(x0, x1, viewport.width);
    let (height, row, exact_rows) = along(1.0 - y1, 1.0 - y0, viewport.height);
    let fits = |first: f64, pixels: u32, whole: f64| first >= 0.0 && first + f64::from(pixels) <= whole;
    let sizes = [width, height].map(|side| side as u32);
    let whole = Viewport::new(sizes[0], sizes[1]).ok();
    let Some(whole) = whole.filter(|_| fits(column, viewport.width, width) && fits(row, viewport.height, height)) else {
        problems.push(Problem::argument(
            "imageRegion of a perspective must lie within 0 to 1, in a whole of at most 16384 pixels per side: the whole is drawn",
        ));
        return None;
    };
    if !(exact_columns && exact_rows) {
        problems.push(Problem::argument("imageRegion of a perspective is rounded to whole pixels"));
    }
    let [column, row] = [column, row].map(|first| first as u32);
    Some(Part { whole, columns: column..column + viewport.width, rows: row..row + viewport.height })
}

impl Default for View {
    /// The view of a camera without parameters.
    fn default() -> Self {
        let projection = Projection::Perspective { field_of_view: 60.0 };
        let camera = Camera { position: DVec3::ZERO, focal_point: DVec3::NEG_Z, view_up: DVec3::Y, projection };
        Self { camera, part: None, pixel_aspect: 1.0, clipping: Clipping::default() }
    }
}
