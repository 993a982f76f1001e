//! Hints for pictures that are empty or of one colour.

use super::scene::OpenedScene;
use crate::camera::{Camera, Projection};
use crate::image::Frame;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::Grid;

/// Smallest alpha of an opaque pixel: one 8-bit step below 1.
const OPAQUE: f32 = 1.0 - 1.0 / 255.0;
/// Channels of a picture of one colour differ by less than two 8-bit steps.
const ONE_COLOUR: f32 = 2.0 / 255.0;
/// Whether a picture shows nothing: not even one 8-bit step of opacity.
pub(super) fn is_empty(frame: &Frame) -> bool {
    frame.pixels().iter().all(|pixel| pixel[3] * 255.0 < 0.5)
}

/// Explains an empty picture, or one of a single colour, and suggests options. `None` for other pictures.
pub(super) fn explain_picture(frame: &Frame, camera: &Camera, scene: &OpenedScene) -> Option<String> {
    let pixels = frame.pixels();
    let (mut least, mut most) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for pixel in pixels {
        for c in 0..4 {
            (least[c], most[c]) = (least[c].min(pixel[c]), most[c].max(pixel[c]));
        }
    }
    if is_empty(frame) {
        return Some(empty(scene, || tiny(camera, frame.height(), scene.volume.grid())));
    }
    let solid = least[3] >= OPAQUE && (0..4).all(|c| most[c] - least[c] < ONE_COLOUR);
    solid.then(|| {
        let (lo, hi) = scene.volume.range();
        format!(
            "the picture is one colour: opaque voxels fill it. The data range from {lo} to {hi}, the background value is {}; try \
             --transfer-range with the values of interest, or a larger --parallel-scale",
            scene.volume.background()
        )
    })
}

/// Explains an empty picture. `tiny` explains views in which the volume is too small to be seen.
fn empty(scene: &OpenedScene, tiny: impl FnOnce() -> Option<String>) -> String {
    let (lo, hi) = scene.volume.range();
    let (settings, transfer) = (&scene.settings, &scene.transfer);
    let is_clipped = !settings.clipping.is_empty();
    match settings.blend {
        Blend::Iso(value) if !(lo..=hi).contains(&value) => {
            format!(
                "the picture is empty: the data range from {lo} to {hi} and have no surface at {value}; try --iso {}",
                (lo + hi) / 2.0
            )
        }
        Blend::Composite if lo == hi && transfer.largest_opacity(lo, hi) <= 0.0 && !scene.surfaces.is_empty() => {
            "the picture is empty: it shows no surface; omit options of the camera, and see `layersplat info FILE` for what the file has"
                .into()
        }
        Blend::Composite if lo == hi && transfer.largest_opacity(lo, hi) <= 0.0 => constant(scene, lo),
        Blend::Composite if transfer.largest_opacity(lo, hi) <= 0.0 => {
            let visible = visible_values(transfer)
                .map_or_else(|| "is transparent".into(), |(first, last)| format!("has opacity only from {first} to {last}"));
            format!(
                "the picture is empty: the data range from {lo} to {hi}, but the transfer function {visible}; try \
                 --transfer-range {lo},{hi}"
            )
        }
        _ if is_clipped => "the picture is empty: the visible part is clipped away; try without --crop and --clip".into(),
        blend => tiny().unwrap_or_else(|| match blend {
            Blend::Composite => format!(
                "the picture is empty: some values in the data's range, {lo} to {hi}, are visible, but the camera sees too little of \
                 them; try --fit visible, or a narrower --transfer-range"
            ),
            _ => "the picture is empty: the volume is outside the view; try --fit volume".into(),
        }),
    }
}

/// Hint for parallel views in which the whole volume is smaller than a pixel.
fn tiny(camera: &Camera, height: u32, grid: &Grid) -> Option<String> {
    let Projection::Parallel { scale } = camera.projection else { return None };
    let fits = grid.diagonal() / 2.0;
    (fits * f64::from(height) < scale).then(|| {
        format!(
            "the picture is empty: at this scale the volume is smaller than a pixel; try --parallel-scale {fits:.3e}, or omit it"
        )
    })
}

/// Hint for volumes whose voxels all have one transparent value. No transfer range helps there.
fn constant(scene: &OpenedScene, value: f64) -> String {
    let remedy = match scene.volume.name().strip_prefix("builtin:") {
        Some(name) => {
            let name = name.split('@').next().unwrap_or(name);
            format!("use more voxels: builtin:{name}@64")
        }
        None => format!("check file, frame and channel, or make {value} visible: --opacity {value}:0.5"),
    };
    format!("the picture is empty: all voxels have the value {value}, where the transfer function is transparent; {remedy}")
}

/// Range of values with non-zero opacity.
fn visible_values(transfer: &TransferFunction) -> Option<(f64, f64)> {
    let points = transfer.opacities();
    let first = points.iter().position(|(_, opacity)| *opacity > 0.0)?;
    let last = points.iter().rposition(|(_, opacity)| *opacity > 0.0)?;
    Some((points[first.saturating_sub(1)].0, points[(last + 1).min(points.len() - 1)].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_values_are_found() {
        let transfer = |opacities| TransferFunction::new("a", vec![(0.0, [1.0; 3])], opacities).unwrap();
        assert_eq!(visible_values(&transfer(vec![(0.0, 0.0), (5.0, 0.0), (9.0, 1.0)])), Some((5.0, 9.0)));
        assert_eq!(visible_values(&transfer(vec![(0.0, 0.0), (9.0, 0.0)])), None);
        assert_eq!(visible_values(&transfer(vec![(3.0, 0.5)])), Some((3.0, 3.0)));
    }
}
