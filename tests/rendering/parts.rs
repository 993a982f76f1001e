//! Rendering a volume in parts, one after the other, is bit-identical to rendering it as a whole.

use crate::common::*;
use glam::DVec3;
use layersplat::device::{DeviceKind, Tuning};
use layersplat::layers::{GradientEstimator, Kernel, PREFILTER_RADIUS};
use layersplat::renderer::{CompositedLayers, PartRenderer};
use layersplat::settings::{Blend, Classification, ClipPlane, Clipping, CropBox, LayerAxis, Layered, Quality};
use layersplat::transfer::Extinction;
use layersplat::volume::{Description, VolumePart, VoxelType, Voxels};
use layersplat::{Axis, Camera, Device, Frame, Renderer, Settings, TransferFunction, Viewport, Volume};
use std::ops::Range;

const DIMS: [usize; 3] = [21, 18, 23];
const SEED: u64 = 11;
/// Rounding of `over` in another order: about 20 layers, half a unit of 2^-24 each.
const REASSOCIATED: f64 = 2e-6;
/// Parts behind an opaque front are not terminated.
const TERMINATED: f64 = Settings::OPAQUE;

/// Views along each axis, from both sides, in both projections.
fn views(volume: &Volume, size: Viewport) -> Vec<(Axis, Camera)> {
    let along =
        [(Axis::X, 80.0, 12.0), (Axis::X, -70.0, -20.0), (Axis::Y, 15.0, 72.0), (Axis::Z, 20.0, -15.0), (Axis::Z, 170.0, 8.0)];
    let both = |(axis, azimuth, elevation)| {
        [(axis, parallel(volume, size, azimuth, elevation)), (axis, perspective(volume, azimuth, elevation, 25.0))]
    };
    along.into_iter().flat_map(both).collect()
}

/// Layers 0 to n in k ranges of nearly equal size.
fn ranges(n: usize, k: usize) -> Vec<Range<usize>> {
    (0..k).map(|i| i * n / k..(i + 1) * n / k).collect()
}

/// Smallest part of a volume from which some layers of an axis can be composited.
fn part_for<'a>(volume: &Volume<'a>, axis: Axis, layers: &Range<usize>, settings: &Settings) -> VolumePart<'a> {
    let (mut first, mut dims) = ([0; 3], volume.grid().dims());
    let needed = PartRenderer::needed(layers, dims[axis.index()], settings);
    (first[axis.index()], dims[axis.index()]) = (needed.start, needed.len());
    volume.part(first, dims).unwrap()
}

/// A camera, a viewport and settings with one layer axis.
struct Shot<'a> {
    device: Device,
    volume: &'a Volume<'static>,
    transfer: &'a TransferFunction,
    axis: Axis,
    camera: Camera,
    size: Viewport,
    settings: Settings,
}

impl Shot<'_> {
    fn whole(&self) -> Frame {
        let mut renderer = Renderer::new(&self.device, self.volume, self.transfer).unwrap();
        renderer.render(&self.camera, self.size, &self.settings).unwrap().0
    }

    fn renderer(&self, layers: &Range<usize>) -> PartRenderer {
        PartRenderer::new(&self.device, &part_for(self.volume, self.axis, layers, &self.settings), self.transfer).unwrap()
    }

    /// Ranges of layers in view order.
    fn in_order(&self, k: usize) -> Vec<Range<usize>> {
        let mut ranges = ranges(self.volume.grid().dims()[self.axis.index()], k);
        let (axis, ascending) = self.renderer(&ranges[0]).order(&self.camera, self.size, &self.settings).unwrap();
        assert_eq!(axis, self.axis);
        if !ascending {
            ranges.reverse();
        }
        ranges
    }

    fn composite(&self, layers: Range<usize>, before: Option<&CompositedLayers>) -> CompositedLayers {
        self.renderer(&layers).composite(&self.camera, self.size, &self.settings, layers, before).unwrap()
    }

    /// Composites part by part, each on top of the previous result.
    fn in_parts(&self, k: usize) -> Frame {
        let mut done: Option<CompositedLayers> = None;
        for layers in self.in_order(k) {
            done = Some(self.composite(layers, done.as_ref()));
        }
        let done = done.unwrap();
        assert_eq!(done.layers(), 0..self.volume.grid().dims()[self.axis.index()]);
        self.renderer(&(0..1)).finish(&done).unwrap()
    }

    /// Composites each part separately, then combines them back to front.
    fn combined(&self, k: usize) -> Frame {
        let parts = self.in_order(k).into_iter().map(|layers| self.composite(layers, None));
        let whole = parts.rev_reduce(|behind, front| CompositedLayers::combine(&front, &behind).unwrap());
        self.renderer(&(0..1)).finish(&whole).unwrap()
    }
}

/// Folds from the last to the first.
trait RevReduce: Iterator {
    fn rev_reduce(self, fold: impl FnMut(Self::Item, Self::Item) -> Self::Item) -> Self::Item;
}

impl<I: DoubleEndedIterator> RevReduce for I {
    fn rev_reduce(self, fold: impl FnMut(I::Item, I::Item) -> I::Item) -> I::Item {
        self.rev().reduce(fold).unwrap()
    }
}

fn forced(axis: Axis, layered: Layered) -> Settings {
    Layered { layer_axis: LayerAxis::Forced(axis), ..layered }.into()
}

/// Both classifications, and `high` with both.
fn sampled() -> [Layered; 4] {
    let high = Quality::High.layered();
    let post = |quality: Quality| Layered { classification: quality.splatted(), ..quality.layered() };
    [Layered::default(), high, post(Quality::Standard), post(Quality::High)]
}

/// Of the same volume, and of another one.
#[test]
fn a_renderer_takes_other_parts() {
    let [volume, other] = [SEED, SEED + 1].map(|seed| random_volume(DIMS, DVec3::new(1.0, 0.9, 1.2), seed));
    let (transfer, size, settings) = (smooth_transfer(), viewport(26, 22), forced(Axis::Z, Layered::default()));
    let camera = parallel(&volume, size, 20.0, -15.0);
    let [front, behind] = [0..11, 11..DIMS[2]];
    let mut renderer = PartRenderer::new(&device(), &part_for(&volume, Axis::Z, &behind, &settings), &transfer).unwrap();
    let (_, ascending) = renderer.order(&camera, size, &settings).unwrap();
    for volume in [&volume, &other] {
        let mut done: Option<CompositedLayers> = None;
        for layers in if ascending { [&front, &behind] } else { [&behind, &front] } {
            renderer.set_part(&part_for(volume, Axis::Z, layers, &settings)).unwrap();
            done = Some(renderer.composite(&camera, size, &settings, layers.clone(), done.as_ref()).unwrap());
        }
        let found = renderer.finish(&done.unwrap()).unwrap();
        assert_close("other parts", &found, &render(volume, &transfer, &camera, size, &settings), 0.0);
    }
}

#[test]
fn in_two_three_and_seven_parts() {
    let volume = random_volume(DIMS, DVec3::new(1.0, 0.9, 1.2), SEED);
    let (transfer, size) = (smooth_transfer(), viewport(26, 22));
    for (axis, camera) in views(&volume, size) {
        for layered in sampled() {
            let settings = forced(axis, layered);
            let shot = Shot { device: device(), volume: &volume, transfer: &transfer, axis, camera, size, settings };
            let whole = shot.whole();
            for k in [2, 3, 7] {
                assert_close(&format!("{axis:?}, {:?}, {layered:?}, {k}", camera.projection), &shot.in_parts(k), &whole, 0.0);
            }
        }
    }
}

/// The GPU schedule, with and without culling: slabs that are not looked up end with the part.
#[test]
fn in_parts_by_a_work_item_per_sample() {
    let (dims, size) = ([40, 44, 36], viewport(61, 47));
    let (volume, transfer) = (random_volume(dims, DVec3::new(1.0, 0.9, 1.2), SEED), smooth_transfer());
    let device = device();
    let samples = device.with_tuning(Tuning::new(DeviceKind::Gpu, "", 1, 1)).unwrap();
    for (n, (axis, camera)) in views(&volume, size).into_iter().enumerate() {
        let settings = Settings { culling: n % 3 != 0, ..forced(axis, sampled()[[2, 1, 2, 3][n % 4]]) };
        let shot = Shot { device: samples.clone(), volume: &volume, transfer: &transfer, axis, camera, size, settings };
        let whole = shot.whole();
        assert_close(&format!("{axis:?}, {:?}, {settings:?}", camera.projection), &shot.in_parts(5), &whole, 0.0);
        let of_tiles = Shot { device: device.clone(), ..shot }.whole();
        assert!(compare(&of_tiles, &whole).max_difference > 0.0, "another schedule must be detected");
        let seen = |frame: &Frame| frame.pixels().iter().filter(|pixel| pixel[3] > 0.05).count();
        assert!(seen(&whole) > 300 && seen(&whole) == seen(&of_tiles), "{} pixels, {} of tiles", seen(&whole), seen(&of_tiles));
    }
}

/// Every kernel for layers, lit and in `high`, composited and reduced, each along one axis.
#[test]
fn every_kernel_of_layers() {
    // Long enough that no part contains all of it, including coefficients.
    let volume = random_volume([33, 31, 35], DVec3::new(1.0, 0.9, 1.2), SEED);
    let (transfer, size) = (smooth_transfer(), viewport(26, 22));
    let views = views(&volume, size);
    for (n, kernel) in Kernel::OF_LAYERS.into_iter().enumerate() {
        for (k, blend) in [(2, Blend::Composite), (3, Blend::Composite), (3, Blend::Maximum)] {
            // Another axis for each, in both projections.
            let (axis, camera) = views[(3 * n + 2 * k + usize::from(blend != Blend::Composite)) % views.len()];
            let settings = Settings { blend, ..forced(axis, with_kernel(Quality::High, kernel)) };
            let shot = Shot { device: device(), volume: &volume, transfer: &transfer, axis, camera, size, settings };
            let what = format!("{kernel:?}, {blend:?}, {axis:?}, {k}");
            let whole = shot.whole();
            assert_close(&what, &shot.in_parts(k), &whole, 0.0);
            // The comparison must detect another kernel.
            let other = if kernel == Kernel::Linear { Kernel::Cubic } else { Kernel::Linear };
            let other = Shot { settings: Settings { blend, ..forced(axis, with_kernel(Quality::High, other)) }, ..shot };
            assert!(compare(&other.in_parts(k), &whole).max_difference > TERMINATED, "{what}: another kernel must be noticed");
        }
    }
}

/// Parts hold as many ghost layers as their estimator of gradients needs: their pictures are those of the whole volume to the bit.
#[test]
fn whatever_gradients_are_estimated_from() {
    let volume = random_volume(DIMS, DVec3::new(1.0, 0.9, 1.2), SEED);
    let (transfer, size) = (smooth_transfer(), viewport(26, 22));
    let estimators = [
        (Kernel::Linear, GradientEstimator::Sobel),
        (Kernel::BSpline, GradientEstimator::Sobel),
        (Kernel::Linear, GradientEstimator::Gaussian(2.0)),
        (Kernel::BSpline, GradientEstimator::Gaussian(0.7)),
    ];
    for (n, (axis, camera)) in views(&volume, size).into_iter().enumerate() {
        let (kernel, gradient) = estimators[n % estimators.len()];
        let settings = Settings {
            gradient: Some(gradient),
            early_termination: false,
            ..forced(axis, with_kernel(Quality::Standard, kernel))
        };
        let shot = Shot { device: device(), volume: &volume, transfer: &transfer, axis, camera, size, settings };
        let (whole, what) = (shot.whole(), format!("{kernel:?}, {gradient}, {axis:?}"));
        assert!(shot.in_parts(5) == whole, "{what}");
        let other = Shot { settings: Settings { gradient: Some(GradientEstimator::Gaussian(0.3)), ..settings }, ..shot };
        assert!(compare(&other.in_parts(5), &whole).max_difference > TERMINATED, "{what}: another estimator must be noticed");
    }
}

/// Ghost layers: two, plus those that the B-spline's coefficients depend on. Parts with fewer are rejected, so none is superfluous.
#[test]
fn layers_around_parts() {
    let dims = [9, 8, 50];
    let volume = random_volume(dims, DVec3::ONE, SEED);
    let (transfer, size) = (smooth_transfer(), viewport(24, 20));
    let camera = parallel(&volume, size, 20.0, 10.0);
    for kernel in Kernel::OF_LAYERS {
        let around = if kernel == Kernel::BSpline { 2 + PREFILTER_RADIUS } else { 2 };
        let settings = forced(Axis::Z, with_kernel(Quality::High, kernel));
        assert_eq!(PartRenderer::needed(&(20..24), 50, &settings), 20 - around..24 + around, "{kernel:?}");
        assert_eq!(PartRenderer::needed(&(1..49), 50, &settings), 0..50, "{kernel:?}");
        for held in [21 - around..24 + around, 20 - around..23 + around, 20 - around..24 + around] {
            let part = volume.part([0, 0, held.start], [dims[0], dims[1], held.len()]).unwrap();
            let mut renderer = PartRenderer::new(&device(), &part, &transfer).unwrap();
            let found = renderer.composite(&camera, size, &settings, 20..24, None);
            if held.len() == 4 + 2 * around {
                assert!(found.is_ok(), "{kernel:?} from {held:?}");
            } else {
                let message = found.expect_err("too little").to_string();
                assert!(message.contains("does not hold"), "{kernel:?} from {held:?}: {message}");
            }
        }
    }
}

#[test]
fn whatever_becomes_of_the_values() {
    let volume = random_volume(DIMS, DVec3::ONE, SEED);
    let (transfer, size) = (smooth_transfer(), viewport(24, 20));
    let clipping =
        Clipping { crop: Some(CropBox { lowest: DVec3::splat(2.5), highest: DVec3::splat(15.2) }), ..Default::default() }
            .with_planes([ClipPlane { point: volume.grid().centre(), normal: DVec3::new(1.0, 2.0, -0.5) }]);
    let blends = [Blend::Composite, Blend::Maximum, Blend::Minimum, Blend::Average, Blend::Iso(90.0)];
    for (n, blend) in blends.into_iter().enumerate() {
        for (m, layered) in sampled().into_iter().enumerate() {
            if matches!((blend, layered.classification), (Blend::Iso(_), Classification::Post(_))) {
                continue; // Splatted layers have no values between samples: Settings::check rejects it.
            }
            let (axis, camera) = views(&volume, size)[(3 * n + m) % 10];
            let variants = [
                Settings { blend, ..forced(axis, layered) },
                Settings {
                    blend,
                    clipping,
                    culling: false,
                    extinction: Extinction::Linear,
                    shading: None,
                    ..forced(axis, layered)
                },
            ];
            for settings in variants {
                let shot = Shot { device: device(), volume: &volume, transfer: &transfer, axis, camera, size, settings };
                let (what, whole) = (format!("{settings:?}"), shot.whole());
                assert_close(&what, &shot.in_parts(3), &whole, 0.0);
                let open = Settings { early_termination: false, ..settings };
                let shot = Shot { settings: open, ..shot };
                assert_close(&what, &shot.combined(4), &shot.whole(), REASSOCIATED);
            }
        }
    }
}

/// Parts that are composited separately cannot use early termination of the parts in front.
#[test]
fn terminated_early() {
    let volume = random_volume(DIMS, DVec3::ONE, SEED);
    let (transfer, size) = (step_transfer(100.0, 0.9), viewport(24, 20));
    let (axis, camera) = views(&volume, size)[0];
    let shot = Shot {
        device: device(),
        volume: &volume,
        transfer: &transfer,
        axis,
        camera,
        size,
        settings: forced(axis, Layered::default()),
    };
    assert_close("one after the other", &shot.in_parts(5), &shot.whole(), 0.0);
    assert_close("each for itself", &shot.combined(5), &shot.whole(), TERMINATED);
}

/// A part with values in the lower half of the range only, and a background outside its values.
#[test]
fn properties_of_the_whole() {
    let [x, y, z] = DIMS;
    let layer = |k: usize| if k < z / 2 { 120 } else { 250 };
    let values: Vec<i16> = (0..x * y * z).map(|n| layer(n / (x * y)) + (n * 7 % 13) as i16).collect();
    let volume = volume(DIMS, DVec3::ONE, Voxels::Int16(values.clone())).with_background(40.0).unwrap();
    let (transfer, size) = (smooth_transfer(), viewport(24, 20));
    let camera = parallel(&volume, size, 20.0, 10.0);
    let shot = Shot {
        device: device(),
        volume: &volume,
        transfer: &transfer,
        axis: Axis::Z,
        camera,
        size,
        settings: forced(Axis::Z, Layered::default()),
    };
    let whole = shot.whole();
    assert_close("parts of the volume", &shot.in_parts(3), &whole, 0.0);

    // The same from voxels elsewhere, with a manual description.
    let description = Description::new("elsewhere", volume.grid().clone(), VoxelType::Int16, (120.0, 262.0)).unwrap();
    let description = description.with_background(40.0).unwrap();
    let in_parts = |description: &Description| {
        let mut done: Option<CompositedLayers> = None;
        let mut finished = None;
        for layers in shot.in_order(4) {
            let needed = PartRenderer::needed(&layers, z, &shot.settings);
            let own = &values[x * y * needed.start..x * y * needed.end];
            let part = VolumePart::new(description.clone(), [0, 0, needed.start], [x, y, needed.len()], own).unwrap();
            let mut renderer = PartRenderer::new(&device(), &part, &transfer).unwrap();
            done = Some(renderer.composite(&camera, size, &shot.settings, layers, done.as_ref()).unwrap());
            finished = Some(renderer.finish(done.as_ref().unwrap()).unwrap());
        }
        finished.unwrap()
    };
    assert_close("described by hand", &in_parts(&description), &whole, 0.0);
    // Using a part's own range must be detected.
    let wrong = Description::new("elsewhere", volume.grid().clone(), VoxelType::Int16, (120.0, 132.0)).unwrap();
    let wrong = wrong.with_background(40.0).unwrap();
    assert!(compare(&in_parts(&wrong), &whole).max_difference > 0.01, "a part's own range must be noticed");
}

#[test]
fn what_does_not_fit_is_refused() {
    let volume = random_volume(DIMS, DVec3::ONE, SEED);
    let (transfer, size) = (smooth_transfer(), viewport(24, 20));
    let camera = parallel(&volume, size, 20.0, 10.0);
    let settings = forced(Axis::Z, Layered::default());
    let shot = Shot { device: device(), volume: &volume, transfer: &transfer, axis: Axis::Z, camera, size, settings };
    let refused = |result: Result<CompositedLayers, layersplat::Error>, words: &str| {
        let message = result.expect_err(words).to_string();
        assert!(message.contains(words), "{message} does not say '{words}'");
    };
    let mut renderer = shot.renderer(&(8..14));
    let composite =
        |r: &mut PartRenderer, layers, before: Option<&CompositedLayers>| r.composite(&camera, size, &settings, layers, before);
    refused(composite(&mut renderer, 7..14, None), "does not hold");
    refused(composite(&mut renderer, 8..15, None), "does not hold");
    #[expect(clippy::reversed_empty_ranges, reason = "the reversed range is the tested error")]
    for nothing in [9..9, 12..10, 20..24] {
        refused(composite(&mut renderer, nothing, None), "layers");
    }
    let middle = composite(&mut renderer, 9..11, None).unwrap();
    let [above, below] = [11..13, 8..9].map(|layers| composite(&mut renderer, layers, Some(&middle)));
    assert!(above.is_ok() != below.is_ok(), "layers can be behind on one side only");
    refused(if above.is_ok() { below } else { above }, "not right behind");
    let farther = composite(&mut renderer, 12..14, None).unwrap();
    refused(CompositedLayers::combine(&middle, &farther), "not right behind");
    let turned = renderer.composite(&parallel(&volume, size, 21.0, 10.0), size, &settings, 11..12, Some(&middle));
    refused(turned, "another view");
    let auto = Settings::from(Layered::default());
    let between = parallel(&volume, size, 45.0, 0.0);
    refused(renderer.composite(&between, size, &auto, 9..10, None), "shared by the layer axes");
    refused(renderer.composite(&parallel(&volume, size, 90.0, 0.0), size, &auto, 9..10, None), "does not hold");
    refused(renderer.composite(&camera, size, &Quality::Paper.settings(), 9..10, None), "use the whole volume");
    for (first, dims) in [([0; 3], [0, 1, 1]), ([20, 0, 0], [2, 1, 1]), ([usize::MAX, 0, 0], [2, 1, 1])] {
        assert!(volume.part(first, dims).unwrap_err().to_string().contains("extends beyond"), "{first:?}, {dims:?}");
    }
    let description = volume.description().clone();
    let wrong_type = VolumePart::new(description.clone(), [0; 3], [2; 3], vec![0u16; 8]).unwrap_err().to_string();
    assert!(wrong_type.contains("uint16"), "{wrong_type}");
    let wrong_count = VolumePart::new(description, [0; 3], [2; 3], vec![0u8; 7]).unwrap_err().to_string();
    assert!(wrong_count.contains('7') && wrong_count.contains('8'), "{wrong_count}");
    for (lo, hi) in [(1.0, 0.0), (f64::NAN, 1.0), (0.0, 1e-33)] {
        assert!(Description::new("r", volume.grid().clone(), VoxelType::Float32, (lo, hi)).is_err());
    }
}
