//! Surfaces in volumes.

use crate::common::surfaces::{Data, Scene, iso_surface, scenes};
use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::reference::{Integral, Marched};
use layersplat::settings::Algorithm;
use layersplat::surface::Surface;
use layersplat::volume::Voxels;
use layersplat::{Frame, Renderer, Settings, Viewport};

/// Distance of the iso-surface of a ball of radius 7 from it, in voxels, and what rounding adds: interpolation along edges of up to √3.
const OFF: f64 = 3.0 / (8.0 * 7.0) + 1e-3;

#[test]
fn iso_surfaces_are_closed_and_where_the_value_is() {
    let centre = DVec3::new(9.3, 10.1, 9.7);
    let value = |n: usize| {
        let p = DVec3::new((n % 20) as f64, (n / 20 % 20) as f64, (n / 400) as f64);
        (20.0 * (10.0 - p.distance(centre))) as f32
    };
    let ball = volume([20; 3], DVec3::ONE, Voxels::Float32((0..8000).map(value).collect()));
    let surface = iso_surface(&ball, 60.0, 1);
    assert!(surface.is_closed());
    let normals = surface.normals().unwrap();
    for (p, normal) in surface.points().iter().zip(normals) {
        let off = *p - centre;
        assert!((off.length() - 7.0).abs() < OFF, "{p}");
        assert!(off.normalize().dot(normal.as_dvec3().normalize()) > 0.99, "{p}: {normal}");
    }
    // Triangles face lower values.
    for [a, b, c] in surface.indices().iter().map(|points| points.map(|n| surface.points()[n as usize])) {
        assert!((b - a).cross(c - a).dot(a - centre) > -1e-9, "{a}, {b}, {c}");
    }
}

/// Surfaces and the volume each change a twentieth of the picture and more.
#[test]
fn scenes_show_surfaces_and_volumes() {
    let size = viewport(24, 24);
    for Scene { name, volume, transfer, surfaces, camera } in scenes(Data::BuiltIn, size) {
        let settings = Algorithm::Raycast { kernel: Kernel::Linear, step: 1.0 }.into();
        let clear = transfer.faded(0.0).unwrap();
        let picture =
            |transfer, sets| Marched::new(&volume, transfer, &settings).with_surfaces(sets).render(&camera, size).unwrap();
        let both = picture(&transfer, &surfaces);
        for alone in [picture(&transfer, &[]), picture(&clear, &surfaces)] {
            let apart = pixels_apart(&both, &alone, 0.02);
            assert!(apart > both.pixels().len() / 20, "{name}: {apart} pixels");
        }
    }
}

/// Colours of fragments have half precision, eleven bits; a ray has tens of them at most.
const ROUNDED_COLORS: f64 = 4e-3;
/// Pixels at silhouettes and at lines where surfaces intersect, which rounded places decide: in pictures as small as these, many.
const SILHOUETTES: f64 = 0.07;
/// Share of pixels that thin tubes cover.
const NOTICED: f64 = 0.01;
/// What surfaces may cost in dB: cuts of segments are between samples.
const LOST: f64 = 1.0;

fn drawn(scene: &Scene, surfaces: &[Surface], size: Viewport, settings: &Settings) -> Frame {
    let mut renderer = Renderer::new(&device(), &scene.volume, &scene.transfer).unwrap();
    renderer.set_surfaces(surfaces).unwrap();
    renderer.render(&scene.camera, size, settings).unwrap().0
}

/// Share of the pixels that differ, and dB of all others.
fn compared(one: &Frame, other: &Frame) -> (f64, f64) {
    let apart: Vec<f64> = one
        .pixels()
        .iter()
        .zip(other.pixels())
        .map(|(p, q)| p.iter().zip(q).map(|(p, q)| f64::from((p - q).abs())).fold(0.0, f64::max))
        .collect();
    let mut sorted = apart.clone();
    sorted.sort_by(f64::total_cmp);
    let kept = &sorted[..((1.0 - SILHOUETTES) * sorted.len() as f64) as usize];
    let mean = kept.iter().map(|d| d * d).sum::<f64>() / kept.len() as f64;
    let differing = apart.iter().filter(|&&d| d > ROUNDED_COLORS).count() as f64 / apart.len() as f64;
    (differing, -10.0 * mean.max(1e-20).log10())
}

#[test]
fn rays_are_those_of_the_reference() {
    let size = viewport(36, 32);
    for scene in scenes(Data::BuiltIn, size) {
        let settings = Settings { early_termination: false, ..Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 }.into() };
        let reference = Marched::new(&scene.volume, &scene.transfer, &settings).with_surfaces(&scene.surfaces);
        let expected = reference.render(&scene.camera, size).unwrap();
        let (differing, db) = compared(&drawn(&scene, &scene.surfaces, size, &settings), &expected);
        println!("{}: {:.4} of the pixels differ, {db:.1} dB of the others", scene.name, differing);
        assert!(differing < SILHOUETTES, "{}: {differing} of the pixels differ", scene.name);
        // Fragments a tenth more opaque.
        let mut wrong = scene.surfaces.clone();
        wrong.iter_mut().for_each(|surface| surface.opacity *= 0.9);
        let (wrong, _) = compared(&drawn(&scene, &wrong, size, &settings), &expected);
        println!("{}: {wrong:.4} differ if opacities are wrong", scene.name);
        assert!(
            wrong > differing + NOTICED,
            "{}: {differing} of the pixels differ, and {wrong} with wrong opacities",
            scene.name
        );
    }
}

#[test]
fn surfaces_cost_no_fidelity() {
    let size = viewport(36, 32);
    for scene in scenes(Data::BuiltIn, size) {
        let settings = Settings::default();
        let integral = |surfaces| {
            let mut integral = Integral::new(&scene.volume, &scene.transfer, None)
                .with_gradient(kernel_of(&settings), settings.gradient_estimator())
                .with_surfaces(surfaces);
            integral.shading = settings.shading;
            integral.render(&scene.camera, size).unwrap()
        };
        let (_, alone) = compared(&drawn(&scene, &[], size, &settings), &integral(&[]));
        let (_, both) = compared(&drawn(&scene, &scene.surfaces, size, &settings), &integral(&scene.surfaces));
        println!("{}: {both:.1} dB with surfaces, {alone:.1} without", scene.name);
        assert!(both > alone - LOST, "{}: {both} dB with surfaces, {alone} without", scene.name);
    }
}
