//! Device time of each stage of a frame. `cargo bench --bench stages`

mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use layersplat::layers::Correction;
use layersplat::settings::{Classification, Layered};
use layersplat::{Background, Renderer, Settings};
use scene::{Scene, viewport};
use std::time::Duration;

/// Device time of a stage in one frame.
fn stage_time(renderer: &mut Renderer, scene: &Scene, azimuth: f64, settings: &Settings, stage: &str) -> Duration {
    let camera = scene.camera(azimuth);
    renderer.measure(true);
    let (_, report) = renderer.render_rgba8(&camera, viewport(), settings, Background::BLACK).expect("a frame");
    let stages = report.measured.expect("asked for").stages;
    let found = stages.iter().find(|(name, _)| *name == stage);
    let (_, ms) = found.unwrap_or_else(|| panic!("no stage {stage} among {stages:?}"));
    Duration::from_secs_f64(ms / 1e3)
}

/// Stages that every frame has.
fn frame_stages(criterion: &mut Criterion, scene: &Scene, name: &str, settings: &Settings, stages: &[&str]) {
    let mut renderer = scene.renderer();
    for stage in stages {
        criterion.bench_function(&format!("stage/{name}/{stage}"), |bencher| {
            bencher.iter_custom(|n| (0..n).map(|_| stage_time(&mut renderer, scene, 72.0, settings, stage)).sum());
        });
    }
}

fn stages(criterion: &mut Criterion) {
    let scene = Scene::built_in("builtin:hydrogen@128");
    let points = Settings::default();
    let splats = Settings {
        algorithm: Layered { classification: Classification::Post(Correction::SubLayers(2)), ..Layered::default() }.into(),
        ..points
    };
    frame_stages(criterion, &scene, "points", &points, &["lattice", "warp"]);
    frame_stages(criterion, &scene, "splats", &splats, &["table", "footprints", "lattice", "warp"]);

    // Stages after a change of the transfer function, and of the first frame of a layer axis.
    let mut renderer = scene.renderer();
    criterion.bench_function("stage/points/visibility", |bencher| {
        bencher.iter_custom(|n| {
            let once = |_| {
                // Another one and back, since the same one would change nothing.
                renderer.set_transfer_function(&scene.transfer.faded(0.5).expect("a share"));
                renderer.set_transfer_function(&scene.transfer);
                stage_time(&mut renderer, &scene, 72.0, &points, "visibility")
            };
            (0..n).map(once).sum()
        });
    });
    for stage in ["transpose", "min-max blocks"] {
        criterion.bench_function(&format!("stage/points/{stage}"), |bencher| {
            bencher.iter_custom(|n| (0..n).map(|_| stage_time(&mut scene.renderer(), &scene, 90.0, &points, stage)).sum());
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = stages
}
criterion_main!(benches);
