//! A scene with one volume, in the API and in the library.

use crate::client::{Device, Object};
use anari_sys::*;
use layersplat::glam::{DAffine3, DVec3};
use layersplat::settings::{Light, Lights, Settings, Shading};
use layersplat::volume::{Grid, Volume};
use layersplat::{Camera, Kernel, OpenOptions, Projection, Quality, TransferFunction, Viewport};
use std::rc::Rc;
use std::sync::OnceLock;

/// Voxels along each side.
pub const SIDE: u64 = 32;
/// Width and height of frames.
pub const SIZE: [u32; 2] = [72, 56];
/// Colours and opacities of the transfer function.
pub const COLORS: [[f32; 3]; 3] = [[0.1, 0.2, 0.9], [0.9, 0.8, 0.2], [1.0, 0.3, 0.1]];
pub const OPACITIES: [f32; 5] = [0.0, 0.1, 0.3, 0.6, 0.9];
/// View of the camera.
pub const POSITION: [f32; 3] = [70.0, 45.0, 90.0];
pub const DIRECTION: [f32; 3] = [-0.55, -0.3, -0.78];
pub const FIELD_OF_VIEW: f32 = 0.3;
/// Direction in which the light shines.
pub const LIGHT: [f32; 3] = [0.5, -1.0, -1.0];

/// A volume with values from 0 to 1.
pub fn voxels() -> &'static [f32] {
    static VOXELS: OnceLock<Vec<f32>> = OnceLock::new();
    VOXELS.get_or_init(|| {
        let volume = Volume::open(format!("builtin:hydrogen@{SIDE}"), &OpenOptions::default()).unwrap();
        let (lo, hi) = volume.range();
        (0..volume.grid().voxel_count()).map(|i| ((volume.value(i) - lo) / (hi - lo)) as f32).collect()
    })
}

/// The objects of a scene. All are committed.
pub struct Scene {
    pub device: Rc<Device>,
    pub data: Object,
    pub field: Object,
    pub volume: Object,
    pub light: Object,
    pub world: Object,
    pub camera: Object,
    pub renderer: Object,
    pub frame: Object,
}

impl Scene {
    /// The scene with a perspective camera, a light, and all channels.
    pub fn new() -> Self {
        let device = Device::new();
        let data = device.array(ANARI_FLOAT32, &[SIDE; 3], voxels());
        let field = device.make(ANARI_SPATIAL_FIELD, c"structuredRegular");
        field.set_object(c"data", &data).commit();
        let volume = device.make(ANARI_VOLUME, c"transferFunction1D");
        let colors = device.array(ANARI_FLOAT32_VEC3, &[COLORS.len() as u64], &COLORS);
        let opacities = device.array(ANARI_FLOAT32, &[OPACITIES.len() as u64], &OPACITIES);
        volume.set_object(c"value", &field).set_object(c"color", &colors).set_object(c"opacity", &opacities).commit();
        let light = device.make(ANARI_LIGHT, c"directional");
        light.set(c"direction", LIGHT).commit();
        let world = device.make(ANARI_WORLD, c"");
        world.set_object(c"volume", &device.objects(&[&volume])).set_object(c"light", &device.objects(&[&light])).commit();
        let camera = device.make(ANARI_CAMERA, c"perspective");
        camera.set(c"position", POSITION).set(c"direction", DIRECTION).set(c"fovy", FIELD_OF_VIEW).commit();
        let renderer = device.make(ANARI_RENDERER, c"default");
        renderer.set(c"ambientRadiance", 0.2f32).commit();
        let frame = device.make(ANARI_FRAME, c"");
        frame.set_object(c"world", &world).set_object(c"camera", &camera).set_object(c"renderer", &renderer);
        frame.set(c"size", SIZE).set_type(c"channel.color", ANARI_UFIXED8_VEC4);
        frame.set_type(c"channel.depth", ANARI_FLOAT32).set_type(c"channel.objectId", ANARI_UINT32).commit();
        device.expect_nothing();
        Self { device, data, field, volume, light, world, camera, renderer, frame }
    }

    /// The colours of the frame with a type of channel.
    pub fn colors<T: Copy>(&self, data_type: ANARIDataType) -> Vec<T> {
        self.frame.set_type(c"channel.color", data_type).commit().render();
        self.frame.channel(c"channel.color", data_type)
    }
}

/// The same scene for the library.
pub struct Expected {
    pub placement: DAffine3,
    pub transfer: TransferFunction,
    pub camera: Camera,
    pub settings: Settings,
    pub viewport: Viewport,
}

impl Expected {
    pub fn new() -> Self {
        let value = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let colors = COLORS.iter().enumerate().map(|(i, color)| (value(i, COLORS.len()), color.map(f64::from))).collect();
        let opacities = OPACITIES.iter().enumerate().map(|(i, &opacity)| (value(i, OPACITIES.len()), opacity.into())).collect();
        let position = DVec3::from_array(POSITION.map(f64::from));
        let projection = Projection::Perspective { field_of_view: f64::from(FIELD_OF_VIEW).to_degrees() };
        let lights = Lights::new(&[Light::towards(-DVec3::from_array(LIGHT.map(f64::from)))]).unwrap();
        let mut layered = Quality::Standard.layered();
        layered.classification = layered.classification.with_kernel(Kernel::Linear);
        Self {
            placement: DAffine3::IDENTITY,
            transfer: TransferFunction::new("the same", colors, opacities).unwrap(),
            camera: Camera {
                position,
                focal_point: position + DVec3::from_array(DIRECTION.map(f64::from)),
                view_up: DVec3::Y,
                projection,
            },
            settings: Settings {
                shading: Some(Shading { lights, ..Shading::default() }),
                unit_distance: Some(1.0),
                ..layered.into()
            },
            viewport: Viewport::new(SIZE[0], SIZE[1]).unwrap(),
        }
    }

    pub fn volume(&self) -> Volume<'static> {
        let grid = Grid::from_affine([SIDE as usize; 3], self.placement).unwrap();
        Volume::new("the same", grid, voxels()).unwrap()
    }

    pub fn renderer(&self) -> layersplat::Renderer {
        let device = layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap();
        layersplat::Renderer::new(&device, &self.volume(), &self.transfer).unwrap()
    }

    /// The library's picture over opaque black.
    pub fn bytes(&self) -> Vec<[u8; 4]> {
        let background = layersplat::Background::BLACK;
        let (bytes, _) = self.renderer().render_rgba8(&self.camera, self.viewport, &self.settings, background).unwrap();
        bytes.as_chunks().0.to_vec()
    }

    /// The library's picture without a background.
    pub fn floats(&self) -> Vec<[f32; 4]> {
        self.renderer().render(&self.camera, self.viewport, &self.settings).unwrap().0.into_pixels()
    }
}

/// Largest difference of any component.
pub fn difference<const N: usize, T: Into<f64> + Copy>(a: &[[T; N]], b: &[[T; N]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(&a, &b)| (a.into() - b.into()).abs()).fold(0.0, f64::max)
}
