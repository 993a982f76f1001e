//! Every kernel passes the place of a sample to `shade`, along the right axes. Depth cueing alone depends on it, along one direction, so
//! these tests edit the kernels: samples are as bright as one coordinate of their place. The exponent of highlights, which then has no other use, selects it.

use crate::camera::{Camera, Orbit};
use crate::device::{Device, DeviceChoice, LatticeSchedule, Tuning};
use crate::layers::{Axis, Correction, Kernel};
use crate::renderer::Renderer;
use crate::settings::{Algorithm, Blend, Classification, Evaluation, LayerAxis, Layered, Settings, Shading};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume, Voxels};
use glam::DVec3;

const SIZE: Viewport = Viewport { width: 40, height: 40 };
const DIMS: [usize; 3] = [28, 26, 20];
/// Centre of an opaque block of 3³ voxels. Its coordinates differ by more than twice the tolerance.
const BLOCK: [usize; 3] = [5, 22, 13];
/// Coordinate at which a sample is white.
const WHITE: f64 = 32.0;
/// Half the block, and the radius of the widest kernel.
const TOLERANCE: f64 = 3.5 / WHITE;
/// The statement of `shade` that is edited.
const STATEMENT: &str = "lighting.factor[i] = base + lit * (lighting.factor[i] - base);";
const EDITED: &str = "lighting.factor[i] = (p->light.power < 1.5f ? point.u : p->light.power < 2.5f ? point.v : point.a) / 32.0f; \
                      lighting.highlight[i] = 0.0f;";

fn volume() -> Volume<'static> {
    let [x, y, _] = DIMS;
    let place = |n: usize| [n % x, n / x % y, n / (x * y)];
    let in_block = |n: usize| place(n).iter().zip(BLOCK).all(|(i, centre)| i.abs_diff(centre) <= 1);
    let voxels = (0..DIMS.iter().product()).map(|n| if in_block(n) { 200 } else { 0 }).collect();
    Volume::new("block", Grid::new(DIMS, DVec3::ONE).unwrap(), Voxels::Uint8(voxels)).unwrap()
}

fn transfer() -> TransferFunction {
    TransferFunction::new("block", vec![(0.0, [1.0; 3])], vec![(80.0, 0.0), (120.0, 0.95)]).unwrap()
}

/// A device whose programs shade by the place.
fn device(tuning: Option<Tuning>) -> Device {
    let device = Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
    let device = tuning.map_or(device.clone(), |tuning| device.with_tuning(tuning).unwrap());
    device.edit_sources(|text| {
        assert!(!text.contains("Lighting shade(") || text.contains(STATEMENT), "shade has changed: edit another statement");
        text.replace(STATEMENT, EDITED)
    });
    device
}

/// Where pictures are taken from.
#[derive(Clone, Copy)]
enum From {
    Outside,
    /// In a perspective.
    Near,
    /// The centre of the volume, for which no lattice applies.
    Inside,
}

/// A camera that looks nearly along an axis or, from inside, at the block.
fn camera(volume: &Volume, along: Axis, from: From) -> Camera {
    let (azimuth, elevation) = match along {
        Axis::X => (82.0, 7.0),
        Axis::Y => (6.0, 80.0),
        Axis::Z => (8.0, 6.0),
    };
    let orbit = Orbit { azimuth, elevation, roll: 0.0 };
    let (centre, diagonal) = (volume.grid().centre(), volume.grid().diagonal());
    let perspective = Camera::fit_perspective(centre, diagonal, 20.0, SIZE, orbit);
    match from {
        From::Outside => Camera::fit_parallel(centre, diagonal, SIZE, orbit),
        From::Near => perspective,
        From::Inside => {
            Camera { position: centre, focal_point: DVec3::from_array(BLOCK.map(|i| i as f64)), view_up: DVec3::Z, ..perspective }
        }
    }
}

/// Mean brightness of the block in a picture.
fn brightness(device: &Device, settings: &Settings, along: Axis, from: From) -> f64 {
    let volume = volume();
    let mut renderer = Renderer::new(device, &volume, &transfer()).unwrap();
    let (frame, _) = renderer.render(&camera(&volume, along, from), SIZE, settings).unwrap();
    let shown: Vec<f64> = frame.pixels().iter().filter(|p| p[3] > 0.3).map(|p| f64::from(p[0] / p[3])).collect();
    assert!(!shown.is_empty(), "{settings:?} along {along:?}: the block is not seen");
    shown.iter().sum::<f64>() / shown.len() as f64
}

/// Fails unless the brightness is that of the coordinate, for views along all axes. `axes`: the world axes of u, v and a, for a layer axis.
fn assert_places(tuning: Option<Tuning>, settings: Settings, from: From, axes: impl Fn(Axis) -> [usize; 3]) {
    let device = device(tuning);
    for along in Axis::ALL {
        for (power, axis) in (1..).zip(axes(along)) {
            let shading = Some(Shading { power: f64::from(power), ..Shading::default() });
            let found = brightness(&device, &Settings { shading, ..settings }, along, from);
            let expected = BLOCK[axis] as f64 / WHITE;
            assert!((found - expected).abs() < TOLERANCE, "{settings:?} along {along:?}, {power}: {found}, not {expected}");
        }
    }
}

/// Axes of kernels that work layer by layer.
fn layer_axes(along: Axis) -> [usize; 3] {
    let frame = along.frame();
    [frame.u, frame.v, frame.a]
}

/// Axes of kernels that march along rays.
fn grid_axes(_: Axis) -> [usize; 3] {
    [0, 1, 2]
}

const SPLATTED: Classification = Classification::Post(Correction::SubLayers(2));

fn layered(classification: Classification, evaluation: Evaluation) -> Settings {
    Layered { classification, evaluation, layer_axis: LayerAxis::Auto, ..Layered::default() }.into()
}

#[test]
fn layers_in_tiles() {
    let own = Layered::default();
    assert_places(None, own.into(), From::Outside, layer_axes);
    assert_places(None, layered(SPLATTED, own.evaluation), From::Outside, layer_axes);
    assert_places(None, layered(SPLATTED, own.evaluation), From::Near, layer_axes);
}

#[test]
fn layers_per_sample() {
    let own = Layered::default();
    let tuning = Some(Tuning { lattice_schedule: LatticeSchedule::Samples, ..*Device::shared().tuning() });
    assert_places(tuning, own.into(), From::Outside, layer_axes);
    assert_places(tuning, layered(SPLATTED, own.evaluation), From::Outside, layer_axes);
}

#[test]
fn layers_per_pixel() {
    let own = Layered::default();
    assert_places(None, layered(own.classification, Evaluation::Direct), From::Outside, layer_axes);
    assert_places(None, layered(SPLATTED, Evaluation::Direct), From::Outside, layer_axes);
}

#[test]
fn rays_and_slices() {
    let raycast = Settings::from(Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 });
    assert_places(None, raycast, From::Outside, grid_axes);
    assert_places(None, Settings { blend: Blend::Iso(100.0), ..raycast }, From::Outside, grid_axes);
    assert_places(None, Algorithm::Slicing { step: 0.5 }.into(), From::Outside, grid_axes);
    assert_places(None, Settings::default(), From::Inside, grid_axes);
}

#[test]
fn sheets() {
    assert_places(None, Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }.into(), From::Outside, layer_axes);
    assert_places(None, Algorithm::ViewSheets { sheet_distance: 1.0 }.into(), From::Outside, grid_axes);
}
