//! What a renderer may be asked for, and what may change about it.

use crate::common::*;
use glam::DVec3;
use layersplat::layers::{Density, Interpolation};
use layersplat::settings::{
    Algorithm, Blend, Classification, ClipPlane, Clipping, CropBox, Evaluation, Footprints, LayerAxis, Layered, Shading,
};
use layersplat::transfer::Extinction;
use layersplat::{Axis, Camera, Correction, Orbit, Projection, Settings, Viewport, Volume};

/// A picture but for its volume.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub settings: Settings,
    /// Which transfer function.
    pub transfer: usize,
    /// Azimuth, elevation and roll in degrees.
    pub orbit: [f64; 3],
    pub eye: Eye,
    pub size: Viewport,
}

/// Where rays come from.
#[derive(Clone, Copy, Debug)]
pub enum Eye {
    /// Parallel, so many times nearer than what fits.
    Parallel(f64),
    /// The field of view in degrees, and the distance from the centre in diagonals.
    Perspective(f64, f64),
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            transfer: 2,
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
    made(Evaluation::Lattice(density), Classification::Preintegrated { samples_per_layer }, Footprints::Exact)
}

const fn made(evaluation: Evaluation, classification: Classification, footprints: Footprints) -> Algorithm {
    Algorithm::Layered(Layered { layer_axis: LayerAxis::Auto, evaluation, classification, footprints })
}

/// Every way to draw.
pub const ALGORITHMS: [Algorithm; 16] = [
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
    made(Evaluation::Direct, Classification::Preintegrated { samples_per_layer: 1 }, Footprints::Exact),
    made(Evaluation::Direct, Classification::Post(Correction::Constant), Footprints::Set),
    Algorithm::Raycast { interpolation: Interpolation::Gaussian, step: 1.1 },
];

/// One of several.
fn any<T: Copy>(random: &mut Random, of: &[T]) -> T {
    of[random.next() as usize % of.len()]
}

/// What may change, one at a time. Each makes something else of what it was.
pub const CHANGES: [fn(&mut Scene, &mut Random); 17] = [
    |s, _| s.transfer = (s.transfer + 1) % 3,
    |s, r| s.settings.unit_distance = any(r, &[None, Some(0.5), Some(1.7), Some(3.0)]),
    |s, _| {
        s.settings.extinction = match s.settings.extinction {
            Extinction::Exponential => Extinction::Linear,
            Extinction::Linear => Extinction::Exponential,
        };
    },
    |s, r| s.orbit = [360.0 * r.unit(), 180.0 * r.unit() - 90.0, 360.0 * r.unit()],
    |s, r| s.settings.blend = any(r, &[Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(90.0), Blend::Iso(140.0)]),
    |s, _| s.transfer = (s.transfer + 2) % 3,
    |s, _| s.settings.blend = Blend::Composite,
    |s, r| {
        s.settings.shading =
            any(r, &[None, Some(Shading::default()), Some(Shading { light: Some(DVec3::X), ..Shading::default() })]);
    },
    |s, _| s.settings.culling = !s.settings.culling,
    |s, r| s.eye = any(r, &[Eye::Perspective(40.0, 1.6), Eye::Perspective(110.0, 0.2), Eye::Perspective(75.0, 0.9)]),
    |s, _| s.settings.early_termination = !s.settings.early_termination,
    |s, r| s.size = viewport(1 + r.next() as u32 % 40, 1 + r.next() as u32 % 40),
    |s, r| {
        let from = DVec3::new(4.0, 3.0, 2.5) * r.unit();
        s.settings.clipping.crop = any(r, &[None, Some(CropBox { lowest: from, highest: from + DVec3::splat(8.5) })]);
    },
    |s, r| {
        let plane = |normal| ClipPlane { point: DVec3::new(7.0, 6.0, 5.0), normal };
        let planes = [plane(DVec3::new(1.0, 0.3, -0.2)), plane(DVec3::NEG_Y)];
        let crop = s.settings.clipping.crop;
        let count = any(r, &[0, 1, 2]);
        s.settings.clipping = Clipping { crop, ..Clipping::default() }.with_planes(planes.into_iter().take(count));
    },
    |s, r| {
        let axis = any(r, &[LayerAxis::Auto, LayerAxis::Forced(Axis::X), LayerAxis::Forced(Axis::Y), LayerAxis::Forced(Axis::Z)]);
        s.settings.algorithm = s.settings.algorithm.along(axis);
    },
    |s, r| s.eye = Eye::Parallel(0.6 + 2.0 * r.unit()),
    |s, r| s.settings.unit_distance = any(r, &[None, Some(0.4), Some(1.3), Some(-1.0)]),
];
