//! Accumulated frames against supersampled pictures.

use crate::common::{SPLATTED, device, parallel, perspective, random_volume, scaled, smooth_transfer, step_transfer, viewport};
use glam::DVec3;
use layersplat::renderer::{Accumulation, volume_renderer};
use layersplat::settings::{Algorithm, Blend, Layered};
use layersplat::volume::OpenOptions;
use layersplat::{Camera, Cancel, Error, Frame, Kernel, Quality, Renderer, Settings, TransferFunction, Volume};

/// dB to the supersampled picture, which has the same rays. Lattices differ where one of them has samples on its pixels. Measured: 60 and more.
const CLOSE: f64 = 50.0;

/// Peak signal-to-noise ratio of premultiplied RGBA, in dB.
fn psnr(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let squares = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2));
    -10.0 * (squares.sum::<f64>() / (4 * a.len()) as f64).log10()
}

/// The mean over 4 × 4 pixels of a frame that is four times as wide and high.
fn averaged(large: &Frame, width: usize, height: usize) -> Vec<[f32; 4]> {
    let mean = |x: usize, y: usize| {
        let mut sum = [0.0f64; 4];
        for (j, i) in (0..4).flat_map(|j| (0..4).map(move |i| (j, i))) {
            let pixel = large.pixels()[(4 * y + j) * 4 * width + 4 * x + i];
            (0..4).for_each(|c| sum[c] += f64::from(pixel[c]));
        }
        sum.map(|c| (c / 16.0) as f32)
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
}

#[test]
fn sixteen_frames_are_a_supersampled_picture() {
    let volume = random_volume([24, 20, 26], DVec3::new(1.0, 0.8, 1.2), 5);
    let (transfer, settings) = (smooth_transfer(), Settings::default());
    let (size, large) = (viewport(48, 40), viewport(192, 160));
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    for (what, camera) in
        [("parallel", parallel(&volume, size, 25.0, 15.0)), ("perspective", perspective(&volume, 25.0, 15.0, 35.0))]
    {
        let expected = averaged(&renderer.render(&camera, large, &settings).unwrap().0, 48, 40);
        let mut picture = Accumulation::new(size).unwrap();
        assert!(picture.mean().unwrap().pixels().iter().all(|pixel| *pixel == [0.0; 4]));
        let mut found = Vec::new();
        while picture.frames() < Accumulation::FRAMES {
            renderer.accumulate(&camera, &settings, &mut picture).unwrap();
            found.push(psnr(picture.mean().unwrap().pixels(), &expected));
        }
        assert!(*found.last().unwrap() >= CLOSE, "{what}: {found:?} dB");
        // A single frame, whose rays lie beside the middles of the pixels, is not.
        assert!(found[0] < CLOSE, "{what}: {found:?} dB");
    }
}

/// Where opacity is a step, single frames have jagged edges: they are far from the supersampled picture.
#[test]
fn accumulated_edges_are_smooth() {
    let volume = random_volume([24, 20, 26], DVec3::new(1.0, 0.8, 1.2), 5);
    let (transfer, settings) = (step_transfer(180.0, 0.95), Settings::default());
    let (size, large) = (viewport(48, 40), viewport(192, 160));
    let camera = Camera { view_up: DVec3::new(0.2, 1.0, 0.0), ..parallel(&volume, size, 25.0, 15.0) };
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let expected = averaged(&renderer.render(&camera, large, &settings).unwrap().0, 48, 40);
    let plain = psnr(renderer.render(&camera, size, &settings).unwrap().0.pixels(), &expected);
    assert!(plain < CLOSE, "{plain} dB");
    let mut picture = Accumulation::new(size).unwrap();
    (0..Accumulation::FRAMES).for_each(|_| drop(renderer.accumulate(&camera, &settings, &mut picture).unwrap()));
    let mean = psnr(picture.mean().unwrap().pixels(), &expected);
    assert!(mean >= CLOSE, "{plain} dB, {mean} dB accumulated");
}

/// dB asked of other views and algorithms. Where voxels are smaller than pixels, lattices of single rays differ from those of a large picture.
const NEAR: f64 = 45.0;

/// Likewise where layers of two axes share the picture. Measured: 43.4, and 45 or more with central differences.
const NEAR_TWO_AXES: f64 = 42.0;

/// Likewise for surfaces, whose edges are steps of opacity from one sample to the next. Measured: 40.4.
const NEAR_EDGES: f64 = 39.0;

/// Views in which pixels hold several voxels, layers of two axes share the picture, or no lattice applies.
#[test]
fn other_views_are_supersampled_too() {
    let volume = Volume::open("builtin:marschner-lobb@52x44x60", &OpenOptions::default()).unwrap();
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let (size, large) = (viewport(24, 20), viewport(96, 80));
    let minified = |voxels: f64| scaled(parallel(&volume, size, 25.0, 15.0), voxels * 10.0);
    let turned = Camera { view_up: DVec3::new(0.4, 1.0, 0.1), ..minified(4.0) };
    let inside = Camera { position: volume.grid().centre(), ..perspective(&volume, 25.0, 15.0, 90.0) };
    let inside = Camera { focal_point: volume.grid().centre() + DVec3::new(1.0, 0.3, -0.4), ..inside };
    let (own, high) = (Settings::default(), Quality::High.settings());
    let splats = Settings::from(Layered { classification: SPLATTED, ..Layered::default() });
    let raycast = Settings::from(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 });
    let surface = Settings { blend: Blend::Iso(0.5 * (volume.range().0 + volume.range().1)), ..own };
    let cases = [
        ("four voxels per pixel", minified(4.0), own),
        ("eight voxels per pixel", minified(8.0), own),
        ("rolled", turned, own),
        ("two axes", scaled(parallel(&volume, size, 45.3, 0.0), 40.0), own),
        ("inside", inside, own),
        ("high", minified(4.0), high),
        ("splats", minified(4.0), splats),
        ("ray casting", minified(4.0), raycast),
        ("surface", minified(4.0), surface),
    ];
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    for (what, camera, settings) in cases {
        let expected = averaged(&renderer.render(&camera, large, &settings).unwrap().0, 24, 20);
        assert!(expected.iter().any(|pixel| pixel[3] > 0.1), "{what}: nothing to see");
        let mut picture = Accumulation::new(size).unwrap();
        (0..Accumulation::FRAMES).for_each(|_| drop(renderer.accumulate(&camera, &settings, &mut picture).unwrap()));
        let mean = psnr(picture.mean().unwrap().pixels(), &expected);
        eprintln!("{what}: {mean:.1} dB");
        let near = match what {
            "surface" => NEAR_EDGES,
            "two axes" => NEAR_TWO_AXES,
            _ => NEAR,
        };
        assert!(mean >= near, "{what}: {mean} dB");
    }
}

/// A volume that is streamed accumulates to the same bits.
#[test]
fn streamed_frames_accumulate() {
    let volume = random_volume([120, 110, 130], DVec3::ONE, 5);
    let (transfer, settings, size) =
        (smooth_transfer(), Settings { unit_distance: Some(60.0), ..Settings::default() }, viewport(24, 20));
    let camera = parallel(&volume, size, 25.0, 15.0);
    let small = device().with_memory(volume.grid().voxel_count() as u64 / 2);
    let [whole, streamed] = [device(), small].map(|device| {
        let mut renderer = volume_renderer(&device, &volume, &transfer).unwrap();
        let mut picture = Accumulation::new(size).unwrap();
        (0..3).for_each(|_| drop(renderer.accumulate(&camera, &settings, &mut picture).unwrap()));
        picture.mean().unwrap()
    });
    assert!(whole == streamed && whole.pixels().iter().any(|pixel| pixel[3] > 0.1));
}

#[test]
fn a_failed_frame_adds_nothing() {
    let volume = random_volume([12, 10, 14], DVec3::ONE, 5);
    let (transfer, settings, size) = (smooth_transfer(), Settings::default(), viewport(24, 20));
    let camera = parallel(&volume, size, 25.0, 15.0);
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let mut picture = Accumulation::new(size).unwrap();
    renderer.accumulate(&camera, &settings, &mut picture).unwrap();
    let before = picture.mean().unwrap();
    let cancel = Cancel::new();
    cancel.cancel();
    renderer.set_cancel(Some(cancel));
    assert!(matches!(renderer.accumulate(&camera, &settings, &mut picture), Err(Error::Cancelled { .. })));
    assert!(picture.frames() == 1 && picture.mean().unwrap() == before);
}

/// dB of a picture that is drawn in parts to the whole. Lattices of parts may have samples at other places. Measured: 49.5 and more.
const CLOSE_PARTS: f64 = 47.0;

/// A large picture in parts is the picture as a whole, also at the seams, in parallel views and in perspectives.
#[test]
fn parts_are_those_of_the_picture() {
    const SIZE: [u32; 2] = [190, 160];
    const PART: [u32; 2] = [80, 64];
    let volume = random_volume([24, 20, 26], DVec3::new(1.0, 0.8, 1.2), 5);
    let (transfer, size) = (smooth_transfer(), viewport(SIZE[0], SIZE[1]));
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let extent = |axis: usize, first: u32| first..(first + PART[axis]).min(SIZE[axis]);
    for settings in
        [Settings::default(), Quality::High.settings(), Settings::from(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 })]
    {
        for (what, camera) in
            [("parallel", parallel(&volume, size, 25.0, 15.0)), ("perspective", perspective(&volume, 25.0, 15.0, 35.0))]
        {
            let whole = renderer.render(&camera, size, &settings).unwrap().0;
            let mut pixels = vec![[f32::NAN; 4]; whole.pixels().len()];
            for [column, row] in (0..SIZE[1]).step_by(64).flat_map(|y| (0..SIZE[0]).step_by(80).map(move |x| [x, y])) {
                let (columns, rows) = (extent(0, column), extent(1, row));
                let (part, _) = renderer.render_part(&camera, size, [columns.clone(), rows.clone()], &settings).unwrap();
                assert_eq!([part.width() as usize, part.height() as usize], [columns.len(), rows.len()]);
                for (row, line) in rows.zip(part.pixels().chunks_exact(columns.len())) {
                    let first = (row * SIZE[0] + column) as usize;
                    pixels[first..first + columns.len()].copy_from_slice(line);
                }
            }
            let found = psnr(&pixels, whole.pixels());
            assert!(found >= CLOSE_PARTS, "{what}: {found} dB");
            // Rows that are moved by one pixel are noticed.
            let moved = psnr(&pixels[190..], &whole.pixels()[..190 * 159]);
            assert!(moved < CLOSE_PARTS, "{what}: {moved} dB");
            for part in [[0..190, 0..161], [0..191, 0..160], [0..190, 5..5], [3..3, 0..160], [0..190, 160..161]] {
                assert!(matches!(renderer.render_part(&camera, size, part, &settings), Err(Error::OutOfRange { .. })));
            }
        }
    }
}
