//! Pictures of real volumes, compared with pictures whose samples march to the light.

use super::*;
use layersplat::layers::{Axis, Rays};
use layersplat::reference::Layered as LayeredReference;
use rayon::prelude::*;

/// Peak signal-to-noise ratio in dB over RGB of some pixels of a picture of 512², compared with the same samples that march to the light.
fn psnr_of_light(volume: &Volume, transfer: &TransferFunction, camera: &Camera, settings: &Settings, every: usize) -> f64 {
    let size = viewport(512, 512);
    let frame = render(volume, transfer, camera, size, settings);
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

/// Least dB with the exact shadow, with F = 4, and of the sky alone: below the table of docs/dev/light.md by up to 10, since the few pixels that
/// are compared by default can lie at shadow edges.
const LEAST: [(&str, f64, [f64; 3]); 5] = [
    ("engine", 72.0, [46.0, 43.0, 36.0]),
    ("cranium", 30.0, [39.0, 34.5, 33.0]),
    ("lobster", 72.0, [51.0, 48.0, 47.0]),
    ("aneurism", 72.0, [39.0, 37.5, 40.0]),
    ("neghip", 72.0, [51.0, 45.0, 44.0]),
];

#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn light_volumes_are_near_marched_light() {
    // A prime, so that all columns are covered. The table is printed with LAYERSPLAT_EVERY=211.
    let every = std::env::var("LAYERSPLAT_EVERY").map_or(1009, |every| every.parse().expect("LAYERSPLAT_EVERY is a number"));
    for (name, azimuth, least) in LEAST {
        let (volume, transfer) = if name == "cranium" { skull() } else { data_set(name) };
        let camera = parallel(&volume, viewport(512, 512), azimuth, 20.0);
        let lights = Lights::BESIDE_CAMERA.in_world(&camera).unwrap();
        let lit = shaded(direct(POINTS), lights.as_slice());
        let exact = Settings { shadows: Some(EXACT), ..lit };
        let forgiven = Settings { shadows: Some(Shadows::default()), ..lit };
        let sky = Shading { ambient: 0.9, diffuse: 0.0, specular: 0.0, ..Shading::default() };
        let occlusion = Some(AmbientOcclusion { gain: 1.0, reach: None });
        let open = Settings { shading: Some(sky), ambient_occlusion: occlusion, ..direct(POINTS) };
        let found = [exact, forgiven, open].map(|settings| psnr_of_light(&volume, &transfer, &camera, &settings, every));
        println!("{name}: F = 1 {:.1}, F = 4 {:.1}, sky {:.1}", found[0], found[1], found[2]);
        for (found, least) in found.iter().zip(least) {
            assert!(*found > least, "{name}: {found} dB, {least} asked");
        }
    }
}
