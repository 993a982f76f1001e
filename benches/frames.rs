//! Whole frames, from the camera to the 8-bit picture on the host: 512², shaded. `cargo bench --bench frames`

mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use layersplat::{Background, Quality};
use scene::{BUILT_IN, Scene, viewport};

fn frames(criterion: &mut Criterion) {
    let scenes = BUILT_IN.map(Scene::built_in).into_iter().chain(Scene::data_sets());
    for scene in scenes {
        let mut renderer = scene.renderer();
        let camera = scene.camera(72.0);
        for (name, quality) in [("draft", Quality::Draft), ("standard", Quality::Standard), ("high", Quality::High)] {
            let settings = quality.settings();
            criterion.bench_function(&format!("frame/{}/{name}", scene.name), |bencher| {
                bencher.iter(|| renderer.render_rgba8(&camera, viewport(), &settings, Background::BLACK).expect("a frame"));
            });
        }
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
