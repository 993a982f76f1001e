//! Whole frames, from the camera to the 8-bit picture on the host: 512², shaded. `cargo bench --bench frames`

mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use layersplat::opencl3::context::Context;
use layersplat::opencl3::memory::{Buffer, CL_MEM_COPY_HOST_PTR, CL_MEM_READ_WRITE};
use layersplat::transfer::{Extinction, TransferTable};
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

/// A frame with a new transfer function, and the creation of the buffers for its tables alone.
fn transfers(criterion: &mut Criterion) {
    for scene in Scene::data_sets().iter().filter(|scene| scene.name == "engine") {
        let mut renderer = scene.renderer();
        let (lo, hi) = scene.transfer.range();
        let other = scene.transfer.stretched(lo, hi + (hi - lo) * 1e-9).expect("a range");
        let mut next = [&other, &scene.transfer].into_iter().cycle();
        criterion.bench_function(&format!("new transfer function/{}", scene.name), |bencher| {
            bencher.iter(|| {
                renderer.set_transfer_function(next.next().expect("endless"));
                let settings = Settings::default();
                renderer.render_rgba8(&scene.camera(72.0), viewport(), &settings, Background::BLACK).expect("a frame");
            });
        });
        let table = TransferTable::new(&scene.transfer, scene.volume.range(), Extinction::Exponential);
        let (entries, nodes) = (table.entries.len(), table.integrals(1.0).nodes.len());
        // Entries, two counts of entries, and integrals with the values at their nodes.
        let mut tables = [16 * entries, 4 * (entries + 1), 4 * (entries + 1), 16 * 2 * nodes].map(|bytes| vec![1_u8; bytes]);
        let context = Context::from_device(&scene::device().id().into()).expect("a context");
        criterion.bench_function(&format!("buffers of a transfer function/{}", scene.name), |bencher| {
            bencher.iter(|| {
                let flags = CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR;
                // SAFETY: the buffer has the length of the table, which is only read.
                tables.each_mut().map(|table| unsafe {
                    Buffer::<u8>::create(&context, flags, table.len(), table.as_mut_ptr().cast()).expect("a buffer")
                })
            });
        });
    }
}

criterion_group!(benches, frames, changes, transfers);
criterion_main!(benches);
