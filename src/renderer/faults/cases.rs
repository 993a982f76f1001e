//! Every render path, from the upload on.

use super::host::Host;
use crate::camera::{Camera, Orbit};
use crate::device::{Device, DeviceMemory};
use crate::error::Error;
use crate::image::Background;
use crate::layers::{Axis, Correction, Kernel};
use crate::renderer::{PartRenderer, PictureFormat, PictureMemory, Renderer, StreamedRenderer};
use crate::settings::{
    Algorithm, Blend, Classification, Evaluation, LayerAxis, Layered, Light, Lights, Settings, Shading, Shadows,
};
use crate::slice::{Slice, SliceAxis, SliceColors};
use crate::surface::{Spheres, Surface};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{OpenOptions, Volume};
use glam::DVec3;

const SIZE: Viewport = Viewport { width: 21, height: 17 };

/// Renders a picture each time it is called.
pub type Draw<'a> = Box<dyn FnMut() -> Result<Vec<u8>, Error> + 'a>;

/// Creates a renderer.
type Make<'a> = dyn Fn(&Device) -> Result<Draw<'a>, Error> + 'a;

/// A render path: creates everything it needs on a device.
pub struct Case<'a> {
    pub name: String,
    pub make: Box<Make<'a>>,
}

/// Test volume and transfer function.
pub struct Scene {
    pub volume: Volume<'static>,
    pub transfer: TransferFunction,
}

impl Scene {
    pub fn new(volume: &str) -> Self {
        let volume = Volume::open(volume, &OpenOptions::default()).unwrap();
        Self { transfer: TransferFunction::builtin("fire", &volume).unwrap(), volume }
    }

    /// Two translucent spheres at the same place.
    fn spheres(&self) -> Result<Surface, Error> {
        let grid = self.volume.grid();
        let mut spheres = Surface::new("spheres", Spheres::new(vec![grid.centre(); 2], vec![0.1 * grid.diagonal(); 2])?);
        spheres.opacity = 0.5;
        Ok(spheres)
    }

    /// A perspective camera if a field of view is given, else a parallel one.
    pub fn camera(&self, azimuth: f64, field_of_view: Option<f64>) -> Camera {
        let (centre, diagonal) = (self.volume.grid().centre(), self.volume.grid().diagonal());
        let orbit = Orbit { azimuth, elevation: 0.0, roll: 8.0 };
        match field_of_view {
            None => Camera::fit_parallel(centre, diagonal, SIZE, orbit),
            Some(degrees) => Camera::fit_perspective(centre, diagonal, degrees, SIZE, orbit),
        }
    }
}

const SPLATTED: Classification = Classification::Post(Correction::SubLayers(2));

fn layered(change: impl FnOnce(&mut Layered)) -> Settings {
    let mut layered = Layered::default();
    change(&mut layered);
    layered.into()
}

fn along_x(kernel: Kernel) -> Settings {
    layered(|l| {
        l.layer_axis = LayerAxis::Forced(Axis::X);
        l.classification = Classification::Preintegrated { kernel, samples_per_layer: 1 };
    })
}

/// Float frames of each algorithm.
pub fn frames(scene: &Scene) -> Vec<Case<'_>> {
    let own = Settings::default();
    let paths = [
        ("points", own, scene.camera(20.0, None)),
        ("points in a perspective", own, scene.camera(20.0, Some(25.0))),
        ("points, shared by two axes", own, scene.camera(45.3, None)),
        ("splats", layered(|l| l.classification = SPLATTED), scene.camera(20.0, None)),
        ("splats in a perspective", layered(|l| l.classification = SPLATTED), scene.camera(20.0, Some(25.0))),
        ("the B-spline along x", along_x(Kernel::BSpline), scene.camera(80.0, None)),
        ("points per pixel", layered(|l| l.evaluation = Evaluation::Direct), scene.camera(20.0, None)),
        (
            "splats per pixel",
            layered(|l| (l.evaluation, l.classification) = (Evaluation::Direct, SPLATTED)),
            scene.camera(20.0, None),
        ),
        ("the largest value", Settings { blend: Blend::Maximum, ..own }, scene.camera(20.0, None)),
        ("ray casting", Algorithm::Raycast { kernel: Kernel::Linear, step: 0.6 }.into(), scene.camera(20.0, None)),
        ("slicing", Algorithm::Slicing { step: 0.8 }.into(), scene.camera(20.0, None)),
        ("axis-sheets", Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }.into(), scene.camera(80.0, None)),
        ("view-sheets", Algorithm::ViewSheets { sheet_distance: 1.0 }.into(), scene.camera(20.0, None)),
    ];
    let case = |(name, settings, camera): (&str, Settings, Camera)| Case {
        name: name.into(),
        make: Box::new(move |device| {
            let mut renderer = Renderer::new(device, &scene.volume, &scene.transfer)?;
            Ok(Box::new(move || Ok(bytemuck::cast_slice(renderer.render(&camera, SIZE, &settings)?.0.pixels()).to_vec())))
        }),
    };
    paths.map(case).into()
}

/// 8-bit pictures: of one lattice, of two lattices, and of screen pixels.
pub fn displayed(scene: &Scene) -> Vec<Case<'_>> {
    let case = |name: &str, azimuth: f64, settings: Settings| Case {
        name: format!("8 bits of {name}"),
        make: Box::new(move |device| {
            let mut renderer = Renderer::new(device, &scene.volume, &scene.transfer)?;
            let camera = scene.camera(azimuth, None);
            Ok(Box::new(move || Ok(renderer.render_rgba8(&camera, SIZE, &settings, Background::BLACK)?.0)))
        }),
    };
    let slicing = Algorithm::Slicing { step: 0.8 }.into();
    let surfaces = Case {
        name: "8 bits of surfaces".into(),
        make: Box::new(move |device| {
            let mut renderer = Renderer::new(device, &scene.volume, &scene.transfer)?;
            renderer.set_surfaces(&[scene.spheres()?])?;
            let camera = scene.camera(20.0, None);
            Ok(Box::new(move || Ok(renderer.render_rgba8(&camera, SIZE, &Settings::default(), Background::BLACK)?.0)))
        }),
    };
    vec![
        case("points", 20.0, Settings::default()),
        case("two axes", 45.3, Settings::default()),
        case("slicing", 20.0, slicing),
        surfaces,
    ]
}

/// Frames enqueued into the embedding application's memory.
pub fn enqueued<'a>(scene: &'a Scene, host: &'a Host) -> Vec<Case<'a>> {
    let format = |rgba8| if rgba8 { PictureFormat::Rgba8(Background::BLACK) } else { PictureFormat::Floats };
    let case = |name: &str, azimuth: f64, with_scratch: bool, rgba8: bool| {
        let with_surfaces = name == "surfaces";
        let name = format!("enqueued {name}, scratch {with_scratch}");
        let make: Box<Make> = Box::new(move |device| {
            let mut renderer = Renderer::new(device, &scene.volume, &scene.transfer)?;
            if with_surfaces {
                renderer.set_surfaces(&[scene.spheres()?])?;
            }
            let (camera, settings) = (scene.camera(azimuth, None), Settings::default());
            let picture = host.buffer(16 * SIZE.pixels());
            let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture)?, format(rgba8));
            if with_scratch {
                let scratch = renderer.scratch_bytes(&camera, SIZE, &settings, &onto)?;
                let scratch: Result<Vec<_>, _> =
                    scratch.into_iter().map(|n| DeviceMemory::from_buffer(&host.buffer(n))).collect();
                renderer.set_scratch(&scratch?)?;
            }
            let bytes = SIZE.pixels() * if rgba8 { 4 } else { 16 };
            Ok(Box::new(move || {
                let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[])?;
                Ok(host.read(&picture, bytes, &event))
            }))
        });
        Case { name, make }
    };
    vec![
        case("points", 20.0, false, false),
        case("points", 20.0, true, true),
        case("two axes", 45.3, true, false),
        case("surfaces", 20.0, false, true),
    ]
}

/// Layers composited by two part renderers.
pub fn in_parts(scene: &Scene) -> Case<'_> {
    Case {
        name: "parts".into(),
        make: Box::new(move |device| {
            let [x, y, z] = scene.volume.grid().dims();
            let (camera, settings) = (scene.camera(180.0, None), Settings::default());
            let middle = z / 2;
            let part = |first: usize, end: usize| {
                let part = scene.volume.part([0, 0, first], [x, y, end - first])?;
                PartRenderer::new(device, &part, &scene.transfer)
            };
            let (mut front, mut behind) = (part(0, middle + 2)?, part(middle - 2, z)?);
            Ok(Box::new(move || {
                let done = front.composite(&camera, SIZE, &settings, 0..middle, None)?;
                let done = behind.composite(&camera, SIZE, &settings, middle..z, Some(&done))?;
                Ok(bytemuck::cast_slice(behind.finish(&done)?.pixels()).to_vec())
            }))
        }),
    }
}

/// A slice, with coefficients of the B-spline.
pub fn sliced(scene: &Scene) -> Case<'_> {
    Case {
        name: "a slice".into(),
        make: Box::new(move |device| {
            let mut renderer = Renderer::new(device, &scene.volume, &scene.transfer)?;
            let slice = Slice::at(scene.volume.grid(), SliceAxis::Y, 3.5, SIZE)?;
            let mut draw = move || renderer.slice(&slice, SIZE, Kernel::BSpline, SliceColors::TRANSFER);
            Ok(Box::new(move || Ok(bytemuck::cast_slice(draw()?.pixels()).to_vec())))
        }),
    }
}

/// A volume streamed in several parts, and one that fits as a whole.
pub fn streamed(scene: &Scene) -> Vec<Case<'_>> {
    let case = |name: &str, budget: Option<u64>, settings: Settings, parts: fn(usize) -> bool| Case {
        name: format!("streamed {name}"),
        make: Box::new(move |device| {
            let device = budget.map_or(device.clone(), |bytes| device.with_memory(bytes));
            let mut renderer = StreamedRenderer::new(&device, &scene.volume, &scene.transfer);
            let camera = scene.camera(20.0, None);
            let plan = renderer.plan(&camera, SIZE, &settings)?.expect("a lattice");
            assert!(plan.lattices.iter().all(|lattice| parts(lattice.parts)), "{plan}");
            Ok(Box::new(move || Ok(bytemuck::cast_slice(renderer.render(&camera, SIZE, &settings)?.0.pixels()).to_vec())))
        }),
    };
    let own = Settings::default();
    // Swept along two axes, and added up.
    let lights = Lights::new(&[Light::towards(DVec3::new(1.0, 0.1, 1.0))]).expect("a light");
    let lit = Settings { shading: Some(Shading { lights, ..Shading::default() }), shadows: Some(Shadows::default()), ..own };
    vec![
        case("in parts", Some(BUDGET), own, |parts| parts > 1),
        case("in parts with shadows", Some(2 * BUDGET), lit, |_| true),
        case("as a whole", None, own, |parts| parts == 1),
    ]
}

/// Memory budget in bytes: less than the streamed volume.
const BUDGET: u64 = 400 << 10;
