//! Roles of the axes, and their placement in the world.

use super::fields::Fields;
use crate::error::Error;
use crate::volume::format::{OpenOptions, choice, load};
use crate::volume::lengths;
use crate::volume::{Contents, FrameSpacing, Grid, ScalarType};
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;

/// Limit of axes in the format.
const MOST: usize = 16;

/// Axes of an array, fastest first.
pub(super) struct Axes {
    pub sizes: Vec<usize>,
    /// Directions of spatial axes.
    directions: Vec<Option<DVec3>>,
    /// Indices of the spatial axes.
    space: Vec<usize>,
    roles: Vec<Role>,
}

/// Place of a frame and a channel in the array.
pub(super) struct Place {
    pub first: u64,
    /// Strides in bytes along x, y, z.
    pub strides: [u64; 3],
    /// Stride in bytes along the axis of channels.
    pub component_stride: u64,
    pub contents: Contents,
}

/// What an axis is, as far as its kind, its unit or its direction tells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    /// An axis of space.
    Space,
    /// Frames, wherever the axis stands among the others.
    Time,
    /// Components of a vector.
    Vector,
    /// Other numbers that belong together: a colour, a matrix.
    Components,
    /// A list, or no role is declared: frames if the axis is slower than space, channels if it is faster.
    Unknown,
}

impl Axes {
    pub fn from_fields(fields: &Fields) -> Result<Self, Error> {
        let count = fields.need("dimension")?.parse().ok().filter(|n| (1..=MOST).contains(n));
        let count = count.ok_or_else(|| fields.wrong(format!("its dimension is not between 1 and {MOST}")))?;
        let sizes: Vec<usize> = fields.numbers("sizes", count)?.ok_or_else(|| fields.wrong("its header has no 'sizes'"))?;
        if sizes.contains(&0) || sizes.iter().try_fold(1u64, |n, &size| n.checked_mul(size as u64)).is_none() {
            return Err(fields.wrong(format!("its sizes {sizes:?} are empty or too large")));
        }
        let (directions, mut roles): (Vec<_>, Vec<_>) = directions(fields, count)?.into_iter().unzip();
        for (role, declared) in roles.iter_mut().zip(declared_roles(fields, count)) {
            if *role == Role::Unknown {
                *role = declared;
            }
        }
        let space = space(fields, &sizes, &directions, &roles)?;
        Ok(Self { sizes, directions, space, roles })
    }

    /// Bytes of the whole array.
    pub fn bytes(&self, scalar: ScalarType) -> u64 {
        self.stride(self.sizes.len(), scalar)
    }

    /// Stride along an axis in bytes.
    pub fn stride(&self, axis: usize, scalar: ScalarType) -> u64 {
        self.sizes[..axis].iter().fold(scalar.bytes() as u64, |bytes, &size| bytes.saturating_mul(size as u64))
    }

    fn dims(&self) -> [usize; 3] {
        [0, 1, 2].map(|i| self.space.get(i).map_or(1, |&axis| self.sizes[axis]))
    }

    /// Grid in the world. Its coordinates are RAS if the file defines anatomical axes.
    pub fn grid(&self, path: &Path, fields: &Fields, options: &OpenOptions) -> Result<Grid, Error> {
        let named = |e: Error| Error::volume(path, e.to_string());
        if let Some(spacing) = options.spacing {
            return Grid::new(self.dims(), spacing).map_err(named);
        }
        let to_ras = to_ras(fields.get("space").unwrap_or_default());
        let known: Vec<DVec3> = self.space.iter().filter_map(|&axis| self.directions[axis]).collect();
        if known.is_empty() {
            return self.spaced(fields).map_err(named);
        }
        let axes = completed(&known);
        let origin =
            fields.get("space origin").map(|text| vector(text).ok_or_else(|| fields.wrong("its space origin is no vector")));
        let origin = origin.map(|origin| origin.map(|(place, _time)| place));
        let origin = origin.transpose()?.unwrap_or(DVec3::ZERO);
        let place = |to_world: DMat3| {
            let affine = DAffine3 { matrix3: to_world * axes, translation: to_world * origin };
            load::grid_of_patient(path, self.dims(), affine, to_ras.is_some(), options)
        };
        place(to_ras.unwrap_or(DMat3::IDENTITY))
    }

    /// Axis-aligned grid from `spacings` and `axis mins`.
    fn spaced(&self, fields: &Fields) -> Result<Grid, Error> {
        let per_axis = |name: &str| -> Result<DVec3, Error> {
            let numbers: Option<Vec<f64>> = fields.numbers(name, self.sizes.len())?;
            let of = |i: usize| Some(numbers.as_ref()?[*self.space.get(i)?]).filter(|n| n.is_finite());
            let unknown = if name == "spacings" { 1.0 } else { 0.0 };
            Ok(DVec3::from_array([0, 1, 2].map(|i| of(i).unwrap_or(unknown))))
        };
        let (spacing, origin) = (per_axis("spacings")?, per_axis("axis mins")?);
        Grid::from_affine(self.dims(), DAffine3 { matrix3: DMat3::from_diagonal(spacing), translation: origin })
    }

    /// Name of the option that selects an index along a non-spatial axis.
    fn chosen_by(&self, axis: usize) -> &'static str {
        let is_slow = self.space.iter().all(|&space_axis| axis > space_axis);
        match self.roles[axis] {
            Role::Time => "frame",
            Role::Vector | Role::Components => "channel",
            Role::Space | Role::Unknown => {
                if is_slow {
                    "frame"
                } else {
                    "channel"
                }
            }
        }
    }

    /// Unit of lengths, if all axes in space have one.
    fn length_unit(&self, fields: &Fields) -> Option<String> {
        let (of_space, of_axes) = (quoted(fields, "space units"), units(fields));
        let stated: Vec<&str> = if of_space.is_empty() {
            self.space.iter().filter_map(|&axis| of_axes.get(axis).copied()).collect()
        } else {
            of_space
        };
        let symbols: Option<Vec<_>> = stated.into_iter().map(lengths::symbol).collect();
        let symbols = symbols?;
        symbols.iter().all(|symbol| symbol == &symbols[0]).then(|| symbols.first().map(ToString::to_string))?
    }

    /// The first byte and the strides of the frame and the channel that are wanted, and what there is to choose from.
    pub fn place(&self, fields: &Fields, path: &Path, scalar: ScalarType, options: &OpenOptions) -> Result<Place, Error> {
        let states_spacing = !self.directions.iter().all(Option::is_none) || fields.get("spacings").is_some();
        let (mut first, mut component_stride) = (0, 0);
        let mut contents = Contents { states_spacing, length_unit: self.length_unit(fields), ..Contents::default() };
        let others = || (0..self.sizes.len()).filter(|axis| !self.space.contains(axis) && self.sizes[*axis] > 1);
        for (field, wanted) in [("frame", options.frame), ("channel", options.channel)] {
            let axes: Vec<usize> = others().filter(|&axis| self.chosen_by(axis) == field).collect();
            if axes.is_empty() {
                choice::chosen(path, field, wanted, 1)?;
            }
            let is_single = axes.len() == 1;
            for axis in axes {
                let several = self.sizes[axis];
                let chosen = if field == "frame" {
                    contents.frame_spacing = frame_spacing(fields, axis, self.sizes.len());
                    contents.choose_frame(path, options, several)?
                } else if is_single {
                    component_stride = self.stride(axis, scalar);
                    contents.choose_component(path, options, several, self.roles[axis] == Role::Vector)?
                } else {
                    contents.choose_channel(path, options, several)?
                };
                first += chosen as u64 * self.stride(axis, scalar);
            }
        }
        // The index of a frame is the same along all axes of frames.
        let of_frames = others().filter(|&axis| self.chosen_by(axis) == "frame").map(|axis| self.sizes[axis]);
        contents.frames = of_frames.min().unwrap_or(1);
        let along = |i: usize| self.space.get(i).map_or(scalar.bytes() as u64, |&axis| self.stride(axis, scalar));
        let mut strides = [0, 1, 2].map(along);
        // Missing axes have one voxel: use dense strides.
        for i in self.space.len()..3 {
            strides[i] = strides[i - 1].saturating_mul(self.dims()[i - 1] as u64);
        }
        Ok(Place { first, strides, component_stride, contents })
    }
}

/// Units that are quoted in a field, one after the other.
fn quoted<'a>(fields: &'a Fields, name: &str) -> Vec<&'a str> {
    fields.get(name).map(|text| text.split('"').skip(1).step_by(2).collect()).unwrap_or_default()
}

/// Spacing of an axis of frames, with its unit.
fn frame_spacing(fields: &Fields, axis: usize, count: usize) -> Option<FrameSpacing> {
    let spacings: Vec<f64> = fields.numbers("spacings", count).ok()??;
    FrameSpacing::new(spacings[axis], units(fields).get(axis).copied())
}

/// Units of the axes, as far as they are stated.
fn units(fields: &Fields) -> Vec<&str> {
    quoted(fields, "units")
}

/// The direction of each axis in space, and its role as far as that tells it.
fn directions(fields: &Fields, count: usize) -> Result<Vec<(Option<DVec3>, Role)>, Error> {
    let Some(text) = fields.get("space directions") else { return Ok(vec![(None, Role::Unknown); count]) };
    let wrong = || {
        fields.wrong(format!("its space directions, '{text}', are not {count} times 'none' or a vector of 1 to 4 finite numbers"))
    };
    let mut directions = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = if rest.starts_with('(') {
            rest.find(')').ok_or_else(wrong)? + 1
        } else {
            rest.find(char::is_whitespace).unwrap_or(rest.len())
        };
        let (word, behind) = rest.split_at(end);
        directions.push(match word {
            "none" => (None, Role::Unknown),
            _ => match vector(word).ok_or_else(wrong)? {
                // Vectors of NaN say none, too.
                (place, time) if place.is_nan() || time.is_nan() => (None, Role::Unknown),
                (place, 0.0) => (Some(place), Role::Space),
                (DVec3::ZERO, _) => (None, Role::Time),
                _ => {
                    return Err(fields.wrong(format!(
                        "its space directions, '{text}', mix space with a fourth dimension: save a volume per time"
                    )));
                }
            },
        });
        rest = behind.trim_start();
    }
    if directions.len() == count { Ok(directions) } else { Err(wrong()) }
}

/// `(x,y,z,t)`, or fewer numbers: in space, and along a fourth dimension, which is time ("…-time", `space dimension: 4`).
fn vector(text: &str) -> Option<(DVec3, f64)> {
    let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Vec<f64> = inner.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    let of = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
    (1..=4).contains(&numbers.len()).then(|| (DVec3::new(of(0), of(1), of(2)), of(3)))
}

/// The roles that kinds and units tell (<https://teem.sourceforge.net/nrrd/format.html#kinds>).
fn declared_roles(fields: &Fields, count: usize) -> Vec<Role> {
    let kinds: Vec<String> =
        fields.get("kinds").map(|text| text.split_whitespace().map(str::to_ascii_lowercase).collect()).unwrap_or_default();
    // `"mm" "mm" "mm" "s"`.
    let units = units(fields);
    let is_time = |unit: &&str| ["s", "sec", "seconds", "ms", "us", "min", "h"].contains(unit);
    let role = |axis: usize| match kinds.get(axis).map_or("none", String::as_str) {
        "time" => Role::Time,
        "domain" | "none" | "???" if units.len() == count && is_time(&units[axis]) => Role::Time,
        "domain" | "space" => Role::Space,
        "list" | "none" | "???" => Role::Unknown,
        "vector" | "covariant-vector" | "normal" | "2-vector" | "3-vector" | "4-vector" | "3-gradient" | "3-normal" => {
            Role::Vector
        }
        // The others are colours and matrices under many names.
        _ => Role::Components,
    };
    (0..count).map(role).collect()
}

/// Completes up to three directions by orthogonal ones.
fn completed(known: &[DVec3]) -> DMat3 {
    let third = |a: DVec3, b: DVec3| a.cross(b).normalize_or(DVec3::Z);
    match *known {
        [a, b, c] => DMat3::from_cols(a, b, c),
        [a, b] => DMat3::from_cols(a, b, third(a, b)),
        [a] => DMat3::from_cols(a, a.any_orthonormal_vector(), third(a, a.any_orthonormal_vector())),
        _ => DMat3::IDENTITY,
    }
}

/// Selects the spatial axes: those with a direction; else those of a spatial kind; else all except time axes. More than three are
/// reduced to three by dropping axes at the ends.
fn space(fields: &Fields, sizes: &[usize], directions: &[Option<DVec3>], roles: &[Role]) -> Result<Vec<usize>, Error> {
    let those = |wanted: &dyn Fn(usize) -> bool| (0..sizes.len()).filter(|&axis| wanted(axis)).collect::<Vec<usize>>();
    let directed = those(&|axis| directions[axis].is_some());
    let by_kind = those(&|axis| roles[axis] == Role::Space);
    let mut found = if !directed.is_empty() {
        directed
    } else if !by_kind.is_empty() {
        by_kind
    } else {
        those(&|axis| roles[axis] != Role::Time)
    };
    while found.len() > 3 {
        let (front, back) = (sizes[found[0]], sizes[found[found.len() - 1]]);
        if found.len() > 4 || back < front {
            found.pop()
        } else {
            Some(found.remove(0))
        };
    }
    if found.is_empty() { Err(fields.wrong("none of its axes is spatial")) } else { Ok(found) }
}

/// Transform from a named anatomical space to RAS; `None` for other spaces.
fn to_ras(space: &str) -> Option<DMat3> {
    let letters: Vec<char> = match space.to_ascii_lowercase().split('-').collect::<Vec<_>>()[..] {
        [name] => name.chars().collect(),
        ref names => names.iter().filter_map(|name| name.chars().next()).collect(),
    };
    let axis = |letter: &char| match letter {
        'r' => Some(DVec3::X),
        'l' => Some(DVec3::NEG_X),
        'a' => Some(DVec3::Y),
        'p' => Some(DVec3::NEG_Y),
        's' => Some(DVec3::Z),
        'i' => Some(DVec3::NEG_Z),
        _ => None,
    };
    let axes: Option<Vec<DVec3>> = letters.iter().take(3).map(axis).collect();
    match axes?[..] {
        [x, y, z] => Some(DMat3::from_cols(x, y, z)).filter(|to_ras| to_ras.determinant() != 0.0),
        _ => None,
    }
}
