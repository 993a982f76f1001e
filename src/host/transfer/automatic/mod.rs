//! Automatic transfer function: finds materials in a sample of a volume's voxels, and opacities by what is visible of them.
//!
//! - `survey`: histograms of sampled voxels, the only pass over the volume besides its statistics;
//! - `modes`: materials are modes among voxels of weak gradient;
//! - `classes`: boundaries between materials, or nested shells where the field is smooth;
//! - `visibility`: opacities along sampled rays, so that no class hides all others.

mod classes;
mod modes;
mod survey;
mod tissues;
mod visibility;

use super::palettes::Palette;
use super::visible_range::visible_range;
use super::{ControlPoint, TransferFunction, hounsfield};
use crate::volume::Volume;
use classes::{Class, Classes};
use survey::Survey;
use visibility::{ClassOpacity, Rays};

/// Opacity of a constant volume: it is solid, since only its shape can be seen.
const CONSTANT: f64 = 0.9;
/// Half the width of a transition between colours, as a fraction of the narrower class.
const BLEND: f64 = 0.08;

/// Derives a transfer function for a volume. Opacities are found per voxel; of a level of a data set they apply per voxel of the finest.
pub(super) fn derived(volume: &Volume, palette: Palette) -> TransferFunction {
    let (found, grid) = (per_voxel(volume, palette), volume.grid());
    let thinner = grid.unit() / grid.spacing().min_element();
    if thinner == 1.0 {
        return found;
    }
    let opacities = found.opacities().iter().map(|&(value, opacity)| (value, 1.0 - (1.0 - opacity).powf(thinner))).collect();
    found.with_opacities(opacities).expect("ascending")
}

fn per_voxel(volume: &Volume, palette: Palette) -> TransferFunction {
    let statistics = volume.statistics();
    if statistics.min >= statistics.max {
        return constant(volume, palette);
    }
    let rays = Rays::new(volume);
    if hounsfield::is_ct(&statistics, volume) {
        let shown = rays.shown(&tissues::classes(), None);
        return function(&tissues::classes(), &shown, &tissues::COLORS, (statistics.min, statistics.max));
    }
    let survey = Survey::new(&statistics, volume);
    let found = modes::modes(&survey);
    let range = (statistics.min, statistics.max);
    match mirrored_if_bright(&survey, &found) {
        None => of_classes(&classes::classes(&survey, &found), &rays, palette, range),
        Some(survey) => {
            let classes = classes::classes(&survey, &modes::modes(&survey));
            let mirrored = of_classes(&classes, &rays.mirrored(), palette, (-range.1, -range.0));
            let points = |point: &ControlPoint<f64>| (-point.0, point.1);
            let colors = mirrored.colors().iter().rev().map(|&(value, color)| (-value, color)).collect();
            let opacities = mirrored.opacities().iter().rev().map(points).collect();
            TransferFunction::new(TransferFunction::AUTOMATIC, colors, opacities).expect("reversed")
        }
    }
}

/// The survey of the negated values, if the background is brighter than everything else.
fn mirrored_if_bright(survey: &Survey, found: &[modes::Mode]) -> Option<Survey> {
    let background = found.iter().max_by(|a, b| a.face_share.total_cmp(&b.face_share))?;
    let beyond = modes::sum(&survey.counts[(background.to as usize).min(survey.bins())..]);
    let below = modes::sum(&survey.counts[..background.from as usize]);
    (background.face_share > 0.8 && below > 4.0 * beyond && below > 0.0).then(|| survey.mirrored())
}

fn of_classes(classes: &Classes, rays: &Rays, palette: Palette, range: (f64, f64)) -> TransferFunction {
    let all = &classes.classes;
    let shown = rays.shown(all, classes.cavity);
    let colors = if classes.are_shells { palette.shells(all.len()) } else { palette.materials(all.len()) };
    function(all, &shown, &colors, range)
}

/// The transfer function of classes, ascending by value.
fn function(classes: &[Class], shown: &[ClassOpacity], colors: &[[f64; 3]], (lo, hi): (f64, f64)) -> TransferFunction {
    let weights: Vec<_> =
        classes.iter().zip(shown).map(|(class, shown)| if shown.is_solid { &class.solid } else { &class.shell }).collect();
    let mut values: Vec<f64> = weights.iter().flat_map(|weights| weights.iter().map(|point| point.0)).chain([lo, hi]).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let opacity = |value: f64| {
        let depth: f64 = weights.iter().zip(shown).map(|(weights, shown)| shown.depth * visibility::weight(weights, value)).sum();
        -(-depth).exp_m1()
    };
    let opacities = values.into_iter().map(|value| (value, opacity(value))).collect();
    let mut points = vec![(lo.min(classes[0].colored.0), colors[0])];
    for n in 1..classes.len() {
        let at = classes[n].colored.0;
        let half = BLEND * (classes[n].colored.1 - at).min(classes[n - 1].colored.1 - classes[n - 1].colored.0).max(0.0);
        let last = points[points.len() - 1].0;
        points.extend([((at - half).max(last), colors[n - 1]), ((at + half).max(last), colors[n])]);
    }
    let last = points[points.len() - 1].0;
    points.push((hi.max(last), colors[colors.len() - 1]));
    TransferFunction::new(TransferFunction::AUTOMATIC, points, opacities).expect("ascending")
}

/// The transfer function of a constant volume.
fn constant(volume: &Volume, palette: Palette) -> TransferFunction {
    let (lo, hi) = visible_range(volume);
    let color = palette.materials(1)[0];
    let opacities = vec![(lo, 0.0), ((lo + hi) / 2.0, 0.0), (hi, CONSTANT)];
    TransferFunction::new(TransferFunction::AUTOMATIC, vec![(lo, color), (hi, color)], opacities).expect("ascending")
}

#[cfg(test)]
mod tests;
