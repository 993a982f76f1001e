//! Depth cueing in all algorithms: closed forms, the f64 reference, parts of volumes.

use crate::common::blends::{
    ISO, VALUES, algorithms, composited, compositing, crop, cuts, has, settings, tolerance, tolerance_of,
};
use crate::common::reference::Pair;
use crate::common::*;
use glam::DVec3;
use layersplat::device::{LatticeSchedule, Tuning};
use layersplat::layers::Kernel;
use layersplat::renderer::{PartRenderer, StreamedRenderer};
use layersplat::settings::{Algorithm, Blend, Clipping, DepthCue};
use layersplat::volume::Voxels;
use layersplat::{Camera, Error, Frame, Settings, TransferFunction, Volume};

/// A dozen roundings of floats between 0 and 1, and a place between samples that is rounded to 2^-17 voxels.
const FLOATS: f64 = 2e-5;
/// Least share of rays that a wrong fade changes: 30 times the share of rays at rims that may differ.
const NOTICED: f64 = 0.1;
/// Strong enough for samples to change, and a colour that each channel fades to differently.
const CUE: DepthCue = DepthCue { strength: 0.8, color: [0.1, 0.9, 0.4] };

fn cued(settings: Settings) -> Settings {
    Settings { depth_cue: Some(CUE), ..settings }
}

/// Each algorithm, lit and unlit.
fn each() -> impl Iterator<Item = Settings> {
    let all = compositing().into_iter().map(|algorithm| composited(algorithm, Clipping::default()));
    all.flat_map(|settings| [settings, Settings { shading: None, ..settings }])
}

fn surfaces() -> impl Iterator<Item = Settings> {
    algorithms().into_iter().filter(|&a| has(a, Blend::Iso(ISO))).map(|a| settings(a, Blend::Iso(ISO)))
}

fn scene() -> (Volume<'static>, [Camera; 2]) {
    let volume = random_volume([14, 11, 12], DVec3::new(1.0, 0.7, 1.3), 21);
    let views = [parallel(&volume, viewport(25, 22), 25.0, -15.0), perspective(&volume, 200.0, 30.0, 35.0)];
    (volume, views)
}

/// Compares with the reference, and shows that another strength, no fade and another colour would be noticed.
fn assert_fades(volume: &Volume, camera: &Camera, settings: Settings, tolerance: f64) {
    let (size, settings) = (viewport(25, 22), cued(settings));
    let what =
        format!("{:?}, {:?}, lit {}, {:?}", settings.algorithm, settings.blend, settings.shading.is_some(), camera.projection);
    Pair::of(volume, &smooth_transfer(), camera, size, &settings).assert_same(&what, tolerance);
    for wrong in [DepthCue { strength: 0.4, ..CUE }, DepthCue { strength: 0.0, ..CUE }, DepthCue { color: [0.0; 3], ..CUE }] {
        let expected = Settings { depth_cue: Some(wrong), ..settings };
        let pair = Pair::against(volume, &smooth_transfer(), camera, size, &settings, &expected);
        assert!(pair.differing(2.0 * tolerance) > NOTICED, "{what}: {wrong:?} must be noticed");
    }
}

#[test]
fn device_and_reference() {
    let (volume, views) = scene();
    for (camera, is_parallel) in views.into_iter().zip([true, false]) {
        for settings in each() {
            assert_fades(&volume, &camera, settings, tolerance_of(&settings, is_parallel));
        }
    }
}

/// Layer axes x and y, seen from both sides; the layers' kernels permute axes.
#[test]
fn along_other_axes() {
    let (volume, _) = scene();
    for (azimuth, elevation) in [(80.0, 12.0), (-75.0, -8.0), (15.0, 72.0), (160.0, -70.0)] {
        let camera = parallel(&volume, viewport(25, 22), azimuth, elevation);
        for settings in each().filter(|s| s.shading.is_some()) {
            let pair = Pair::of(&volume, &smooth_transfer(), &camera, viewport(25, 22), &cued(settings));
            pair.assert_same(&format!("{:?} from {azimuth}, {elevation}", settings.algorithm), tolerance_of(&settings, true));
        }
    }
}

#[test]
fn cut_and_of_surfaces() {
    let (volume, [camera, _]) = scene();
    let cut = each().map(|settings| Settings { clipping: cuts(), ..settings });
    for settings in surfaces().chain(cut) {
        let tolerance = tolerance_of(&settings, true).max(tolerance(&settings, true));
        let what = format!("{:?}, {:?}", settings.algorithm, settings.blend);
        Pair::of(&volume, &smooth_transfer(), &camera, viewport(25, 22), &cued(settings)).assert_same(&what, tolerance);
    }
}

/// The eye in the middle of the volume: colours fade from there.
#[test]
fn from_inside() {
    let (volume, [_, perspective]) = scene();
    let centre = volume.grid().centre();
    let camera = Camera { position: centre, focal_point: centre + DVec3::new(0.5, 0.2, 1.0), ..perspective };
    let settings = composited(CONVERGED, Clipping::default());
    assert_fades(&volume, &camera, settings, tolerance_of(&settings, false));
}

/// On GPUs a work-item is one sample of a lattice.
#[test]
fn per_sample() {
    let (volume, views) = scene();
    let device = device();
    let device = device.with_tuning(Tuning { lattice_schedule: LatticeSchedule::Samples, ..*device.tuning() }).unwrap();
    for (camera, is_parallel) in views.into_iter().zip([true, false]) {
        for settings in each().filter(|s| s.layered().is_some()) {
            let pair = Pair::on(&device, &volume, &smooth_transfer(), &camera, viewport(25, 22), &cued(settings));
            pair.assert_same(&format!("{:?}", settings.algorithm), tolerance_of(&settings, is_parallel));
        }
    }
}

/// A plane that faces the viewer at a known depth: value k in layer k of a grey ramp, at 10 of 0 … 15.
#[test]
fn a_plane_at_a_known_depth() {
    let (dims, iso, size) = ([12, 12, 16], 10.0, viewport(9, 9));
    let rising = (0..dims[0] * dims[1] * dims[2]).map(|i| (i / (dims[0] * dims[1])) as f32).collect();
    let volume = volume(dims, DVec3::new(1.0, 0.8, 1.5), Voxels::Float32(rising));
    let orange = TransferFunction::new("orange", vec![(0.0, [0.9, 0.5, 0.2])], vec![(0.0, 1.0)]).unwrap();
    let draw = |azimuth: f64, settings: &Settings| {
        let camera = scaled(parallel(&volume, size, azimuth, 0.0), 2.0);
        render(&volume, &orange, &camera, size, settings).pixel(4, 4)
    };
    // At azimuth 0 the eye is on the side of layer 15. The crop box ends at layers 4 and 12. Uncropped, the first surface from there lies
    // in front of the box, between layer 15 and the background of 0: it does not fade.
    let cropped = crop([0.0, 0.0, 4.0], [11.0, 11.0, 12.0]);
    for (azimuth, clipping, depth) in [
        (0.0, Clipping::default(), 0.0),
        (180.0, Clipping::default(), 10.0 / 15.0),
        (0.0, cropped, 2.0 / 8.0),
        (180.0, cropped, 6.0 / 8.0),
    ] {
        // Smooth kernels bend the ramp between voxels, where steps of 0.6 find the surface by linear interpolation.
        let exact =
            surfaces().filter(|s| !matches!(s.algorithm, Algorithm::Raycast { kernel: Kernel::Cubic | Kernel::Gaussian, .. }));
        for own in exact.flat_map(|s| [s, Settings { shading: None, ..s }]) {
            let own = Settings { blend: Blend::Iso(iso), clipping, ..own };
            let plain = draw(azimuth, &own);
            assert_eq!(plain[3], 1.0, "{:?}", own.algorithm);
            for color in [[0.0; 3], [1.0, 0.2, 0.6]] {
                let found = draw(azimuth, &Settings { depth_cue: Some(DepthCue { strength: 0.6, color }), ..own });
                let share = 0.6 * depth;
                for c in 0..3 {
                    let expected = f64::from(plain[c]) * (1.0 - share) + color[c] * share;
                    let off = (f64::from(found[c]) - expected).abs();
                    assert!(off < FLOATS, "{:?} from {azimuth}, {color:?}: {found:?} and {plain:?}, off by {off}", own.algorithm);
                }
                assert_eq!(found[3], 1.0);
            }
        }
    }
}

/// A strength of 0 changes no bit, and no strength changes opacities or projections of values.
#[test]
fn what_does_not_change() {
    let (volume, views) = scene();
    let draw = |camera, settings: &Settings| render(&volume, &smooth_transfer(), camera, viewport(25, 22), settings);
    let alphas = |frame: &Frame| frame.pixels().iter().map(|p| p[3]).collect::<Vec<_>>();
    for camera in &views {
        for settings in each().chain(surfaces()) {
            let plain = draw(camera, &settings);
            let none = Some(DepthCue { strength: 0.0, color: [1.0; 3] });
            assert_eq!(draw(camera, &Settings { depth_cue: none, ..settings }), plain, "{:?}", settings.algorithm);
            // Unlit colours are composited by the kernels of lit ones, in which smooth kernels have another sample per segment.
            if settings.shading.is_some() {
                let found = draw(camera, &cued(settings));
                assert_ne!(found, plain, "{:?}", settings.algorithm);
                assert_eq!(alphas(&found), alphas(&plain), "{:?}", settings.algorithm);
            }
        }
        for blend in VALUES {
            let projected = Settings { blend, ..Settings::default() };
            assert_eq!(draw(camera, &cued(projected)), draw(camera, &projected), "{blend:?}");
        }
    }
}

/// The box is that of the whole volume: parts and streams have the bits of the whole.
#[test]
fn parts_and_streams() {
    let (volume, _) = scene();
    let size = viewport(25, 22);
    let camera = parallel(&volume, size, 20.0, -15.0);
    let layers = volume.grid().dims()[2];
    for settings in [Settings::default(), Settings { shading: None, ..Settings::default() }].map(cued) {
        let whole = render(&volume, &smooth_transfer(), &camera, size, &settings);
        let streamed = StreamedRenderer::new(&device(), &volume, &smooth_transfer()).render(&camera, size, &settings).unwrap().0;
        assert_eq!(streamed, whole);
        let part = |layers: &std::ops::Range<usize>| {
            let (mut first, mut dims) = ([0; 3], volume.grid().dims());
            let needed = PartRenderer::needed(layers, dims[2], &settings);
            (first[2], dims[2]) = (needed.start, needed.len());
            PartRenderer::new(&device(), &volume.part(first, dims).unwrap(), &smooth_transfer()).unwrap()
        };
        let mut ranges = vec![0..4, 4..9, 9..layers];
        if !part(&ranges[0]).order(&camera, size, &settings).unwrap().1 {
            ranges.reverse();
        }
        let mut done = None;
        for range in ranges {
            done = Some(part(&range).composite(&camera, size, &settings, range, done.as_ref()).unwrap());
        }
        assert_eq!(part(&(0..4)).finish(&done.unwrap()).unwrap(), whole);
    }
}

#[test]
fn refusals() {
    let (volume, [camera, _]) = scene();
    let mut renderer = layersplat::Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    for (strength, green) in [(-0.1, 0.0), (1.1, 0.0), (f64::NAN, 0.0), (0.5, 1.5), (0.5, f64::NAN)] {
        let cue = DepthCue { strength, color: [0.0, green, 0.0] };
        let refused =
            renderer.render(&camera, viewport(9, 9), &Settings { depth_cue: Some(cue), ..Settings::default() }).unwrap_err();
        assert!(matches!(refused, Error::OutOfRange { name: "depth_cue", .. }), "{cue:?}: {refused}");
    }
}
