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
