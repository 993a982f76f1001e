//! Colours and lights, against manual calculations and the f64 reference, on grids of any orientation.

use crate::common::*;
use glam::{DMat3, DVec3};
use layersplat::image::Background;
use layersplat::reference::Layered as LayeredReference;
use layersplat::settings::{Evaluation, Layered, Light, Lights, Shading};
use layersplat::volume::{Grid, Voxels};
use layersplat::{Camera, Projection, Settings, TransferFunction, Volume};

/// Reciprocal roots are accurate to 5e-6; powers amplify the error.
const TOLERANCE: f64 = 5e-5;

/// Ambient, diffuse, specular, power, light.
const LIGHTS: [(f64, f64, f64, f64, Option<DVec3>); 5] = [
    (0.0, 1.0, 0.0, 1.0, Some(DVec3::new(0.0, 0.0, 1.0))),
    (0.3, 0.2, 1.5, 3.0, Some(DVec3::new(-2.0, 1.0, 0.5))),
    (0.1, 0.6, 0.8, 60.0, Some(DVec3::new(1.0, 3.0, 2.0))),
    (0.0, 0.0, 1.0, 0.5, Some(DVec3::new(0.2, -1.0, 0.1))),
    (0.5, 0.1, 0.9, 5.0, None),
];

fn lit((ambient, diffuse, specular, power, light): (f64, f64, f64, f64, Option<DVec3>)) -> Option<Shading> {
    Some(Shading {
        ambient,
        ambient_color: [1.0; 3],
        diffuse,
        specular,
        power,
        lights: light.map_or_else(Lights::default, one_light),
    })
}

/// Values increase by 1, 4 and 2 per voxel along x, y and z; the spacing along y is 2. Normals are (1, 2, 2) / 3.
fn ramp() -> Volume<'static> {
    let [x, y, z] = [24, 12, 24];
    let voxel = |i: usize| (i % x + 4 * (i / x % y) + 2 * (i / x / y)) as u8;
    volume([x, y, z], DVec3::new(1.0, 2.0, 1.0), Voxels::Uint8((0..x * y * z).map(voxel).collect()))
}

/// An opaque slope lit from the side: eye at e = (0, 0, −1), light at l = (−3, 0, −4) / 5, n = (1, 2, 2) / 3.
///
/// |n · l| = 2.2 / 3. Half-way between e and l is h = (−1, 0, −3) / √10, |n · h| = 7 / (3 √10), to the fourth power 49² / 90².
///
/// For a light at the eye |n · e| = 2 / 3 = |n · h|. For one along y |n · l| = 2 / 3 and n · h = 0.
#[test]
fn a_lit_slope_has_the_colour_worked_out_by_hand() {
    let volume = ramp();
    let colors = vec![(0.0, [0.9, 0.5, 0.2])];
    let transfer = TransferFunction::new("slope", colors, vec![(0.0, 0.0), (60.0, 0.0), (60.0, 1.0), (255.0, 1.0)]).unwrap();
    let centre = volume.grid().centre();
    let camera = Camera {
        position: centre - DVec3::new(0.0, 0.0, 100.0),
        focal_point: centre,
        view_up: DVec3::Y,
        projection: Projection::Parallel { scale: 2.0 },
    };
    let light = Light::towards(DVec3::new(-3.0, 0.0, -4.0));
    // 0.1 + 0.5 · 2.2 / 3 of the colour, and a white highlight of 0.4 · 2401 / 8100.
    let expected = [0.9 * 0.466_667 + 0.118_568, 0.5 * 0.466_667 + 0.118_568, 0.2 * 0.466_667 + 0.118_568, 1.0];
    // Exponent 8: 0.4 · (49 / 90)⁴.
    let sharper = [0.42 + 0.035_146, 0.233_333 + 0.035_146, 0.093_333 + 0.035_146, 1.0];
    // With lights at the eye (strength 0.5) and along y (0.25): 0.1 + 0.5 · (2.2 / 3 + 1 / 3 + 0.5 / 3) of the colour, and highlights of
    // 0.4 · (2401 / 8100 + 0.5 · 16 / 81).
    let of_three = [0.645 + 0.158_074, 0.358_333 + 0.158_074, 0.143_333 + 0.158_074, 1.0];
    let three = [light, Light { strength: 0.5, ..Light::AT_CAMERA }, Light { strength: 0.25, ..Light::towards(DVec3::Y) }];
    for settings in evaluations() {
        // Axis-aligned sheets splat voxel colours, whose opacities do not have a simple closed form.
        if settings.algorithm.name() == "axis-sheets" {
            continue;
        }
        for (lights, power, expected) in [(&three[..1], 4.0, expected), (&three[..1], 8.0, sharper), (&three[..], 4.0, of_three)]
        {
            let lights = Lights::new(lights).unwrap();
            let shading = Shading { ambient: 0.1, ambient_color: [1.0; 3], diffuse: 0.5, specular: 0.4, power, lights };
            let settings = Settings { shading: Some(shading), ..settings };
            let frame = render(&volume, &transfer, &camera, viewport(7, 7), &settings);
            let what = format!("{:?}", settings.algorithm);
            for pixel in frame.pixels() {
                let off = (0..4).map(|c| (f64::from(pixel[c]) - expected[c]).abs()).fold(0.0, f64::max);
                assert!(off < TOLERANCE, "{what}: {pixel:?} for {expected:?}, off by {off}");
            }
        }
    }
}

/// Colour at a quarter of the interval between two points of a preset, in the frame and in 8 bits.
#[test]
fn a_preset_has_the_colours_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("presets.json");
    let preset = r#"[{"Name": "other", "RGBPoints": [0,1,1,1], "Points": [0,1,0.5,0]},
        {"Name": "hues", "RGBPoints": [190,0.1,0.5,0.9, 230,0.3,0.1,0.7], "Points": [190,1,0.5,0, 230,1,0.5,0]}]"#;
    std::fs::write(&file, preset).unwrap();
    // Constant, with the same background: otherwise an opaque skin of intermediate values would hide it.
    let volume = volume([8; 3], DVec3::ONE, Voxels::Uint8(vec![200; 512]));
    let size = viewport(9, 9);
    let camera = scaled(parallel(&volume, size, 20.0, 10.0), 1.0);
    let by_name = format!("{}#hues", file.display());
    for transfer in [TransferFunction::from_file(&file, Some("hues")), TransferFunction::open(by_name, &volume)] {
        let transfer = transfer.unwrap();
        for settings in evaluations() {
            let frame = render(&volume, &transfer, &camera, size, &Settings { shading: None, ..settings });
            // Gaussian sheets have colour times opacity to a few per cent only, so compare the quotient.
            let [r, g, b, a] = frame.pixel(4, 4).map(f64::from);
            for (found, expected) in [r / a, g / a, b / a].into_iter().zip([0.15, 0.4, 0.85]) {
                assert!((found - expected).abs() < TOLERANCE, "{:?}: {found} for {expected}", settings.algorithm);
            }
        }
        let frame = render(&volume, &transfer, &camera, size, &Settings { shading: None, ..Settings::default() });
        let bytes = frame.to_rgba8(Background::BLACK);
        // 38.25, 102 and 216.75.
        assert_eq!(bytes[4 * (4 * 9 + 4)..][..4], [38, 102, 217, 255]);
    }
}

/// Per pixel, on a rotated, mirrored and translated grid.
#[test]
fn lights_and_turned_grids_are_the_references() {
    let (dims, spacing) = ([13, 11, 12], DVec3::new(1.0, 0.7, 1.3));
    let turn = DMat3::from_rotation_y(2.1) * DMat3::from_rotation_x(0.6);
    let mirror = DMat3::from_rotation_z(-0.8) * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    let size = viewport(20, 18);
    for (direction, light) in [turn, mirror].into_iter().flat_map(|d| LIGHTS.map(|light| (d, light))) {
        let grid = Grid::oriented(dims, spacing, DVec3::new(-4.0, 9.0, 2.0), direction).unwrap();
        let volume = Volume::new("turned", grid, Voxels::Uint8(random_bytes(dims, 21))).unwrap().with_background(0.0).unwrap();
        for camera in [parallel(&volume, size, 35.0, -15.0), perspective(&volume, 200.0, 25.0, 25.0)] {
            for classification in CLASSIFICATIONS {
                let layered = Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() };
                let right = Settings { shading: lit(light), early_termination: false, ..layered.into() };
                let axis = direct_axis(&volume, &camera, size, &right);
                let expected = LayeredReference::new(&volume, &smooth_transfer(), &right).render(&camera, size, axis).unwrap();
                let found = |settings: &Settings| render(&volume, &smooth_transfer(), &camera, size, settings);
                assert_close(&format!("{light:?}, {layered:?}"), &found(&right), &expected, DEVICE_TOLERANCE);
                let default = found(&Settings { shading: Some(Shading::default()), ..right });
                let noticed = compare(&default, &expected).max_difference > 5.0 * DEVICE_TOLERANCE;
                assert!(noticed, "{light:?}: another light must be noticed");
            }
        }
    }
}
