//! Frames in bands are those of whole launches, bit for bit, and can be paused and cancelled in the middle.

use crate::common::{CLASSIFICATIONS, OTHERS, device, parallel, perspective, random_volume, smooth_transfer, viewport};
use glam::DVec3;
use layersplat::device::{Bands, LatticeSchedule, Tuning};
use layersplat::renderer::volume_renderer;
use layersplat::settings::{AmbientOcclusion, Blend, Evaluation, LayerAxis, Layered, Shadows};
use layersplat::{Background, Camera, Cancel, Error, Renderer, Settings};
use std::time::Duration;

/// All algorithms, classifications and blend modes, and swept light.
fn all_settings() -> Vec<(String, Settings)> {
    let own = Settings::default();
    let layered = |layered: Layered| Settings::from(layered);
    let mut all: Vec<(String, Settings)> = OTHERS.iter().map(|&a| (format!("{a:?}"), a.into())).collect();
    for classification in CLASSIFICATIONS {
        for evaluation in [Layered::default().evaluation, Evaluation::Direct] {
            all.push((
                format!("{classification:?}, {evaluation:?}"),
                layered(Layered { classification, evaluation, ..Layered::default() }),
            ));
        }
    }
    for blend in [Blend::Maximum, Blend::Average, Blend::Iso(128.0)] {
        all.push((format!("{blend:?}"), Settings { blend, ..own }));
    }
    all.push(("shadows".into(), Settings { shadows: Some(Shadows::default()), ..own }));
    all.push(("occlusion".into(), Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..own }));
    all.push((
        "along x".into(),
        layered(Layered { layer_axis: LayerAxis::Forced(layersplat::layers::Axis::X), ..Layered::default() }),
    ));
    all
}

#[test]
fn bands_change_no_bit() {
    let (volume, transfer, size) =
        (random_volume([41, 38, 44], DVec3::new(1.0, 0.9, 1.1), 5), smooth_transfer(), viewport(203, 190));
    let cameras: [(&str, Camera); 2] =
        [("parallel", parallel(&volume, size, 25.0, 15.0)), ("perspective", perspective(&volume, 25.0, 15.0, 35.0))];
    let own = device();
    let samples =
        own.with_tuning(Tuning { lattice_schedule: LatticeSchedule::Samples, vector_width: 1, ..*own.tuning() }).unwrap();
    for (schedule, device) in [("tiles", own), ("samples", samples)] {
        let mut whole = Renderer::new(&device, &volume, &transfer).unwrap();
        let mut banded = Renderer::new(&device, &volume, &transfer).unwrap();
        banded.set_bands(Some(Bands::new()));
        let all = all_settings();
        // Other kernels do not depend on the schedule.
        let all = all.iter().filter(|(_, settings)| schedule == "tiles" || settings.layered().is_some());
        for (what, settings) in all {
            for (projection, camera) in &cameras {
                let expected = whole.render(camera, size, settings);
                // Sheets have parallel views only.
                let Ok((expected, _)) = expected else { continue };
                assert!(expected.pixels().iter().any(|pixel| pixel[3] > 0.05), "{what}: nothing to see");
                // The second frame has the sizes of bands that the first one found.
                for n in 0..2 {
                    assert!(
                        banded.render(camera, size, settings).unwrap().0 == expected,
                        "{schedule}, {what}, {projection}, {n}"
                    );
                }
                let [a, b] =
                    [&mut whole, &mut banded].map(|r| r.render_rgba8(camera, size, settings, Background::BLACK).unwrap().0);
                assert!(a == b, "{schedule}, {what}, {projection}");
            }
        }
    }
}

#[test]
fn streamed_frames_have_bands_too() {
    let (volume, transfer, size) = (random_volume([120, 110, 130], DVec3::ONE, 5), smooth_transfer(), viewport(24, 20));
    let camera = parallel(&volume, size, 25.0, 15.0);
    let small = device().with_memory(volume.grid().voxel_count() as u64 / 2);
    let mut renderer = volume_renderer(&small, &volume, &transfer).unwrap();
    let expected = renderer.render(&camera, size, &Settings::default()).unwrap().0.unwrap();
    renderer.set_bands(Some(Bands::new()));
    assert!(renderer.render(&camera, size, &Settings::default()).unwrap().0.unwrap() == expected);
}

/// A paused frame waits, goes on to the same picture, and can be cancelled while it waits.
#[test]
fn frames_pause_and_go_on() {
    let (volume, transfer, size) = (random_volume([41, 38, 44], DVec3::ONE, 5), smooth_transfer(), viewport(203, 190));
    let (camera, settings) = (parallel(&volume, size, 25.0, 15.0), Settings::default());
    let (bands, cancel) = (Bands::new(), Cancel::new());
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    renderer.set_bands(Some(bands.clone()));
    renderer.set_cancel(Some(cancel.clone()));
    let expected = renderer.render(&camera, size, &settings).unwrap().0;
    /// Longer than a test that hangs is waited for.
    const LONG: Duration = Duration::from_secs(3600);
    bands.pause(LONG);
    std::thread::scope(|threads| {
        let frame = threads.spawn(|| renderer.render(&camera, size, &settings).unwrap().0);
        std::thread::sleep(Duration::from_millis(50));
        assert!(!frame.is_finished(), "a paused frame was drawn");
        bands.resume();
        assert!(frame.join().unwrap() == expected);
    });
    bands.pause(LONG);
    std::thread::scope(|threads| {
        let frame = threads.spawn(|| renderer.render(&camera, size, &settings));
        std::thread::sleep(Duration::from_millis(20));
        cancel.cancel();
        assert!(matches!(frame.join().unwrap(), Err(Error::Cancelled { .. })));
    });
}
