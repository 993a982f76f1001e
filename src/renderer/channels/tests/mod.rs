//! Several fields in one picture.

mod light;

use super::*;
use crate::camera::{Camera, Orbit};
use crate::device::Device;
use crate::image::Frame;
use crate::layers::{Correction, Kernel};
use crate::renderer::Renderer;
use crate::settings::{Algorithm, Classification, Clipping, CropBox, Layered, Quality};
use crate::transfer::Extinction;
use crate::viewport::Viewport;
use crate::volume::{Grid, OpenOptions, Volume};
use glam::{DMat3, DVec3};

const VIEWPORT: Viewport = Viewport { width: 56, height: 48 };

/// Views with layer axes z and x, and a perspective.
fn cameras(volume: &Volume) -> [Camera; 3] {
    let grid = volume.grid();
    let orbit = |azimuth| Orbit { azimuth, elevation: 15.0, roll: 0.0 };
    let parallel = |azimuth| Camera::fit_parallel(grid.centre(), grid.diagonal(), VIEWPORT, orbit(azimuth));
    [parallel(20.0), parallel(75.0), Camera::fit_perspective(grid.centre(), grid.diagonal(), 30.0, VIEWPORT, orbit(200.0))]
}

/// Two volumes of one grid, on the device, with transfer functions of different hues.
fn scene(device: &Device) -> (Volume<'static>, [Channel; 2]) {
    let [one, other] = ["hydrogen", "gyroid"].map(|name| {
        let volume = Volume::open(format!("builtin:{name}@24"), &OpenOptions::default()).unwrap();
        let uploaded = UploadedVolume::new(device, &volume).unwrap();
        (volume, uploaded)
    });
    let channels = [(&one, [0.1, 0.9, 0.3]), (&other, [0.9, 0.2, 0.7])].map(|((volume, uploaded), color)| {
        let (lo, hi) = volume.range();
        let opacities = vec![(lo, 0.0), (lo + 0.4 * (hi - lo), 0.0), (hi, 0.4)];
        let transfer = TransferFunction::new("ramp", vec![(lo, color), (hi, [1.0, 1.0, color[2]])], opacities).unwrap();
        Channel::new(uploaded, &transfer)
    });
    (one.0, channels)
}

fn kernels() -> [Settings; 6] {
    let layered = |kernel, samples_per_layer| {
        let classification = Classification::Preintegrated { kernel, samples_per_layer };
        Settings { algorithm: Algorithm::Layered(Layered { classification, ..Layered::default() }), ..Settings::default() }
    };
    let raycast = Settings { algorithm: Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }, ..Settings::default() };
    let post = |correction| {
        let classification = Classification::Post(correction);
        Settings { algorithm: Algorithm::Layered(Layered { classification, ..Layered::default() }), ..Settings::default() }
    };
    let splatted = [post(Correction::Constant), post(Correction::SubLayers(2))];
    let [one, several] = splatted;
    [layered(Kernel::CatmullRom, 1), layered(Kernel::Cubic, 2), Quality::High.settings(), raycast, one, several]
}

fn pictures(renderer: &mut Renderer, cameras: &[Camera], settings: &Settings) -> Vec<Frame> {
    cameras.iter().map(|camera| renderer.render(camera, VIEWPORT, settings).unwrap().0).collect()
}

/// Largest difference in any channel, alpha included.
fn difference(one: &[Frame], other: &[Frame]) -> f32 {
    let pairs = one.iter().zip(other).flat_map(|(one, other)| one.pixels().iter().zip(other.pixels()));
    pairs.flat_map(|(one, other)| one.iter().zip(other).map(|(a, b)| (a - b).abs())).fold(0.0, f32::max)
}

/// Two halves of a field are the whole: lit, along all axes, with every kernel, with both extinctions.
#[test]
fn two_halves_are_the_whole() {
    /// Rounding of two sums instead of one.
    const TOLERANCE: f32 = 1e-5;
    let device = Device::shared();
    let (volume, [channel, _]) = scene(&device);
    let cameras = cameras(&volume);
    for settings in kernels() {
        for extinction in [Extinction::Exponential, Extinction::Linear] {
            let settings = Settings { extinction, ..settings };
            let whole = pictures(&mut Renderer::from_channels(std::slice::from_ref(&channel)).unwrap(), &cameras, &settings);
            let halves = [0.5, 0.5].map(|factor| channel.clone().with_factor(factor).unwrap());
            let mut renderer = Renderer::from_channels(&halves).unwrap();
            let together = pictures(&mut renderer, &cameras, &settings);
            let error = difference(&whole, &together);
            assert!(error <= TOLERANCE, "{error:e} with {extinction:?}, {settings:?}");
            // A factor that is off by a percent would be noticed.
            renderer.set_channels(&[0.5, 0.51].map(|factor| channel.clone().with_factor(factor).unwrap())).unwrap();
            assert!(difference(&whole, &pictures(&mut renderer, &cameras, &settings)) > 10.0 * TOLERANCE);
        }
    }
}

/// The order of the channels does not matter, one alone is its own picture to the bit, and culling changes nothing.
#[test]
fn channels_have_no_order_and_hidden_ones_no_effect() {
    const TOLERANCE: f32 = 1e-6;
    let device = Device::shared();
    let (volume, [one, other]) = scene(&device);
    let cameras = cameras(&volume);
    let settings = Settings::default();
    let draw = |channels: &[Channel]| pictures(&mut Renderer::from_channels(channels).unwrap(), &cameras, &settings);
    let both = draw(&[one.clone(), other.clone()]);
    assert!(difference(&both, &draw(&[other.clone(), one.clone()])) <= TOLERANCE);
    let alone = draw(std::slice::from_ref(&other));
    assert!(draw(&[one.clone().with_visibility(false), other.clone()]) == alone);
    assert!(draw(&[other.clone(), one.clone().with_visibility(false)]) == alone);
    assert!(difference(&both, &alone) > 0.1);
    let empty = one.clone().with_factor(0.0).unwrap();
    assert!(draw(&[other.clone(), empty]) == alone, "an empty channel costs nothing");
    let transparent = Channel::new(&one.volume, &one.transfer.faded(0.0).unwrap());
    assert!(draw(&[transparent, other.clone()]) == alone);
    // On a grid of its own, which would extend and refine that of the picture.
    let fine = UploadedVolume::new(&device, &moved(&volume, 0.4, DVec3::splat(40.0))).unwrap();
    let fine = Channel::new(&fine, &one.transfer).with_visibility(false);
    assert!(draw(&[fine.clone(), other.clone()]) == alone && draw(&[other.clone(), fine]) == alone);
    let hidden = draw(&[one.clone().with_visibility(false)]);
    assert!(hidden.iter().all(|frame| frame.pixels().iter().all(|pixel| *pixel == [0.0; 4])));
    for settings in kernels() {
        let mut renderer = Renderer::from_channels(&[one.clone(), other.clone()]).unwrap();
        let culled = pictures(&mut renderer, &cameras, &settings);
        assert!(culled == pictures(&mut renderer, &cameras, &Settings { culling: false, ..settings }), "{settings:?}");
    }
}

/// Maximum, minimum and average of each field; their colours add.
#[test]
fn gathered_values_add_as_colors() {
    const TOLERANCE: f32 = 1e-6;
    const FACTOR: f64 = 1.75;
    let device = Device::shared();
    let (volume, channels) = scene(&device);
    for blend in [Blend::Maximum, Blend::Minimum, Blend::Average] {
        let settings = Settings { blend, shading: None, ..Settings::default() };
        let draw = |channels: &[Channel], camera| {
            let mut renderer = Renderer::from_channels(channels).unwrap();
            // Before the warp, which keeps colours in the range of those around.
            renderer.lattice_picture(camera, VIEWPORT, &settings).unwrap().unwrap().samples
        };
        for camera in &cameras(&volume) {
            let together = draw(&channels, camera);
            let [one, other] = channels.each_ref().map(|channel| draw(std::slice::from_ref(channel), camera));
            let mut changed = 0;
            for (sample, (one, other)) in together.iter().zip(one.iter().zip(&other)) {
                for c in 0..4 {
                    assert!(
                        (sample[c] - (one[c] + other[c]).min(1.0)).abs() <= TOLERANCE,
                        "{blend:?}: {sample:?}, {one:?}, {other:?}"
                    );
                }
                changed += usize::from(sample[0] > one[0] + 0.05);
            }
            assert!(changed > 100, "{blend:?}: the second channel adds something");
            // A factor brightens.
            let bright = draw(&[channels[0].clone().with_factor(FACTOR).unwrap()], camera);
            for (sample, one) in bright.iter().zip(&one) {
                let expected = [0, 1, 2].map(|c| (one[c] * FACTOR as f32).min(1.0));
                assert!(
                    (0..3).all(|c| (sample[c] - expected[c]).abs() <= TOLERANCE) && sample[3] == one[3],
                    "{sample:?}, {one:?}"
                );
            }
        }
    }
}

/// Of two surfaces the nearer one is seen.
#[test]
fn the_nearest_surface_is_seen() {
    let device = Device::shared();
    let (volume, [channel, _]) = scene(&device);
    let cameras = cameras(&volume);
    let (lo, hi) = volume.range();
    let [inner, outer] = [0.7, 0.3].map(|share| lo + share * (hi - lo));
    let settings = Settings { blend: Blend::Iso(outer), ..Settings::default() };
    let alone = pictures(&mut Renderer::from_channels(std::slice::from_ref(&channel)).unwrap(), &cameras, &settings);
    let both = [channel.clone().with_iso(inner), channel.clone()];
    // The surface of the larger values lies inside the other one.
    let together = pictures(&mut Renderer::from_channels(&both).unwrap(), &cameras, &settings);
    assert!(difference(&together, &alone) <= 1e-6);
    let only_inner = pictures(&mut Renderer::from_channels(&both[..1]).unwrap(), &cameras, &settings);
    assert!(difference(&only_inner, &alone) > 0.1);
}

/// The same voxels as `volume`, in another type and on another part of the world.
fn moved(volume: &Volume, spacing: f64, origin: DVec3) -> Volume<'static> {
    let grid = Grid::oriented(volume.grid().dims(), DVec3::splat(spacing), origin, DMat3::IDENTITY).unwrap();
    let voxels: Vec<f32> = (0..grid.voxel_count()).map(|n| volume.value(n) as f32).collect();
    Volume::new("moved", grid, voxels).unwrap()
}

/// Fields of two voxel types have the picture of fields of one.
#[test]
fn voxel_types_may_differ() {
    const TOLERANCE: f32 = 1e-5;
    let device = Device::shared();
    let (volume, [one, other]) = scene(&device);
    let cameras = cameras(&volume);
    let floats = UploadedVolume::new(&device, &moved(&volume, 1.0, DVec3::ZERO)).unwrap();
    let draw = |channels: &[Channel]| pictures(&mut Renderer::from_channels(channels).unwrap(), &cameras, &Settings::default());
    let bytes = draw(&[one.clone(), other.clone()]);
    let mixed = draw(&[Channel::new(&floats, &one.transfer), other.clone()]);
    assert!(difference(&bytes, &mixed) <= TOLERANCE);
    // A transfer function for other values would be noticed.
    assert!(difference(&bytes, &draw(&[Channel::new(&floats, &other.transfer), other])) > 0.01);
}

/// A field alone, and with an invisible one that extends the grid, has one picture; crop boxes count its own voxels.
#[test]
fn a_larger_grid_changes_nothing_within_it() {
    /// Mean difference. Lattices are anchored at the centre of the grid, so their samples are elsewhere: single pixels differ by 0.03.
    const TOLERANCE: f32 = 2e-4;
    let device = Device::shared();
    let (volume, [one, _]) = scene(&device);
    let cameras = cameras(&volume);
    let mean = |one: &[Frame], other: &[Frame]| {
        let pairs = one.iter().zip(other).flat_map(|(one, other)| one.pixels().iter().zip(other.pixels()));
        let differences: Vec<f32> =
            pairs.map(|(one, other)| (0..4).map(|c| (one[c] - other[c]).abs()).sum::<f32>() / 4.0).collect();
        differences.iter().sum::<f32>() / differences.len() as f32
    };
    let far = UploadedVolume::new(&device, &moved(&volume, 2.0, DVec3::new(-14.0, -9.0, 10.0))).unwrap();
    let empty = Channel::new(&far, &one.transfer.faded(0.0).unwrap());
    let crop = CropBox { lowest: DVec3::new(3.0, 4.0, 5.0), highest: DVec3::new(20.0, f64::INFINITY, 18.0) };
    for crop in [None, Some(crop)] {
        let settings = Settings { clipping: Clipping { crop, ..Clipping::default() }, ..Settings::default() };
        let mut renderer = Renderer::from_channels(std::slice::from_ref(&one)).unwrap();
        let alone = pictures(&mut renderer, &cameras, &settings);
        renderer.set_channels(&[one.clone(), empty.clone()]).unwrap();
        assert_ne!(renderer.grid().dims(), volume.grid().dims());
        let error = mean(&alone, &pictures(&mut renderer, &cameras, &settings));
        assert!(error <= TOLERANCE, "{error}, {crop:?}");
        // A box that counts voxels of the larger grid would be noticed.
        let shifted = crop.map(|crop| CropBox { lowest: crop.lowest + 4.0, highest: crop.highest + 4.0 });
        let settings = Settings { clipping: Clipping { crop: shifted, ..Clipping::default() }, ..settings };
        let error = mean(&alone, &pictures(&mut renderer, &cameras, &settings));
        assert!(crop.is_none() || error > 2.0 * TOLERANCE, "{error}");
    }
}

#[test]
fn bad_channels_are_refused() {
    let device = Device::shared();
    let (volume, [one, other]) = scene(&device);
    let mut renderer = Renderer::from_channels(std::slice::from_ref(&one)).unwrap();
    let fine = UploadedVolume::new(&device, &moved(&volume, 1e-4, DVec3::ZERO)).unwrap();
    let problem = renderer.set_channels(&[one.clone(), Channel::new(&fine, &one.transfer)]).unwrap_err().to_string();
    assert!(problem.contains("moved has a spacing of 1.0000e-4") && problem.contains("units"), "{problem}");
    let many = vec![one.clone(); Channel::MOST + 1];
    for channels in [&[][..], &many] {
        assert!(matches!(renderer.set_channels(channels), Err(Error::Settings { field: "channels", .. })));
    }
    assert!(matches!(Renderer::from_channels(&[]), Err(Error::Settings { field: "channels", .. })));
    for factor in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(other.clone().with_factor(factor), Err(Error::OutOfRange { name: "factor", .. })));
    }
}
