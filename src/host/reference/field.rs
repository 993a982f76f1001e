//! Reconstructed field of a kernel, with background outside the grid.

use super::coefficients::{interpolate, mirrored};
use super::interval::Interval;
use super::smoothing::smoothed;
use super::taps::Taps;
use crate::layers::{GradientEstimator, Kernel, Ray};
use crate::settings::Blend;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use glam::DVec3;

/// The voxels of a volume, the values outside, the reconstruction kernel, and the estimation of gradients.
#[derive(Clone)]
pub(super) struct Field {
    kernel: Kernel,
    gradient: GradientEstimator,
    /// Spacing along x, y and z.
    spacing: DVec3,
    dims: [i64; 3],
    background: f64,
    gaussian_background: f64,
    /// Range of voxels and background, or of the voxels alone if the background is excluded.
    range: (f64, f64),
    /// Whether missing voxels repeat the nearest one (mirrored, for B-spline coefficients), which excludes the background.
    edge_goes_on: bool,
    /// Inputs of the kernel: voxels, or B-spline coefficients.
    voxels: Vec<f64>,
    /// The voxels that gradients are estimated from, if these are others.
    gradient_voxels: Option<Vec<f64>>,
}

impl Field {
    /// The field as a blend mode sees it, with the gradients that fit the kernel most closely.
    pub fn new(volume: &Volume, transfer: &TransferFunction, blend: Blend, kernel: Kernel) -> Self {
        let gaussian_background = match blend {
            Blend::Composite => transfer.gaussian_background(volume.range().0, volume.background()),
            Blend::Iso(_) => volume.background(),
            // The weights of a Gaussian sum to about 1 only. Measure values from the smallest, to bound the error.
            _ => volume.range().0,
        };
        let mut voxels: Vec<f64> = (0..volume.grid().voxel_count()).map(|i| volume.value(i)).collect();
        let range = match blend.gathers_values() {
            true => voxels.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v))),
            false => volume.field_range(),
        };
        let mut gradient_voxels = None;
        if kernel == Kernel::BSpline {
            gradient_voxels = Some(voxels.clone());
            interpolate(volume.grid().dims(), &mut voxels);
        }
        Self {
            kernel,
            gradient: GradientEstimator::for_kernel(kernel),
            spacing: volume.grid().spacing(),
            dims: volume.grid().dims().map(|n| n as i64),
            background: volume.background(),
            gaussian_background,
            range,
            edge_goes_on: blend.gathers_values(),
            voxels,
            gradient_voxels,
        }
    }

    /// Estimates gradients in another way.
    pub fn with_gradient(self, gradient: GradientEstimator) -> Self {
        let gradient_voxels = match gradient {
            GradientEstimator::Gaussian(sigma) => {
                let sigmas = sigma * self.spacing.min_element() / self.spacing;
                let voxels = self.gradient_voxels.as_ref().unwrap_or(&self.voxels);
                Some(smoothed(voxels, self.dims, self.background, sigmas))
            }
            _ => self.gradient_voxels,
        };
        Self { gradient, gradient_voxels, ..self }
    }

    /// Whether gradients are estimated at the voxels and interpolated.
    pub fn has_gradients_at_voxels(&self) -> bool {
        self.gradient.is_at_voxels(self.kernel)
    }

    /// Whether gradients are the derivative of the field.
    pub fn has_own_gradients(&self) -> bool {
        self.gradient == GradientEstimator::Own
    }

    /// Reconstruction kernel.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [i64; 3] {
        self.dims
    }

    /// Value of voxels outside the grid.
    #[cfg(feature = "paper")]
    pub fn background(&self) -> f64 {
        self.background
    }

    /// Value of missing voxels as the kernel sees it.
    pub fn missing(&self) -> f64 {
        if self.kernel == Kernel::Gaussian { self.gaussian_background } else { self.background }
    }

    /// Any voxel (for B-splines, coefficient), inside or outside the grid.
    pub fn voxel(&self, p: [i64; 3]) -> f64 {
        self.voxel_or(p, self.background)
    }

    /// Any voxel, or `missing` outside the grid.
    pub fn voxel_or(&self, p: [i64; 3], missing: f64) -> f64 {
        let [x, y, z] = self.dims;
        let instead = |i: usize| match self.kernel {
            Kernel::BSpline => mirrored(p[i], self.dims[i]),
            _ => p[i].clamp(0, self.dims[i] - 1),
        };
        let p = if self.edge_goes_on { [instead(0), instead(1), instead(2)] } else { p };
        if (0..x).contains(&p[0]) && (0..y).contains(&p[1]) && (0..z).contains(&p[2]) {
            self.voxels[(p[0] + x * (p[1] + y * p[2])) as usize]
        } else {
            missing
        }
    }

    /// Any of the voxels that gradients are estimated from, or the background outside the grid.
    fn gradient_voxel(&self, p: [i64; 3]) -> f64 {
        let [x, y, _] = self.dims;
        let inside = p.iter().zip(self.dims).all(|(i, n)| (0..n).contains(i));
        let voxels = self.gradient_voxels.as_ref().unwrap_or(&self.voxels);
        if inside { voxels[(p[0] + x * (p[1] + y * p[2])) as usize] } else { self.background }
    }

    /// Value of the reconstructed field at a point in voxels: missing + Σ (ρ − missing) × weights. The weights sum to 1, except those of the
    /// Gaussian.
    pub fn reconstructed(&self, p: DVec3) -> f64 {
        let [x, y, z] = p.to_array().map(|x| Taps::weights(self.kernel, x));
        self.missing() + self.sum([&x, &y, &z])
    }

    /// Value that is classified: sums of a Gaussian overshoot the range of the data and are clamped.
    pub fn classified(&self, p: DVec3) -> f64 {
        let value = self.reconstructed(p);
        if self.kernel == Kernel::Gaussian { self.within_range(value) } else { value }
    }

    /// Gradient per voxel: slopes along each axis, weights across it.
    pub fn gradient(&self, p: DVec3) -> DVec3 {
        if self.has_gradients_at_voxels() {
            return self.gradient_at_voxels(p);
        }
        let [x, y, z] = &p.to_array().map(|x| Taps::weights(self.kernel, x));
        let [along_x, along_y, along_z] = &p.to_array().map(|x| Taps::slopes(self.kernel, x));
        DVec3::new(self.sum([along_x, y, z]), self.sum([x, along_y, z]), self.sum([x, y, along_z]))
    }

    /// Gradients estimated at the eight voxels around a point, interpolated linearly.
    fn gradient_at_voxels(&self, p: DVec3) -> DVec3 {
        let below = p.floor();
        (0..8).map(|n| DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2))).fold(DVec3::ZERO, |sum, corner| {
            let weight = (DVec3::ONE - (p - below - corner).abs()).element_product();
            sum + weight * self.gradient_of_voxel((below + corner).to_array().map(|i| i as i64))
        })
    }

    /// Central differences at a voxel, of voxels that the estimator smooths across their direction.
    fn gradient_of_voxel(&self, p: [i64; 3]) -> DVec3 {
        let smoothing = self.gradient.smoothing_across(self.spacing).to_array();
        let along = |axis: usize| -> f64 {
            let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
            let weight = |i: i64, axis: usize| if i == 0 { 1.0 - 2.0 * smoothing[axis] } else { smoothing[axis] };
            let mut sum = 0.0;
            for i in -1..=1 {
                for j in -1..=1 {
                    let at = |step: i64| {
                        let mut voxel = p;
                        voxel[axis] += step;
                        voxel[one] += i;
                        voxel[other] += j;
                        self.gradient_voxel(voxel)
                    };
                    sum += weight(i, one) * weight(j, other) * (at(1) - at(-1)) / 2.0;
                }
            }
            sum
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// Σ (ρ − missing) × taps.
    fn sum(&self, [x, y, z]: [&Taps; 3]) -> f64 {
        let missing = self.missing();
        let inside = [x, y, z].iter().zip(self.dims).all(|(taps, n)| taps.first >= 0 && taps.first + taps.count as i64 <= n);
        let row = |j: i64, k: i64| -> f64 {
            if inside {
                let start = (x.first + self.dims[0] * (j + self.dims[1] * k)) as usize;
                let voxels = &self.voxels[start..start + x.count];
                voxels.iter().zip(&x.taps).map(|(voxel, tap)| tap * (voxel - missing)).sum()
            } else {
                x.each().map(|(i, tap)| tap * (self.voxel_or([i, j, k], missing) - missing)).sum()
            }
        };
        z.each().map(|(k, wz)| wz * y.each().map(|(j, wy)| wy * row(j, k)).sum::<f64>()).sum()
    }

    /// Clamps a value to the range of the data.
    pub fn within_range(&self, value: f64) -> f64 {
        value.clamp(self.range.0, self.range.1)
    }

    /// Intersection of a ray with the support of the field, [−r, n−1+r] per axis.
    pub fn support(&self, ray: &Ray) -> Option<Interval> {
        self.within(ray, f64::from(self.kernel.radius()))
    }

    /// The interval of a ray within the grid and `reach` voxels beyond it.
    pub fn within(&self, ray: &Ray, reach: f64) -> Option<Interval> {
        let last = DVec3::from_array(self.dims.map(|n| n as f64 - 1.0));
        Interval::in_box(ray, DVec3::splat(-reach), last + reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Grid, Voxels};
    use approx::assert_abs_diff_eq;

    const ROUNDING: f64 = 1e-9;
    /// Influence of the boundary on the coefficients of a parabola at this distance in voxels: |√3 − 2|¹⁰ of the largest.
    const FAR_FROM_BOUNDARIES: f64 = 10.0;
    const LEFT_OF_BOUNDARIES: f64 = 2e-3;
    /// Least difference to any other field.
    const NOTICED: f64 = 0.02;

    /// Field of a kernel through given voxels.
    fn field(dims: [usize; 3], blend: Blend, kernel: Kernel, number: impl Fn(DVec3) -> f64) -> Field {
        let [x, y, z] = dims;
        let place = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64);
        let numbers = (0..x * y * z).map(|n| number(place(n)) as f32).collect();
        let volume = Volume::new("test", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Float32(numbers)).unwrap();
        Field::new(&volume, &TransferFunction::automatic(&volume), blend, kernel)
    }

    /// Pseudo-random voxels that f32 represents exactly.
    fn noise(p: DVec3) -> f64 {
        ((p.dot(DVec3::new(12.9, 78.2, 37.7)).sin() * 1024.0).round() / 16.0).clamp(-50.0, 50.0)
    }

    fn voxels(dims: [i64; 3]) -> impl Iterator<Item = DVec3> {
        let [x, y, z] = dims;
        (0..x * y * z).map(move |n| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64))
    }

    /// Largest deviation of a field from the expected one at some positions.
    fn most_off(field: &Field, expected: impl Fn(DVec3) -> f64, places: impl Iterator<Item = DVec3>) -> f64 {
        places.map(|p| (field.reconstructed(p) - expected(p)).abs()).fold(0.0, f64::max)
    }

    /// All fields interpolate inner voxels; with a B-spline, the background affects voxels near the boundary, because it is not a mirror image.
    #[test]
    fn fields_meet_voxels() {
        let dims = [7, 6, 9];
        let inside = |p: &DVec3| (0..3).all(|a| (1.0..=dims[a] as f64 - 2.0).contains(&p[a]));
        for kernel in Kernel::OF_LAYERS {
            let composited = field(dims, Blend::Composite, kernel, noise);
            assert!(most_off(&composited, noise, voxels(composited.dims()).filter(inside)) < ROUNDING, "{kernel:?}");
            let half_way = |p: DVec3| noise(p - DVec3::X / 2.0);
            assert!(most_off(&composited, half_way, voxels(composited.dims()).filter(inside)) > NOTICED, "{kernel:?}");
        }
    }

    #[test]
    fn fields_that_go_on_meet_the_outermost_voxels_too() {
        for dims in [[7, 6, 9], [1, 2, 3], [2, 1, 1]] {
            for kernel in Kernel::OF_LAYERS {
                let gathered = field(dims, Blend::Maximum, kernel, noise);
                assert!(most_off(&gathered, noise, voxels(gathered.dims())) < ROUNDING, "{kernel:?}, {dims:?}");
            }
            let composited = field(dims, Blend::Composite, Kernel::BSpline, noise);
            assert!(
                most_off(&composited, noise, voxels(composited.dims())) > NOTICED,
                "the background is not a mirror image, \
                                                                                        {dims:?}"
            );
        }
    }

    /// Positions between voxels, at a distance from the boundary of 26³ voxels.
    fn places(margin: f64) -> impl Iterator<Item = DVec3> {
        let share = move |n: u32, by: f64| margin + (25.0 - 2.0 * margin) * (f64::from(n) * by).fract();
        (1..60).map(move |n| DVec3::new(share(n, 0.618), share(n, 0.414), share(n, 0.732)))
    }

    fn assert_gradient(field: &Field, expected: impl Fn(DVec3) -> DVec3, margin: f64, tolerance: f64) {
        for p in places(margin) {
            let off = (field.gradient(p) - expected(p)).length();
            assert!(off < tolerance, "{:?} at {p}: off by {off}", field.kernel());
        }
    }

    #[test]
    fn ramps_are_ramps() {
        let slope = DVec3::new(1.5, -0.75, 0.25);
        let ramp = |p: DVec3| slope.dot(p) + 3.0;
        for kernel in Kernel::OF_LAYERS {
            let field = field([26; 3], Blend::Composite, kernel, ramp);
            // A mirrored ramp has a kink, which affects the spline's coefficients.
            let (margin, tolerance) =
                if kernel == Kernel::BSpline { (FAR_FROM_BOUNDARIES, LEFT_OF_BOUNDARIES) } else { (3.0, ROUNDING) };
            assert_gradient(&field, |_| slope, margin, if kernel == Kernel::Cubic { f64::INFINITY } else { tolerance });
            let off = most_off(&field, ramp, places(margin));
            assert_eq!(off < tolerance, kernel != Kernel::Cubic, "{kernel:?}: off by {off}: Eq. 2 has steps, no other");
        }
    }

    #[test]
    fn parabolas_are_parabolas() {
        let parabola = |p: DVec3| p.x * p.x - 0.5 * p.y * p.y + p.x * p.z + 2.0 * p.y;
        let slope = |p: DVec3| DVec3::new(2.0 * p.x + p.z, 2.0 - p.y, p.x);
        for (kernel, tolerance) in [(Kernel::CatmullRom, ROUNDING), (Kernel::BSpline, LEFT_OF_BOUNDARIES)] {
            let field = field([26; 3], Blend::Composite, kernel, parabola);
            let off = most_off(&field, parabola, places(FAR_FROM_BOUNDARIES));
            assert!(off < tolerance, "{kernel:?}: off by {off}");
            assert_gradient(&field, slope, FAR_FROM_BOUNDARIES, tolerance);
        }
        let linear = field([26; 3], Blend::Composite, Kernel::Linear, parabola);
        assert!(most_off(&linear, parabola, places(FAR_FROM_BOUNDARIES)) > NOTICED);
    }

    /// Other gradients are not derivatives: they are central differences of the field over two voxels.
    #[test]
    fn other_gradients_are_central_differences() {
        for kernel in [Kernel::Linear, Kernel::Cubic, Kernel::Gaussian] {
            let field = field([7, 6, 9], Blend::Composite, kernel, noise);
            for p in [DVec3::new(2.3, 3.0, 4.9), DVec3::new(-0.4, 5.7, 8.2), DVec3::new(6.6, 0.1, -1.2)] {
                let along = |d: DVec3| (field.reconstructed(p + d) - field.reconstructed(p - d)) / 2.0;
                let differences = DVec3::from_array(DVec3::AXES.map(along));
                assert!((field.gradient(p) - differences).length() < ROUNDING, "{kernel:?} at {p}");
                let h = 1e-4;
                let derivative = DVec3::from_array(DVec3::AXES.map(|d| along(h * d) / h));
                assert!((derivative - differences).length() > NOTICED, "{kernel:?} at {p}: no derivative");
            }
        }
    }

    /// Ramps keep their slope, and a voxel's gradient has the weights 1 2 1 across the difference.
    #[test]
    fn sobel_smooths_across_the_difference() {
        let slope = DVec3::new(1.5, -0.75, 0.25);
        for kernel in [Kernel::Linear, Kernel::Cubic, Kernel::CatmullRom] {
            let ramp = field([26; 3], Blend::Composite, kernel, |p| slope.dot(p) + 3.0);
            assert_gradient(&ramp.with_gradient(GradientEstimator::Sobel), |_| slope, 3.0, ROUNDING);
        }
        let single = |p: DVec3| if p == DVec3::splat(5.0) { 32.0 } else { 0.0 };
        let sobel = field([11; 3], Blend::Composite, Kernel::Linear, single).with_gradient(GradientEstimator::Sobel);
        let along_x = |p: [f64; 3]| sobel.gradient(DVec3::from_array(p)).x;
        assert_eq!([along_x([4.0, 5.0, 5.0]), along_x([4.0, 6.0, 5.0]), along_x([4.0, 6.0, 4.0])], [4.0, 2.0, 1.0]);
        assert_eq!([along_x([5.0, 5.0, 5.0]), along_x([6.0, 5.0, 5.0]), along_x([4.0, 7.0, 5.0])], [0.0, -4.0, 0.0]);
        assert_eq!(along_x([4.5, 5.0, 5.0]), 2.0, "interpolated linearly");
    }

    #[test]
    fn only_what_overshoots_without_meaning_to_is_cut_off() {
        // Catmull-Rom overshoots at a step.
        let step = |p: DVec3| if p.x < 12.5 { 0.0 } else { 100.0 };
        let [catmull_rom, gaussian] = [Kernel::CatmullRom, Kernel::Gaussian].map(|k| field([26; 3], Blend::Composite, k, step));
        let behind = DVec3::new(13.5, 12.0, 12.0);
        assert_abs_diff_eq!(catmull_rom.classified(behind), catmull_rom.reconstructed(behind));
        assert!(catmull_rom.classified(behind) > 105.0);
        let most = places(3.0).map(|p| gaussian.classified(p)).fold(0.0, f64::max);
        let unlimited = places(3.0).map(|p| gaussian.reconstructed(p)).fold(0.0, f64::max);
        assert!(most == 100.0 && unlimited > 101.0, "{most}, {unlimited}");
    }
}
