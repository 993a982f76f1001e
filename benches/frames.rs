//! Whole frames, from the camera to the 8-bit picture on the host: 512², shaded. `cargo bench --bench frames`

mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use layersplat::{Background, Quality, Renderer, Settings};
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

/// A frame after the voxels have changed in place, compared with the first frame of a new upload.
fn changes(criterion: &mut Criterion) {
    let scenes = [Scene::built_in(BUILT_IN[0])].into_iter().chain(Scene::data_sets());
    for scene in scenes.filter(|scene| ["hydrogen@128", "aneurism"].contains(&scene.name.as_str())) {
        let device = scene::device();
        let draw = |renderer: &mut Renderer| {
            renderer.render_rgba8(&scene.camera(72.0), viewport(), &Settings::default(), Background::BLACK).expect("a frame");
        };
        let new = || Renderer::new(&device, &scene.volume, &scene.transfer).expect("a renderer");
        let mut renderer = new();
        draw(&mut renderer);
        criterion.bench_function(&format!("changed/{}", scene.name), |bencher| {
            bencher.iter(|| {
                renderer.volume_changed(&[]).expect("an event");
                draw(&mut renderer);
            });
        });
        criterion.bench_function(&format!("uploaded anew/{}", scene.name), |bencher| bencher.iter(|| draw(&mut new())));
    }
}

criterion_group!(benches, frames, changes);
criterion_main!(benches);
