//! Comparison of device pictures with the f64 reference, ray by ray, for all algorithms.

use super::*;
use layersplat::layers::{Ray, Rays};
use layersplat::reference::{Layered as LayeredReference, Marched, Sheets};
use layersplat::renderer::{LatticePicture, PaperPlan};
use layersplat::settings::Blend;

/// Position error of a sample in f32, in voxels: coordinates of up to 100 voxels have 17 fractional bits, and tens of operations round.
pub const ROUNDED_PLACE: f64 = 1e-4;
/// Width of a table entry, as a fraction of the value range: 1/4096 of a range that overshooting kernels and control points beyond the data
/// extend by up to 1.6.
pub const ROUNDED_VALUE: f64 = 4e-4;
/// Fraction of rays that such an error takes across a discontinuity: the edge of the support, a face of the crop box, a step of opacity,
/// 45° between two layer axes, or the first visible value, at which lit segments of smooth kernels are split. These rays may differ by no
/// more than the reference changes within that error ([`Pair::unexplained`]). PoCL has at most 2 of 3132; other devices round differently.
pub const RIM_SHARE: f64 = 3e-3;
/// Fraction of rays of refined surfaces: false position stops short of the surface where the field bends strongly, as in noise, and the
/// gradient there differs. This changes the lighting only.
pub const REFINED_SHARE: f64 = 6e-3;
/// The largest difference of such a ray. Measured on PoCL: 0.14.
pub const REFINED_MOST: f64 = 0.2;

/// The same rays, rendered by the device and by the reference.
pub struct Pair<'a> {
    pub found: Vec<[f64; 4]>,
    pub expected: Vec<[f64; 4]>,
    truth: Truth<'a>,
}

impl<'a> Pair<'a> {
    /// Renders a view with both. On a lattice, compares all of its samples before the warp.
    pub fn of(volume: &'a Volume, transfer: &TransferFunction, camera: &Camera, size: Viewport, settings: &Settings) -> Self {
        Self::against(volume, transfer, camera, size, settings, settings)
    }

    /// As [`Pair::of`], on a device with other tuning values.
    pub fn on(
        device: &Device,
        volume: &'a Volume,
        transfer: &TransferFunction,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
    ) -> Self {
        Self::drawn(Renderer::new(device, volume, transfer).unwrap(), volume, camera, size, settings, settings)
    }

    /// As [`Pair::of`], with other settings for the reference, to show that a comparison can fail.
    pub fn against(
        volume: &'a Volume,
        transfer: &TransferFunction,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
        expected: &Settings,
    ) -> Self {
        Self::drawn(Renderer::new(&device(), volume, transfer).unwrap(), volume, camera, size, settings, expected)
    }

    fn drawn(
        mut renderer: Renderer,
        volume: &'a Volume,
        camera: &Camera,
        size: Viewport,
        settings: &Settings,
        expected: &Settings,
    ) -> Self {
        let plan = Plan::new(&Rays::new(camera, size, volume.grid()).unwrap(), size, volume.grid(), settings).unwrap();
        let transfer = renderer.transfer_function().clone();
        let (lattice, found) = if matches!(plan, Plan::Lattice(..)) {
            let picture = renderer.lattice_picture(camera, size, settings).unwrap().expect("a lattice, as planned");
            let found = wide(&picture.samples);
            (Some(picture), found)
        } else {
            (None, wide(renderer.render(camera, size, settings).unwrap().0.pixels()))
        };
        let truth = Truth { volume, transfer, camera: *camera, size, settings: *expected, plan, lattice };
        Self { found, expected: truth.colors(Step::default()), truth }
    }

    /// Fraction of rays that differ by more than a tolerance in a channel, alpha included.
    pub fn differing(&self, tolerance: f64) -> f64 {
        differing(&self.found, &self.expected, tolerance)
    }

    /// Asserts that the pictures are the same but for the rays that are allowed, that there is something to see, that not all rays are the
    /// same, and that a shift by one ray is noticed.
    #[track_caller]
    pub fn assert_same(&self, what: &str, tolerance: f64) {
        let seen = self.expected.iter().filter(|p| p[3] > 0.02).count();
        assert!(20 * seen > self.expected.len(), "{what}: {seen} of {} rays show anything", self.expected.len());
        self.assert_allowed(what, tolerance);
        let shifted = differing(&self.found[1..], &self.expected[..self.expected.len() - 1], tolerance);
        let allowed = RIM_SHARE.max(REFINED_SHARE);
        assert!(shifted > 5.0 * allowed, "{what}: a shift by one ray must be noticed, but changes only {shifted} of them");
    }

    /// Asserts of rays that differ by more than a tolerance that they are few, and off by no more than their cause explains.
    #[track_caller]
    pub fn assert_allowed(&self, what: &str, tolerance: f64) {
        let (share, largest) = (self.differing(tolerance), self.largest());
        let is_refined = is_refined(&self.truth.settings);
        let (allowed, most) = if is_refined { (REFINED_SHARE, REFINED_MOST) } else { (RIM_SHARE, tolerance) };
        assert!(share <= allowed, "{what}: {share} of the rays off by more than {tolerance}, up to {largest}");
        let is_within = largest <= most;
        if !is_within {
            let unexplained = self.unexplained(most);
            assert!(unexplained.is_empty(), "{what}: off by up to {largest}, and not at a rim: {unexplained:?}");
        }
    }

    /// The rays that differ by more than a tolerance from all colours between those that the reference has within [`ROUNDED_PLACE`] and
    /// [`ROUNDED_VALUE`] of them.
    pub fn unexplained(&self, tolerance: f64) -> Vec<usize> {
        let near: Vec<_> = Step::all().map(|step| self.truth.colors(step)).collect();
        let explained = |n: usize, c: usize| {
            let colors = near.iter().map(|colors| colors[n][c]).chain([self.expected[n][c]]);
            let (lo, hi) = colors.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (v.min(lo), v.max(hi)));
            (lo - tolerance..=hi + tolerance).contains(&self.found[n][c])
        };
        (0..self.found.len()).filter(|&n| !(0..4).all(|c| explained(n, c))).collect()
    }

    /// Largest difference of any channel.
    pub fn largest(&self) -> f64 {
        largest(self.found.iter().zip(&self.expected).map(|(a, b)| difference(a, b)))
    }
}

/// Whether a surface is refined on the field between two samples.
fn is_refined(settings: &Settings) -> bool {
    let samples = settings.layered().map_or(1, |layered| layered.classification.samples_per_layer());
    matches!(settings.blend, Blend::Iso(_)) && samples > 1
}

/// A small change of a view: translation of all rays in voxels, translation of the focal point alone in voxels, and an offset of all values as
/// a fraction of their range.
#[derive(Clone, Copy, Default)]
struct Step {
    moved: DVec3,
    turned: DVec3,
    raised: f64,
}

impl Step {
    /// Steps of the size of rounding errors, in each direction.
    fn all() -> impl Iterator<Item = Self> {
        let steps = DVec3::AXES.into_iter().flat_map(|axis| [axis * ROUNDED_PLACE, -axis * ROUNDED_PLACE]);
        let placed = steps.flat_map(|step| [Self { moved: step, ..Self::default() }, Self { turned: step, ..Self::default() }]);
        placed.chain([ROUNDED_VALUE, -ROUNDED_VALUE].map(|raised| Self { raised, ..Self::default() }))
    }
}

/// The reference of a view.
struct Truth<'a> {
    volume: &'a Volume<'a>,
    transfer: TransferFunction,
    camera: Camera,
    size: Viewport,
    settings: Settings,
    plan: Plan,
    /// Compared at its samples; without a lattice, at pixels.
    lattice: Option<LatticePicture>,
}

impl Truth<'_> {
    /// Transfer function and settings for raised values: these are looked up lower.
    fn lowered(&self, raised: f64) -> (TransferFunction, Settings) {
        let (lo, hi) = self.volume.range();
        let by = raised * (hi - lo);
        let (colors, opacities) = (self.transfer.colors().to_vec(), self.transfer.opacities().to_vec());
        let colors = colors.into_iter().map(|(value, color)| (value - by, color)).collect();
        let opacities = opacities.into_iter().map(|(value, opacity)| (value - by, opacity)).collect();
        let blend = if let Blend::Iso(iso) = self.settings.blend { Blend::Iso(iso - by) } else { self.settings.blend };
        (TransferFunction::new(self.transfer.name(), colors, opacities).unwrap(), Settings { blend, ..self.settings })
    }

    /// Colours of all rays after a step.
    fn colors(&self, step: Step) -> Vec<[f64; 4]> {
        let Self { volume, size, .. } = self;
        let (transfer, settings) = &self.lowered(step.raised);
        let layered = LayeredReference::new(volume, transfer, settings);
        if let (Some(picture), Plan::Lattice(lattice, _)) = (&self.lattice, &self.plan) {
            let (axis, to_eye) = (lattice.frame.layer_axis(), Rays::new(&self.camera, *size, volume.grid()).unwrap().to_eye);
            let places = (0..picture.size[1]).flat_map(|row| (0..picture.size[0]).map(move |column| (column, row)));
            let moved = |ray: Ray| Ray { origin: ray.origin + step.moved + step.turned, ..ray };
            return places.map(|(column, row)| layered.composite(&moved(picture.ray(column, row)), Some(axis), to_eye)).collect();
        }
        let grid = volume.grid();
        let [moved, turned] = [step.moved, step.turned].map(|step| grid.direction() * (step * grid.spacing()));
        let camera = &Camera {
            position: self.camera.position + moved,
            focal_point: self.camera.focal_point + moved + turned,
            ..self.camera
        };
        let frame = match self.plan {
            Plan::Direct(axis, _) => layered.render(camera, *size, axis),
            Plan::Paper(PaperPlan::AxisSheets(_) | PaperPlan::ViewSheets(_)) => {
                Sheets::new(volume, transfer, settings).render(camera, *size)
            }
            Plan::Paper(PaperPlan::Slicing(_)) => Marched::new(volume, transfer, settings).render(camera, *size),
            // Ray casting replaces layers and slices where these cannot be rendered.
            Plan::Raycast(kernel, step) | Plan::CastValues(kernel, step) => {
                let gradient = Some(settings.gradient_estimator());
                let cast = Settings { algorithm: Algorithm::Raycast { kernel, step }, gradient, ..*settings };
                Marched::new(volume, transfer, &cast).render(camera, *size)
            }
            ref other => panic!("no reference for {other}"),
        };
        wide(frame.unwrap().pixels())
    }
}

fn wide(pixels: &[[f32; 4]]) -> Vec<[f64; 4]> {
    pixels.iter().map(|p| p.map(f64::from)).collect()
}

/// NaN if any is.
pub fn largest(mut differences: impl Iterator<Item = f64>) -> f64 {
    differences.try_fold(0.0, |most: f64, d| if d.is_nan() { Err(d) } else { Ok(most.max(d)) }).unwrap_or_else(|nan| nan)
}

fn difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| (a - b).abs()))
}

/// The share of rays of which a channel, alpha included, differs by more than a tolerance.
pub fn differing(a: &[[f64; 4]], b: &[[f64; 4]], tolerance: f64) -> f64 {
    let same = a.iter().zip(b).filter(|(a, b)| difference(a, b) <= tolerance).count();
    1.0 - same as f64 / a.len() as f64
}
