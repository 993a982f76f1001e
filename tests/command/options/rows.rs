//! Table of the options of `layersplat render` and their effects.

use super::scene::{Scene, Transfer};
use super::{HEADER, SECOND};
use crate::common::*;
use glam::DVec3;
use layersplat::camera::Up;
use layersplat::layers::{Axis, Kernel};
use layersplat::settings::{
    Algorithm, AmbientOcclusion, Blend, Classification, ClipPlane, Clipping, CropBox, DepthCue, Evaluation, Footprints,
    GradientOpacity, LayerAxis, Light, LightGrid, LightSpace, Lights, Look, Quality, Shading, Shadows, Sky, Studio,
};
use layersplat::transfer::Extinction;
use layersplat::volume::{Endian, Grid, ScalarType};
use layersplat::{Background, Correction, Density, GradientEstimator, Orbit, Settings, TransferFunction, Volume};

/// An option with its prerequisites.
pub struct Row {
    /// Name as in the help.
    pub option: &'static str,
    /// Other arguments, and their effect.
    pub beside: (&'static str, fn(&mut Scene)),
    /// The option with its value, and its effect.
    pub given: (&'static str, fn(&mut Scene)),
}

/// Enables shadows of the light that stands beside the camera.
fn cast_shadows(scene: &mut Scene, shadows: Shadows) {
    scene.settings.shading = Some(Shading { lights: Lights::BESIDE_CAMERA, ..Shading::default() });
    scene.settings.shadows = Some(shadows);
}

/// Lights the scene as the studio does.
fn set_studio(scene: &mut Scene, studio: Studio) {
    scene.settings = Settings { studio: Some(studio), ..scene.settings.with_look(Look::Studio) };
}

/// A row without other arguments.
const fn row(option: &'static str, given: &'static str, change: fn(&mut Scene)) -> Row {
    beside("", |_| (), option, given, change)
}

const fn beside(
    others: &'static str,
    before: fn(&mut Scene),
    option: &'static str,
    given: &'static str,
    change: fn(&mut Scene),
) -> Row {
    Row { option, beside: (others, before), given: (given, change) }
}

/// Volume, transfer function and camera.
pub const SCENES: &[Row] = &[
    row("VOLUME", "", |s| s.source = "builtin:marschner-lobb@12"),
    beside("", |s| s.source = "builtin:cube@64", "VOLUME", "", |s| s.source = "builtin:hydrogen"),
    row("--dims", "--dims 10x12x14", |s| s.raw.dims = Some([10, 12, 14])),
    row("--type", "--type int8", |s| s.raw.voxel_type = Some(ScalarType::Int8)),
    row("--spacing", "--spacing 1,2.5,2.5", |s| s.raw.spacing = Some(DVec3::new(1.0, 2.5, 2.5))),
    // A plane of the world cuts the moved volume elsewhere.
    beside(
        "--clip 6,5,4,1,-2,-0.5",
        |s| s.settings.clipping = Clipping::default().with_planes([plane()]),
        "--origin",
        "--origin 3,1,0",
        |s| s.raw.origin = Some(DVec3::new(3.0, 1.0, 0.0)),
    ),
    // Slices at another distance than their pixels stand upright.
    row("--spacing", "--spacing 1,2.5,0.75", |s| (s.raw.spacing, s.up) = (Some(DVec3::new(1.0, 2.5, 0.75)), Up::Z)),
    beside(
        "--spacing 1,2.5,0.75",
        |s| (s.raw.spacing, s.up) = (Some(DVec3::new(1.0, 2.5, 0.75)), Up::Z),
        "--up",
        "--up y",
        |s| {
            s.up = Up::Y;
        },
    ),
    beside("", |s| s.source = super::WIDE_VOLUME, "--endian", "--endian big", |s| s.raw.endian = Some(Endian::Big)),
    // Skips the first slice instead of the last.
    beside(
        "--dims 14x12x9",
        |s| s.source = super::SLICE_LESS,
        "--header-bytes",
        "--header-bytes 168",
        |s| (s.source, s.raw.dims, s.raw.header_bytes) = (super::VOLUME, Some([14, 12, 9]), Some(HEADER)),
    ),
    row("--surface", "--surface sphere.ply,radius=4", |s| s.sphere = Some((DVec3::new(7.0, 6.0, 4.0), 4.0))),
    row("--background-value", "--background-value 120.5", |s| s.background_value = Some(120.5)),
    row("--background-value", "--background-value -60", |s| s.background_value = Some(-60.0)),
    row("--transfer", "--transfer viridis", |s| s.transfer = Transfer::Named("viridis")),
    row("--palette", "--palette vivid", |s| s.transfer = Transfer::Palette("vivid")),
    row("--preset", "--preset ct-bone", |s| s.transfer = Transfer::Preset("ct-bone")),
    row("--transfer", "--transfer two.json#second", |s| s.transfer = Transfer::Made(second)),
    beside(
        "--transfer two.json",
        |s| s.transfer = Transfer::Made(first),
        "--transfer",
        "--transfer two.json#second",
        |s| s.transfer = Transfer::Made(second),
    ),
    row("--transfer-range", "--transfer-range -20,140", |s| s.transfer_range = Some((-20.0, 140.0))),
    row("--transfer-range", "--transfer-range p10,p90.5", |s| s.transfer_range = Some((percentile(10.0), percentile(90.5)))),
    row("--opacity", "--opacity 20:0,90.5:0.7,90.5:0.1,200:0.4", |s| {
        s.shaped = |t| t.with_opacities(vec![(20.0, 0.0), (90.5, 0.7), (90.5, 0.1), (200.0, 0.4)]).unwrap();
    }),
    row("--opacity", "--opacity p25:0,p99.5:0.6", |s| {
        s.shaped = |t| t.with_opacities(vec![(percentile(25.0), 0.0), (percentile(99.5), 0.6)]).unwrap();
    }),
    row("--window", "--window 150,80", |s| s.shaped = |t| t.windowed(150.0, 80.0).unwrap()),
    row("--window", "--window p60,90", |s| s.shaped = |t| t.windowed(percentile(60.0), 90.0).unwrap()),
    row("--tent", "--tent 120,30", |s| s.shaped = |t| t.faded(0.0).unwrap().with_tent(120.0, 30.0, 0.5).unwrap()),
    beside(
        "--tent p20,10 --opacity 200:0,255:0.3",
        |s| s.shaped = one_tent,
        "--tent",
        "--tent 120,30,0.9",
        |s| s.shaped = |t| one_tent(t).with_tent(120.0, 30.0, 0.9).unwrap(),
    ),
    // With one angle, the others are 0.
    row("--azimuth", "--azimuth 35", |s| s.orbit = Orbit { azimuth: 35.0, ..Orbit::default() }),
    row("--elevation", "--elevation -25", |s| s.orbit = Orbit { elevation: -25.0, ..Orbit::default() }),
    row("--roll", "--roll 40", |s| s.orbit = Orbit { roll: 40.0, ..Orbit::default() }),
    row("--roll", "--roll 0", |s| s.orbit = Orbit::default()),
    row("--up", "--up -x", |s| s.up = Up::NegativeX),
    row("--up", "--up z", |s| s.up = Up::Z),
    row("--from", "--from left", |s| s.orbit = Orbit { azimuth: 270.0, ..Orbit::default() }),
    beside(
        "--up z --roll 10",
        |s| (s.up, s.orbit) = (Up::Z, Orbit { roll: 10.0, ..Orbit::default() }),
        "--from",
        "--from above",
        |s| {
            s.orbit.elevation = 90.0;
        },
    ),
    row("--fit", "--fit volume", |s| s.whole = true),
    row("--parallel-scale", "--parallel-scale 4.5", |s| s.fixed.scale = Some(4.5)),
    row("--perspective", "--perspective 50", |s| s.field_of_view = Some(50.0)),
    beside(
        "--perspective 50",
        |s| s.field_of_view = Some(50.0),
        "--distance",
        "--distance 30",
        |s| {
            s.fixed.distance = Some(30.0);
        },
    ),
    beside("--perspective 50 --fit volume", of_all_in_perspective, "--distance", "--distance 30", |s| {
        s.fixed.distance = Some(30.0);
    }),
    beside("--fit volume", |s| s.whole = true, "--parallel-scale", "--parallel-scale 4.5", |s| s.fixed.scale = Some(4.5)),
    beside("--fit volume", |s| s.whole = true, "--center", "--center 9,-1,5.5", |s| s.fixed.centre = Some(CENTRE)),
    row("--center", "--center 9,-1,5.5", |s| s.fixed.centre = Some(CENTRE)),
    row("--size", "--size 20x44", |s| s.size = viewport(20, 44)),
    row("--background", "--background #204060", |s| s.background = "#204060".parse().ok()),
    row("--background", "--background 1,0,0.5", |s| s.background = Some(Background::Color([1.0, 0.0, 0.5]))),
    row("--samples", "--samples 3", |s| s.samples = 3),
    row("--box", "--box", |s| s.annotations.bounding_box = true),
    row("--axes", "--axes", |s| s.annotations.axes = true),
    beside(
        "--background #e0f0ff",
        |s| s.background = "#e0f0ff".parse().ok(),
        "--legend",
        "--legend",
        |s| {
            s.annotations.legend = true;
        },
    ),
    beside("--legend --size 120x90", large_legend, "--legend-place", "--legend-place over", |s| s.over = true),
    beside("--legend --size 120x90", large_legend, "--units", "--units HU", |s| s.annotations.units = Some("HU".into())),
    beside("--legend --size 120x90", large_legend, "--length-units", "--length-units mm", |s| {
        s.annotations.length_units = Some("mm".into());
    }),
];

/// Algorithm and quality.
pub const QUALITIES: &[Row] = &[
    row("--algorithm", "--algorithm axis-sheets", |s| {
        s.settings.algorithm = Algorithm::AxisSheets { layer_axis: LayerAxis::Auto };
    }),
    row("--algorithm", "--algorithm view-sheets", view_sheets),
    row("--algorithm", "--algorithm slicing", slicing),
    row("--algorithm", "--algorithm raycast", raycast),
    beside("--algorithm view-sheets", view_sheets, "--sheet-distance", "--sheet-distance 0.5", |s| {
        s.settings.algorithm = Algorithm::ViewSheets { sheet_distance: 0.5 };
    }),
    beside("--algorithm slicing", slicing, "--step", "--step 2", |s| s.settings.algorithm = Algorithm::Slicing { step: 2.0 }),
    beside("--algorithm raycast", raycast, "--step", "--step 2", |s| {
        s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::Linear, step: 2.0 };
    }),
    beside("--algorithm raycast", raycast, "--kernel", "--kernel cubic", |s| {
        s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 };
    }),
    beside("--algorithm raycast", raycast, "--kernel", "--kernel gaussian", |s| {
        s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::Gaussian, step: 0.5 };
    }),
    beside("--algorithm raycast", raycast, "--kernel", "--kernel bspline", |s| {
        s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::BSpline, step: 0.5 };
    }),
    // Former name of the option.
    beside("--algorithm raycast", raycast, "--kernel", "--interpolation tricubic", |s| {
        s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 };
    }),
    row("--kernel", "--kernel linear", |s| s.settings = with_kernel(Quality::Standard, Kernel::Linear).into()),
    row("--kernel", "--kernel catmull-rom", |s| s.settings = with_kernel(Quality::Standard, Kernel::CatmullRom).into()),
    row("--kernel", "--kernel bspline", |s| s.settings = with_kernel(Quality::Standard, Kernel::BSpline).into()),
    beside(
        "--quality high",
        |s| s.settings = Quality::High.settings(),
        "--kernel",
        "--kernel cubic",
        |s| s.settings = with_kernel(Quality::High, Kernel::Cubic).into(),
    ),
    row("--quality", "--quality draft", |s| s.settings = Quality::Draft.settings()),
    row("--quality", "--quality high", |s| s.settings = Quality::High.settings()),
    row("--quality", "--quality paper", |s| s.settings = Quality::Paper.settings()),
    row("--classification", "--classification post", |s| s.layered(|l| l.classification = SPLATTED)),
    row("--correction", "--correction none", |s| s.layered(|l| l.classification = Classification::Post(Correction::None))),
    beside("--classification post", post, "--correction", "--correction constant", |s| {
        s.layered(|l| l.classification = Classification::Post(Correction::Constant));
    }),
    beside("--quality draft --classification post", draft_splats, "--correction", "--correction sublayers", post),
    row("--sublayers", "--sublayers 3", |s| {
        s.layered(|l| l.classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 3 });
    }),
    beside("--classification post", post, "--sublayers", "--sublayers 5", |s| {
        s.layered(|l| l.classification = Classification::Post(Correction::SubLayers(5)));
    }),
    row("--extinction", "--extinction linear", |s| s.settings.extinction = Extinction::Linear),
    row("--shading", "--shading off", |s| s.settings.shading = None),
    row("--light", "--light -1,0.5,0.25", |s| {
        s.settings.shading = Some(Shading { lights: one_light(DVec3::new(-1.0, 0.5, 0.25)), ..Shading::default() });
    }),
    beside(
        "--light -1,0.5,0.25",
        |s| s.settings.shading = Some(Shading { lights: one_light(DVec3::new(-1.0, 0.5, 0.25)), ..Shading::default() }),
        "--light",
        "--light camera:0.4",
        |s| {
            let lights = [Light::towards(DVec3::new(-1.0, 0.5, 0.25)), Light { strength: 0.4, ..Light::AT_CAMERA }];
            s.settings.shading = Some(Shading { lights: Lights::new(&lights).unwrap(), ..Shading::default() });
        },
    ),
    beside(
        "--light -1,0.5,0.25",
        |s| s.settings.shading = Some(Shading { lights: one_light(DVec3::new(-1.0, 0.5, 0.25)), ..Shading::default() }),
        "--light-space",
        "--light-space camera",
        |s| {
            let lights = Lights::new(&[Light::from_camera(DVec3::new(-1.0, 0.5, 0.25))]).unwrap();
            s.settings.shading = Some(Shading { lights, ..Shading::default() });
        },
    ),
    row("--light", "--light 0.5,1,0.25:0.8:#ff8000", |s| {
        let light = Light { strength: 0.8, color: [1.0, 128.0 / 255.0, 0.0], ..Light::towards(DVec3::new(0.5, 1.0, 0.25)) };
        s.settings.shading = Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() });
    }),
    row("--ambient-color", "--ambient-color 0.2,1,0.5", |s| {
        s.settings.shading = Some(Shading { ambient_color: [0.2, 1.0, 0.5].map(|c| f64::from(c as f32)), ..Shading::default() });
    }),
    row("--shadows", "--shadows on", |s| cast_shadows(s, Shadows::default())),
    beside(
        "--shadows on",
        |s| cast_shadows(s, Shadows::default()),
        "--shadow-strength",
        "--shadow-strength 0.5",
        |s| {
            cast_shadows(s, Shadows { strength: 0.5, ..Shadows::default() });
        },
    ),
    beside(
        "--shadows on",
        |s| cast_shadows(s, Shadows::default()),
        "--shadow-forgiveness",
        "--shadow-forgiveness 1",
        |s| {
            cast_shadows(s, Shadows { forgiveness: 1.0, ..Shadows::default() });
        },
    ),
    beside(
        "--shadows on",
        |s| cast_shadows(s, Shadows::default()),
        "--light-grid",
        "--light-grid half",
        |s| {
            cast_shadows(s, Shadows::default());
            s.settings.light_grid = LightGrid::Half;
        },
    ),
    row("--ambient-occlusion", "--ambient-occlusion on", |s| s.settings.ambient_occlusion = Some(AmbientOcclusion::default())),
    beside(
        "--ambient-occlusion on",
        |s| s.settings.ambient_occlusion = Some(AmbientOcclusion::default()),
        "--ao-reach",
        "--ao-reach 3",
        |s| s.settings.ambient_occlusion = Some(AmbientOcclusion { reach: Some(3.0), ..AmbientOcclusion::default() }),
    ),
    row("--look", "--look studio", |s| set_studio(s, Studio::default())),
    beside(
        "--look studio",
        |s| set_studio(s, Studio::default()),
        "--sky",
        "--sky white,#000000:0.5",
        |s| {
            // Up is that of the volume.
            let (up, space) = (DVec3::Y, LightSpace::World);
            let sky = Sky { top: [1.0; 3], bottom: [0.0; 3], strength: 0.5, up, space };
            set_studio(s, Studio { sky, ..Studio::default() });
        },
    ),
    beside(
        "--look studio",
        |s| set_studio(s, Studio::default()),
        "--sky-up",
        "--sky-up 1,0,2",
        |s| {
            let sky = Sky { up: DVec3::new(1.0, 0.0, 2.0), ..Sky::default().up_in(LightSpace::World) };
            set_studio(s, Studio { sky, ..Studio::default() });
        },
    ),
    beside(
        "--look studio",
        |s| set_studio(s, Studio::default()),
        "--scattering",
        "--scattering 0.25",
        |s| {
            set_studio(s, Studio { scattering: 0.25, ..Studio::default() });
        },
    ),
    row("--gradient", "--gradient central", |s| s.settings.gradient = Some(GradientEstimator::Central)),
    row("--gradient-opacity", "--gradient-opacity 2:0,9:0.75", |s| {
        s.settings.gradient_opacity = Some(GradientOpacity::new(&[(2.0, 0.0), (9.0, 0.75)]).unwrap());
    }),
    row("--depth-cue", "--depth-cue 0.75", |s| {
        s.settings.depth_cue = Some(DepthCue { strength: 0.75, ..DepthCue::default() });
    }),
    beside(
        "--background #e0f0ff",
        |s| s.background = "#e0f0ff".parse().ok(),
        "--depth-cue",
        "--depth-cue 1",
        |s| {
            s.settings.depth_cue =
                Some(DepthCue { strength: 1.0, color: [0xe0, 0xf0, 0xff].map(|c| f64::from(c as f32 / 255.0)) })
        },
    ),
    // Along an axis: at the default view, the lattice has a sample per pixel.
    beside(
        "--azimuth 0",
        |s| s.orbit = Orbit::default(),
        "--lattice",
        "--lattice direct",
        |s| {
            s.layered(|l| l.evaluation = Evaluation::Direct);
        },
    ),
    row("--lattice", "--lattice 1", |s| s.layered(|l| l.evaluation = Evaluation::Lattice(Density::Fixed(1)))),
    beside("--lattice direct --classification post", direct_splats, "--footprints", "--footprints set", |s| {
        s.layered(|l| l.footprints = Footprints::Set);
    }),
    beside(
        "--azimuth 40",
        |s| s.orbit = Orbit { azimuth: 40.0, ..Orbit::default() },
        "--layer-axis",
        "--layer-axis x",
        |s| {
            s.layered(|l| l.layer_axis = LayerAxis::Forced(Axis::X));
        },
    ),
    row("--unit-distance", "--unit-distance 3", |s| s.settings.unit_distance = Some(3.0)),
    // Opacities apply to ten units per voxel.
    beside(
        "--unit-distance 0.1",
        |s| s.settings.unit_distance = Some(0.1),
        "--early-termination",
        "--early-termination off",
        |s| s.settings.early_termination = false,
    ),
    row("--blend", "--blend maximum", |s| s.settings.blend = Blend::Maximum),
    row("--blend", "--blend minimum", |s| s.settings.blend = Blend::Minimum),
    row("--blend", "--blend average", |s| s.settings.blend = Blend::Average),
    row("--blend", "--blend iso --iso 130", |s| s.settings.blend = Blend::Iso(130.0)),
    // An iso-surface has no default value, so compare two values.
    beside(
        "--blend iso",
        |s| s.settings.blend = Blend::Iso(130.0),
        "--iso",
        "--iso 90.5",
        |s| {
            s.settings.blend = Blend::Iso(90.5);
        },
    ),
    row("--iso", "--iso 130", |s| s.settings.blend = Blend::Iso(130.0)),
    row("--iso-color", "--iso 130 --iso-color #804020", |s| {
        s.settings.blend = Blend::Iso(130.0);
        s.transfer = Transfer::Made(brown);
    }),
    row("--mip", "--mip", |s| s.settings.blend = Blend::Maximum),
    row("--minip", "--minip", |s| s.settings.blend = Blend::Minimum),
    row("--blend", "--blend Iso --iso p60", |s| s.settings.blend = Blend::Iso(percentile(60.0))),
    row("--crop", "--crop 2:9.5,:6,3:", |s| {
        let (lowest, highest) = (DVec3::new(2.0, f64::NEG_INFINITY, 3.0), DVec3::new(9.5, 6.0, f64::INFINITY));
        s.settings.clipping.crop = Some(CropBox { lowest, highest });
    }),
    row("--clip", "--clip 6,5,4,1,-2,-0.5", |s| s.settings.clipping = Clipping::default().with_planes([plane()])),
    beside(
        "--clip 6,5,4,1,-2,-0.5",
        |s| s.settings.clipping = Clipping::default().with_planes([plane()]),
        "--clip",
        "--clip 4,3,4,-1,0,0.25",
        |s| {
            let second = ClipPlane { point: DVec3::new(4.0, 3.0, 4.0), normal: DVec3::new(-1.0, 0.0, 0.25) };
            s.settings.clipping = Clipping::default().with_planes([plane(), second]);
        },
    ),
];

/// The colour #804020, as a transfer function.
fn brown() -> TransferFunction {
    TransferFunction::new("brown", vec![(0.0, [128.0, 64.0, 32.0].map(|c| f64::from((c / 255.0) as f32)))], vec![(0.0, 1.0)])
        .unwrap()
}

/// Options that cannot change a picture, with the reason.
pub const UNCHANGED: &[(&str, &str)] = &[
    ("--device", "every device gives the same picture; a separate test asserts the selected device"),
    ("--device-unchecked", "says whether a device that draws wrongly is refused; tests/command/device_checks.rs has one"),
    ("--memory", "streams larger volumes, to the same bits; a separate test asserts that"),
    ("--time-limit", "aborts slower renders, without other effects; a separate test asserts that"),
    ("--cameras", "is many pictures; tests/command_sequences/many.rs has some"),
    ("--frame", "chooses one of several volumes, which raw files have not; tests/command/volumes.rs has files that do"),
    ("--channel", "chooses one of several numbers per voxel; tests/command/volumes.rs"),
    ("--channels", "draws several numbers per voxel; tests/command/channels.rs"),
    ("--with", "draws several volumes; tests/command/channels.rs"),
    ("--scene", "draws several volumes; tests/command/channels.rs"),
    ("--field", "changes one of several volumes; tests/command/channels.rs"),
    ("--colors", "draws numbers of voxels as colours; tests/command/channels.rs"),
    ("--color-opacity", "draws numbers of voxels as colours; tests/command/channels.rs"),
    ("--labels", "draws labels; tests/command/channels.rs"),
    ("--mask", "draws voxels within labels; tests/command/channels.rs"),
    ("--label-colors", "draws the colours of labels; tests/command/channels.rs"),
    ("--label", "draws labels; tests/command/channels.rs"),
    ("--label-surfaces", "draws labels; tests/command/channels.rs"),
    ("--series", "chooses one of several series of DICOM images; tests/command/volumes.rs"),
    ("--level", "chooses one of several resolutions; tests/command/volumes.rs"),
    ("--oversample", "reads a finer level; tests/command/urls.rs"),
    ("--region", "reads a part of a Zarr; tests/command/urls.rs"),
    ("--download", "bounds what a URL may have; tests/command/urls.rs"),
    ("--no-cache", "of URLs, whose answers it does not keep; tests/command/urls.rs"),
    ("--missing", "of URLs whose server refuses chunks; tests/command/urls.rs"),
    ("--array", "chooses one of several arrays; tests/command/volumes.rs"),
    ("--output", "says where the picture goes; a test of its own looks there"),
    ("--depth", "writes depths beside the picture; tests/command/pictures.rs has some"),
    ("--bits", "says how a file is encoded; tests/command/pictures.rs reads some"),
    ("--dither", "says how a file is encoded; tests/command/pictures.rs"),
    ("--gamma", "changes pictures of 8 and 16 bits, not floats; tests/command/pictures.rs"),
    ("--exposure", "changes pictures of 8 and 16 bits, not floats; tests/command/pictures.rs"),
    ("--tone", "changes pictures of 8 and 16 bits, not floats; tests/command/pictures.rs"),
    ("--dpi", "says how a file is encoded; tests/command/pictures.rs"),
    ("--font-size", "needs --dpi, which NumPy files refuse; src/host/annotation/tests.rs and tests/command/pictures.rs"),
    ("--legend-only", "writes the colour bar instead of a picture; tests/command/pictures.rs"),
    ("--no-metadata", "says what a file holds beside the picture; tests/command_line has a test"),
    ("--fail-empty", "changes the exit code of empty pictures; tests/command_line has a test"),
    ("--json", "says what is printed; a test of its own reads it"),
    ("--verbose", "says what is told; a test of tests/command/output.rs reads it"),
    ("--help", "prints, and renders nothing"),
    ("--version", "prints, and renders nothing"),
];

const CENTRE: DVec3 = DVec3::new(9.0, -1.0, 5.5);

fn large_legend(s: &mut Scene) {
    (s.annotations.legend, s.size) = (true, viewport(120, 90));
}

/// Percentile of the default volume's voxels.
fn percentile(percent: f64) -> f64 {
    let grid = Grid::new([14, 12, 10], DVec3::ONE).unwrap();
    // Histograms of bytes are exact.
    Volume::new("t", grid, super::random_bytes([14, 12, 10], 7)).unwrap().statistics().quantile(percent / 100.0)
}

/// A triangular peak over a ramp.
fn one_tent(transfer: TransferFunction) -> TransferFunction {
    transfer.with_opacities(vec![(200.0, 0.0), (255.0, 0.3)]).unwrap().with_tent(percentile(20.0), 10.0, 0.5).unwrap()
}

fn of_all_in_perspective(s: &mut Scene) {
    (s.whole, s.field_of_view) = (true, Some(50.0));
}

fn view_sheets(s: &mut Scene) {
    s.settings.algorithm = Algorithm::ViewSheets { sheet_distance: 1.0 };
}

fn slicing(s: &mut Scene) {
    s.settings.algorithm = Algorithm::Slicing { step: 1.0 };
}

fn raycast(s: &mut Scene) {
    s.settings.algorithm = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 };
}

/// Classification after interpolation, with the two sub-layers of the default quality.
fn post(s: &mut Scene) {
    s.layered(|l| l.classification = SPLATTED);
}

fn draft_splats(s: &mut Scene) {
    s.settings = Settings::from(Quality::Draft.layered());
    s.layered(|l| l.classification = Classification::Post(Correction::Constant));
}

fn direct_splats(s: &mut Scene) {
    s.layered(|l| (l.evaluation, l.classification) = (Evaluation::Direct, SPLATTED));
}

fn plane() -> ClipPlane {
    ClipPlane { point: DVec3::new(6.0, 5.0, 4.0), normal: DVec3::new(1.0, -2.0, -0.5) }
}

/// First preset of the file.
fn first() -> TransferFunction {
    TransferFunction::new("first", vec![(0.0, [0.1, 0.9, 0.5]), (255.0, [0.7, 0.2, 1.0])], vec![(0.0, 0.0), (255.0, 0.4)])
        .unwrap()
}

/// Second preset of the file.
fn second() -> TransferFunction {
    let [from, to] = SECOND;
    TransferFunction::new("second", vec![(20.0, from), (200.0, to)], vec![(60.0, 0.0), (180.0, 0.8)]).unwrap()
}
