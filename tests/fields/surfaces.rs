//! Surfaces in colours, labels and several fields: a translucent plane lies over the part behind it and under the part before it, and clip
//! planes draw both parts without it.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::Density;
use layersplat::renderer::{Channel, ColorOpacity, LabelColors, UploadedColors, UploadedVolume};
use layersplat::settings::{ClipPlane, Clipping, Evaluation, Layered};
use layersplat::surface::{Surface, SurfaceShading, Triangles};
use layersplat::volume::LabelSurfaces;
use layersplat::{Frame, Renderer, Settings, Viewport, Volume};

/// Pixels smaller than voxels, so that the lattice samples them, as it does with surfaces.
const SIZE: Viewport = Viewport { width: 64, height: 56 };
const MIDDLE: DVec3 = DVec3::splat(3.5);
const NORMAL: DVec3 = DVec3::new(0.3, -0.2, 1.0);
const COLOR: [f32; 3] = [0.9, 0.3, 0.1];
const OPACITY: f32 = 0.4;
/// Colours of fragments have half precision.
const TOLERANCE: f32 = 5e-4;
const ENTRIES: [[f64; 4]; 3] = [[0.0; 4], [1.0, 0.2, 0.0, 0.4], [0.1, 0.5, 1.0, 0.7]];

/// A square on the plane, or off it by some voxels, larger than the picture.
fn plane(off: f64) -> Surface {
    let along = NORMAL.normalize().any_orthonormal_vector();
    let across = NORMAL.normalize().cross(along);
    let corner = |x: f64, y: f64| MIDDLE + off * NORMAL + 40.0 * (x * along + y * across);
    let points = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mut surface = Surface::new("plane", Triangles::new(points, vec![[0, 1, 2], [0, 2, 3]]).unwrap());
    (surface.color, surface.opacity, surface.shading) = (COLOR, OPACITY, SurfaceShading::Off);
    surface
}

fn values() -> Volume<'static> {
    random_volume([8; 3], DVec3::ONE, 5)
}

fn uploaded() -> UploadedVolume {
    UploadedVolume::new(&device(), &values()).unwrap()
}

/// Blocks of labels 0, 1 and 2.
fn ids() -> Volume<'static> {
    let id = |n: usize| ((n / 3 + n / 64 + n / 256) % 3) as u8;
    Volume::new("ids", values().grid().clone(), (0..512).map(id).collect::<Vec<u8>>()).unwrap()
}

fn colors() -> UploadedColors {
    let component = |seed| UploadedVolume::new(&device(), &random_volume([8; 3], DVec3::ONE, seed)).unwrap();
    UploadedColors::from_components(&[1, 2, 3, 4].map(component), ColorOpacity::Alpha, &smooth_transfer()).unwrap()
}

fn labels(surfaces: LabelSurfaces) -> UploadedColors {
    UploadedColors::from_labels(&[(&UploadedVolume::new(&device(), &ids()).unwrap(), &ENTRIES)], surfaces).unwrap()
}

/// The largest difference of a picture with a surface from the parts before and behind the plane with the surface between.
fn difference(renderer: &mut Renderer, surface: Surface, shaded: bool) -> f32 {
    let camera = parallel(&values(), SIZE, 20.0, 10.0);
    let layered = Layered { evaluation: Evaluation::Lattice(Density::Screen), ..Layered::default() };
    let shading = Settings::default().shading.filter(|_| shaded);
    let settings = Settings { shading, early_termination: false, ..layered.into() };
    let part = |renderer: &mut Renderer, normal: DVec3| {
        let clipping = Clipping::default().with_planes([ClipPlane { point: MIDDLE, normal }]);
        renderer.render(&camera, SIZE, &Settings { clipping, ..settings }).unwrap().0
    };
    // The eye looks along −z.
    let [front, back]: [Frame; 2] = [part(renderer, NORMAL), part(renderer, -NORMAL)];
    renderer.set_surfaces(&[surface]).unwrap();
    let whole = renderer.render(&camera, SIZE, &settings).unwrap().0;
    renderer.set_surfaces(&[]).unwrap();
    assert!(largest_opacity(&front) > 0.3 && largest_opacity(&back) > 0.3);
    let pairs = front.pixels().iter().zip(back.pixels()).zip(whole.pixels());
    let largest = pairs.map(|((front, back), whole)| {
        let fragment = |c: usize| OPACITY * if c < 3 { COLOR[c] } else { 1.0 };
        let expected = |c: usize| front[c] + (1.0 - front[3]) * (fragment(c) + (1.0 - OPACITY) * back[c]);
        (0..4).map(|c| (expected(c) - whole[c]).abs()).fold(0.0, f32::max)
    });
    largest.fold(0.0, f32::max)
}

#[test]
fn a_plane_lies_between_the_parts_of_any_field() {
    let transfer = smooth_transfer();
    let channel = || Channel::new(&uploaded(), &transfer);
    let of_colors = |colors: &UploadedColors| Renderer::from_colors(colors).unwrap();
    let mut of_label_colors = Renderer::from_uploaded(&uploaded(), &transfer).unwrap();
    let label_colors = LabelColors::new(of_label_colors.device(), &[(&ids(), &ENTRIES)]).unwrap();
    of_label_colors.set_label_colors(Some(&label_colors)).unwrap();
    let mixed = [channel(), Channel::from_colors(&labels(LabelSurfaces::Smooth)).unwrap()];
    for (name, mut renderer) in [
        ("one field", Renderer::from_uploaded(&uploaded(), &transfer).unwrap()),
        ("two fields", Renderer::from_channels(&[channel(), channel()]).unwrap()),
        ("colours", of_colors(&colors())),
        ("labels", of_colors(&labels(LabelSurfaces::Smooth))),
        ("labels as voxels", of_colors(&labels(LabelSurfaces::Voxels))),
        ("a field in the colours of labels", of_label_colors),
        ("a field and labels", Renderer::from_channels(&mixed).unwrap()),
    ] {
        for shaded in [false, true] {
            let found = difference(&mut renderer, plane(0.0), shaded);
            assert!(found < TOLERANCE, "{name}, shading {shaded}: {found}");
            let off = difference(&mut renderer, plane(0.05), shaded);
            assert!(off > 2.0 * TOLERANCE, "{name}, shading {shaded}: {off}, a twentieth of a voxel off");
        }
    }
}
