//! Time limit per frame.

use crate::common::{CONVERGED, POINTS, SPLATTED, device, layered, parallel, random_volume, smooth_transfer, viewport};
use glam::DVec3;
use layersplat::renderer::{PartRenderer, StreamedRenderer};
use layersplat::settings::{Algorithm, Evaluation, LayerAxis, Layered};
use layersplat::{Background, Camera, Error, Frame, Renderer, Settings, TransferFunction, Viewport, Volume};
use std::time::Duration;

const PLENTY: Option<Duration> = Some(Duration::from_secs(3600));
const NOTHING: Option<Duration> = Some(Duration::ZERO);

fn scene() -> (Volume<'static>, TransferFunction, Camera, Viewport) {
    let volume = random_volume([21, 18, 24], DVec3::new(1.0, 0.8, 1.1), 5);
    let size = viewport(31, 26);
    let camera = parallel(&volume, size, 25.0, 15.0);
    (volume, smooth_transfer(), camera, size)
}

/// Lattices of either classification, per pixel, ray casting, and sheets, which read back data during a frame.
fn ways() -> Vec<Settings> {
    let settings = Settings::default();
    let of = |classification, evaluation| Settings {
        algorithm: Layered { classification, evaluation, ..layered(settings) }.into(),
        ..settings
    };
    vec![
        settings,
        of(SPLATTED, layered(settings).evaluation),
        of(POINTS, Evaluation::Direct),
        CONVERGED.into(),
        Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }.into(),
        Algorithm::ViewSheets { sheet_distance: 1.0 }.into(),
    ]
}

/// Checks an output path: without a limit, within one, beyond one, and without one again.
#[track_caller]
fn check(what: &str, mut draw: impl FnMut(Option<Duration>) -> Result<Frame, Error>, expected: &Frame) {
    for longest in [NOTHING, None, PLENTY, NOTHING, NOTHING, PLENTY, None] {
        match draw(longest) {
            Ok(frame) => assert!(longest != NOTHING && frame == *expected, "{what}, {longest:?}"),
            Err(Error::TooLong { stage, longest: told }) => {
                assert!(longest == NOTHING && told == Duration::ZERO && !stage.is_empty(), "{what}, {longest:?}");
            }
            Err(other) => panic!("{what}, {longest:?}: {other}"),
        }
    }
}

#[test]
fn frames_that_take_too_long_are_given_up() {
    let (volume, transfer, camera, size) = scene();
    for settings in ways() {
        let expected = crate::common::render(&volume, &transfer, &camera, size, &settings);
        assert!(crate::common::largest_opacity(&expected) > 0.1);
        let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
        let draw = |longest| {
            renderer.limit(longest);
            renderer.render(&camera, size, &settings).map(|(frame, _)| frame)
        };
        check(&format!("{settings:?}"), draw, &expected);
        renderer.limit(NOTHING);
        assert!(matches!(renderer.render_rgba8(&camera, size, &settings, Background::BLACK), Err(Error::TooLong { .. })));
    }
}

#[test]
fn parts_that_take_too_long_are_given_up() {
    let (volume, transfer, camera, size) = scene();
    let settings = Settings::default();
    let [x, y, z] = volume.grid().dims();
    let mut renderer = PartRenderer::new(&device(), &volume.part([0; 3], [x, y, z]).unwrap(), &transfer).unwrap();
    let draw = |longest| {
        renderer.limit(longest);
        let done = renderer.composite(&camera, size, &settings, 0..z, None)?;
        renderer.finish(&done)
    };
    let (axis, _) = PartRenderer::new(&device(), &volume.part([0; 3], [x, y, z]).unwrap(), &transfer)
        .unwrap()
        .order(&camera, size, &settings)
        .unwrap();
    assert_eq!(axis, layersplat::Axis::Z);
    check("parts", draw, &crate::common::render(&volume, &transfer, &camera, size, &settings));
}

#[test]
fn streams_that_take_too_long_are_given_up() {
    let volume = random_volume([70, 64, 80], DVec3::ONE, 5);
    let (transfer, size, settings) = (smooth_transfer(), viewport(24, 20), Settings::default());
    let camera = parallel(&volume, size, 20.0, 10.0);
    let expected = crate::common::render(&volume, &transfer, &camera, size, &settings);
    for (what, budget, in_parts) in [("in parts", 400 << 10, true), ("as a whole", 1 << 30, false)] {
        let mut renderer = StreamedRenderer::new(&device().with_memory(budget), &volume, &transfer);
        let plan = renderer.plan(&camera, size, &settings).unwrap().expect("a lattice");
        assert_eq!(plan.lattices[0].parts > 1, in_parts, "{plan}");
        let draw = |longest| {
            renderer.limit(longest);
            renderer.render(&camera, size, &settings).map(|(frame, _)| frame)
        };
        check(what, draw, &expected);
    }
}
