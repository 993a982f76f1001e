//! Which slices make a volume, and where they lie.

use super::image::{Frame, Image};
use crate::error::Error;
use crate::volume::format::load::upright;
use crate::volume::format::{OpenOptions, choice};
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;

/// How far directions of slices may be apart.
const SAME_DIRECTION: f64 = 1e-3;
/// Share of a pixel up to which slices lie at one place.
const SAME_PLACE: f64 = 0.01;
/// Share of the distance between slices by which one may lie beside where it would be if all were even.
const UNEVEN: f64 = 0.1;
/// Share of a pixel by which the last slice may be shifted against the first: the rounding of positions, which nobody sees.
const SHIFTED: f64 = 0.5;

/// A slice: an image's number, and a frame's in it.
pub(super) type Slice = (usize, usize);

/// Slices in order, and where voxel (i, j, k) of them sits, to the right, the front and the top.
pub(super) struct Stack {
    pub slices: Vec<Slice>,
    pub index_to_world: DAffine3,
}

/// The slices of one time.
pub(super) fn stack(path: &Path, images: &[Image], options: &OpenOptions) -> Result<Stack, Error> {
    let all = |image: usize| (0..images[image].frames.len()).map(move |frame| (image, frame));
    let slices: Vec<Slice> = (0..images.len()).flat_map(all).collect();
    let frame = |(image, frame): Slice| &images[image].frames[frame];
    let Some(located) = located(path, &slices, frame)? else { return unlocated(path, slices, frame, options) };
    let first = frame(slices[0]);
    let spacing = first.spacing.unwrap_or([1.0; 2]);
    let times = times(path, located.heights, SAME_PLACE * spacing[0].min(spacing[1]))?;
    let time = choice::chosen(path, "frame", options.frame, times[0].len())?;
    let chosen: Vec<(f64, Slice)> = times.into_iter().map(|mut of_place| of_place.swap_remove(time)).collect();
    let places: Vec<DVec3> = chosen.iter().filter_map(|&(_, slice)| frame(slice).position).collect();
    let heights: Vec<f64> = chosen.iter().map(|&(height, _)| height).collect();
    if options.spacing.is_none() {
        check_even(path, &heights, |index| &images[chosen[index].1.0].path)?;
        check_upright(path, &places, located.normal, spacing)?;
    }
    let [x, y] = located.axes;
    let (last, origin) = (heights.len() - 1, places[0]);
    let between = match last {
        0 => first.thickness.unwrap_or(spacing[0]),
        _ => (heights[last] - heights[0]) / last as f64,
    };
    let axes = DMat3::from_cols(x * spacing[0], y * spacing[1], located.normal * between);
    let right_front_top = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    let index_to_world = DAffine3 { matrix3: right_front_top * axes, translation: right_front_top * origin };
    Ok(Stack { slices: chosen.into_iter().map(|(_, slice)| slice).collect(), index_to_world })
}

/// Slices of one direction.
struct Located {
    axes: [DVec3; 2],
    normal: DVec3,
    /// How far each slice lies along the normal, sorted by that, and what those of one place are sorted by.
    heights: Vec<(f64, Slice)>,
}

/// Nothing where slices have no places.
fn located<'a>(path: &Path, slices: &[Slice], frame: impl Fn(Slice) -> &'a Frame) -> Result<Option<Located>, Error> {
    let Some([x, y]) = frame(slices[0]).axes else { return Ok(None) };
    let (axes, normal) = ([x.normalize(), y.normalize()], x.cross(y).normalize_or_zero());
    let mut heights = Vec::new();
    for &slice in slices {
        let (Some([a, b]), Some(position)) = (frame(slice).axes, frame(slice).position) else { return Ok(None) };
        if !(a.normalize().abs_diff_eq(axes[0], SAME_DIRECTION) && b.normalize().abs_diff_eq(axes[1], SAME_DIRECTION)) {
            let problem = "its slices lie in several directions, as those of overviews do: they make no volume; give another series, or \
                           put those of one direction into a folder of their own";
            return Err(Error::volume(path, problem));
        }
        heights.push((position.dot(normal), slice));
    }
    heights.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| frame(a.1).order.cmp(&frame(b.1).order)));
    Ok(Some(Located { axes, normal, heights }))
}

/// All slices of each place: as many everywhere.
fn times(path: &Path, heights: Vec<(f64, Slice)>, same: f64) -> Result<Vec<Vec<(f64, Slice)>>, Error> {
    let mut places: Vec<Vec<(f64, Slice)>> = Vec::new();
    for found in heights {
        match places.last_mut() {
            Some(place) if found.0 - place[0].0 <= same => place.push(found),
            _ => places.push(vec![found]),
        }
    }
    let (least, most) = (places.iter().map(Vec::len).min(), places.iter().map(Vec::len).max());
    match (least, most) {
        (Some(least), Some(most)) if least == most => Ok(places),
        (least, most) => {
            let [least, most] = [least, most].map(Option::unwrap_or_default);
            let problem = format!(
                "at each of its {} places there should be as many slices, and there are {least} to {most}: some are missing, or of \
                 another series",
                places.len()
            );
            Err(Error::volume(path, problem))
        }
    }
}

fn check_even<'a>(path: &Path, heights: &[f64], file: impl Fn(usize) -> &'a std::path::PathBuf) -> Result<(), Error> {
    let Some(last) = heights.len().checked_sub(1).filter(|&last| last > 0) else { return Ok(()) };
    let between = (heights[last] - heights[0]) / last as f64;
    let off = |k: usize| (heights[k] - heights[0] - k as f64 * between).abs();
    if (0..=last).all(|k| off(k) <= UNEVEN * between) {
        return Ok(());
    }
    let gaps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let largest = (0..last).max_by(|&a, &b| gaps[a].total_cmp(&gaps[b])).unwrap_or(0);
    let (least, most) = (gaps.iter().copied().fold(f64::INFINITY, f64::min), gaps[largest]);
    let problem = format!(
        "its slices are {least} to {most} apart, most between {} and {}: some are missing, or the distance changes; add them, take \
         those of one distance, or show them as if they were even, with a spacing",
        file(largest).display(),
        file(largest + 1).display()
    );
    Err(Error::volume(path, problem))
}

/// Refuses slices that are shifted against each other.
fn check_upright(path: &Path, places: &[DVec3], normal: DVec3, spacing: [f64; 2]) -> Result<(), Error> {
    let way = places[places.len() - 1] - places[0];
    let along = way.dot(normal);
    let sideways = (way - normal * along).length();
    if sideways <= SHIFTED * spacing[0].min(spacing[1]) {
        return Ok(());
    }
    let degrees = sideways.atan2(along).to_degrees();
    let problem = format!(
        "its slices are shifted against each other by a tilt of {degrees:.2} degrees (of a scanner's gantry): sheared grids cannot be \
         rendered yet; resample it onto axes at right angles, or show it as if it were upright, with a spacing"
    );
    Err(Error::volume(path, problem))
}

/// Slices of which nothing but their order is known.
fn unlocated<'a>(
    path: &Path,
    mut slices: Vec<Slice>,
    frame: impl Fn(Slice) -> &'a Frame,
    options: &OpenOptions,
) -> Result<Stack, Error> {
    choice::chosen(path, "frame", options.frame, 1)?;
    slices.sort_by_key(|&slice| frame(slice).order);
    if slices.len() > 1 {
        tracing::warn!(
            "{}: it does not tell where its {} slices lie: they are in the order of their numbers",
            path.display(),
            slices.len()
        );
    }
    let first = frame(slices[0]);
    let [x, y] = first.spacing.unwrap_or([1.0; 2]);
    let spacing = DVec3::new(x, y, first.thickness.unwrap_or(x));
    Ok(Stack { slices, index_to_world: upright(spacing, DVec3::ZERO) })
}
