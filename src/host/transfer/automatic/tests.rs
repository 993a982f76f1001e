use super::*;
use crate::volume::{Grid, Voxels};
use glam::DVec3;

fn automatic(values: Vec<f32>) -> TransferFunction {
    let grid = Grid::new([values.len(), 1, 1], DVec3::ONE).unwrap();
    TransferFunction::automatic(&Volume::new("t", grid, Voxels::Float32(values)).unwrap())
}

#[test]
fn something_is_visible_and_not_everything() {
    let ramp = automatic((0..1000).map(|i| i as f32).collect());
    assert!(ramp.opacity(100.0) == 0.0 && ramp.opacity(999.0) > 0.0);
    let mask = automatic((0..1000).map(|i| if i % 2 == 0 { 0.0 } else { 1.0 }).collect());
    assert!(mask.opacity(0.0) == 0.0 && mask.opacity(1.0) > 0.0 && mask.opacity(1.0) < 1.0);
    let outlier = automatic((0..1000).map(|i| if i == 7 { 1e6 } else { 0.0 }).collect());
    assert!(outlier.opacity(0.0) == 0.0 && outlier.opacity(1e6) > 0.0);
    let negative = automatic((0..1000).map(|i| -1000.0 + i as f32).collect());
    assert!(negative.opacity(-1000.0) == 0.0 && negative.opacity(-1.0) > 0.0);
}

#[test]
fn constant_volumes_have_one_too() {
    for value in [0.0, 5.0, -5.0] {
        assert!(automatic(vec![value; 8]).opacity(value.into()).is_finite());
    }
    assert!(automatic(vec![5.0; 8]).opacity(5.0) > 0.0);
}

/// Nested balls: noisy air, then a soft, a hard and a very hard material.
#[test]
fn materials_have_colours_of_their_own_and_noise_none() {
    let n = 48;
    let value = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - 23.5;
        let noise = ((i * 7919) % 13) as f64;
        noise + [(8.0, 900.0), (14.0, 600.0), (20.0, 300.0)].iter().find(|b| p.length() < b.0).map_or(0.0, |b| b.1)
    };
    let grid = Grid::new([n; 3], DVec3::ONE).unwrap();
    let values = (0..n * n * n).map(|i| value(i) as f32).collect();
    let transfer = TransferFunction::automatic(&Volume::new("balls", grid, Voxels::Float32(values)).unwrap());
    assert_eq!(transfer.opacity(12.0), 0.0, "noise must be transparent");
    let materials = [306.0, 606.0, 906.0];
    let opacities = materials.map(|v| transfer.opacity(v));
    assert!(opacities[0] > 0.0 && opacities[0] < opacities[1] && opacities[1] < opacities[2], "{opacities:?}");
    let colors = materials.map(|v| transfer.color(v));
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let difference = (0..3).map(|c| (colors[a][c] - colors[b][c]).abs()).fold(0.0, f64::max);
        assert!(difference > 0.25, "{colors:?}");
    }
}

/// Nested balls of 48³ voxels around air: values from the outermost to the innermost, edges two voxels wide, and noise of a standard
/// deviation.
fn balls(values: &[f64], noise: f64) -> Volume<'static> {
    let n = 48;
    let mut state = 1_u64;
    // Sum of uniform numbers: nearly Gaussian.
    let mut random = move || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    };
    let value = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - 23.5;
        let mut before = 0.0;
        let mut value = 0.0;
        for (shell, &own) in values.iter().enumerate() {
            let radius = 21.0 - 4.0 * shell as f64;
            value += (own - before) * ((radius - p.length()) / 2.0 + 0.5).clamp(0.0, 1.0);
            before = own;
        }
        value
    };
    let grid = Grid::new([n; 3], DVec3::ONE).unwrap();
    let voxels = (0..n * n * n).map(|i| (value(i) + noise * random()) as f32).collect();
    Volume::new("balls", grid, Voxels::Float32(voxels)).unwrap()
}

fn found(volume: &Volume) -> classes::Classes {
    let survey = Survey::new(&volume.statistics(), volume);
    classes::classes(&survey, &modes::modes(&survey))
}

/// Four standard deviations of noise around a value.
fn around(value: f64, noise: f64) -> impl Iterator<Item = f64> {
    (-4..=4).map(move |n| value + f64::from(n) * noise)
}

#[test]
fn as_many_materials_as_there_are_and_no_noise() {
    for values in [&[800.0][..], &[300.0, 900.0], &[300.0, 600.0, 900.0], &[250.0, 500.0, 750.0, 1000.0]] {
        for noise in [0.0, 5.0, 20.0] {
            let volume = balls(values, noise);
            let classes = found(&volume);
            assert_eq!((classes.classes.len(), classes.are_shells), (values.len(), false), "{values:?} ± {noise}: {classes:?}");
            let transfer = TransferFunction::automatic(&volume);
            for air in around(0.0, noise) {
                assert_eq!(transfer.opacity(air), 0.0, "{values:?} ± {noise}: air at {air}");
            }
            // Each material has one colour, noise included, and boundaries lie between materials.
            for (n, &value) in values.iter().enumerate() {
                let (from, to) = classes.classes[n].colored;
                assert!(from < value && value <= to, "{values:?} ± {noise}: {value} in {from} to {to}");
                assert!(transfer.opacity(value) > 0.0);
                for other in &values[..n] {
                    let apart = (0..3).map(|c| (transfer.color(value)[c] - transfer.color(*other)[c]).abs()).fold(0.0, f64::max);
                    assert!(apart > 0.2, "{value} and {other} look alike");
                }
            }
        }
    }
}

#[test]
fn boundaries_lie_half_way_between_materials() {
    // The tolerance is a tenth of the difference: ramps of opacity are wider.
    let classes = found(&balls(&[300.0, 900.0], 10.0)).classes;
    let [outer, inner] = [0, 1].map(|n| (classes[n].solid[0].0 + classes[n].solid[1].0) / 2.0);
    assert!((outer - 150.0).abs() < 30.0 && (inner - 600.0).abs() < 60.0, "{outer} and {inner}");
}

/// Light that passes a path through a material.
fn through(transfer: &TransferFunction, value: f64, distance: f64) -> f64 {
    (-transfer.extinction(value) * distance).exp()
}

#[test]
fn shells_do_not_hide_what_is_inside() {
    let transfer = TransferFunction::automatic(&balls(&[300.0, 600.0, 900.0], 5.0));
    // The interiors of both shells, 4 voxels thick each; the innermost ball is 26 voxels thick.
    assert!(through(&transfer, 300.0, 4.0) * through(&transfer, 600.0, 4.0) > 0.5);
    assert!(through(&transfer, 900.0, 26.0) < 0.05);
    // Two balls that are side by side from all three directions hide nothing, so both are solid.
    let n = 60;
    let value = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64);
        let inside = |x: f64, y: f64| p.distance(DVec3::new(x, y, 30.0)) < 11.0;
        if inside(13.0, 47.0) { 100 } else { u8::from(inside(47.0, 13.0)) * 200 }
    };
    let voxels: Vec<u8> = (0..n * n * n).map(value).collect();
    let transfer = TransferFunction::automatic(&Volume::new("two", Grid::new([n; 3], DVec3::ONE).unwrap(), voxels).unwrap());
    assert!(through(&transfer, 100.0, 20.0) < 0.1 && through(&transfer, 200.0, 20.0) < 0.1, "{transfer:?}");
}

#[test]
fn fields_without_materials_become_nested_shells() {
    let open = |name: &str| Volume::open(name, &crate::OpenOptions::default()).unwrap();
    let classes = found(&open("builtin:hydrogen@48"));
    assert!(classes.are_shells && classes.classes.len() == 3, "{classes:?}");
    assert!(classes.classes.windows(2).all(|pair| pair[0].core.0 < pair[1].core.0));
}

#[test]
fn pure_noise_has_a_function_too() {
    let grid = Grid::new([32; 3], DVec3::ONE).unwrap();
    let voxels: Vec<u8> = (0..32_usize.pow(3)).map(|n| ((n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8).collect();
    let transfer = TransferFunction::automatic(&Volume::new("noise", grid, voxels).unwrap());
    assert!(transfer.opacity(0.0) == 0.0 && transfer.opacity(255.0) > 0.0);
}

#[test]
fn masks_and_labels_are_materials() {
    let n = 32;
    let label = |i: usize, labels: &[u8]| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - 15.5;
        labels.iter().rev().enumerate().find(|(k, _)| p.length() < 5.0 + 4.0 * *k as f64).map_or(0, |(_, &label)| label)
    };
    for labels in [&[1][..], &[255], &[1, 2], &[1, 2, 3]] {
        let grid = Grid::new([n; 3], DVec3::ONE).unwrap();
        let voxels: Vec<u8> = (0..n * n * n).map(|i| label(i, labels)).collect();
        let volume = Volume::new("labels", grid, voxels).unwrap();
        assert_eq!(found(&volume).classes.len(), labels.len(), "{labels:?}");
        let transfer = TransferFunction::automatic(&volume);
        assert_eq!(transfer.opacity(0.0), 0.0);
        assert!(labels.iter().all(|&label| transfer.opacity(label.into()) > 0.0), "{labels:?}: {transfer:?}");
    }
}

#[test]
fn the_unit_of_values_does_not_matter() {
    let plain = balls(&[300.0, 900.0], 10.0);
    let expected = TransferFunction::automatic(&plain);
    for factor in [1e-20, 1e-6, 1e20] {
        let scaled = (0..plain.grid().voxel_count()).map(|i| (plain.value(i) * factor) as f32).collect();
        let volume = Volume::new("scaled", plain.grid().clone(), Voxels::Float32(scaled)).unwrap();
        let transfer = TransferFunction::automatic(&volume);
        for value in [0.0, 150.0, 300.0, 600.0, 900.0] {
            // Values that rounding moves to another bin move a boundary a little.
            assert!((transfer.opacity(value * factor) - expected.opacity(value)).abs() < 0.01, "{factor}: {value}");
        }
    }
    // A few outliers do not hide the rest either.
    let mut values: Vec<f32> = (0..plain.grid().voxel_count()).map(|i| plain.value(i) as f32).collect();
    (values[77], values[5000]) = (1e7, 3e6);
    let volume = Volume::new("outliers", plain.grid().clone(), Voxels::Float32(values)).unwrap();
    assert_eq!(found(&volume).classes.len(), 2);
}

#[test]
fn dark_objects_on_bright_ground_are_shown() {
    let plain = balls(&[300.0, 900.0], 10.0);
    let voxels = (0..plain.grid().voxel_count()).map(|i| 1000.0 - plain.value(i) as f32).collect();
    let transfer = TransferFunction::automatic(&Volume::new("negative", plain.grid().clone(), Voxels::Float32(voxels)).unwrap());
    assert!(around(1000.0, 10.0).all(|air| transfer.opacity(air) == 0.0));
    assert!(transfer.opacity(100.0) > 0.1 && transfer.opacity(700.0) > 0.0, "{transfer:?}");
    assert_ne!(transfer.color(100.0), transfer.color(700.0));
}

/// A head: air, skin and brain, skull.
fn head(air: i16, tissue: i16, bone: i16) -> Volume<'static> {
    let n = 48;
    let value = |i: usize| {
        let p = DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) - 23.5;
        match p.length() {
            r if r < 14.0 => tissue,
            r if r < 18.0 => bone,
            r if r < 21.0 => tissue,
            _ => air + (i % 7) as i16,
        }
    };
    Volume::new("head", Grid::new([n; 3], DVec3::ONE).unwrap(), (0..n * n * n).map(value).collect::<Vec<i16>>()).unwrap()
}

#[test]
fn hounsfield_units_are_recognised() {
    let is_ct = |volume: &Volume| hounsfield::is_ct(&volume.statistics(), volume);
    let ct = head(-1000, 40, 900);
    assert!(is_ct(&ct) && is_ct(&head(-1024, 0, 1500)));
    assert!(!is_ct(&head(0, 1040, 1900)) && !is_ct(&head(-1000, 500, 900)) && !is_ct(&head(-500, 40, 900)));
    let stored = head(24, 1064, 1924).with_rescale(crate::volume::Rescale::new(1.0, -1024.0).unwrap());
    assert!(is_ct(&stored));
    let transfer = TransferFunction::automatic(&ct);
    // Fixed tissues: skin in front of bone, which is solid; air and foam are transparent.
    assert!([-1000.0, -800.0, -500.0].iter().all(|&air| transfer.opacity(air) == 0.0));
    assert!(transfer.opacity(-260.0) > 0.0 && through(&transfer, 40.0, 3.0) > 0.4 && through(&transfer, 900.0, 4.0) < 0.3);
    assert_eq!(TransferFunction::automatic(&stored).colors().len(), transfer.colors().len());
}

#[test]
fn surveys_are_the_same_twice() {
    let volume = balls(&[300.0, 900.0], 10.0);
    assert_eq!(TransferFunction::automatic(&volume), TransferFunction::automatic(&volume));
}
