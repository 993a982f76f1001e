//! Frames that another thread cancels.

mod common;

use common::{device, parallel, random_volume, smooth_transfer, viewport};
use glam::DVec3;
use layersplat::renderer::StreamedRenderer;
use layersplat::{Background, Cancel, Error, Renderer, Settings};
use std::time::Duration;

/// Parts of the streamed volume: a frame has a few kernels for each, so that a cancellation meets it between two.
const LEAST_PARTS: usize = 20;

#[test]
fn a_cancelled_frame_ends_and_the_next_is_whole() {
    let volume = random_volume([21, 18, 24], DVec3::ONE, 5);
    let (transfer, size, settings) = (smooth_transfer(), viewport(31, 26), Settings::default());
    let camera = parallel(&volume, size, 25.0, 15.0);
    let expected = common::render(&volume, &transfer, &camera, size, &settings);
    let cancel = Cancel::new();
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    renderer.set_cancel(Some(cancel.clone()));
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
    cancel.cancel();
    assert!(matches!(renderer.render(&camera, size, &settings), Err(Error::Cancelled { .. })));
    assert!(matches!(renderer.render_rgba8(&camera, size, &settings, Background::BLACK), Err(Error::Cancelled { .. })));
    cancel.reset();
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
    cancel.cancel();
    renderer.set_cancel(None);
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected, "the token is no longer looked at");
}

#[test]
fn another_thread_cancels_a_frame_in_progress() {
    let volume = random_volume([96, 96, 96], DVec3::ONE, 7);
    let (transfer, size, settings) = (smooth_transfer(), viewport(64, 64), Settings::default());
    let camera = parallel(&volume, size, 20.0, 10.0);
    let expected = common::render(&volume, &transfer, &camera, size, &settings);
    let mut renderer = StreamedRenderer::new(&device().with_memory(600 << 10), &volume, &transfer);
    let plan = renderer.plan(&camera, size, &settings).unwrap().expect("a lattice");
    assert!(plan.lattices[0].parts >= LEAST_PARTS, "{plan}");
    // All kernels are built now.
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
    let cancel = Cancel::new();
    renderer.set_cancel(Some(cancel.clone()));
    let other = cancel.clone();
    let thread = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(1));
        other.cancel();
    });
    // Frames go on until one meets the cancellation: no frame can end whole after it.
    let ended = loop {
        let was_cancelled = cancel.is_cancelled();
        match renderer.render(&camera, size, &settings) {
            Ok(_) => assert!(!was_cancelled, "a frame that began after the cancellation was drawn"),
            Err(error) => break error,
        }
    };
    thread.join().unwrap();
    assert!(matches!(ended, Error::Cancelled { .. }), "{ended}");
    cancel.reset();
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
}
