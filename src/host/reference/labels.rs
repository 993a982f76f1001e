//! Converged volume rendering integral of labels with smooth surfaces.

use super::compositing::{Gathered, picture};
use super::field::Field;
use super::shading::{Lighting, ShadingInputs};
use super::shadow_rays::Reached;
use super::smoothing::smoothed;
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{GradientEstimator, Kernel, Ray, Rays};
use crate::settings::{Blend, Shading};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use glam::DVec3;

/// Steps per smallest spacing.
const STEPS: f64 = 32.0;
/// Change of a share within which the opacity changes from one label's to another's; over the reach in thick slices.
const WIDTH: f64 = 0.2;
/// Slices are thick from this multiple of the larger spacing within them, and distances reach twice their thickness.
const THICK: f64 = 1.5;
const REACH: f64 = 2.0;
/// Variance of opacities, relative to the squared mean, below which they are one.
const LEAST_VARIANCE: f64 = 1e-5;
/// Largest opacity.
const LARGEST: f64 = 0.99999;
/// Part of the opacity that the smoothed opacity lacks where a label is lit fully.
const LIT_LACK: f64 = 0.2;

/// Labels whose surfaces lie where the share of one is one half. Voxels hold the means of the opacity around them, of its square and its
/// cube, and of opacity times colour. The interpolated means determine two opacities and their shares, as Gauss's quadrature does.
pub struct Labels {
    /// Means of opacity, its square, its cube, and of opacity times red, green and blue.
    means: [Field; 6],
    /// The mean opacity, smoothed for gradients.
    smoothed: Field,
    opacity: Volume<'static>,
    /// The smallest opacity of a label that is visible.
    smallest: f64,
    width: f64,
    shading: Option<Shading>,
}

impl Labels {
    /// Of voxel n, the colour and the opacity are entry n. Gradients are those of a Gaussian of this standard deviation.
    ///
    /// # Errors
    /// For volumes too large for the memory.
    pub fn new(labels: &Volume, entries: &[[f64; 4]], kernel: Kernel, sigma: f64) -> Result<Self, Error> {
        let grid = labels.grid();
        let means = means(labels, entries);
        let volume = |n: usize| {
            let voxels: Vec<f32> = means.iter().map(|voxel| voxel[n] as f32).collect();
            Volume::new("labels", grid.clone(), voxels)?.with_background(0.0)
        };
        // It is not read: fields are interpolated, not classified.
        let transfer = TransferFunction::new("unused", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0)])?;
        let field = |volume: &Volume| Field::new(volume, &transfer, Blend::Composite, kernel);
        let volumes = [volume(0)?, volume(1)?, volume(2)?, volume(3)?, volume(4)?, volume(5)?];
        let sigmas = sigma * grid.spacing().min_element() / grid.spacing();
        let first: Vec<f64> = means.iter().map(|voxel| voxel[0]).collect();
        let voxels =
            smoothed(&first, grid.dims().map(|n| n as i64), 0.0, sigmas).into_iter().map(|v| v as f32).collect::<Vec<_>>();
        let smoothed = field(&Volume::new("labels", grid.clone(), voxels)?.with_background(0.0)?);
        let mut fields = volumes.each_ref().map(field);
        fields[0] = fields[0].clone().with_gradient(GradientEstimator::Gaussian(sigma));
        let smallest = entries.iter().map(|entry| entry[3]).filter(|&opacity| opacity > 0.0).fold(1.0, f64::min);
        let [opacity, ..] = volumes;
        let width = WIDTH / thick_slices(grid).map_or(1.0, |(_, farthest)| farthest);
        Ok(Self { means: fields, smoothed, opacity, smallest, width, shading: None })
    }

    /// Shades colours, or not.
    pub fn with_shading(self, shading: Option<Shading>) -> Self {
        Self { shading, ..self }
    }

    /// Renders the picture of a camera.
    ///
    /// # Errors
    /// For cameras that are not valid.
    pub fn render(&self, camera: &Camera, viewport: Viewport) -> Result<Frame, Error> {
        let rays = Rays::new(camera, viewport, self.opacity.grid())?;
        Ok(picture(viewport, |x, y| self.composite(&rays.at(x, y), rays.to_eye)))
    }

    fn composite(&self, ray: &Ray, to_eye: DVec3) -> [f64; 4] {
        let Some(extent) = self.means[0].support(ray) else { return [0.0; 4] };
        let spacing = self.opacity.grid().spacing();
        let per_t = (ray.direction * spacing).length() / self.opacity.grid().unit();
        let steps = ((extent.to - extent.from) * per_t * STEPS).ceil().max(1.0);
        let step = (extent.to - extent.from) / steps;
        let mut gathered = Gathered::new();
        for n in 0..steps as usize {
            let p = ray.origin + ray.direction * (extent.from + (n as f64 + 0.5) * step);
            let [first, second, third, r, g, b] = self.means.each_ref().map(|field| field.reconstructed(p));
            if first <= (0.5 - 0.5 * self.width) * self.smallest {
                continue;
            }
            let (at_point, of_label) = opacity([first, second, third], self.width);
            let color = [r, g, b].map(|c| c / first);
            let color = self.shading.map_or(color, |shading| {
                let lack = (of_label - self.smoothed.reconstructed(p)) / (LIT_LACK * of_label);
                let look = ShadingInputs {
                    shading: Some(shading),
                    gradient_opacity: None,
                    extinction: Extinction::Exponential,
                    reached: Reached::ALL,
                };
                let gradient = self.means[0].gradient(p);
                let length = (gradient / spacing).length() / self.opacity.description().steepness();
                let by_surface = 1.0 - (1.0 - of_label.clamp(0.0, 1.0)).powi(4);
                let lighting = Lighting::new(&self.opacity, look, gradient, to_eye);
                lighting.in_part(smooth_step(lack), length, by_surface, look).on(color)
            });
            gathered.add(color, 1.0 - (1.0 - at_point).powf(step * per_t));
        }
        gathered.rgba()
    }
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The opacity at a point with these means, and that of the label that it is part of.
fn opacity([first, second, third]: [f64; 3], width: f64) -> (f64, f64) {
    let variance = second - first * first;
    if variance <= LEAST_VARIANCE * first * first {
        return (first.clamp(0.0, LARGEST), first);
    }
    // Nodes x and weights of Gauss's quadrature with two nodes: x² = a x + b for both.
    let a = (third - first * second) / variance;
    let b = second - a * first;
    let half = (a * a / 4.0 + b).max(0.0).sqrt();
    let [smaller, larger] = [a / 2.0 - half, a / 2.0 + half];
    let share = (first - smaller) / (larger - smaller);
    let past = (share - 0.5) / width + 0.5;
    let at_point = smaller + smooth_step(past) * (larger - smaller);
    (at_point.clamp(0.0, LARGEST), if past > 0.0 { larger } else { smaller })
}

/// The means of each voxel: over the 27 voxels around it, with the weights of a Gaussian, one half at the smallest spacing. Beyond the ends,
/// the nearest voxels count. Where a label is one voxel thin, its share is such that its cut lies in the middle. In thick slices, the share is
/// that of the distance to the nearest voxel of another label in the slice.
fn means(labels: &Volume, entries: &[[f64; 4]]) -> Vec<[f64; 6]> {
    let grid = labels.grid();
    let (dims, spacing) = (grid.dims(), grid.spacing());
    let slices = thick_slices(grid);
    let mut beside = (-(spacing / spacing.min_element()).powf(2.0)).to_array().map(f64::exp2);
    if let Some((axis, _)) = slices {
        beside[axis] = 0.0;
    }
    let id = |p: [i64; 3]| {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| p[a].clamp(0, dims[a] as i64 - 1) as usize);
        labels.value((z * dims[1] + y) * dims[0] + x) as usize
    };
    let numbers = |id: usize| {
        let [r, g, b, opacity] = entries[id];
        let opacity = opacity.min(LARGEST);
        [opacity, opacity * opacity, opacity.powi(3), opacity * r, opacity * g, opacity * b]
    };
    let of_voxel = |n: usize| {
        let centre = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|c| c as i64);
        let own = id(centre);
        let mut others = [0.0; 6];
        let mut of_others = 0.0;
        for step in (0..27).map(|n: i64| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]) {
            let other = id(std::array::from_fn(|a| centre[a] + step[a]));
            if other != own {
                let weight: f64 = (0..3).map(|a| if step[a] == 0 { 1.0 } else { beside[a] } / (1.0 + 2.0 * beside[a])).product();
                of_others += weight;
                numbers(other).iter().zip(&mut others).for_each(|(number, sum)| *sum += weight * number);
            }
        }
        let is_thin = |axis: usize| {
            [-1, 1].iter().all(|step| id(std::array::from_fn(|a| centre[a] + if a == axis { *step } else { 0 })) != own)
        };
        let smooth = 1.0 - of_others;
        let thin = (0..3).filter(|&axis| beside[axis] > 0.0 && of_others > 0.0 && is_thin(axis));
        let mut share = thin.map(|axis| 1.0 - smooth * beside[axis]).fold(smooth, f64::max);
        if let Some((axis, farthest)) = slices {
            let mut distance = 2.0 * share - 1.0;
            if of_others == 0.0 {
                let voxels = (0..grid.voxel_count())
                    .map(|n| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|c| c as i64));
                let away = |p: [i64; 3]| {
                    let step = DVec3::from_array(std::array::from_fn(|a| (p[a] - centre[a]) as f64));
                    (step * spacing / spacing.min_element()).length()
                };
                let apart = voxels.filter(|p| p[axis] == centre[axis] && id(*p) != own);
                let nearest = apart.min_by(|p, q| away(*p).total_cmp(&away(*q)));
                distance = nearest.map_or(farthest, |p| (away(p) - 0.5).min(farthest));
                if let Some(p) = nearest {
                    (others, of_others) = (numbers(id(p)), 1.0);
                }
            }
            share = 0.5 + 0.5 * distance / farthest;
        }
        let scale = if of_others > 0.0 { (1.0 - share) / of_others } else { 0.0 };
        let own = numbers(own);
        std::array::from_fn(|n| share * own[n] + scale * others[n])
    };
    (0..grid.voxel_count()).map(of_voxel).collect()
}

/// The axis across thick slices, and the farthest distance in one that changes shares, in smallest spacings.
fn thick_slices(grid: &Grid) -> Option<(usize, f64)> {
    let spacing = grid.spacing();
    let axis = (0..3).find(|&axis| {
        let within = [spacing[(axis + 1) % 3], spacing[(axis + 2) % 3]];
        spacing[axis] >= THICK * within[0].max(within[1])
    })?;
    Some((axis, REACH * spacing[axis] / spacing.min_element()))
}
