//! Pixels that are wider or higher than square: every third column, or row, of a picture with square pixels.

use crate::common::*;
use glam::DVec3;
use layersplat::settings::Algorithm;
use layersplat::{Camera, Frame, Kernel, Settings, Viewport, Volume};

const SIDES: [u32; 2] = [40, 36];
/// Rays of the same place, whose coordinates are rounded otherwise.
const SAME_RAYS: f64 = 1e-4;
/// Least fidelity of a lattice to that of square pixels, whose samples lie elsewhere.
const LATTICES_DB: f64 = 40.0;

/// The middle column, or row, of every three.
fn thinned(frame: &Frame, columns: bool) -> Frame {
    let [width, height] = SIDES;
    let place = |x, y| if columns { frame.pixel(3 * x + 1, y) } else { frame.pixel(x, 3 * y + 1) };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| place(x, y)).collect();
    Frame::new(viewport(width, height), pixels)
}

fn pictures(volume: &Volume, camera: &Camera, settings: Settings, columns: bool) -> [Frame; 3] {
    let [width, height] = SIDES;
    let draw =
        |size: Viewport, pixel_aspect| render(volume, &smooth_transfer(), camera, size, &Settings { pixel_aspect, ..settings });
    let (fine, aspect) = if columns { (viewport(3 * width, height), 3.0) } else { (viewport(width, 3 * height), 1.0 / 3.0) };
    let size = viewport(width, height);
    [draw(size, aspect), thinned(&draw(fine, 1.0), columns), draw(size, 1.0)]
}

#[test]
fn columns_and_rows_of_square_pixels() {
    let volume = random_volume([18, 15, 16], DVec3::new(1.0, 0.8, 1.2), 5);
    let raycast = Settings::from(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 });
    for camera in [parallel(&volume, viewport(40, 36), 25.0, 20.0), perspective(&volume, 40.0, 15.0, 35.0)] {
        for columns in [true, false] {
            let [found, expected, square] = pictures(&volume, &camera, raycast, columns);
            assert_close("rays", &found, &expected, SAME_RAYS);
            assert!(compare(&square, &expected).max_difference > 0.1, "another aspect must be noticed");
            let [found, expected, square] = pictures(&volume, &camera, Settings::default(), columns);
            let [same, other] = [&found, &square].map(|frame| compare(frame, &expected).psnr.unwrap_or(f64::INFINITY));
            assert!(same > LATTICES_DB && other < LATTICES_DB - 10.0, "columns {columns}: {same:.1} dB, else {other:.1} dB");
        }
    }
}

#[test]
fn refusals() {
    for pixel_aspect in [0.0, -1.0, 0.06, 17.0, f64::NAN, f64::INFINITY] {
        let volume = cube([4; 3], DVec3::ONE);
        let mut renderer = layersplat::Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
        let camera = parallel(&volume, viewport(8, 8), 0.0, 0.0);
        let refused = renderer.render(&camera, viewport(8, 8), &Settings { pixel_aspect, ..Settings::default() });
        assert!(refused.unwrap_err().to_string().contains("pixel_aspect"), "{pixel_aspect}");
    }
}
