//! Fitted cameras, in all picture shapes: everything is visible and as large as possible.

use super::decoded::Picture;
use super::{OFF, OFF_IN_PERSPECTIVE, colored, one_voxel, ways};
use crate::common::*;
use glam::DVec3;
use layersplat::framing::{Fixed, Framing};
use layersplat::volume::Voxels;
use layersplat::{Camera, Orbit, Settings, TransferFunction, Volume};

/// Landscape, portrait and square.
const SIZES: [[u32; 2]; 3] = [[80, 40], [40, 80], [56, 56]];
/// A box with 9 voxels per side has a diagonal of 8·√3 spacings.
const DIMS: [usize; 3] = [9; 3];
const DIAGONAL: f64 = 8.0 * 1.732_050_807_568_877_2;

/// Views in which the corner (8, 8, 8) is at the left or right, or at the top. The direction from the centre to it is (1, 1, 1)/√3, 35.26°
/// above the xz plane at azimuth 45°.
fn orbits() -> [(Orbit, [f64; 2]); 3] {
    let above = (1.0 / 2f64.sqrt()).atan().to_degrees();
    let at = |azimuth, elevation, roll| Orbit { azimuth, elevation, roll };
    [
        // At azimuth 45° − 90° the corner is perpendicular to the view, 35.26° above the horizontal.
        (at(-45.0, 0.0, -above), [1.0, 0.0]),
        (at(135.0, 0.0, above), [-1.0, 0.0]),
        (at(-45.0, 0.0, 90.0 - above), [0.0, 1.0]),
    ]
}

/// A corner at the silhouette just fits along the narrower side: half the diagonal from the centre.
#[test]
fn corners_reach_the_narrower_side() {
    let (volume, transfer) = (one_voxel(DIMS, [1.0; 3], [8; 3]), colored());
    for [width, height] in SIZES {
        let (w, h) = (f64::from(width), f64::from(height));
        for (orbit, [right, up]) in orbits() {
            let size = viewport(width, height);
            let reach = w.min(h) / 2.0;
            let centre = DVec3::splat(4.0);
            // Slightly larger than the picture, so that the whole blot of the corner is visible.
            let larger = 1.25;
            let camera = Camera::fit_parallel(centre, DIAGONAL * larger, size, orbit);
            let found = Picture::of(&render(&volume, &transfer, &camera, size, &ways()[1])).middle();
            let expected = [w / 2.0 + right * reach / larger, h / 2.0 - up * reach / larger];
            assert!(super::distance(found, expected) < OFF, "{width}x{height} {orbit:?}: {found:.2?}, not {expected:.2?}");

            // In a perspective, the bounding sphere touches the side: its silhouette is at the angle sin⁻¹(r/D), and the corner, which is closer to
            // the centre, at tan⁻¹(r/D). The field of view is the narrower one.
            for degrees in [30.0f64, 90.0] {
                let camera = Camera::fit_perspective(centre, DIAGONAL * larger, degrees, size, orbit);
                let found = Picture::of(&render(&volume, &transfer, &camera, size, &ways()[1])).middle();
                let narrower = (degrees.to_radians() / 2.0).tan() * w.min(h) / h;
                let eye = DIAGONAL * larger / 2.0 / narrower.atan().sin();
                let part = DIAGONAL / 2.0 / eye / narrower;
                let expected = [w / 2.0 + right * reach * part, h / 2.0 - up * reach * part];
                let off = super::distance(found, expected);
                assert!(off < OFF_IN_PERSPECTIVE, "{width}x{height} {degrees}° {orbit:?}: {found:.2?}, not {expected:.2?}");
            }
        }
    }
}

/// A block of 255 that fills its grid, with spacing 1, 2, 1: with kernel radii 10 wide, 20 high and 10 deep.
fn block() -> Volume<'static> {
    volume([9; 3], DVec3::new(1.0, 2.0, 1.0), Voxels::Uint8(vec![255; 729])).with_background(0.0).unwrap()
}

/// Opacity above which a pixel counts as covered.
const COVERED: f64 = 0.02;
/// Width of the kernel's tail below that opacity, in world units; the margin is 0.3 along the tighter axis.
const FAINT: f64 = 0.1;

/// Opaque from the first value above the background on.
fn sudden() -> TransferFunction {
    TransferFunction::new("sudden", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (1.0, 0.0), (2.0, 0.9)]).unwrap()
}

/// The visible part has a margin of a twentieth on either side of the tighter axis, and a larger one along the other.
#[test]
fn what_is_visible_fills_the_picture_but_for_its_margin() {
    let (volume, transfer) = (block(), sudden());
    let framing = Framing::visible(&volume, &transfer, None);
    let settings = Settings { shading: None, ..ways()[1] };
    for (size, orbit, box_size) in [
        ([240, 120], [0.0, 0.0, 0.0], [10.0, 20.0]),
        ([120, 240], [0.0, 0.0, 0.0], [10.0, 20.0]),
        ([80, 240], [0.0, 0.0, 0.0], [10.0, 20.0]),
        ([240, 80], [0.0, 0.0, 90.0], [20.0, 10.0]),
        ([80, 240], [0.0, 0.0, 90.0], [20.0, 10.0]),
        ([120, 240], [90.0, 0.0, 0.0], [10.0, 20.0]),
        ([120, 240], [0.0, 90.0, 0.0], [10.0, 10.0]),
    ] {
        let [azimuth, elevation, roll] = orbit;
        let camera = framing.parallel(Orbit { azimuth, elevation, roll }, viewport(size[0], size[1]), Fixed::default());
        let picture = Picture::of(&render(&volume, &transfer, &camera, viewport(size[0], size[1]), &settings));
        let sides = size.map(f64::from);
        // Pixels per world unit, by the tighter axis.
        let scale = 0.95 * (sides[0] / box_size[0]).min(sides[1] / box_size[1]);
        for (i, [first, last]) in picture.extent(COVERED).into_iter().enumerate() {
            let half = box_size[i] / 2.0 * scale;
            let (low, high) = (sides[i] / 2.0 - half, sides[i] / 2.0 + half);
            let inside = first >= low - 1.0 && last + 1.0 <= high + 1.0;
            let faint = FAINT * scale + 1.0;
            let tight = first <= low + faint && last + 1.0 >= high - faint;
            assert!(inside && tight, "{size:?} {orbit:?}: {first} to {last} on side {i}, not {low:.1} to {high:.1}");
        }
    }
}
