//! Possible scenes, and their changes.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Density, Kernel};
use layersplat::settings::{
    Algorithm, Blend, Classification, ClipPlane, Clipping, CropBox, DepthCue, Evaluation, Footprints, GradientOpacity, LayerAxis,
    Layered, Light, Lights, Shading,
};
use layersplat::transfer::Extinction;
use layersplat::{Axis, Camera, Correction, Orbit, Projection, Settings, Viewport, Volume};

/// All inputs of a picture except the volume.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub settings: Settings,
    /// Index of the transfer function.
    pub transfer: usize,
    /// Azimuth, elevation and roll in degrees.
    pub orbit: [f64; 3],
    pub eye: Eye,
    pub size: Viewport,
}

/// Projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// Parallel, with a magnification relative to the fitted view.
    Parallel(f64),
    /// Field of view in degrees, and distance from the centre in diagonals.
    Perspective(f64, f64),
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            transfer: 0,
            orbit: [20.0, 10.0, 0.0],
            eye: Eye::Parallel(1.0),
            size: viewport(32, 24),
        }
    }
}

impl Scene {
    pub fn camera(&self, volume: &Volume) -> Camera {
        let (centre, diagonal) = (volume.grid().centre(), volume.grid().diagonal());
        let [azimuth, elevation, roll] = self.orbit;
        let (distance, projection) = match self.eye {
            Eye::Parallel(zoom) => (diagonal, Projection::Parallel { scale: diagonal / 2.0 / zoom }),
            Eye::Perspective(field_of_view, distance) => (diagonal * distance, Projection::Perspective { field_of_view }),
        };
        Camera::orbit(centre, distance, Orbit { azimuth, elevation, roll }, projection)
    }
}

const fn points(density: Density, samples_per_layer: u32) -> Algorithm {
    made(
        Evaluation::Lattice(density),
        Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer },
        Footprints::Exact,
    )
}

const fn made(evaluation: Evaluation, classification: Classification, footprints: Footprints) -> Algorithm {
    Algorithm::Layered(Layered { layer_axis: LayerAxis::Auto, evaluation, classification, footprints, adapts_to_opacity: true })
}

/// All algorithms. A fresh renderer takes half a second to prepare the footprint set of the last one.
pub const ALGORITHMS: [Algorithm; 17] = [
    points(Density::Relaxed, 1),
    points(Density::Fine, 2),
    points(Density::Fixed(1), 1),
    made(Evaluation::Lattice(Density::Relaxed), SPLATTED, Footprints::Exact),
    made(Evaluation::Lattice(Density::AtLeast(2)), Classification::Post(Correction::None), Footprints::Exact),
    OTHERS[0],
    OTHERS[1],
    OTHERS[2],
    OTHERS[3],
    OTHERS[4],
    OTHERS[5],
    OTHERS[6],
    Algorithm::Slicing { step: 1.6 },
    made(Evaluation::Direct, Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 }, Footprints::Exact),
    made(Evaluation::Direct, Classification::Post(Correction::Constant), Footprints::Exact),
    Algorithm::Raycast { kernel: Kernel::Gaussian, step: 1.1 },
    made(Evaluation::Direct, Classification::Post(Correction::Constant), Footprints::Set),
];

/// A random choice that differs from the current one.
fn other<T: Copy + PartialEq>(random: &mut Random, now: T, of: &[T]) -> T {
    let others: Vec<T> = of.iter().copied().filter(|one| *one != now).collect();
    others[random.next() as usize % others.len()]
}

fn another_unit(s: &mut Scene, r: &mut Random) {
    s.settings.unit_distance = other(r, s.settings.unit_distance, &[None, Some(0.5), Some(1.7), Some(3.0)]);
}

fn other_gradient_opacity(s: &mut Scene, r: &mut Random) {
    let edges = |points: &[(f64, f64)]| Some(GradientOpacity::new(points).unwrap());
    let of = [None, edges(&[(2.0, 0.0), (30.0, 1.0)]), edges(&[(0.0, 1.0), (20.0, 0.3)])];
    s.settings.gradient_opacity = other(r, s.settings.gradient_opacity, &of);
}

fn other_depth_cue(s: &mut Scene, r: &mut Random) {
    let cue = |strength| Some(DepthCue { strength, color: [0.9, 0.5, 0.1] });
    s.settings.depth_cue = other(r, s.settings.depth_cue, &[None, cue(0.0), cue(0.4), cue(1.0)]);
}

fn other_extinction(s: &mut Scene, _: &mut Random) {
    s.settings.extinction = match s.settings.extinction {
        Extinction::Exponential => Extinction::Linear,
        Extinction::Linear => Extinction::Exponential,
    };
}

fn other_transfer(s: &mut Scene, r: &mut Random) {
    s.transfer = other(r, s.transfer, &[0, 1, 2]);
}

fn other_blend(s: &mut Scene, r: &mut Random) {
    let blends = [Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(90.0), Blend::Iso(140.0)];
    s.settings.blend = other(r, s.settings.blend, &blends);
}

fn other_axis(s: &mut Scene, r: &mut Random) {
    let axes = [Axis::X, Axis::Y, Axis::Z].map(LayerAxis::Forced);
    s.settings.algorithm = s.settings.algorithm.along(other(r, LayerAxis::Auto, &axes));
}

fn other_planes(s: &mut Scene, r: &mut Random) {
    let plane = |normal| ClipPlane { point: DVec3::new(7.0, 6.0, 5.0), normal };
    let planes = [plane(DVec3::new(1.0, 0.3, -0.2)), plane(DVec3::NEG_Y)];
    let clipping =
        |count| Clipping { crop: s.settings.clipping.crop, ..Clipping::default() }.with_planes(planes.into_iter().take(count));
    s.settings.clipping = other(r, s.settings.clipping, &[clipping(0), clipping(1), clipping(2)]);
}

fn other_crop(s: &mut Scene, r: &mut Random) {
    let from = DVec3::new(4.0, 3.0, 2.5) * r.unit();
    let crop = Some(CropBox { lowest: from, highest: from + DVec3::splat(8.5) });
    s.settings.clipping.crop = other(r, s.settings.clipping.crop, &[None, crop]);
}

/// Changes of inputs of tables and lists, the first of which changes nothing.
pub const TABLES: [fn(&mut Scene, &mut Random); 12] = [
    |_, _| (),
    another_unit,
    other_transfer,
    another_unit,
    // From near the x axis to near the y axis: the layer axis changes.
    |s, r| s.orbit = [80.0 + 20.0 * r.unit(), 15.0, 360.0 * r.unit()],
    |s, r| s.orbit = [360.0 * r.unit(), 75.0, 0.0],
    other_blend,
    other_extinction,
    |s, _| s.settings.blend = Blend::Composite,
    another_unit,
    other_transfer,
    other_extinction,
];

/// All other changes.
pub const OTHER: [fn(&mut Scene, &mut Random); 12] = [
    other_gradient_opacity,
    other_depth_cue,
    |s, r| s.orbit = [360.0 * r.unit(), 180.0 * r.unit() - 90.0, 360.0 * r.unit()],
    |s, r| {
        let lit_by = |lights| Some(Shading { lights, ..Shading::default() });
        let two = Lights::new(&[Light::towards(DVec3::X), Light { strength: 0.5, ..Light::AT_CAMERA }]).unwrap();
        let shadings = [None, lit_by(Lights::AT_CAMERA), lit_by(one_light(DVec3::X)), lit_by(two)];
        s.settings.shading = other(r, s.settings.shading, &shadings);
    },
    |s, _| s.settings.culling = !s.settings.culling,
    |s, r| s.eye = other(r, s.eye, &[Eye::Perspective(40.0, 1.6), Eye::Perspective(110.0, 0.2), Eye::Perspective(75.0, 0.9)]),
    |s, _| s.settings.early_termination = !s.settings.early_termination,
    |s, r| s.size = viewport(1 + r.next() as u32 % 40, 1 + r.next() as u32 % 40),
    other_crop,
    other_planes,
    other_axis,
    |s, r| s.eye = Eye::Parallel(0.6 + 2.0 * r.unit()),
];
