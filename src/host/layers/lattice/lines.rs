//! Lines of a lattice that the warp interpolates along.

use super::Lattice;
use crate::layers::Rays;
use crate::viewport::Viewport;
use glam::{DMat3, DVec3};

/// Largest deviation from upright of a lattice line that still counts as upright, in samples over the height of the viewport.
const MAX_LEAN: f64 = 0.01;
/// Largest number of lattice lines per pixel that kernels/picture/lines.cl supports.
const MAX_LINES_PER_PIXEL: f64 = 4.0;

/// Lines of a lattice that the warp interpolates along: rows of pixels cross them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// Which coordinate is constant along each: 0 for u, 1 for v.
    pub axis: usize,
    /// Whether each is seen in one column of the screen.
    pub upright: bool,
}

impl Lines {
    /// Lines that rows of pixels cross; `None` where neither those of one u nor those of one v are crossed well.
    pub fn new(lattice: &Lattice, rays: &Rays, viewport: Viewport) -> Option<Self> {
        let from_screen = lattice.from_screen(rays);
        let upright = if lattice.is_parallel() { upright_lines(&from_screen, viewport) } else { None };
        let crossed = upright.or_else(|| crossed_lines(&from_screen, viewport));
        crossed.map(|axis| Self { axis, upright: upright.is_some() })
    }
}

/// The lattice axis that depends on screen x alone, if there is one: 0 for u, 1 for v. For parallel projections.
fn upright_lines(from_screen: &DMat3, viewport: Viewport) -> Option<usize> {
    let [x, y, _] = from_screen.to_cols_array_2d();
    let upright =
        |&i: &usize| y[i].abs() * f64::from(viewport.height) <= MAX_LEAN && x[i] != 0.0 && x[i].abs() <= MAX_LINES_PER_PIXEL;
    [0, 1].into_iter().find(upright)
}

/// Least number of lattice lines per pixel of a row that still crosses these lines well.
const MIN_LINES_PER_PIXEL: f64 = 0.05;

/// The lattice axis whose lines rows of pixels cross nearest to a right angle, if they cross few enough lines per pixel everywhere: 0 for
/// lines of one u, 1 for those of one v.
fn crossed_lines(from_screen: &DMat3, viewport: Viewport) -> Option<usize> {
    let [width, height] = [viewport.width, viewport.height].map(f64::from);
    // Steps of the lattice position from a pixel to the next, along x and y.
    let steps = |x: f64, y: f64| {
        let at = *from_screen * DVec3::new(x, y, 1.0);
        [0, 1].map(|axis| {
            let change = from_screen.col(axis);
            [0, 1].map(|i| (change[i] * at.z - at[i] * change.z) / (at.z * at.z))
        })
    };
    let corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)];
    let w = corners.map(|(x, y)| (*from_screen * DVec3::new(x, y, 1.0)).z);
    if !(w.iter().all(|&w| w > 0.0) || w.iter().all(|&w| w < 0.0)) {
        return None;
    }
    let [across, down] = steps(width / 2.0, height / 2.0);
    let axis = usize::from(across[1].abs() * down[0].abs() > across[0].abs() * down[1].abs());
    // Lines per pixel are a linear function of y, divided by the square of a linear function: at most these bounds between the corners.
    let linear = corners.map(|(x, y)| steps(x, y)[0][axis]).into_iter().zip(w).map(|(step, w)| step * w * w);
    let (lo, hi) = linear.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), n| (lo.min(n), hi.max(n)));
    let squares = w.map(|w| w * w);
    let (nearest, farthest) =
        (squares.iter().fold(f64::INFINITY, |a, &b| a.min(b)), squares.iter().fold(0.0_f64, |a, &b| a.max(b)));
    let least = if lo * hi > 0.0 { lo.abs().min(hi.abs()) / farthest } else { 0.0 };
    let most = lo.abs().max(hi.abs()) / nearest;
    (least >= MIN_LINES_PER_PIXEL && most <= MAX_LINES_PER_PIXEL).then_some(axis)
}
