//! Scenes that distinguish kernels: samples of known signals.

use crate::common::*;
use glam::DVec3;
use layersplat::reference::Integral;
use layersplat::settings::{Algorithm, Clipping, CropBox, Shading};
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Frame, GradientEstimator, Orbit, Projection, Settings, TransferFunction, Viewport, Volume};
use std::f64::consts::PI;

/// A volume, its view, and a crop box that hides boundaries, where kernels read missing voxels.
pub struct Scene {
    pub name: String,
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
    pub camera: Camera,
    pub size: Viewport,
    pub clipping: Clipping,
    pub unit_distance: f64,
}

impl Scene {
    /// Renders the scene, with the gradients that fit the kernel most closely.
    pub fn render(&self, algorithm: Algorithm, shading: Option<Shading>) -> Frame {
        self.render_with(&closest(algorithm, shading))
    }

    /// Renders the scene with other settings than its own clipping and unit distance.
    pub fn render_with(&self, settings: &Settings) -> Frame {
        self.render_from(&self.camera, settings)
    }

    /// Renders the scene with the camera shifted by half a voxel, which comparisons must detect.
    pub fn render_aside(&self, algorithm: Algorithm, shading: Option<Shading>) -> Frame {
        let aside = self.volume.grid().spacing() * DVec3::splat(0.5);
        let Camera { position, focal_point, .. } = self.camera;
        let camera = Camera { position: position + aside, focal_point: focal_point + aside, ..self.camera };
        self.render_from(&camera, &closest(algorithm, shading))
    }

    fn render_from(&self, camera: &Camera, settings: &Settings) -> Frame {
        let (clipping, unit_distance) = (self.clipping, Some(self.unit_distance));
        let settings = Settings { clipping, unit_distance, ..*settings };
        render(&self.volume, &self.transfer, camera, self.size, &settings)
    }

    /// Integral of the scene on the host.
    pub fn integral(&self, shading: Option<Shading>) -> Integral<'_> {
        let mut integral = Integral::new(&self.volume, &self.transfer, Some(self.unit_distance));
        (integral.shading, integral.clipping) = (shading, self.clipping);
        integral
    }
}

/// Settings with the gradients that fit the kernel most closely.
pub fn closest(algorithm: Algorithm, shading: Option<Shading>) -> Settings {
    let settings = Settings { shading, ..algorithm.into() };
    Settings { gradient: Some(GradientEstimator::for_kernel(kernel_of(&settings))), ..settings }
}

/// Visible part of Marschner and Lobb's signal per axis of −1 … 1: three voxels less than all of 41³, equal for all sizes.
const SHOWN: f64 = 0.85;

/// Marschner and Lobb's signal (1994), sampled n³ times and rounded to bytes. All sizes give the same picture, except for lost detail.
pub fn marschner_lobb(n: usize) -> Scene {
    let volume = Volume::open(format!("builtin:marschner-lobb@{n}"), &layersplat::OpenOptions::default()).unwrap();
    let half = (n as f64 - 1.0) / 2.0;
    // Rings cut at the middle of their slope, behind thin fog.
    let opacities =
        vec![(0.0, 0.0), (40.0, 0.0), (70.0, 0.015), (100.0, 0.0), (0.45 * 255.0, 0.0), (0.55 * 255.0, 0.9), (255.0, 0.9)];
    let colors = vec![(0.0, [0.2, 0.4, 0.9]), (100.0, [0.2, 0.6, 0.8]), (128.0, [0.95, 0.7, 0.3]), (255.0, [0.8, 0.3, 0.2])];
    let size = viewport(256, 256);
    Scene {
        name: format!("marschner-lobb@{n}"),
        transfer: TransferFunction::new("rings", colors, opacities).unwrap(),
        camera: scaled(parallel(&volume, size, 15.0, 35.0), 1.15 * half),
        size,
        clipping: cropped(DVec3::splat(half - SHOWN * half), DVec3::splat(half + SHOWN * half)),
        unit_distance: half / 32.0,
        volume,
    }
}

/// The signal at a position in voxels of n³ samples, in units of bytes, not rounded, and its gradient.
pub fn marschner_lobb_signal(n: usize, p: DVec3) -> (f64, DVec3) {
    const FREQUENCY: f64 = 6.0;
    const AMPLITUDE: f64 = 0.25;
    let half = (n as f64 - 1.0) / 2.0;
    let q = p / half - 1.0;
    let r = q.x.hypot(q.y);
    let phase = 2.0 * PI * FREQUENCY * (PI * r / 2.0).cos();
    let value = 1.0 - (PI * q.z / 2.0).sin() + AMPLITUDE * (1.0 + phase.cos());
    let along_r = AMPLITUDE * phase.sin() * PI * PI * FREQUENCY * (PI * r / 2.0).sin();
    // At the centre of the rings the direction is undefined, and the slope 0.
    let outwards = if r > 0.0 { q.truncate() / r } else { q.truncate() };
    let slope = (along_r * outwards).extend(-PI / 2.0 * (PI * q.z / 2.0).cos());
    let bytes = 255.0 / (2.0 * (1.0 + AMPLITUDE));
    (bytes * value, bytes / half * slope)
}

/// A full data set, and its half-resolution version: means of 2³ voxels, rounded to bytes, at the centres of their eight voxels. Both have
/// the same view and crop box.
pub fn whole_and_halved(name: &str) -> [Scene; 2] {
    /// Hidden margin on every side, in half-resolution voxels.
    const MARGIN: f64 = 4.0;
    let (volume, transfer) = data_set(name);
    let halves = halved(&volume);
    let size = viewport(256, 256);
    let last = DVec3::from_array(halves.grid().dims().map(|n| n as f64 - 1.0));
    let (lowest, highest) = (DVec3::splat(MARGIN), last - MARGIN);
    // Half-resolution voxel i lies at 2i + 0.5 of the full volume.
    let of_the_whole = cropped(2.0 * lowest + 0.5, 2.0 * highest + 0.5);
    let orbit = Orbit { azimuth: 72.0, elevation: 20.0, roll: 0.0 };
    let grid = halves.grid();
    let camera = Camera::orbit(grid.centre(), 1.0, orbit, Projection::Parallel { scale: 0.35 * grid.diagonal() });
    let unit_distance = volume.grid().spacing().min_element();
    let scene = |name: String, volume, clipping| Scene {
        name,
        volume,
        transfer: transfer.clone(),
        camera,
        size,
        clipping,
        unit_distance,
    };
    [scene(name.into(), volume, of_the_whole), scene(format!("{name}, halved"), halves, cropped(lowest, highest))]
}

fn halved(volume: &Volume) -> Volume<'static> {
    let grid = volume.grid();
    let ([nx, ny, _], dims) = (grid.dims(), grid.dims().map(|n| n / 2));
    let mut bytes = Vec::with_capacity(dims.iter().product());
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            for i in 0..dims[0] {
                let corner = |n: usize| volume.value(2 * i + (n & 1) + nx * (2 * j + (n >> 1 & 1) + ny * (2 * k + (n >> 2))));
                bytes.push(((0..8).map(corner).sum::<f64>() / 8.0).round() as u8);
            }
        }
    }
    let origin = grid.index_to_world().transform_point3(DVec3::splat(0.5));
    let grid = Grid::oriented(dims, 2.0 * grid.spacing(), origin, grid.direction()).unwrap();
    Volume::new("halved", grid, Voxels::Uint8(bytes)).unwrap()
}

fn cropped(lowest: DVec3, highest: DVec3) -> Clipping {
    Clipping { crop: Some(CropBox { lowest, highest }), ..Clipping::default() }
}
