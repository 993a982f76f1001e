//! Frames that another thread cancels.

use crate::common::{device, parallel, random_volume, smooth_transfer, viewport};
use glam::DVec3;
use layersplat::renderer::{PartRenderer, StreamedRenderer, volume_renderer};
use layersplat::{Background, Cancel, Error, Renderer, Settings};
use std::fmt::Debug;
use std::time::Duration;

/// Parts of the streamed volume: a frame has a few kernels for each, so that a cancellation meets it between two.
const LEAST_PARTS: usize = 20;

/// Asserts that a call was cancelled.
#[track_caller]
fn is_cancelled<T: Debug>(found: Result<T, Error>) {
    assert!(matches!(found, Err(Error::Cancelled { .. })), "{found:?}");
}

/// Repeats a frame until another thread has cancelled it. A frame that begins after the cancellation must not end whole.
#[track_caller]
fn cancelled_in_progress<T>(cancel: &Cancel, mut frame: impl FnMut() -> Result<T, Error>) {
    let other = cancel.clone();
    let thread = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(1));
        other.cancel();
    });
    let ended = loop {
        let was_cancelled = cancel.is_cancelled();
        match frame() {
            Ok(_) => assert!(!was_cancelled, "a frame that began after the cancellation was drawn"),
            Err(error) => break error,
        }
    };
    thread.join().unwrap();
    assert!(matches!(ended, Error::Cancelled { .. }), "{ended}");
}

#[test]
fn a_cancelled_frame_ends_and_the_next_is_whole() {
    let volume = random_volume([21, 18, 24], DVec3::ONE, 5);
    let (transfer, size, settings) = (smooth_transfer(), viewport(31, 26), Settings::default());
    let camera = parallel(&volume, size, 25.0, 15.0);
    let expected = crate::common::render(&volume, &transfer, &camera, size, &settings);
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
    let expected = crate::common::render(&volume, &transfer, &camera, size, &settings);
    let mut renderer = StreamedRenderer::new(&device().with_memory(600 << 10), &volume, &transfer);
    let plan = renderer.plan(&camera, size, &settings).unwrap().expect("a lattice");
    assert!(plan.lattices[0].parts >= LEAST_PARTS, "{plan}");
    // All kernels are built now.
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
    let cancel = Cancel::new();
    renderer.set_cancel(Some(cancel.clone()));
    cancelled_in_progress(&cancel, || renderer.render(&camera, size, &settings));
    cancel.reset();
    assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected);
}

/// Compositing of a part and finishing of the picture, cancelled before the first frame and in progress. Cached data that a cancelled
/// frame has written in part are made again.
#[test]
fn frames_of_a_part_are_cancelled() {
    let volume = random_volume([48, 40, 52], DVec3::ONE, 11);
    let (transfer, size, settings) = (smooth_transfer(), viewport(31, 26), Settings::default());
    let camera = parallel(&volume, size, 25.0, 15.0);
    let expected = crate::common::render(&volume, &transfer, &camera, size, &settings);
    let mut renderer = PartRenderer::new(&device(), &volume.part([0; 3], [48, 40, 52]).unwrap(), &transfer).unwrap();
    let (_, is_ascending) = renderer.order(&camera, size, &settings).unwrap();
    let [first, second] = if is_ascending { [0..20, 20..52] } else { [20..52, 0..20] };
    let cancel = Cancel::new();
    renderer.set_cancel(Some(cancel.clone()));
    cancel.cancel();
    is_cancelled(renderer.composite(&camera, size, &settings, first.clone(), None));
    cancel.reset();
    let front = renderer.composite(&camera, size, &settings, first, None).unwrap();
    cancelled_in_progress(&cancel, || renderer.composite(&camera, size, &settings, second.clone(), Some(&front)));
    cancel.reset();
    let all = renderer.composite(&camera, size, &settings, second, Some(&front)).unwrap();
    cancel.cancel();
    is_cancelled(renderer.finish(&all));
    cancel.reset();
    cancelled_in_progress(&cancel, || renderer.finish(&all));
    cancel.reset();
    assert!(renderer.finish(&all).unwrap() == expected);
    cancel.cancel();
    renderer.set_cancel(None);
    assert!(renderer.finish(&all).unwrap() == expected, "the token is no longer checked");
}

/// By renderers of the whole volume, with and without a memory budget.
#[test]
fn depths_are_cancelled() {
    let volume = random_volume([48, 40, 52], DVec3::ONE, 11);
    let (transfer, size, settings) = (smooth_transfer(), viewport(31, 26), Settings::default());
    let camera = parallel(&volume, size, 25.0, 15.0);
    let expected = Renderer::new(&device(), &volume, &transfer).unwrap().depths(&camera, size, &settings).unwrap();
    assert!(expected.first().iter().any(|depth| depth.is_finite()));
    for device in [device(), device().with_memory(1 << 30)] {
        let mut renderer = volume_renderer(&device, &volume, &transfer).unwrap();
        let cancel = Cancel::new();
        renderer.set_cancel(Some(cancel.clone()));
        cancel.cancel();
        is_cancelled(renderer.depths(&camera, size, &settings));
        cancel.reset();
        assert!(renderer.depths(&camera, size, &settings).unwrap() == expected);
        cancelled_in_progress(&cancel, || renderer.depths(&camera, size, &settings));
        cancel.reset();
        assert!(renderer.depths(&camera, size, &settings).unwrap() == expected);
    }
}
