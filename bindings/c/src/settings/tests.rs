//! Settings: defaults, values that arrive, values that are refused, older versions.

use super::*;
use layersplat::glam::DVec3;
use layersplat::settings::{AmbientOcclusion, LightGrid, LightSpace, Lights};
use std::mem::MaybeUninit;

fn refused(change: impl FnOnce(&mut Settings)) -> String {
    let mut settings = from_quality(Quality::Standard);
    change(&mut settings);
    settings.checked().unwrap_err().message
}

#[test]
fn defaults_are_those_of_the_library() {
    for quality in Quality::ALL {
        assert_eq!(from_quality(quality).checked().unwrap(), quality.settings());
    }
    // SAFETY: null is accepted.
    assert_eq!(unsafe { checked(std::ptr::null()) }.unwrap(), settings::Settings::default());
}

#[test]
fn fields_reach_the_library() {
    let standard = from_quality(Quality::Standard);
    let slicing = Settings { algorithm: AlgorithmChoice::Slicing as i32, step: 0.7, lit: 0, ..standard };
    let expected = settings::Settings { shading: None, ..Algorithm::Slicing { step: 0.7 }.into() };
    assert_eq!(slicing.checked().unwrap(), expected);
    let plane = Plane { point: [1.0; 3], normal: [0.0, 0.0, 2.0] };
    let cut = Settings { plane_count: 1, planes: [plane; 6], blend: BlendChoice::Iso as i32, iso_value: 3.0, ..standard };
    let cut = cut.checked().unwrap();
    assert_eq!((cut.clipping.planes.iter().flatten().count(), cut.blend), (1, Blend::Iso(3.0)));
    let splatted = Settings { splatted: 1, ..standard }.checked().unwrap();
    assert_eq!(splatted.layered().unwrap().classification, Quality::Standard.splatted());
    let side = Light { direction: [1.0, 0.0, 0.0], strength: 0.5 };
    let lit = Settings { light_count: 2, lights: [side, Light { strength: 2.0, ..Light::default() }, side, side], ..standard };
    let lights = lit.checked().unwrap().shading.unwrap().lights;
    let expected = [
        settings::Light { strength: 0.5, ..settings::Light::towards(DVec3::X) },
        settings::Light { strength: 2.0, ..settings::Light::AT_CAMERA },
    ];
    assert_eq!(lights.as_slice(), expected);
    let kernel = Settings { kernel: KernelChoice::CatmullRom as i32, ..standard }.checked().unwrap();
    assert_eq!(
        kernel.layered().unwrap().classification,
        Quality::Standard.layered().classification.with_kernel(Kernel::CatmullRom)
    );
}

/// All fields of the header but the size, each with what its value needs.
#[test]
fn every_field_changes_the_settings() {
    let standard = from_quality(Quality::Standard);
    let side = Light { direction: [1.0, 0.0, 0.0], strength: 0.5 };
    let plane = Plane { point: [1.0; 3], normal: [0.0, 0.0, 2.0] };
    let raycast = Settings { algorithm: AlgorithmChoice::Raycast as i32, ..standard };
    let cropped = Settings { cropped: 1, crop_highest: [9.0; 3], ..standard };
    let (lit, cut) = (Settings { light_count: 1, lights: [side; 4], ..standard }, Settings { plane_count: 1, ..standard });
    let edges = Settings { gradient_point_count: 1, ..standard };
    let gaussian = Settings { gradient: GradientChoice::Gaussian as i32, ..standard };
    let (cued, shadowed) = (Settings { depth_cue: 0.5, ..standard }, Settings { shadows: 1, ..standard });
    let (iso, occluded) = (Settings { blend: 4, ..standard }, Settings { ambient_occlusion: 1, ..standard });
    type Change = fn(&mut Settings);
    let studio = Settings { look: 1, ..standard };
    let all: [(&str, Settings, Change); 48] = [
        ("quality", standard, |s| s.quality = 2),
        ("algorithm", standard, |s| s.algorithm = 4),
        ("kernel", standard, |s| s.kernel = 2),
        ("splatted", standard, |s| s.splatted = 1),
        ("blend", standard, |s| s.blend = 1),
        ("lit", standard, |s| s.lit = 0),
        ("light_count", Settings { light_count: 0, ..lit }, |s| s.light_count = 1),
        ("early_termination", standard, |s| s.early_termination = 0),
        ("cropped", Settings { cropped: 0, ..cropped }, |s| s.cropped = 1),
        ("plane_count", standard, |s| s.plane_count = 1),
        ("gradient_point_count", standard, |s| s.gradient_point_count = 1),
        ("step", raycast, |s| s.step = 0.25),
        ("iso_value", iso, |s| s.iso_value = 3.0),
        ("ambient", standard, |s| s.ambient = 0.5),
        ("diffuse", standard, |s| s.diffuse = 0.5),
        ("specular", standard, |s| s.specular = 0.5),
        ("power", standard, |s| s.power = 5.0),
        ("lights", lit, |s| s.lights[0].strength = 1.0),
        ("unit_distance", standard, |s| s.unit_distance = 2.0),
        ("gradient_opacity", edges, |s| s.gradient_opacity[0] = [1.0, 0.5]),
        ("crop_lowest", cropped, |s| s.crop_lowest = [1.0; 3]),
        ("crop_highest", cropped, |s| s.crop_highest = [8.0; 3]),
        ("planes", cut, |s| s.planes[0].normal[0] = 1.0),
        ("gradient", standard, |s| s.gradient = 1),
        ("gradient_sigma", gaussian, |s| s.gradient_sigma = 0.5),
        ("depth_cue", standard, |s| s.depth_cue = 0.5),
        ("depth_cue_color", cued, |s| s.depth_cue_color = [1.0; 3]),
        ("shadows", standard, |s| s.shadows = 1),
        ("ambient_occlusion", standard, |s| s.ambient_occlusion = 1),
        ("light_grid", standard, |s| s.light_grid = 1),
        ("lights_in_camera_space", lit, |s| s.lights_in_camera_space = 1),
        ("shadow_strength", shadowed, |s| s.shadow_strength = 0.5),
        ("shadow_forgiveness", shadowed, |s| s.shadow_forgiveness = 2.0),
        ("ao_reach", occluded, |s| s.ao_reach = 5.0),
        ("ao_gain", occluded, |s| s.ao_gain = 5.0),
        ("light_angles", lit, |s| s.light_angles[0] = 5.0),
        ("light_colors", lit, |s| s.light_colors[0] = [0.5; 3]),
        ("ambient_color", standard, |s| s.ambient_color = [0.5; 3]),
        ("gamma", standard, |s| s.gamma = 2.0),
        ("look", standard, |s| s.look = 1),
        ("tone", studio, |s| s.tone = 0),
        ("sky_top", studio, |s| s.sky_top = [1.0; 3]),
        ("sky_bottom", studio, |s| s.sky_bottom = [1.0; 3]),
        ("sky_strength", studio, |s| s.sky_strength = 1.0),
        ("scattering", studio, |s| s.scattering = 0.5),
        ("exposure", studio, |s| s.exposure = 1.0),
        ("studio_specular", studio, |s| s.studio_specular = 0.5),
        ("studio_power", studio, |s| s.studio_power = 5.0),
    ];
    for (name, beside, change) in &all {
        let mut changed = Settings { planes: if *name == "planes" { beside.planes } else { [plane; 6] }, ..*beside };
        let before = changed.checked().unwrap();
        change(&mut changed);
        assert_ne!(changed.checked().unwrap(), before, "{name}");
    }
    let header = include_str!("../../include/layersplat.h");
    let (_, fields) = header.split_once("typedef struct layersplat_settings {").unwrap();
    let (fields, _) = fields.split_once("} layersplat_settings;").unwrap();
    let names = fields.lines().filter_map(|line| line.trim().strip_suffix(';')?.split(' ').next_back());
    let names = names.map(|name| name.split('[').next().unwrap()).filter(|&name| name != "size");
    let names: Vec<_> = names.collect();
    assert_eq!(names.len(), all.len(), "{names:?}");
    assert!(names.iter().all(|name| all.iter().any(|(known, ..)| known == name)), "{names:?}");
}

#[test]
fn shadows_and_ambient_occlusion_reach_the_library() {
    let standard = from_quality(Quality::Standard);
    let shadowed = Settings { shadows: 1, shadow_strength: 0.5, shadow_forgiveness: 2.0, light_grid: 1, ..standard };
    let found = shadowed.checked().unwrap();
    assert_eq!(found.shadows, Some(Shadows { strength: 0.5, forgiveness: 2.0 }));
    assert_eq!((found.light_grid, found.ambient_occlusion), (LightGrid::Half, None));
    assert_eq!(found.shading.unwrap().lights, Lights::BESIDE_CAMERA);
    // A given light at the camera stays there.
    let headlight = Settings { light_count: 1, lights: [Light { strength: 1.0, ..Light::default() }; 4], ..shadowed };
    assert_eq!(headlight.checked().unwrap().shading.unwrap().lights, Lights::AT_CAMERA);

    let occluded = |ao_reach| Settings { ambient_occlusion: 1, ao_reach, light_grid: 2, ..standard }.checked().unwrap();
    for (given, reach) in [(0.0, None), (f64::INFINITY, None), (7.5, Some(7.5)), (-1.0, Some(-1.0))] {
        assert_eq!(occluded(given).ambient_occlusion, Some(AmbientOcclusion { reach, ..AmbientOcclusion::default() }));
    }
    let brighter = Settings { ambient_occlusion: 1, ao_gain: 5.0, ..standard }.checked().unwrap();
    assert_eq!(brighter.ambient_occlusion, Some(AmbientOcclusion { reach: None, gain: 5.0 }));
    assert_eq!((occluded(0.0).light_grid, occluded(0.0).shadows), (LightGrid::Quarter, None));
    assert_eq!(occluded(0.0).shading.unwrap().lights, Lights::AT_CAMERA);
}

#[test]
fn axes_angles_and_colors_of_lights_reach_the_library() {
    let side = Light { direction: [1.0, 2.0, 3.0], strength: 0.5 };
    let lights = [side, Light { strength: 2.0, ..Light::default() }, side, side];
    let light_colors = [[1.0, 0.5, 0.0], [1.0; 3], [9.0; 3], [9.0; 3]];
    let standard =
        Settings { light_count: 2, lights, light_angles: [5.0, 7.0, 99.0, 0.0], light_colors, ..from_quality(Quality::Standard) };
    for (lights_in_camera_space, space) in [(0, LightSpace::World), (1, LightSpace::Camera)] {
        let found = Settings { lights_in_camera_space, ..standard }.checked().unwrap().shading.unwrap().lights;
        let direction = Some(DVec3::new(1.0, 2.0, 3.0));
        let expected = [
            settings::Light { direction, space, strength: 0.5, angle: 5.0, color: [1.0, 0.5, 0.0] },
            settings::Light { direction: None, space: LightSpace::World, strength: 2.0, angle: 7.0, color: [1.0; 3] },
        ];
        assert_eq!(found.as_slice(), expected);
    }
}

/// Words after the settings of an older version, which must stay unchanged.
const BEHIND: u64 = 0x5a5a_5a5a_5a5a_5a5a;

#[test]
fn the_first_version_is_still_accepted() {
    // Programs compiled with its header pass this size.
    #[cfg(target_pointer_width = "64")]
    assert_eq!(FIRST_VERSION, 752);
    let words = FIRST_VERSION / size_of::<u64>();
    let mut memory = vec![BEHIND; size_of::<Settings>() / size_of::<u64>()];
    let settings: *mut Settings = memory.as_mut_ptr().cast();
    // SAFETY: there is memory of `FIRST_VERSION` bytes, and of a whole struct.
    unsafe {
        assert_eq!(layersplat_settings_default(Quality::High as i32, settings, FIRST_VERSION), Status::Ok);
        assert_eq!((&raw const (*settings).size).read(), FIRST_VERSION);
        (&raw mut (*settings).power).write(7.0);
        let found = checked(settings).unwrap();
        let mut expected = Quality::High.settings();
        expected.shading.as_mut().unwrap().power = 7.0;
        assert_eq!(found, expected);
        // With the size of this version, what is behind the settings counts.
        (&raw mut (*settings).size).write(size_of::<Settings>());
        assert!(checked(settings).unwrap_err().message.contains(&(BEHIND as u32).to_string()));
    }
    assert!(words < memory.len() && memory[words..].iter().all(|&word| word == BEHIND));
}

#[test]
fn other_sizes_are_rejected() {
    let complete = size_of::<Settings>();
    for size in [0, size_of::<usize>(), FIRST_VERSION - 8, FIRST_VERSION + 8, complete - 8, complete + 8] {
        let mut settings = MaybeUninit::<Settings>::uninit();
        // SAFETY: nothing but the size is read, and nothing is written.
        unsafe {
            assert_eq!(layersplat_settings_default(1, settings.as_mut_ptr(), size), Status::InvalidArgument);
            (&raw mut (*settings.as_mut_ptr()).size).write(size);
            let message = checked(settings.as_ptr()).unwrap_err().message;
            let known = VERSIONS.map(|size| size.to_string()).join(" or ");
            assert!(message.contains(&format!("{size} bytes, and this version of layersplat expects {known}")), "{message}");
        }
    }
}

#[test]
fn invalid_numbers_are_rejected() {
    assert_eq!(refused(|s| s.quality = 9), "quality is 9: expected 0 (draft), 1 (standard), 2 (high), 3 (paper)");
    assert!(refused(|s| s.algorithm = -1).starts_with("algorithm is -1: expected 0 (layered), 1 (axis-sheets)"));
    assert!(refused(|s| s.blend = 5).starts_with("blend is 5: expected 0 (composite)"));
    assert!(
        refused(|s| s.kernel = 6)
            .ends_with("expected 0 (default), 1 (cubic), 2 (linear), 3 (catmull-rom), 4 (bspline), 5 (gaussian)")
    );
    assert!(refused(|s| s.lit = 2).contains("lit is 2"));
    assert!(refused(|s| s.plane_count = 7).contains("0 to 6"));
    assert!(refused(|s| s.plane_count = -1).contains("-1"));
    assert!(refused(|s| s.light_count = 5).contains("0 to 4"));
    assert!(refused(|s| (s.light_count, s.lights[0].strength) = (1, -1.0)).contains("0 to 100"));
    let sheets = |s: &mut Settings| (s.kernel, s.algorithm) = (1, AlgorithmChoice::ViewSheets as i32);
    assert!(refused(sheets).contains("no meaning for view-sheets"));
    assert_eq!(refused(|s| s.light_grid = 3), "light_grid is 3: expected 0 (full), 1 (half), 2 (quarter)");
    assert!(refused(|s| s.shadows = 2).contains("shadows is 2"));
    assert!(refused(|s| s.ambient_occlusion = -1).contains("ambient_occlusion is -1"));
    assert!(refused(|s| s.lights_in_camera_space = 2).contains("lights_in_camera_space is 2"));
    let one = |s: &mut Settings| (s.light_count, s.lights[0].strength, s.light_angles[0]) = (1, 1.0, 46.0);
    assert!(refused(one).contains("0 to 45 degrees"));
}
