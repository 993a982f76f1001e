//! What a viewer changes from one frame to the next, each for itself.

use crate::scene::{Scene, viewport};
use layersplat::settings::{Algorithm, Blend, Classification, Clipping, CropBox, GradientOpacity, Layered};
use layersplat::{Camera, Kernel, Orbit, Projection, Quality, Settings, TransferFunction, glam::DVec3};

/// One change of what is shown or how.
pub struct Change {
    pub name: &'static str,
    pub camera: Camera,
    pub settings: Settings,
    /// In place of the scene's own.
    pub transfer: Option<TransferFunction>,
}

/// Degrees about the y axis of the view that all changes begin at: layer axis z.
const AZIMUTH: f64 = 30.0;

/// The view from an azimuth, rolled, that all of the volume fits into.
pub fn orbit(scene: &Scene, azimuth: f64, roll: f64) -> Camera {
    let grid = scene.volume.grid();
    Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport(), Orbit { azimuth, elevation: 20.0, roll })
}

/// The same, a part of it that many times larger.
pub fn zoomed(camera: Camera, zoom: f64) -> Camera {
    let projection = match camera.projection {
        Projection::Parallel { scale } => Projection::Parallel { scale: scale / zoom },
        perspective => perspective,
    };
    Camera { projection, ..camera }
}

/// A perspective of a field of view in degrees, from within the volume: the eye is a quarter of its diagonal away from its centre.
pub fn perspective(scene: &Scene, field_of_view: f64) -> Camera {
    let (grid, orbit) = (scene.volume.grid(), Orbit { azimuth: AZIMUTH, elevation: 20.0, roll: 0.0 });
    Camera::orbit(grid.centre(), grid.diagonal() / 4.0, orbit, Projection::Perspective { field_of_view })
}

/// The scene's transfer function, opaque wherever it shows anything.
pub fn opaque(scene: &Scene) -> TransferFunction {
    let points = scene.transfer.opacities().iter().map(|&(value, opacity)| (value, f64::from(opacity > 0.0))).collect();
    scene.transfer.with_opacities(points).expect("opacities of 0 and 1")
}

/// The middle of the volume, half as long along each axis.
pub fn cropped(scene: &Scene) -> Clipping {
    let size = DVec3::from_array(scene.volume.grid().dims().map(|n| n as f64 - 1.0));
    Clipping { crop: Some(CropBox { lowest: size * 0.25, highest: size * 0.75 }), ..Clipping::default() }
}

/// The standard settings with another kernel, or other samples per layer.
fn sampled(kernel: Kernel, samples_per_layer: u32) -> Settings {
    let classification = Classification::Preintegrated { kernel, samples_per_layer };
    Algorithm::Layered(Layered { classification, ..Quality::Standard.layered() }).into()
}

/// All changes, the frame that a viewer begins with before them.
pub fn all(scene: &Scene) -> Vec<Change> {
    let (view, settings) = (orbit(scene, AZIMUTH, 0.0), Settings::default());
    let high = Quality::High.settings();
    let base = |name| Change { name, camera: view, settings, transfer: None };
    let seen = |name, camera| Change { camera, ..base(name) };
    let set = |name, settings| Change { settings, ..base(name) };
    let (lowest, largest) = scene.transfer.range();
    let steep = GradientOpacity::new(&[(0.0, 0.0), (0.1 * (largest - lowest), 1.0)]).expect("two points");
    vec![
        base("very first"),
        seen("layer axis x", orbit(scene, 80.0, 0.0)),
        seen("exactly 45°", orbit(scene, 45.0, 0.0)),
        seen("zoom 4", zoomed(view, 4.0)),
        Change { transfer: Some(opaque(scene)), ..base("an opaque transfer function") },
        seen("perspective of 90°", perspective(scene, 90.0)),
        set("high", high),
        Change { camera: orbit(scene, AZIMUTH, 20.0), ..set("high, rolled", high) },
        set("linear", sampled(Kernel::Linear, 1)),
        set("catmull-rom", sampled(Kernel::CatmullRom, 1)),
        set("bspline", sampled(Kernel::BSpline, 1)),
        set("gradient opacity", Settings { gradient_opacity: Some(steep), ..settings }),
        set("crop", Settings { clipping: cropped(scene), ..settings }),
        set("maximum", Settings { blend: Blend::Maximum, ..settings }),
        set("minimum", Settings { blend: Blend::Minimum, ..settings }),
        set("average", Settings { blend: Blend::Average, ..settings }),
        set("iso", Settings { blend: Blend::Iso((lowest + largest) / 2.0), ..settings }),
        set("2 samples per layer", sampled(Kernel::Cubic, 2)),
    ]
}
