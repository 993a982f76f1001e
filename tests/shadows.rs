//! Shadows and ambient occlusion: closed forms, the f64 reference with marched shadow rays, culling, all algorithms.

mod common;

use common::*;
use layersplat::layers::{Axis, Rays};
use layersplat::reference::Layered as LayeredReference;
use layersplat::settings::{AmbientOcclusion, Evaluation, Layered, Lights, Shading, Shadows};
use layersplat::{Camera, Renderer, Settings, TransferFunction, Volume};
use rayon::prelude::*;

/// Peak signal-to-noise ratio in dB over RGB of some pixels of a picture, compared with samples that march to the light.
fn psnr_of_light(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings, every: usize) -> f64 {
    let size = viewport(512, 512);
    let mut renderer = Renderer::new(&device(), volume, transfer).unwrap();
    let (frame, _) = renderer.render(camera, size, settings).unwrap();
    let rays = Rays::new(camera, size, volume.grid()).unwrap();
    let axis = Axis::most_parallel(rays.central_direction());
    let reference = LayeredReference::new(volume, transfer, settings);
    let pixels: Vec<usize> = (0..size.pixels()).step_by(every).collect();
    let error: f64 = pixels
        .par_iter()
        .map(|&n| {
            let (x, y) = ((n % 512) as f64 + 0.5, (n / 512) as f64 + 0.5);
            let expected = reference.composite(&rays.at(x, y), Some(axis), rays.to_eye);
            (0..3).map(|c| (f64::from(frame.pixels()[n][c]) - expected[c]).powi(2)).sum::<f64>()
        })
        .sum();
    -10.0 * (error / (3 * pixels.len()) as f64).log10()
}

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs the real data sets")]
fn light_volumes_are_near_marched_light() {
    let only = std::env::var("SETS").unwrap_or("engine cranium lobster aneurism neghip".into());
    for (name, azimuth) in [("engine", 72.0), ("cranium", 30.0), ("lobster", 72.0), ("aneurism", 72.0), ("neghip", 72.0)] {
        if !only.split(' ').any(|set| name.starts_with(set)) {
            continue;
        }
        let (volume, transfer) = if name == "cranium" { skull() } else { data_set(name) };
        let camera = parallel(&volume, viewport(512, 512), azimuth, 20.0);
        let lights = Lights::BESIDE_CAMERA.in_world(&camera).unwrap();
        let direct = Settings::from(Layered { evaluation: Evaluation::Direct, ..Layered::default() });
        let lit = Settings { shading: Some(Shading { lights, ..Shading::default() }), ..direct };
        let psnr = |settings: Settings| {
            psnr_of_light(&volume, &transfer, &camera, &settings, std::env::var("EVERY").map_or(97, |e| e.parse().unwrap()))
        };
        print!("{name}: none {:.1}", psnr(lit));
        for forgiveness in [1.0, 4.0] {
            let shadows = Some(Shadows { forgiveness, ..Shadows::default() });
            print!(", F {forgiveness}: {:.1}", psnr(Settings { shadows, ..lit }));
        }
        let sky = Shading { ambient: 0.9, diffuse: 0.0, specular: 0.0, ..Shading::default() };
        let occlusion = Some(AmbientOcclusion { gain: 1.0, ..AmbientOcclusion::default() });
        println!(", sky {:.1}", psnr(Settings { shading: Some(sky), ambient_occlusion: occlusion, ..direct }));
    }
}
