//! What is told to someone whose picture shows nothing, or one colour only.

use super::scene::Scene;
use crate::camera::{Camera, Projection};
use crate::image::Frame;
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::Grid;

/// Opacity from which on a pixel hides what is behind it: a step of 8 bits below 1.
const OPAQUE: f32 = 1.0 - 1.0 / 255.0;
/// How much the channels of a picture of one colour differ: less than two steps of 8 bits.
const ONE_COLOUR: f32 = 2.0 / 255.0;
/// Spacings this many times another are suspicious: one of them may be missing, or in another unit.
const FAR_APART: f64 = 20.0;

/// Why a picture is empty or a wall of one colour, and what to try; nothing where it is neither.
pub(super) fn of_picture(frame: &Frame, camera: &Camera, scene: &Scene) -> Option<String> {
    let pixels = frame.pixels();
    let (mut least, mut most) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for pixel in pixels {
        for c in 0..4 {
            (least[c], most[c]) = (least[c].min(pixel[c]), most[c].max(pixel[c]));
        }
    }
    if most[3] * 255.0 < 0.5 {
        return Some(empty(scene, || tiny(camera, frame.height(), scene.volume.grid())));
    }
    let solid = least[3] >= OPAQUE && (0..4).all(|c| most[c] - least[c] < ONE_COLOUR);
    solid.then(|| {
        let (lo, hi) = scene.volume.range();
        format!(
            "the picture is one colour: what is opaque fills it. The data's range is {lo} to {hi}, the background {}; try --transfer-range \
             with the values that matter, or --parallel-scale to step back",
            scene.volume.background()
        )
    })
}

/// Why nothing is visible. `tiny`: what to say if the view makes the volume too small to be seen.
fn empty(scene: &Scene, tiny: impl FnOnce() -> Option<String>) -> String {
    let (lo, hi) = scene.volume.range();
    let (settings, transfer) = (&scene.settings, &scene.transfer);
    let cut = !settings.clipping.is_empty();
    match settings.blend {
        Blend::Iso(value) if !(lo..=hi).contains(&value) => {
            format!(
                "the picture is empty: the data's range is {lo} to {hi}, and has no surface at {value}; try --iso {}",
                (lo + hi) / 2.0
            )
        }
        Blend::Composite if lo == hi && transfer.largest_opacity(lo, hi) <= 0.0 => constant(scene, lo),
        Blend::Composite if transfer.largest_opacity(lo, hi) <= 0.0 => {
            let visible =
                visible_values(transfer).map_or_else(|| "nowhere".into(), |(first, last)| format!("from {first} to {last}"));
            format!(
                "the picture is empty: the data's range is {lo} to {hi}, and the transfer function has opacity {visible}; try \
                 --transfer-range {lo},{hi}"
            )
        }
        _ if cut => "the picture is empty: what is visible is cut away; try without --crop and --clip".into(),
        blend => tiny().unwrap_or_else(|| match blend {
            Blend::Composite => format!(
                "the picture is empty: there are values with opacity in the data ({lo} to {hi}), but the camera sees none of them, or too \
                 little; try --fit visible, or --transfer-range with fewer values"
            ),
            _ => "the picture is empty: the camera does not see the volume; try --fit volume".into(),
        }),
    }
}

/// What helps where a parallel view makes the whole volume smaller than a pixel.
fn tiny(camera: &Camera, height: u32, grid: &Grid) -> Option<String> {
    let Projection::Parallel { scale } = camera.projection else { return None };
    let fits = grid.diagonal() / 2.0;
    (fits * f64::from(height) < scale).then(|| {
        format!(
            "the picture is empty: at this scale the volume is smaller than a pixel; try --parallel-scale {fits:.3e}, or none"
        )
    })
}

/// What helps where all voxels have one value without opacity: no range of values can.
fn constant(scene: &Scene, value: f64) -> String {
    let remedy = match scene.volume.name().strip_prefix("builtin:") {
        Some(name) => {
            let name = name.split('@').next().unwrap_or(name);
            format!("take more of them: builtin:{name}@64")
        }
        None => format!("check that it is the right file, frame and channel, or give {value} an opacity: --opacity {value}:0.5"),
    };
    format!("the picture is empty: all voxels have the value {value}, where the transfer function has no opacity; {remedy}")
}

/// The first and the last value with opacity.
fn visible_values(transfer: &TransferFunction) -> Option<(f64, f64)> {
    let points = transfer.opacities();
    let first = points.iter().position(|(_, opacity)| *opacity > 0.0)?;
    let last = points.iter().rposition(|(_, opacity)| *opacity > 0.0)?;
    Some((points[first.saturating_sub(1)].0, points[(last + 1).min(points.len() - 1)].0))
}

/// What is odd about spacings.
pub(super) fn of_spacing(spacing: glam::DVec3) -> Option<String> {
    let apart = spacing.max_element() / spacing.min_element();
    (apart > FAR_APART).then(|| {
        let [x, y, z] = spacing.to_array();
        format!("voxels are {apart:.0} times as far apart along one axis as along another ({x},{y},{z}); if that is wrong, give --spacing X,Y,Z")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn spacings_that_are_far_apart_are_told() {
        assert_eq!(of_spacing(DVec3::new(1.0, 1.0, 20.0)), None);
        assert!(
            of_spacing(DVec3::new(0.5, 0.5, 40.0)).is_some_and(|text| text.contains("80 times") && text.contains("--spacing"))
        );
    }

    #[test]
    fn values_with_opacity_are_found() {
        let of = |opacities| TransferFunction::new("a", vec![(0.0, [1.0; 3])], opacities).unwrap();
        assert_eq!(visible_values(&of(vec![(0.0, 0.0), (5.0, 0.0), (9.0, 1.0)])), Some((5.0, 9.0)));
        assert_eq!(visible_values(&of(vec![(0.0, 0.0), (9.0, 0.0)])), None);
        assert_eq!(visible_values(&of(vec![(3.0, 0.5)])), Some((3.0, 3.0)));
    }
}
