//! Axes of arrays that are declared: their names, roles, units and coordinates.

use super::{OpenOptions, strided};
use crate::error::Error;
use crate::volume::{Contents, FrameSpacing, lengths};
use glam::{DAffine3, DVec3};
use std::path::Path;

/// An axis as a file declares it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub name: String,
    /// `space`, `time`, `channel` or another role, or empty if not specified.
    pub kind: String,
    /// Unit, or empty if not specified.
    pub unit: String,
    /// Coordinate of its first position, and distance to the next one. 0 and 1 if not specified.
    pub first: f64,
    pub step: f64,
    /// Whether the file states the distance.
    pub has_step: bool,
}

impl Default for Axis {
    fn default() -> Self {
        let text = String::new;
        Self { name: text(), kind: text(), unit: text(), first: 0.0, step: 1.0, has_step: false }
    }
}

/// Distances may differ by this fraction: coordinates may be 32-bit floats.
const EVEN: f64 = 1e-3;

impl Axis {
    /// An axis of this name.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The axis with the role that the CF conventions state (`axis`).
    #[cfg(feature = "hdf5")]
    pub fn with_role(self, role: Option<&str>) -> Self {
        match role {
            Some("T") => Self { kind: "time".into(), ..self },
            Some(role @ ("X" | "Y" | "Z")) => Self { kind: "space".into(), name: role.into(), ..self },
            _ => self,
        }
    }

    /// The axis at these coordinates, if they are evenly spaced.
    pub fn at(self, coordinates: &[f64], unit: String) -> Self {
        let Some((first, step)) = evenly_spaced(coordinates) else { return Self { unit, ..self } };
        Self { unit, first, step, has_step: true, ..self }
    }
}

/// The first coordinate, and the distance between all; `None` if they are uneven or fewer than two.
fn evenly_spaced(coordinates: &[f64]) -> Option<(f64, f64)> {
    let [first, .., last] = coordinates else { return None };
    let step = (last - first) / (coordinates.len() - 1) as f64;
    let is_near = |(n, &at): (usize, &f64)| (first + step * n as f64 - at).abs() <= EVEN * step.abs();
    (step != 0.0 && step.is_finite() && coordinates.iter().enumerate().all(is_near)).then_some((*first, step))
}

/// Names of axes in lower case, in order of x, y and z. The geographic ones are those of the CF conventions.
const SPACE: [&[&str]; 3] = [
    &["x", "lon", "longitude", "rlon", "xc", "easting"],
    &["y", "lat", "latitude", "rlat", "yc", "northing"],
    &["z", "depth", "lev", "level", "height", "altitude", "alt", "plev"],
];
const TIME: &[&str] = &["t", "time", "times"];
const CHANNEL: &[&str] = &["c", "channel", "channels", "band", "bands"];

/// Roles of the axes of an array.
#[derive(Debug)]
pub(super) struct Roles {
    /// Axes of x, y and z.
    pub space: [Option<usize>; 3],
    pub frames: Vec<usize>,
    pub channels: Vec<usize>,
}

impl Roles {
    /// Roles by type or name. Of axes without either, the last ones are x, y and z, unless others are called so, and those before them
    /// frames.
    pub fn new(axes: &[Axis], count: usize) -> Self {
        let is_called = |i: usize, names: &[&str]| {
            axes.get(i).is_some_and(|axis: &Axis| names.contains(&axis.name.to_ascii_lowercase().as_str()))
        };
        let is = |i: usize, kind: &str, names: &[&str]| match axes.get(i).map(|axis| axis.kind.as_str()) {
            None | Some("") => is_called(i, names),
            Some(own) => own == kind,
        };
        let channels: Vec<usize> = (0..count).filter(|&i| is(i, "channel", CHANNEL)).collect();
        let rest: Vec<usize> = (0..count).filter(|i| !channels.contains(i) && !is(*i, "time", TIME)).collect();
        let mut space = SPACE.map(|names| rest.iter().copied().find(|&i| is_called(i, names)));
        let mut others = rest.into_iter().rev().filter(|i| !space.contains(&Some(*i))).collect::<Vec<_>>().into_iter();
        for axis in space.iter_mut().filter(|axis| axis.is_none()) {
            *axis = others.next();
        }
        let frames = (0..count).filter(|i| !channels.contains(i) && !space.contains(&Some(*i))).collect();
        Self { space, frames, channels }
    }

    /// Voxels along x, y and z.
    pub fn dims(&self, shape: &[usize]) -> [usize; 3] {
        self.space.map(|axis| axis.map_or(1, |axis| shape[axis]))
    }

    /// Selects a frame and a channel. Returns their position along all axes, 0 along those of space.
    pub fn choose(
        &self,
        path: &Path,
        options: &OpenOptions,
        shape: &[usize],
        contents: &mut Contents,
    ) -> Result<Vec<usize>, Error> {
        let counts = |axes: &[usize]| axes.iter().map(|&axis| shape[axis]).collect::<Vec<_>>();
        let all = |counts: &[usize]| counts.iter().fold(1usize, |n, &size| n.saturating_mul(size));
        let (frames, channels) = (counts(&self.frames), counts(&self.channels));
        let frame = contents.choose_frame(path, options, all(&frames))?;
        let channel = contents.choose_channel(path, options, all(&channels))?;
        let mut at = vec![0; shape.len()];
        for (axes, places) in
            [(&self.frames, strided::place(frame, &frames)), (&self.channels, strided::place(channel, &channels))]
        {
            axes.iter().zip(places).for_each(|(&axis, place)| at[axis] = place);
        }
        Ok(at)
    }

    /// Distance between frames, if they have one axis whose unit and distance are stated.
    fn frame_spacing(&self, axes: &[Axis]) -> Option<FrameSpacing> {
        let [axis] = self.frames[..] else { return None };
        let Axis { unit, step, .. } = axes.get(axis)?;
        // "days since 1950-01-01" are days.
        let unit = unit.split_whitespace().next()?;
        FrameSpacing::new(*step, Some(if ["second", "seconds"].contains(&unit) { "s" } else { unit }))
    }

    /// Placement of the voxels along the axes of space, in the unit of x. Completes what `contents` say about distances.
    pub fn place(&self, path: &Path, axes: &[Axis], shape: &[usize], contents: &mut Contents) -> DAffine3 {
        contents.frame_spacing = self.frame_spacing(axes);
        let long = |axis: &Option<usize>| axis.filter(|&axis| shape[axis] > 1).and_then(|axis| axes.get(axis));
        let along: Vec<&Axis> = self.space.iter().filter_map(long).collect();
        contents.states_spacing = !along.is_empty() && along.iter().all(|axis| axis.has_step);
        let units: Vec<&str> = along.iter().map(|axis| axis.unit.as_str()).collect();
        let listed = || along.iter().map(|axis| format!("{} in {}", axis.name, axis.unit)).collect::<Vec<_>>().join(", ");
        let Some((unit, factors)) = common_unit(&units) else {
            if contents.states_spacing {
                tracing::warn!("{}: its axes have different units ({}): voxels are taken as cubes", path.display(), listed());
            }
            contents.states_spacing = false;
            return DAffine3::IDENTITY;
        };
        if !contents.states_spacing {
            let names: Vec<&str> = along.iter().filter(|axis| !axis.has_step).map(|axis| axis.name.as_str()).collect();
            if names.len() < along.len() {
                let names = names.join(", ");
                tracing::warn!(
                    "{}: its positions along {names} are not evenly spaced: voxels are taken as cubes",
                    path.display()
                );
            }
            return DAffine3::IDENTITY;
        }
        if units.iter().any(|unit| unit.is_empty()) && unit.is_some() {
            tracing::warn!("{}: some of its axes have no unit ({}): it is taken as that of the others", path.display(), listed());
        }
        contents.length_unit = unit;
        let factor = |axis: &Axis| along.iter().position(|other| *other == axis).map_or(1.0, |n| factors[n]);
        let of = |read: &dyn Fn(&Axis) -> f64, missing: f64| {
            DVec3::from_array(
                self.space.map(|axis| axis.and_then(|i| axes.get(i)).map_or(missing, |axis| read(axis) * factor(axis))),
            )
        };
        let steps = of(&|axis| if axis.step == 0.0 { 1.0 } else { axis.step }, 1.0);
        super::load::upright(steps, of(&|axis| axis.first, 0.0))
    }
}

/// The unit of the first axis that has one, and the factors that convert lengths along each axis to it. `None` if units cannot be converted.
fn common_unit(units: &[&str]) -> Option<(Option<String>, Vec<f64>)> {
    let Some(first) = units.iter().find(|unit| !unit.is_empty()) else { return Some((None, vec![1.0; units.len()])) };
    let factor = |unit: &&str| match (lengths::metres(unit), lengths::metres(first)) {
        _ if unit.is_empty() || unit == first => Some(1.0),
        (Some(unit), Some(first)) => Some(unit / first),
        // Degrees east and degrees north.
        _ => (unit.starts_with("degree") && first.starts_with("degree")).then_some(1.0),
    };
    let factors: Option<Vec<f64>> = units.iter().map(factor).collect();
    Some((Some(lengths::symbol(first).unwrap_or(first).to_owned()), factors?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roles(names: &[&str]) -> ([Option<usize>; 3], Vec<usize>, Vec<usize>) {
        let axes: Vec<Axis> = names.iter().map(|name| Axis::named(*name)).collect();
        let found = Roles::new(&axes, names.len());
        (found.space, found.frames, found.channels)
    }

    #[test]
    fn axes_are_told_by_their_names_or_their_order() {
        assert_eq!(roles(&["t", "c", "z", "y", "x"]), ([Some(4), Some(3), Some(2)], vec![0], vec![1]));
        assert_eq!(roles(&["x", "y", "z", "c"]), ([Some(0), Some(1), Some(2)], vec![], vec![3]));
        assert_eq!(roles(&["", "", "", ""]), ([Some(3), Some(2), Some(1)], vec![0], vec![]));
        assert_eq!(roles(&["lat", "lon"]), ([Some(1), Some(0), None], vec![], vec![]));
        assert_eq!(roles(&["lon", "lat", "depth", "time"]), ([Some(0), Some(1), Some(2)], vec![3], vec![]));
        assert_eq!(roles(&["x", "y", "z", "member"]), ([Some(0), Some(1), Some(2)], vec![3], vec![]));
        assert_eq!(roles(&["time", "sigma", "latitude", "longitude"]), ([Some(3), Some(2), Some(1)], vec![0], vec![]));
        assert_eq!(roles(&["z", "x"]), ([Some(1), None, Some(0)], vec![], vec![]));
    }

    fn placed(axes: &[Axis]) -> (DAffine3, Contents) {
        let mut contents = Contents::default();
        let place = Roles::new(axes, axes.len()).place(Path::new("t"), axes, &vec![4; axes.len()], &mut contents);
        (place, contents)
    }

    #[test]
    fn lengths_of_all_axes_are_in_one_unit() {
        let axis = |name: &str, unit: &str, step| Axis { unit: unit.into(), step, has_step: true, ..Axis::named(name) };
        let axes = [axis("z", "nanometer", 500.0), axis("y", "micrometer", 0.25), axis("x", "micrometer", 0.125)];
        let (place, contents) = placed(&axes);
        assert_eq!((place.matrix3.col(0).x, place.matrix3.col(1).y, place.matrix3.col(2).z), (0.125, 0.25, 0.5));
        assert_eq!((contents.length_unit.as_deref(), contents.states_spacing), (Some("µm"), true));
        // Depth in metres and positions in degrees have no common unit.
        let (place, contents) =
            placed(&[axis("depth", "m", 5.0), axis("lat", "degrees_north", 0.25), axis("lon", "degrees_east", 0.5)]);
        assert_eq!((place, contents.states_spacing), (DAffine3::IDENTITY, false));
        let (place, _) = placed(&[axis("lat", "degrees_north", 0.25), axis("lon", "degrees_east", 0.5)]);
        assert_eq!((place.matrix3.col(0).x, place.matrix3.col(1).y), (0.5, 0.25));
    }

    #[test]
    fn coordinates_are_used_where_they_are_even() {
        let axis = |name: &str, coordinates: &[f64]| Axis::named(name).at(coordinates, "m".into());
        let even = [axis("y", &[3.0, 5.0, 7.0, 9.0]), axis("x", &[2.0, 1.5, 1.0, 0.5])];
        let (place, contents) = placed(&even);
        assert_eq!(place.translation, DVec3::new(2.0, 3.0, 0.0));
        assert_eq!((place.matrix3.col(0).x, place.matrix3.col(1).y, contents.states_spacing), (-0.5, 2.0, true));
        let (place, contents) = placed(&[axis("y", &[3.0, 5.0, 7.0, 90.0]), even[1].clone()]);
        assert_eq!((place, contents.states_spacing), (DAffine3::IDENTITY, false));
    }

    #[test]
    fn times_are_apart_where_a_unit_says_so() {
        let apart = |unit: &str| {
            let time = Axis { unit: unit.into(), step: 0.5, ..Axis::named("t") };
            placed(&[time, Axis::named("z"), Axis::named("y"), Axis::named("x")]).1.frame_spacing
        };
        assert_eq!(apart("second"), FrameSpacing::new(0.5, Some("s")));
        assert_eq!(apart("hours since 1950-01-01"), FrameSpacing::new(0.5, Some("hours")));
        assert_eq!(apart(""), None);
    }
}
