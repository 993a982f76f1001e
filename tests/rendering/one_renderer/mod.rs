//! A reused renderer: each frame is bit-identical to that of a fresh one. Cached data must be keyed by everything they depend on.

mod scene;

use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::renderer::{FrameReport, LatticePicture, Measured};
use layersplat::settings::{Blend, Classification, LayerAxis, Layered};
use layersplat::volume::{Rescale, Voxels};
use layersplat::{Axis, Background, Error, Frame, Renderer, Settings, TransferFunction, Volume};
use scene::{ALGORITHMS, OTHER, Scene, TABLES};

/// A reused renderer and its state.
struct Kept {
    volume: Volume<'static>,
    transfers: [TransferFunction; 3],
    renderer: Renderer,
    random: Random,
    drawn: usize,
    seen: usize,
    refused: usize,
}

impl Kept {
    fn new(volume: Volume<'static>, seed: u64) -> Self {
        let smooth = smooth_transfer();
        let transfers = [deep(), smooth.faded(0.4).unwrap(), smooth];
        let renderer = Renderer::new(&device(), &volume, &transfers[0]).unwrap();
        Self { volume, transfers, renderer, random: Random(seed), drawn: 0, seen: 0, refused: 0 }
    }

    /// Renders a scene with the reused renderer and with a fresh one.
    fn step(&mut self, scene: &Scene) {
        let transfer = &self.transfers[scene.transfer];
        let (camera, size, settings) = (scene.camera(&self.volume), scene.size, &scene.settings);
        let mut fresh = Renderer::new(&device(), &self.volume, transfer).unwrap();
        self.renderer.set_transfer_function(transfer);
        let measuring = [self.random.next().is_multiple_of(2), self.random.next().is_multiple_of(2)];
        self.renderer.measure(measuring[0]);
        fresh.measure(measuring[1]);
        let expected = fresh.render(&camera, size, settings);
        // One frame in four uses another output path.
        let way = self.random.next() % 8;
        if let Ok((frame, _)) = &expected {
            self.drawn += 1;
            self.seen += usize::from(largest_opacity(frame) > 0.02);
        }
        let what = || format!("frame {}, {scene:?}", self.drawn);
        match (way, expected) {
            (0, Ok((frame, report))) => {
                let background = Background::Color([0.2, 0.5, 0.9]);
                let (bytes, told) = self.renderer.render_rgba8(&camera, size, settings, background).expect("as the fresh one");
                assert!(bytes == frame.to_rgba8(background), "{}: the 8-bit picture differs", what());
                same_reports(&what(), &told, &report);
            }
            (1, Ok(_)) => {
                let kept = self.renderer.lattice_picture(&camera, size, settings).expect("as the fresh one");
                let expected = fresh.lattice_picture(&camera, size, settings).unwrap();
                let samples = |picture: Option<LatticePicture>| picture.map(|p| (p.size, p.samples));
                assert!(samples(kept) == samples(expected), "{}: the lattice differs", what());
            }
            (_, Ok((frame, report))) => {
                let (found, told) = self.renderer.render(&camera, size, settings).expect("as the fresh one");
                assert!(found == frame, "{}: off by {}", what(), compare(&found, &frame).max_difference);
                same_reports(&what(), &told, &report);
            }
            (_, Err(expected)) => {
                let refused: Error = self.renderer.render(&camera, size, settings).expect_err(&what());
                assert_eq!(refused.to_string(), expected.to_string());
                self.refused += 1;
            }
        }
    }
}

/// Times differ; counts must agree if both are measured.
#[track_caller]
fn same_reports(what: &str, a: &FrameReport, b: &FrameReport) {
    assert_eq!(a.lattice, b.lattice, "{what}");
    if let (Some(a), Some(b)) = (&a.measured, &b.measured) {
        assert_eq!(a.active_samples, b.active_samples, "{what}: samples");
        let stages = |measured: &Measured| -> Vec<&str> { measured.stages.iter().map(|&(stage, _)| stage).collect() };
        // A fresh renderer has more preparation stages, and `present` converts to 8 bits. Stages of earlier frames must not remain.
        let stray: Vec<&str> = stages(a).into_iter().filter(|stage| *stage != "present" && !stages(b).contains(stage)).collect();
        assert!(stray.is_empty(), "{what}: {stray:?}, not in {:?}", stages(b));
    }
}

/// Opaque from 200 on, in several hues: the tables of segments then depend on their length.
fn deep() -> TransferFunction {
    let colors = vec![(0.0, [0.9, 0.1, 0.2]), (128.0, [0.1, 0.9, 0.2]), (255.0, [0.2, 0.1, 0.9])];
    TransferFunction::new("deep", colors, vec![(0.0, 0.0), (60.0, 0.0), (100.0, 0.1), (200.0, 1.0)]).unwrap()
}

/// Isolated drops in empty space, so that most blocks are culled.
fn drops_volume() -> Volume<'static> {
    let dims = [24, 21, 23];
    let mut random = Random(13);
    let drops: [DVec3; 9] = std::array::from_fn(|_| DVec3::from_array(dims.map(|n| n as f64 * random.unit())));
    let value = |n: usize| {
        let place = DVec3::new((n % dims[0]) as f64, (n / dims[0] % dims[1]) as f64, (n / dims[0] / dims[1]) as f64);
        let nearest = drops.iter().map(|drop| drop.distance(place)).fold(f64::INFINITY, f64::min);
        (255.0 * (1.3 - nearest / 2.5)).clamp(0.0, 255.0) as u8
    };
    volume(dims, DVec3::new(1.0, 1.2, 0.9), Voxels::Uint8((0..dims.iter().product()).map(value).collect()))
}

fn bytes_volume() -> Volume<'static> {
    random_volume([17, 14, 12], DVec3::new(1.0, 1.3, 0.8), 11)
}

/// Stored with a negative slope, so that larger values are smaller numbers, and far from 0.
fn reversed_volume() -> Volume<'static> {
    let numbers = random_bytes([13, 16, 11], 12).into_iter().map(|b| 3000 - 4 * i16::from(b)).collect();
    let volume = volume([13, 16, 11], DVec3::new(0.9, 0.7, 1.2), Voxels::Int16(numbers));
    volume.with_rescale(Rescale::new(-0.25, 750.0).unwrap()).with_background(0.0).unwrap()
}

/// Most frames must not be empty; some look past the volume.
fn shown(kept: &Kept, least: usize) {
    let Kept { drawn, seen, .. } = kept;
    assert!(*seen >= least && *seen * 2 > *drawn, "{seen} of {drawn} frames are not empty");
}

/// Each algorithm, followed by a change of each input of its tables.
#[test]
fn each_change_counts_in_each_algorithm() {
    let mut kept = Kept::new(drops_volume(), 21);
    let mut random = Random(22);
    // The footprint set does not depend on any of these inputs.
    let [algorithms @ .., _] = ALGORITHMS;
    for algorithm in algorithms {
        let mut scene = Scene { settings: algorithm.into(), ..Scene::default() };
        for change in TABLES {
            let before = scene;
            change(&mut scene, &mut random);
            let refused = kept.refused;
            kept.step(&scene);
            if kept.refused > refused {
                scene = before;
            }
        }
    }
    shown(&kept, ALGORITHMS.len() * TABLES.len() * 3 / 4);
}

/// Each algorithm after each other one, for the same scene.
#[test]
fn each_algorithm_after_each_other() {
    let volume = drops_volume();
    let transfer = deep();
    let scene = Scene::default();
    let draw =
        |renderer: &mut Renderer, settings: &Settings| renderer.render(&scene.camera(&volume), scene.size, settings).unwrap().0;
    let all: Vec<Settings> = ALGORITHMS.map(Settings::from).into();
    let fresh = || Renderer::new(&device(), &volume, &transfer).unwrap();
    let expected: Vec<Frame> = all.iter().map(|settings| draw(&mut fresh(), settings)).collect();
    // In both orders, so that each follows each other one.
    for backwards in [false, true] {
        let mut kept = fresh();
        for n in 0..all.len() {
            let n = if backwards { all.len() - 1 - n } else { n };
            assert!(draw(&mut kept, &all[n]) == expected[n], "{:?}, backwards: {backwards}", all[n].algorithm);
        }
    }
}

/// Segments of equal length, once a whole layer and once half of one: attenuation within a segment is decided per layer.
#[test]
fn segments_of_one_length_from_layers_of_two() {
    let mut kept = Kept::new(bytes_volume(), 61);
    let per_layer = |samples_per_layer, unit_distance| {
        let own = layered(Settings::default());
        let classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer };
        let settings = Layered { classification, ..own }.into();
        Scene { settings: Settings { unit_distance: Some(unit_distance), ..settings }, transfer: 2, ..Scene::default() }
    };
    // Two lengths that are not a factor of two apart, from thin to deep.
    for n in 0..8 {
        let unit = 1.2 / 1.7f64.powi(n);
        kept.step(&per_layer(1, unit));
        kept.step(&per_layer(2, unit / 2.0));
    }
    shown(&kept, 12);
}

/// Several changes at once, in any order.
fn walk(volume: Volume<'static>, seed: u64) {
    let mut kept = Kept::new(volume, seed);
    let mut random = Random(seed + 1);
    let mut scene = Scene::default();
    for _ in 0..60 {
        let before = scene;
        for _ in 0..1 + random.next() % 4 {
            if random.next().is_multiple_of(4) {
                scene.settings.algorithm = ALGORITHMS[random.next() as usize % ALGORITHMS.len()];
            }
            let changes = [&TABLES[..], &OTHER].concat();
            changes[random.next() as usize % changes.len()](&mut scene, &mut random);
        }
        let refused = kept.refused;
        kept.step(&scene);
        if kept.refused > refused {
            scene = before;
        }
    }
    shown(&kept, 30);
}

#[test]
fn a_walk_through_bytes() {
    walk(bytes_volume(), 31);
}

#[test]
fn a_walk_through_drops() {
    walk(drops_volume(), 71);
}

#[test]
fn a_walk_through_rescaled_numbers() {
    walk(reversed_volume(), 41);
}

/// Each kind of error between two frames.
#[test]
fn what_is_refused_leaves_nothing_behind() {
    let mut kept = Kept::new(bytes_volume(), 51);
    let default = Settings::default();
    let axis = LayerAxis::Forced(Axis::X);
    let refusals = [
        Settings { unit_distance: Some(0.0), ..default },
        Settings { blend: Blend::Iso(f64::NAN), ..default },
        Settings { blend: Blend::Maximum, algorithm: ALGORITHMS[5], ..default },
        // Detected when the view is planned.
        Settings::from(Layered { layer_axis: axis, ..layered(default) }),
        Settings::from(layersplat::settings::Algorithm::AxisSheets { layer_axis: axis }),
    ];
    // A third of them, of each kind, because errors are independent of the algorithm.
    for algorithm in ALGORITHMS.into_iter().step_by(3) {
        let scene = Scene { settings: algorithm.into(), ..Scene::default() };
        kept.step(&scene);
        for settings in refusals {
            // Along z, where the x axis is out of reach.
            let refused = kept.refused;
            kept.step(&Scene { settings, transfer: 1, orbit: [0.0, 3.0, 0.0], ..scene });
            assert_eq!(kept.refused, refused + 1, "{settings:?} is not refused");
        }
        kept.step(&scene);
    }
}
