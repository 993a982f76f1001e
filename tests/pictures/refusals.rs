//! Invalid combinations of settings, and their errors.

use crate::common::blends::*;
use crate::common::*;
use layersplat::layers::{Density, Kernel};
use layersplat::settings::{Algorithm, Blend, Clipping, Evaluation, LayerAxis, Layered};
use layersplat::{Error, Quality, Renderer};

#[test]
fn what_has_no_blend_mode_says_so() {
    let volume = bump();
    let size = viewport(8, 8);
    let camera = parallel(&volume, size, 0.0, 0.0);
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let mut problem = |algorithm, blend| match renderer.render(&camera, size, &settings(algorithm, blend)) {
        Err(error @ (Error::Settings { .. } | Error::OutOfRange { .. })) => error.to_string(),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("{algorithm:?} {blend:?} was drawn"),
    };
    for blend in BLENDS {
        for sheets in [Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }, Algorithm::ViewSheets { sheet_distance: 1.0 }] {
            let problem = problem(sheets, blend);
            assert!(problem.contains("blend") && problem.contains("sheets mix voxels"), "{problem}");
        }
    }
    for evaluation in [Evaluation::Direct, Evaluation::Lattice(Density::Relaxed)] {
        let splatted = Layered { classification: SPLATTED, evaluation, ..Layered::default() };
        let problem = problem(splatted.into(), Blend::Iso(ISO));
        assert!(problem.contains("blend") && problem.contains("pre-integrated"), "{problem}");
    }
    for value in [f64::NAN, f64::INFINITY] {
        let problem = problem(Algorithm::default(), Blend::Iso(value));
        assert!(problem.contains("blend") && problem.contains("finite"), "{problem}");
    }
}

/// Kernels whose weights do not sum to one are rejected for layers, but accepted for ray casting.
#[test]
fn what_layers_cannot_be_sampled_with_says_so() {
    let volume = bump();
    let size = viewport(8, 8);
    let camera = parallel(&volume, size, 0.0, 0.0);
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    for evaluation in [Evaluation::Direct, Evaluation::Lattice(Density::Relaxed)] {
        let mut draw = |kernel| {
            let layered = Layered { evaluation, ..with_kernel(Quality::High, kernel) };
            renderer.render(&camera, size, &layered.into())
        };
        match draw(Kernel::Gaussian) {
            Err(error @ Error::Settings { field: "kernel", .. }) => assert!(error.to_string().contains("gaussian"), "{error}"),
            other => panic!("{:?}", other.map(|_| "drawn")),
        }
        assert!(draw(Kernel::Cubic).is_ok(), "the other kernels must be accepted");
    }
}

#[test]
fn what_is_no_box_or_plane_says_so() {
    let volume = bump();
    let size = viewport(8, 8);
    let camera = parallel(&volume, size, 0.0, 0.0);
    let mut renderer = Renderer::new(&device(), &volume, &smooth_transfer()).unwrap();
    let only = |p| Clipping::default().with_planes([p]);
    for (clipping, expected) in [
        (crop([2.0, 0.0, 0.0], [2.0, 5.0, 5.0]), "lowest below highest"),
        (crop([2.0, 6.0, 0.0], [4.0, 5.0, 5.0]), "lowest below highest"),
        (crop([2.0, f64::NAN, 0.0], [4.0, 5.0, 5.0]), "lowest below highest"),
        (only(plane([0.0; 3], [0.0; 3])), "a finite normal other than 0"),
        (only(plane([0.0; 3], [f64::NAN, 1.0, 0.0])), "a finite normal other than 0"),
        (only(plane([f64::INFINITY, 0.0, 0.0], [1.0; 3])), "a finite point"),
    ] {
        let settings = clipped(Algorithm::default(), Blend::Composite, clipping);
        match renderer.render(&camera, size, &settings) {
            Err(error @ Error::OutOfRange { .. }) => {
                let message = error.to_string();
                assert!(message.contains("clipping") && message.contains(expected), "{message}");
            }
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("{clipping:?} was drawn"),
        }
    }
}
