//! Arbitrary inputs: volumes, transfer functions, cameras, sizes and settings.

use crate::common::Random;
use glam::{DMat3, DQuat, DVec3, EulerRot};
use layersplat::layers::{Correction, Kernel};
use layersplat::settings::{
    Algorithm, Blend, Classification, ClipPlane, Clipping, CropBox, Evaluation, GradientOpacity, LayerAxis, Layered, Light,
    Lights, Shading,
};
use layersplat::transfer::Extinction;
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Orbit, Projection, Settings, TransferFunction, Viewport, Volume};
use proptest::prelude::*;

/// All inputs of a picture.
#[derive(Clone, Debug)]
pub struct Shot {
    pub way: usize,
    pub grid: Grid,
    pub voxels: Vec<u8>,
    pub background: Option<u8>,
    pub colors: Vec<(f64, [f64; 3])>,
    pub opacities: Vec<(f64, f64)>,
    pub camera: Camera,
    pub viewport: Viewport,
    pub settings: Settings,
}

impl Shot {
    pub fn volume(&self) -> Volume<'static> {
        let volume = Volume::new("any", self.grid.clone(), Voxels::Uint8(self.voxels.clone())).unwrap();
        self.background.map_or(volume.clone(), |value| volume.with_background(value.into()).unwrap())
    }

    pub fn transfer(&self) -> TransferFunction {
        TransferFunction::new("any", self.colors.clone(), self.opacities.clone()).unwrap()
    }
}

/// Each algorithm with one kernel, one blend mode, lit or unlit: the variants that programs are built for. Everything else varies.
pub fn ways() -> Vec<Settings> {
    let points = |kernel, samples_per_layer| Layered {
        classification: Classification::Preintegrated { kernel, samples_per_layer },
        ..Layered::default()
    };
    let splats = Layered { classification: Classification::Post(Correction::SubLayers(2)), ..Layered::default() };
    let unlit = |settings: Settings| Settings { shading: None, ..settings };
    let with = |blend, settings: Settings| Settings { blend, ..settings };
    let raycast = |kernel| Algorithm::Raycast { kernel, step: 0.7 };
    vec![
        Settings::default(),
        unlit(with(Blend::Maximum, points(Kernel::Linear, 1).into())),
        with(Blend::Iso(128.0), points(Kernel::BSpline, 2).into()),
        splats.into(),
        unlit(Layered { evaluation: Evaluation::Direct, ..points(Kernel::Cubic, 1) }.into()),
        Layered { evaluation: Evaluation::Direct, ..splats }.into(),
        raycast(Kernel::CatmullRom).into(),
        unlit(with(Blend::Average, raycast(Kernel::Linear).into())),
        unlit(Algorithm::Slicing { step: 0.9 }.into()),
        Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }.into(),
        Algorithm::ViewSheets { sheet_distance: 0.75 }.into(),
    ]
}

/// 0, 1, or any number between.
fn share() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![1 => Just(0.0), 1 => Just(1.0), 4 => 0.0..=1.0f64]
}

fn dims() -> impl Strategy<Value = [usize; 3]> {
    let axis = || prop_oneof![1 => Just(1usize), 1 => Just(2usize), 4 => 3..12usize];
    prop::array::uniform3(axis())
}

/// Anisotropy up to a factor of a thousand, any world scale; rotated and mirrored.
fn grid() -> impl Strategy<Value = Grid> {
    let spacing = (prop::array::uniform3(prop_oneof![2 => Just(0.0), 3 => -1.0..1.0f64, 1 => -1.5..1.5f64]), -3.0..3.0f64);
    let turned = prop::array::uniform3(-180.0..180.0f64)
        .prop_map(|[x, y, z]| DMat3::from_quat(DQuat::from_euler(EulerRot::XYZ, x.to_radians(), y.to_radians(), z.to_radians())));
    let direction = (prop_oneof![1 => Just(DMat3::IDENTITY), 1 => turned], any::<bool>())
        .prop_map(|(turned, mirrored)| if mirrored { turned * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)) } else { turned });
    let origin = prop_oneof![1 => Just(DVec3::ZERO), 1 => prop::array::uniform3(-500.0..500.0f64).prop_map(DVec3::from_array)];
    (dims(), spacing, origin, direction).prop_map(|(dims, (each, all), origin, direction)| {
        let spacing = DVec3::from_array(each.map(|power| 10f64.powf(power + all)));
        Grid::oriented(dims, spacing, origin, direction).unwrap()
    })
}

/// Noise, a constant, or two values.
fn voxels(count: usize) -> impl Strategy<Value = Vec<u8>> {
    (any::<u64>(), prop_oneof![3 => Just(255u64), 1 => Just(0), 1 => Just(1)], any::<u8>()).prop_map(
        move |(seed, spread, least)| {
            let mut random = Random(seed);
            (0..count)
                .map(
                    |_| {
                        if spread == 255 {
                            random.next() as u8
                        } else {
                            least.saturating_add((random.next() % (spread + 1)) as u8)
                        }
                    },
                )
                .collect()
        },
    )
}

/// Ascending values of control points, some repeated for steps.
fn values() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((prop_oneof![4 => -20.0..280.0f64, 1 => Just(128.0)], prop::bool::weighted(0.3)), 1..6).prop_map(
        |points| {
            let mut values: Vec<f64> =
                points.iter().flat_map(|&(x, twice)| std::iter::repeat_n(x, 1 + usize::from(twice))).collect();
            values.sort_by(f64::total_cmp);
            values
        },
    )
}

fn points<T: std::fmt::Debug + Clone>(of: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = Vec<(f64, T)>> {
    values().prop_flat_map(move |values| {
        let count = values.len();
        prop::collection::vec(of.clone(), count).prop_map(move |of| values.iter().copied().zip(of).collect())
    })
}

/// Any orientation, exactly along an axis, and exactly between two.
fn orbit() -> impl Strategy<Value = Orbit> {
    let angle = || prop_oneof![3 => -180.0..180.0f64, 1 => (-4..=4).prop_map(|n| f64::from(n) * 45.0), 1 => Just(44.999)];
    (angle(), angle(), prop_oneof![1 => Just(0.0), 1 => -180.0..180.0f64]).prop_map(|(azimuth, elevation, roll)| Orbit {
        azimuth,
        elevation,
        roll,
    })
}

/// Fitted, near, far, inside the volume, looking past it; in both projections.
fn camera(grid: Grid) -> impl Strategy<Value = Camera> {
    let sizes = prop_oneof![3 => Just(1.0), 1 => 0.01..1.0f64, 1 => 1.0..50.0f64];
    let distance = prop_oneof![3 => Just(2.0), 1 => 0.01..1.0f64, 1 => 2.0..2000.0f64];
    let aside = prop_oneof![2 => Just([0.0; 3]), 1 => prop::array::uniform3(-0.6..0.6f64)];
    let field_of_view = prop_oneof![3 => 10.0..60.0f64, 1 => 0.01..179.0f64];
    (orbit(), any::<bool>(), sizes, distance, aside, field_of_view).prop_map(
        move |(orbit, parallel, size, distance, aside, field_of_view)| {
            let projection = match parallel {
                true => Projection::Parallel { scale: grid.diagonal() * size / 2.0 },
                false => Projection::Perspective { field_of_view },
            };
            let centre = grid.centre() + DVec3::from_array(aside) * grid.diagonal();
            let own = Camera::orbit(DVec3::ZERO, distance * grid.diagonal(), orbit, projection);
            // Along the axes of the volume, in any rotation.
            let turned = |v: DVec3| grid.direction() * v;
            Camera { position: centre + turned(own.position), focal_point: centre, view_up: turned(own.view_up), projection }
        },
    )
}

fn clipping(grid: Grid) -> impl Strategy<Value = Clipping> {
    let unit = || prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array);
    let crop = (unit(), prop::array::uniform3(0.01..1.0f64)).prop_map({
        let grid = grid.clone();
        move |(lowest, size)| {
            let dims = DVec3::from_array(grid.dims().map(|n| n as f64));
            CropBox { lowest: lowest * dims, highest: (lowest + DVec3::from_array(size)) * dims }
        }
    });
    let plane = (unit(), unit()).prop_map(move |(point, normal)| ClipPlane {
        point: grid.centre() + point * grid.diagonal() / 2.0,
        normal: normal + DVec3::splat(1e-3),
    });
    let some = (prop::option::of(crop), prop::collection::vec(plane, 0..=6));
    let some = some.prop_map(|(crop, planes)| Clipping { crop, ..Clipping::default().with_planes(planes) });
    prop_oneof![2 => Just(Clipping::default()), 1 => some]
}

fn shading() -> impl Strategy<Value = Shading> {
    let strength = || prop_oneof![3 => 0.0..1.0f64, 1 => 0.0..100.0f64];
    let direction = prop::option::of(prop::array::uniform3(-1.0..1.0f64).prop_map(|v| DVec3::from_array(v) + DVec3::splat(1e-3)));
    // Mostly white: lights with colours have programs of their own.
    let color = || prop_oneof![3 => Just([1.0; 3]), 1 => prop::array::uniform3(0.0..=1.0f64)];
    let light = (direction, strength(), color()).prop_map(|(direction, strength, color)| Light {
        direction,
        strength,
        color,
        ..Light::AT_CAMERA
    });
    let lights = prop::collection::vec(light, 1..=Lights::MOST).prop_map(|lights| Lights::new(&lights).expect("good lights"));
    let power = prop_oneof![3 => 1.0..100.0f64, 1 => 1e-3..1e4f64];
    (strength(), color(), strength(), strength(), power, lights).prop_map(
        |(ambient, ambient_color, diffuse, specular, power, lights)| Shading {
            ambient,
            ambient_color,
            diffuse,
            specular,
            power,
            lights,
        },
    )
}

fn gradient_opacity() -> impl Strategy<Value = Option<GradientOpacity>> {
    let point = || ((-3.0..3.0f64).prop_map(|power| 10f64.powf(power)), 0.0..=1.0f64);
    prop::option::of(prop::collection::vec(point(), 1..=GradientOpacity::MOST_POINTS).prop_map(|mut points| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by_key(|point| point.0);
        GradientOpacity::new(&points).expect("sorted")
    }))
}

fn settings(grid: Grid) -> impl Strategy<Value = (usize, Settings)> {
    let smallest = grid.spacing().min_element();
    let unit_distance = prop::option::of((-3.0..3.0f64).prop_map(move |power| smallest * 10f64.powf(power)));
    let switches = (any::<bool>(), any::<bool>(), any::<bool>());
    let by_gradients = (shading(), gradient_opacity());
    (0..ways().len(), by_gradients, clipping(grid), unit_distance, switches, -10.0..270.0f64).prop_map(
        |(way, (shading, gradient_opacity), clipping, unit_distance, (early_termination, culling, linear), iso)| {
            let own = ways()[way];
            let settings = Settings {
                blend: if matches!(own.blend, Blend::Iso(_)) { Blend::Iso(iso) } else { own.blend },
                shading: own.shading.map(|_| shading),
                gradient_opacity: gradient_opacity.filter(|_| own.blend == Blend::Composite),
                extinction: if linear { Extinction::Linear } else { Extinction::Exponential },
                clipping,
                unit_distance,
                early_termination,
                culling,
                ..own
            };
            (way, settings)
        },
    )
}

fn viewport() -> impl Strategy<Value = Viewport> {
    let side = || prop_oneof![1 => Just(1u32), 3 => 2..24u32, 1 => 24..70u32];
    (side(), side()).prop_map(|(width, height)| Viewport { width, height })
}

pub fn shot() -> impl Strategy<Value = Shot> {
    grid().prop_flat_map(|grid| {
        let of_volume = (voxels(grid.voxel_count()), prop::option::of(any::<u8>()));
        let of_transfer = (points(prop::array::uniform3(share())), points(share()));
        let of_view = (camera(grid.clone()), viewport(), settings(grid.clone()));
        (Just(grid), of_volume, of_transfer, of_view).prop_map(
            |(grid, (voxels, background), (colors, opacities), (camera, viewport, (way, settings)))| Shot {
                way,
                grid,
                voxels,
                background,
                colors,
                opacities,
                camera,
                viewport,
                settings,
            },
        )
    })
}
