//! World axes, drawn as arrows in a corner.

use super::canvas::Canvas;
use super::extent::Extent;
use super::screen::Screen;
use glam::{DVec2, DVec3};

/// Length of an axis parallel to the screen, in pixels at scale 1.
const LENGTH: f64 = 30.0;
/// Distance of the origin from the corner, in pixels at scale 1.
const MARGIN: f64 = 50.0;
/// Shorter side of a picture, in pixels at scale 1, below which the axes shrink.
const SMALL: f64 = 160.0;
const AXES: [(DVec3, &str, [u8; 3]); 3] =
    [(DVec3::X, "x", [232, 88, 80]), (DVec3::Y, "y", [96, 190, 90]), (DVec3::Z, "z", [88, 144, 240])];
/// Least projected length of an axis with an arrowhead, relative to its length.
const SHORT: f64 = 0.12;

/// Size of axes that have room of their own, which a picture loses, relative to those over the picture.
const BESIDE: f64 = 0.75;

/// Height of the strip at the lower edge that the axes take.
pub(super) fn room(extent: Extent) -> f64 {
    2.0 * MARGIN * BESIDE * unit(extent)
}

/// Pixels at scale 1. Small pictures get proportionally smaller axes.
fn unit(Extent { viewport, scale }: Extent) -> f64 {
    scale * (f64::from(viewport.width.min(viewport.height)) / SMALL).min(1.0)
}

/// Draws the axes, smaller ones if they are `beside` the picture.
pub(super) fn draw(screen: &Screen, beside: bool, canvas: &mut Canvas) {
    let viewport = canvas.viewport();
    let scale = unit(canvas.extent()) * if beside { BESIDE } else { 1.0 };
    let origin = DVec2::new(MARGIN * scale, f64::from(viewport.height) - MARGIN * scale);
    let basis = screen.basis();
    let mut axes = AXES.map(|(axis, name, color)| {
        let seen = DVec2::new(axis.dot(basis.right), -axis.dot(basis.up));
        (seen, axis.dot(basis.forward), name, color)
    });
    // Back to front.
    axes.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (seen, _, name, color) in axes {
        let tip = origin + seen * LENGTH * scale;
        canvas.line(origin, tip, 2.0 * scale, color, 1.0);
        if seen.length() > SHORT {
            let head = seen.normalize() * 9.0 * scale;
            canvas.stroke([tip - head * 0.3, tip + head * 0.7], [7.0 * scale, 0.0], color, 1.0);
        }
        let size = canvas.text_size(name);
        let beside = seen.try_normalize().unwrap_or(DVec2::new(-0.7, 0.7)) * 13.0 * scale;
        let at = tip + beside - size / 2.0;
        canvas.text_in([at.x, at.y], name, color);
    }
}
