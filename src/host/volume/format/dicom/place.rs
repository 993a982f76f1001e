//! Selection, order and placement of slices.

use super::image::{Frame, Image};
use crate::error::Error;
use crate::numbers::shortened;
use crate::volume::Contents;
use crate::volume::format::OpenOptions;
use crate::volume::format::load::upright;
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;

/// Tolerance of slice directions.
const SAME_DIRECTION: f64 = 1e-3;
/// Fraction of a pixel within which slices share a position.
pub(super) const SAME_PLACE: f64 = 0.01;
/// Deviation of a slice from even spacing that rounded positions have, as a fraction of the slice distance.
pub(super) const EVEN: f64 = 0.02;
/// Allowed deviation of a slice from even spacing, as a fraction of the slice distance.
pub(super) const UNEVEN: f64 = 0.1;
/// Allowed shift of the last slice against the first, as a fraction of a pixel. It accounts for rounded positions and is invisible.
pub(super) const SHIFTED: f64 = 0.5;

/// A slice: index of the image, and of the frame in it.
pub(super) type Slice = (usize, usize);

/// Slices in order, and the transform from voxel (i, j, k) to the world.
pub(super) struct Stack {
    pub slices: Vec<Slice>,
    pub index_to_world: DAffine3,
    /// Whether the slices have positions, so that the world is RAS.
    pub is_anatomical: bool,
    pub contents: Contents,
}

/// The slices of one point in time.
pub(super) fn stack(path: &Path, images: &[Image], options: &OpenOptions) -> Result<Stack, Error> {
    let all = |image: usize| (0..images[image].frames.len()).map(move |frame| (image, frame));
    let slices: Vec<Slice> = (0..images.len()).flat_map(all).collect();
    let frame = |(image, frame): Slice| &images[image].frames[frame];
    let Some(located) = located(path, &slices, frame)? else { return Ok(unlocated(path, slices, frame)) };
    let first = frame(slices[0]);
    let spacing = first.spacing.unwrap_or([1.0; 2]);
    let times = times(path, located.heights, SAME_PLACE * spacing[0].min(spacing[1]))?;
    let mut contents = Contents {
        states_spacing: first.spacing.is_some(),
        length_unit: first.spacing.map(|_| "mm".into()),
        frame_spacing: images[0].frame_spacing.clone(),
        ..Contents::default()
    };
    let time = contents.choose_frame(path, options, times[0].len())?;
    let chosen: Vec<(f64, Slice)> = times.into_iter().map(|mut slices_at_place| slices_at_place.swap_remove(time)).collect();
    let places: Vec<DVec3> = chosen.iter().filter_map(|&(_, slice)| frame(slice).position).collect();
    let heights: Vec<f64> = chosen.iter().map(|&(height, _)| height).collect();
    let mut shift = DVec3::ZERO;
    if options.spacing.is_none() {
        check_even(path, &heights, |index| &images[chosen[index].1.0].path)?;
        shift = tilt(path, &places, located.normal, spacing)?;
    }
    let [x, y] = located.axes;
    let (last, origin) = (heights.len() - 1, places[0]);
    let between = match last {
        0 => first.thickness.unwrap_or(spacing[0]),
        _ => (heights[last] - heights[0]) / last as f64,
    };
    let axes = DMat3::from_cols(x * spacing[0], y * spacing[1], located.normal * between + shift);
    let index_to_world = to_world(axes, origin);
    let slices = chosen.into_iter().map(|(_, slice)| slice).collect();
    Ok(Stack { slices, index_to_world, is_anatomical: true, contents })
}

/// The transform of axes and an origin in LPS coordinates.
pub(super) fn to_world(axes: DMat3, origin: DVec3) -> DAffine3 {
    let right_front_top = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    DAffine3 { matrix3: right_front_top * axes, translation: right_front_top * origin }
}

/// Parallel slices.
pub(super) struct Located {
    pub axes: [DVec3; 2],
    pub normal: DVec3,
    /// Position of each slice along the normal. Sorted by position, then by the order of the frames.
    pub heights: Vec<(f64, Slice)>,
}

/// `None` if slices have no positions.
pub(super) fn located<'a>(path: &Path, slices: &[Slice], frame: impl Fn(Slice) -> &'a Frame) -> Result<Option<Located>, Error> {
    let Some([x, y]) = frame(slices[0]).axes else { return Ok(None) };
    let (axes, normal) = ([x.normalize(), y.normalize()], x.cross(y).normalize_or_zero());
    let mut heights = Vec::new();
    for &slice in slices {
        let (Some([a, b]), Some(position)) = (frame(slice).axes, frame(slice).position) else { return Ok(None) };
        if !(a.normalize().abs_diff_eq(axes[0], SAME_DIRECTION) && b.normalize().abs_diff_eq(axes[1], SAME_DIRECTION)) {
            let problem = "its slices have different directions, as in localisers, so they do not form a volume: give another \
                           series, or put the slices of one direction into a separate folder";
            return Err(Error::volume(path, problem));
        }
        heights.push((position.dot(normal), slice));
    }
    heights.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| frame(a.1).order.cmp(&frame(b.1).order)));
    Ok(Some(Located { axes, normal, heights }))
}

/// Groups slices by position. All positions must have the same number of slices.
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
                "its {} positions have {least} to {most} slices each instead of equally many: slices are missing or belong to \
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
    let most_off = (0..=last).map(off).fold(0.0, f64::max);
    let gaps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let largest = (0..last).max_by(|&a, &b| gaps[a].total_cmp(&gaps[b])).unwrap_or(0);
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let (least, most) = (shortened(least), shortened(gaps[largest]));
    if most_off <= UNEVEN * between {
        if most_off > EVEN * between {
            let path = path.display();
            tracing::warn!(
                "{path}: its slice distances vary from {least} to {most}: shown as if even, {} apart",
                shortened(between)
            );
        }
        return Ok(());
    }
    let problem = format!(
        "its slice distances vary from {least} to {most}, the largest between {} and {}: add missing slices, use slices of one \
         distance, or treat them as evenly spaced by giving a spacing",
        file(largest).display(),
        file(largest + 1).display()
    );
    Err(Error::volume(path, problem))
}

/// The shift of each slice beside the one before, by a tilted gantry, if it is visible. Says of others that they are not shown.
fn tilt(path: &Path, places: &[DVec3], normal: DVec3, spacing: [f64; 2]) -> Result<DVec3, Error> {
    let way = places[places.len() - 1] - places[0];
    let along = way.dot(normal);
    let sideways = (way - normal * along).length();
    let (degrees, pixel) = (sideways.atan2(along).to_degrees(), spacing[0].min(spacing[1]));
    if sideways <= SHIFTED * pixel {
        if sideways > SAME_PLACE * pixel {
            let share = sideways / pixel;
            tracing::warn!(
                "{}: a gantry tilt of {degrees:.2} degrees shifts its last slice by {share:.2} of a pixel: shown as if upright",
                path.display()
            );
        }
        return Ok(DVec3::ZERO);
    }
    let between = way / (places.len() - 1) as f64;
    let is_even = |(n, place): (usize, &DVec3)| (places[0] + between * n as f64 - *place).length() <= SHIFTED * pixel;
    if places.iter().enumerate().all(is_even) {
        return Ok(between - normal * between.dot(normal));
    }
    let problem = format!(
        "its slices are shifted unevenly beside each other, by a gantry tilt of {degrees:.2} degrees in the mean: ignore the shifts \
         by giving a spacing"
    );
    Err(Error::volume(path, problem))
}

/// Stacks slices of which only the order is known.
fn unlocated<'a>(path: &Path, mut slices: Vec<Slice>, frame: impl Fn(Slice) -> &'a Frame) -> Stack {
    slices.sort_by_key(|&slice| frame(slice).order);
    if slices.len() > 1 {
        tracing::warn!(
            "{}: its {} slices have no positions: using the order of their instance numbers",
            path.display(),
            slices.len()
        );
    }
    let first = frame(slices[0]);
    let [x, y] = first.spacing.unwrap_or([1.0; 2]);
    let spacing = DVec3::new(x, y, first.thickness.unwrap_or(x));
    let contents = Contents {
        states_spacing: first.spacing.is_some(),
        length_unit: first.spacing.map(|_| "mm".into()),
        ..Contents::default()
    };
    Stack { slices, index_to_world: upright(spacing, DVec3::ZERO), is_anatomical: false, contents }
}
