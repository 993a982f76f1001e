//! Opacities of classes by what is visible of them, estimated along a sample of rays (visibility histograms, Correa & Ma 2011).

use super::classes::{Class, Weights};
use crate::volume::Volume;
use glam::DVec3;
use rayon::prelude::*;

/// Directions towards the eye: the default view, azimuth 30° and elevation 20°, for each axis that may be up.
const DIRECTIONS: [[f64; 3]; 3] = [[0.470, 0.342, 0.814], [0.814, 0.470, 0.342], [0.342, 0.814, 0.470]];
/// Rays along each side of a view, and the largest number of steps of a ray along the volume's diagonal.
const RAYS: usize = 32;
const STEPS: f64 = 1024.0;
/// Share of the light that reaches the innermost class through all classes in front of it.
const THROUGH: f64 = 0.4;
/// Optical depth of a class that looks solid, along a typical ray through it.
const SOLID: f64 = 3.5;
/// Smallest and largest optical depth per unit distance of a solid class, and of a shell.
const SOLID_LIMITS: (f64, f64) = (0.12, 2.3);
const SHELL_LIMITS: (f64, f64) = (0.01, 0.8);
/// Share of a class's rays that must meet other classes behind it, so that it becomes translucent.
const COVERS: f64 = 0.03;
/// Smallest depth, in unit distances, of a class on a ray that counts as met.
const MET: f64 = 1.0;

/// Samples along rays, each ray's from the eye on. The same on all processes that share the volume.
pub struct Rays {
    values: Vec<f64>,
    /// First sample of each ray, and the end of the last one.
    starts: Vec<usize>,
    /// Distance of samples, in units of the smallest spacing.
    step: f64,
}

/// How a class is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassOpacity {
    pub is_solid: bool,
    /// Optical depth per unit distance where the class's weight is 1.
    pub depth: f64,
}

impl Rays {
    pub fn new(volume: &Volume) -> Self {
        let grid = volume.grid();
        let dims = grid.dims().map(|n| n as f64);
        let spacing = grid.spacing() / grid.spacing().min_element();
        let half = DVec3::from_array(dims) * spacing / 2.0;
        let step = (2.0 * half.length() / STEPS).max(1.0);
        let (mut indices, mut starts) = (Vec::new(), vec![0]);
        for to_eye in DIRECTIONS.map(|direction| DVec3::from_array(direction).normalize()) {
            let (right, up) = to_eye.any_orthonormal_pair();
            for ray in 0..RAYS * RAYS {
                let across = |n: usize| (n as f64 + 0.5) / RAYS as f64 * 2.0 - 1.0;
                let origin = (right * across(ray % RAYS) + up * across(ray / RAYS)) * half.length();
                let Some((near, far)) = inside(origin, to_eye, half) else { continue };
                for n in 0..((far - near) / step) as usize {
                    let place = (origin + to_eye * (far - step * n as f64) + half) / spacing;
                    let [x, y, z] = [0, 1, 2].map(|axis| (place[axis].max(0.0) as usize).min(grid.dims()[axis] - 1));
                    indices.push(x + grid.dims()[0] * (y + grid.dims()[1] * z));
                }
                starts.push(indices.len());
            }
        }
        let own = volume.own_box();
        let of_others = |index: usize| !own.has(grid.place(index));
        let mut values: Vec<f64> =
            volume.look(|value| indices.par_iter().map(|&index| if of_others(index) { 0.0 } else { value(index) }).collect());
        // All but one of the processes add 0.
        volume.add_all(&mut values);
        Self { values, starts, step }
    }

    fn each(&self) -> impl ParallelIterator<Item = &[f64]> + '_ {
        self.starts.par_windows(2).map(|ends| &self.values[ends[0]..ends[1]])
    }

    /// How to show each class, so that it does not hide the classes after it, nor cavities with values in `cavity`. The last class is
    /// solid.
    pub fn shown(&self, classes: &[Class], cavity: Option<(f64, f64)>) -> Vec<ClassOpacity> {
        let cores: Vec<(f64, f64)> = classes.iter().map(|class| class.core).chain(cavity).collect();
        let share = THROUGH.powf(1.0 / (cores.len() as f64 - 1.0).max(1.0));
        let translucent = |n: usize| match n + 1 < classes.len() {
            true => self.translucent(&classes[n], &cores[n + 1..], share),
            false => None,
        };
        let solid = |class: &Class| ClassOpacity { is_solid: true, depth: self.solid(class) };
        (0..classes.len()).map(|n| translucent(n).unwrap_or_else(|| solid(&classes[n]))).collect()
    }

    /// The rays with negated values.
    pub fn mirrored(self) -> Self {
        Self { values: self.values.into_iter().map(|value| -value).collect(), ..self }
    }

    /// First sample on a ray up to which the ray was in a range of values for [`MET`] at least.
    fn first_met(&self, ray: &[f64], core: (f64, f64)) -> Option<usize> {
        let long = (2.0 * MET / self.step).ceil() as usize + 1;
        let mut run = 0;
        ray.iter().position(|&value| {
            run = if (core.0..=core.1).contains(&value) { run + 1 } else { 0 };
            run >= long
        })
    }

    /// Optical depth per unit distance with which a class looks solid.
    fn solid(&self, class: &Class) -> f64 {
        let integral = Integral::new(&class.solid);
        let mut depths: Vec<f64> = self
            .each()
            .map(|ray| ray.windows(2).map(|ends| integral.mean(ends[0], ends[1])).sum::<f64>() * self.step)
            .filter(|&depth| depth > 0.5)
            .collect();
        depths.sort_by(f64::total_cmp);
        // Thin parts, too, should look solid.
        let thin = depths.get(depths.len() / 4).copied().unwrap_or(1.0);
        (SOLID / thin).clamp(SOLID_LIMITS.0, SOLID_LIMITS.1)
    }

    /// A translucent shell that lets `share` of the light through to the classes `behind` it; `None` if there is hardly any behind.
    fn translucent(&self, class: &Class, behind: &[(f64, f64)], share: f64) -> Option<ClassOpacity> {
        let integral = Integral::new(&class.shell);
        let depth_before = |ray: &[f64]| -> (f64, bool) {
            let inner = behind.iter().filter_map(|&core| self.first_met(ray, core)).min();
            let front = &ray[..inner.unwrap_or(ray.len())];
            let depth = front.windows(2).map(|ends| integral.mean(ends[0], ends[1])).sum::<f64>() * self.step;
            // The boundary of an inner class passes through the values of outer ones, but only their core covers it.
            (depth, inner.is_some() && self.first_met(front, class.core).is_some())
        };
        let depths: Vec<(f64, bool)> = self.each().map(depth_before).filter(|(depth, _)| *depth > 0.02).collect();
        let covering: Vec<f64> = depths.iter().filter(|(_, covers)| *covers).map(|(depth, _)| *depth).collect();
        if covering.is_empty() || (covering.len() as f64) < COVERS * depths.len() as f64 {
            return None;
        }
        // The geometric mean of the transmittances is `share`.
        let mean = covering.iter().sum::<f64>() / covering.len() as f64;
        Some(ClassOpacity { is_solid: false, depth: (-share.ln() / mean).clamp(SHELL_LIMITS.0, SHELL_LIMITS.1) })
    }
}

/// Distances along `direction` at which a line enters and leaves a box around the origin.
fn inside(origin: DVec3, direction: DVec3, half: DVec3) -> Option<(f64, f64)> {
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    (near < far).then_some((near, far))
}

/// Running integral of weights, for their mean between the values at both ends of a step.
struct Integral<'a> {
    weights: &'a Weights,
    sums: Vec<f64>,
}

impl<'a> Integral<'a> {
    fn new(weights: &'a Weights) -> Self {
        let mut sums = vec![0.0];
        for pair in weights.windows(2) {
            sums.push(sums[sums.len() - 1] + (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1) / 2.0);
        }
        Self { weights, sums }
    }

    /// Weight at a value: constant beyond the ends.
    fn weight(&self, value: f64) -> f64 {
        weight(self.weights, value)
    }

    fn until(&self, value: f64) -> f64 {
        let n = self.weights.partition_point(|point| point.0 <= value);
        if n == 0 {
            return (value - self.weights[0].0) * self.weights[0].1;
        }
        let (from, own) = self.weights[n - 1];
        self.sums[n - 1] + (value - from) * (own + self.weight(value)) / 2.0
    }

    fn mean(&self, a: f64, b: f64) -> f64 {
        let (from, to) = (self.weights[0].0, self.weights[self.weights.len() - 1].0);
        // Steps that stay in a narrow range, or leave the range of the control points, need no difference of integrals.
        if (b - a).abs() <= 1e-6 * (to - from) { self.weight(a) } else { (self.until(b) - self.until(a)) / (b - a) }
    }
}

/// Weight at a value: linear between control points, constant beyond them.
pub fn weight(weights: &Weights, value: f64) -> f64 {
    let n = weights.partition_point(|point| point.0 <= value);
    match (n.checked_sub(1).map(|i| weights[i]), weights.get(n)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (value - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => 0.0,
    }
}
