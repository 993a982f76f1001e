//! Writes every kernel as a GPU compiler receives it, for scripts/gpu-static, which runs offline compilers without a GPU.

use super::pictures::{self, SIZE};
use super::{Family, figures};
use crate::camera::{Camera, Projection};
use crate::device::{Buffer, DeviceKind, Started, Tuning, kernel_names};
use crate::layers::Kernel;
use crate::renderer::{Channel, DeviceVoxels, LabelColors, Renderer, UploadedColors, UploadedVolume};
use crate::settings::{
    Algorithm, AmbientOcclusion, Blend, Clipping, CropBox, GradientOpacity, LightGrid, Quality, Settings, Shadows,
};
use crate::transfer::TransferFunction;
use crate::volume::{LabelSurfaces, Volume, VoxelType, Voxels};
use crate::{Device, DeviceChoice};
use glam::DVec3;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Serialize)]
struct Program {
    #[serde(flatten)]
    started: Started,
    source: String,
    /// Qualities that start it by default, on uint8 or uint16 voxels.
    qualities: BTreeSet<&'static str>,
}

#[derive(Serialize)]
struct Programs {
    kernels: Vec<Program>,
    /// Kernels that are not started here.
    others: BTreeSet<&'static str>,
}

/// A fresh device, tuned as a GPU.
fn device() -> Device {
    let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
    device.with_tuning(Tuning::new(DeviceKind::Gpu, "", 1, 1)).unwrap()
}

fn values() -> Vec<f64> {
    let volume = pictures::volume();
    (0..volume.grid().dims().iter().product()).map(|n| volume.value(n)).collect()
}

/// The views of the default family, a close view with so few voxels that layers are sampled more densely, and a perspective with voxels of
/// about a pixel, which is sampled at its pixels.
fn cameras() -> [Camera; 4] {
    let [parallel, perspective] = pictures::views(Family::PointLattice).map(|picture| picture.camera);
    let near = Camera { projection: Projection::Parallel { scale: 1.2 }, ..parallel };
    let far = Camera { position: 2.0 * perspective.position - perspective.focal_point, ..perspective };
    [parallel, perspective, near, far]
}

/// Renders these views with the settings of a quality, to floats and to 8 bits.
fn draw(renderer: &mut Renderer, quality: Quality) {
    for camera in cameras() {
        renderer.render(&camera, SIZE, &quality.settings()).unwrap();
        renderer.render_rgba8(&camera, SIZE, &quality.settings(), figures::BACKGROUND).unwrap();
    }
}

/// Draws with shadows and ambient occlusion, in each of the media that light is swept through.
fn draw_light(device: &Device) {
    let volume = pictures::volume();
    let mut renderer = Renderer::new(device, &volume, &pictures::transfer()).unwrap();
    let [picture, _] = pictures::views(Family::Light);
    let crop = CropBox { lowest: DVec3::ONE, highest: DVec3::splat(6.0) };
    let clipping = Clipping { crop: Some(crop), ..Clipping::default() };
    let thinned = Some(GradientOpacity::new(&[(1.0, 0.2), (30.0, 1.0)]).unwrap());
    let lit = Settings { ambient_occlusion: Some(AmbientOcclusion::default()), ..picture.settings };
    for settings in [
        lit,
        Settings { clipping, gradient_opacity: thinned, ..lit },
        Settings { clipping, gradient_opacity: thinned, light_grid: LightGrid::Quarter, ..lit },
        Settings { clipping, blend: Blend::Iso(60.0), ..lit },
    ] {
        renderer.render(&picture.camera, SIZE, &settings).unwrap();
    }
}

/// Draws several fields, labels, and a field in the colours of labels, in layers, cast, and with a light volume.
fn draw_colors(device: &Device) {
    let volume = UploadedVolume::new(device, &pictures::volume()).unwrap();
    let entries: Vec<[f64; 4]> = (0..256).map(|n| [1.0, f64::from(n) / 255.0, 0.0, f64::from(n) / 512.0]).collect();
    let channels = |count| vec![Channel::new(&volume, &pictures::transfer()); count];
    let labels =
        |surfaces| Renderer::from_colors(&UploadedColors::from_labels(&[(&volume, &entries)], surfaces).unwrap()).unwrap();
    let mut scan = Renderer::from_uploaded(&volume, &pictures::transfer()).unwrap();
    scan.set_label_colors(Some(&LabelColors::new(device, &[(&pictures::volume(), &entries)]).unwrap())).unwrap();
    let two = Renderer::from_channels(&channels(2)).unwrap();
    let three = Renderer::from_channels(&channels(3)).unwrap();
    let renderers = [two, three, labels(LabelSurfaces::Smooth), labels(LabelSurfaces::Voxels), scan];
    let standard = Quality::Standard.settings();
    let cast = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 };
    let shadows = Settings { shadows: Some(Shadows::default()), ..standard };
    for mut renderer in renderers {
        draw(&mut renderer, Quality::Standard);
        draw(&mut renderer, Quality::High);
        for settings in [Settings { algorithm: cast, ..standard }, shadows] {
            renderer.render(&cameras()[0], SIZE, &settings).unwrap();
        }
    }
}

/// The transfer function of the check, and one with strong attenuation within a layer.
fn transfers() -> [TransferFunction; 2] {
    let colors = vec![(0.0, [0.0, 0.0, 1.0]), (127.0, [1.0, 0.0, 0.0])];
    let opacities = vec![(0.0, 0.0), (10.0, 0.99), (127.0, 0.99)];
    [pictures::transfer(), TransferFunction::new("opaque", colors, opacities).unwrap()]
}

fn started_by(quality: Quality) -> BTreeSet<Started> {
    let device = device();
    let words = Voxels::Uint16(values().iter().map(|&value| value as u16).collect());
    let words = Volume::new("words", pictures::volume().grid().clone(), words).unwrap().with_background(0.0).unwrap();
    for volume in [pictures::volume(), words] {
        for transfer in transfers() {
            draw(&mut Renderer::new(&device, &volume, &transfer).unwrap(), quality);
        }
    }
    device.started()
}

/// The programs of the device check, of light and of colours, and those of float voxels in a caller's buffer whose range is unknown.
fn started_by_check() -> BTreeSet<Started> {
    let device = device();
    device.check().unwrap();
    let floats: Vec<f32> = values().iter().map(|&value| value as f32).collect();
    let voxels = DeviceVoxels::new(&Buffer::from_slice(&device, &floats, "floats").unwrap().as_memory(), VoxelType::Float32);
    let description = voxels.describe(&device, "floats", pictures::volume().grid().clone(), &[]).unwrap();
    let volume = UploadedVolume::in_place(&device, &description, &voxels).unwrap();
    draw(&mut Renderer::from_uploaded(&volume, &pictures::transfer()).unwrap(), Quality::Standard);
    draw_light(&device);
    draw_colors(&device);
    device.started()
}

#[test]
#[ignore = "writes the file $LAYERSPLAT_PROGRAMS for scripts/gpu-static"]
fn write_programs() {
    let path = std::env::var("LAYERSPLAT_PROGRAMS").expect("scripts/gpu-static sets it");
    let mut qualities: BTreeMap<Started, BTreeSet<&str>> =
        started_by_check().into_iter().map(|started| (started, BTreeSet::new())).collect();
    for (name, quality) in [("standard", Quality::Standard), ("high", Quality::High)] {
        for started in started_by(quality) {
            qualities.entry(started).or_default().insert(name);
        }
    }
    let found: BTreeSet<_> = qualities.keys().map(|started| started.kernel).collect();
    let others = kernel_names().difference(&found).copied().collect();
    let kernels = qualities.into_iter().map(|(started, qualities)| Program { source: started.source(), started, qualities });
    let programs = Programs { kernels: kernels.collect(), others };
    std::fs::write(path, serde_json::to_string(&programs).unwrap()).unwrap();
}
