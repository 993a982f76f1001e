//! Surfaces in volumes.

use crate::common::surfaces::{Data, Scene, iso_surface, scenes};
use crate::common::*;
use glam::DVec3;
use layersplat::layers::Kernel;
use layersplat::reference::Marched;
use layersplat::settings::Algorithm;
use layersplat::volume::Voxels;

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
