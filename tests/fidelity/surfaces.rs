//! Surfaces in volumes.

use crate::common::surfaces::{Data, Scene, iso_surface, scenes};
use crate::common::*;
use glam::{DVec3, DVec4};
use layersplat::layers::{Kernel, Rays};
use layersplat::reference::{Integral, Marched};
use layersplat::renderer::Accumulation;
use layersplat::settings::Algorithm;
use layersplat::surface::Surface;
use layersplat::volume::Voxels;
use layersplat::{Frame, Renderer, Settings, Viewport};
use std::ops::Range;

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

/// The converged integral of a scene with these surfaces.
fn integral_of<'a>(scene: &'a Scene, surfaces: &'a [Surface], settings: &Settings) -> Integral<'a> {
    let mut integral = Integral::new(&scene.volume, &scene.transfer, None)
        .with_gradient(kernel_of(settings), settings.gradient_estimator())
        .with_surfaces(surfaces);
    integral.shading = settings.shading;
    integral
}

#[test]
fn surfaces_cost_no_fidelity() {
    let size = viewport(36, 32);
    for scene in scenes(Data::BuiltIn, size) {
        let settings = Settings::default();
        let integral = |surfaces| integral_of(&scene, surfaces, &settings).render(&scene.camera, size).unwrap();
        let (_, alone) = compared(&drawn(&scene, &[], size, &settings), &integral(&[]));
        let (_, both) = compared(&drawn(&scene, &scene.surfaces, size, &settings), &integral(&scene.surfaces));
        println!("{}: {both:.1} dB with surfaces, {alone:.1} without", scene.name);
        assert!(both > alone - LOST, "{}: {both} dB with surfaces, {alone} without", scene.name);
    }
}

/// Share of pixels at silhouettes in large pictures, and dB of these with 4 × 4 samples.
const FEW_SILHOUETTES: f64 = 0.03;
const SAMPLED: f64 = 40.0;

/// dB of colours, and of opacities.
fn decibels(pairs: &[([f32; 4], [f64; 4])]) -> [f64; 2] {
    let mean = |of: Range<usize>| {
        let squares = pairs.iter().flat_map(|(p, q)| of.clone().map(|c| (f64::from(p[c]) - q[c]).powi(2)));
        squares.sum::<f64>() / (of.len() * pairs.len()) as f64
    };
    [mean(0..3), mean(3..4)].map(|mean| -10.0 * mean.max(1e-20).log10())
}

/// Data sets, lit, with as many pixels to a side as LAYERSPLAT_SIDE says.
#[test]
#[ignore = "LAYERSPLAT_SIDE=512 cargo test --release --test fidelity real_scenes -- --ignored --nocapture"]
fn real_scenes_cost_no_fidelity() {
    let side = std::env::var("LAYERSPLAT_SIDE").map_or(128, |side| side.parse().expect("a number of pixels"));
    let size = viewport(side, side);
    let mut missed = Vec::new();
    for scene in scenes(Data::Real, size) {
        let settings = Settings::default();
        let integral = |surfaces| integral_of(&scene, surfaces, &settings);
        let [alone, both] = [&[][..], &scene.surfaces].map(|surfaces| {
            let expected = integral(surfaces).render(&scene.camera, size).unwrap();
            let found = drawn(&scene, surfaces, size, &settings);
            let widen = |pixel: &[f32; 4]| pixel.map(f64::from);
            found.pixels().iter().zip(expected.pixels()).map(|(p, q)| (*p, widen(q))).collect::<Vec<_>>()
        });
        let off = |n: &usize| (0..4).map(|c| (f64::from(both[*n].0[c]) - both[*n].1[c]).abs()).fold(0.0, f64::max);
        let mut order: Vec<usize> = (0..both.len()).collect();
        order.sort_by(|n, m| off(n).total_cmp(&off(m)));
        let differing = order.iter().filter(|n| off(n) > ROUNDED_COLORS).count() as f64 / order.len() as f64;
        let (kept, exempt) = order.split_at(((1.0 - FEW_SILHOUETTES) * order.len() as f64) as usize);
        let of = |all: &[([f32; 4], [f64; 4])], which: &[usize]| decibels(&which.iter().map(|&n| all[n]).collect::<Vec<_>>());
        // The pixels that are exempt, with 4 × 4 samples.
        let mut renderer = Renderer::new(&device(), &scene.volume, &scene.transfer).unwrap();
        renderer.set_surfaces(&scene.surfaces).unwrap();
        let mut accumulation = Accumulation::new(size).unwrap();
        (0..Accumulation::FRAMES).for_each(|_| _ = renderer.accumulate(&scene.camera, &settings, &mut accumulation).unwrap());
        let (sampled, rays) = (accumulation.mean().unwrap(), Rays::new(&scene.camera, size, scene.volume.grid()).unwrap());
        let truth = integral(&scene.surfaces);
        let pairs: Vec<_> = exempt
            .iter()
            .map(|&n| {
                let (x, y) = (n as u32 % side, n as u32 / side);
                let at = |first: u32, part: u32| f64::from(first) + (f64::from(part) + 0.5) / 4.0;
                let ray = |n: u32| rays.at(at(x, n % 4), at(y, n / 4));
                let parts = (0..16).map(|n| DVec4::from_array(truth.composite(&ray(n), rays.to_eye)));
                (sampled.pixel(x, y), (parts.sum::<DVec4>() / 16.0).to_array())
            })
            .collect();
        let ([color, alpha], [all_color, _]) = (of(&both, kept), of(&both, &order));
        let [color_alone, alpha_alone] = of(&alone, kept);
        let [color_sampled, alpha_sampled] = decibels(&pairs);
        println!(
            "{}, {side}: {color:.1} dB, opacity {alpha:.1}, without surfaces {color_alone:.1} and {alpha_alone:.1}; all pixels {all_color:.1}, \
             {differing:.4} of them differ; exempt ones with 4 x 4 samples {color_sampled:.1}, {alpha_sampled:.1}",
            scene.name
        );
        let reached = color > color_alone - LOST && alpha > alpha_alone - LOST && color_sampled.min(alpha_sampled) > SAMPLED;
        missed.extend((!reached).then_some(scene.name));
    }
    assert!(missed.is_empty(), "{missed:?}");
}
