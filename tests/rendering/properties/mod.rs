//! Property tests: any request gives a valid, reproducible picture, or an error that names the problem.
//!
//! The cases are the same in every run; PROPTEST_CASES increases their number, PROPTEST_RNG_SEED changes them.

mod scenes;

use layersplat::{Background, Error, Projection, Renderer};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use scenes::{Shot, shot, ways};
use std::cell::RefCell;

/// Excess of a colour over its opacity: half an ulp of f32, a few tens of times.
const ROUNDING: f32 = 1e-5;
/// Negative colours: lit colours whose integrals are 0 within rounding.
const BELOW_BLACK: f32 = -1e-7;
/// At least one of this many pictures of each algorithm must succeed, or little is tested.
const LEAST_SHARE: usize = 2;

fn runner(cases: u32) -> TestRunner {
    let own = Config::default();
    let seed = if own.rng_seed == RngSeed::Random { RngSeed::Fixed(15) } else { own.rng_seed };
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { own.cases } else { cases };
    TestRunner::new(Config { cases, rng_seed: seed, failure_persistence: None, max_shrink_iters: 100, ..own })
}

/// Returns whether there is a picture.
fn check(shot: &Shot) -> Result<bool, TestCaseError> {
    let (volume, transfer) = (shot.volume(), shot.transfer());
    let mut renderer =
        Renderer::new(&crate::common::device(), &volume, &transfer).map_err(|e| TestCaseError::fail(e.to_string()))?;
    let mut frame = || renderer.render(&shot.camera, shot.viewport, &shot.settings).map(|(frame, _)| frame);
    let first = match frame() {
        Ok(first) => first,
        Err(Error::Settings { .. } | Error::OutOfRange { .. } | Error::Camera { .. }) => return Ok(false),
        Err(other) => return Err(TestCaseError::fail(other.to_string())),
    };
    for pixel in first.pixels() {
        let [colors @ .., alpha] = pixel;
        prop_assert!(pixel.iter().all(|c| c.is_finite()), "{pixel:?}");
        prop_assert!((0.0..=1.0).contains(alpha), "{pixel:?}");
        prop_assert!(colors.iter().all(|c| (BELOW_BLACK..=alpha + ROUNDING).contains(c)), "{pixel:?}");
    }
    let again = frame().map_err(|e| TestCaseError::fail(e.to_string()))?;
    let bits = |frame: &layersplat::Frame| frame.pixels().iter().flatten().map(|c| c.to_bits()).collect::<Vec<_>>();
    prop_assert!(bits(&first) == bits(&again), "the second picture has different bits");
    let displayed = renderer.render_rgba8(&shot.camera, shot.viewport, &shot.settings, Background::Transparent);
    let (displayed, _) = displayed.map_err(|e| TestCaseError::fail(e.to_string()))?;
    let steps = displayed.iter().zip(first.to_rgba8(Background::Transparent)).map(|(&a, b)| a.abs_diff(b)).max();
    prop_assert!(steps <= Some(1), "the 8-bit picture differs by {steps:?}");
    Ok(true)
}

#[test]
fn pictures_are_pictures() {
    let seen = RefCell::new(vec![[0, 0]; ways().len()]);
    let done = runner(800).run(&shot(), |shot| {
        let there = check(&shot)?;
        let [all, pictures] = &mut seen.borrow_mut()[shot.way];
        (*all, *pictures) = (*all + 1, *pictures + usize::from(there));
        Ok(())
    });
    if let Err(failed) = done {
        panic!("{failed}");
    }
    for (way, [all, pictures]) in ways().into_iter().zip(seen.into_inner()) {
        assert!(pictures * LEAST_SHARE >= all, "{pictures} of {all} were not refused: {way:?}");
    }
}

/// Cameras with non-finite numbers are rejected with a message.
#[test]
fn cameras_that_are_no_numbers_are_refused() {
    let odd = prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)];
    let done = runner(60).run(&(shot(), odd, 0..10usize), |(shot, odd, place)| {
        let mut camera = shot.camera;
        let vectors = [&mut camera.position, &mut camera.focal_point, &mut camera.view_up];
        match vectors.into_iter().nth(place / 3) {
            Some(vector) => vector[place % 3] = odd,
            None => {
                camera.projection = match camera.projection {
                    Projection::Parallel { .. } => Projection::Parallel { scale: odd },
                    Projection::Perspective { .. } => Projection::Perspective { field_of_view: odd },
                };
            }
        }
        let mut renderer = Renderer::new(&crate::common::device(), &shot.volume(), &shot.transfer()).unwrap();
        let refused = renderer.render(&camera, shot.viewport, &shot.settings).map(|_| ());
        prop_assert!(matches!(refused, Err(Error::Camera { .. } | Error::OutOfRange { .. })), "{refused:?}");
        Ok(())
    });
    if let Err(failed) = done {
        panic!("{failed}");
    }
}
