//! Classes of values that a transfer function distinguishes: materials with boundaries between them, or nested shells of a smooth field.

use super::modes::{Mode, sum};
use super::survey::Survey;

/// Control points of a weight 0 … 1 over data values, ascending.
pub type Weights = Vec<(f64, f64)>;

/// Values that share a colour and whose opacity is chosen together.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// Range of values that have the class's colour.
    pub colored: (f64, f64),
    /// Range of values inside the class, without its boundaries.
    pub core: (f64, f64),
    /// Opacity of a class that is shown solid, relative to its largest.
    pub solid: Weights,
    /// Opacity of a class that is shown as a translucent shell, relative to its largest.
    pub shell: Weights,
}

/// The classes of a volume, ascending by value, without the background.
#[derive(Clone, Debug, PartialEq)]
pub struct Classes {
    pub classes: Vec<Class>,
    /// Whether they are nested shells of one quantity instead of materials.
    pub are_shells: bool,
    /// Values of a cavity that a material encloses. They are below the background, as the values around the volume may be, so they stay
    /// transparent.
    pub cavity: Option<(f64, f64)>,
}

/// Share of the faces that the background takes at least; with less, the lowest mode is the background.
const SURROUNDS: f64 = 0.5;
/// Share of the faces above which a mode near the background is a medium in which the object is embedded …
const EMBEDS: f64 = 0.1;
/// … and the distance to the background that counts as near, as a fraction of the range.
const NEAR: f64 = 0.15;
/// Share of the faces below which a mode beyond the background is a cavity of the object.
const ENCLOSED: f64 = 0.02;
/// Standard deviations of the background's noise that stay transparent.
const NOISE: f64 = 4.0;
/// Fewer samples above a noisy background, or a smaller share of them, are no object: all is noise, and it is shown.
const SPECKS: (f64, f64) = (8.0, 3e-4);
/// Standard deviation of white noise, relative to the median magnitude of its central differences.
const DEVIATION: f64 = 0.92;
/// Half the width of an opacity ramp at a boundary, as a fraction of the distance between the materials.
const RAMP: f64 = 0.22;
/// Half the width of a ramp between neighbouring values of integers, in bins.
const ONE_VALUE: f64 = 0.5;
/// Least half width of a ramp between two classes, as a fraction of the range: a narrower one draws noise, rounding and the grid instead of the
/// boundary.
const LEAST_RAMP: f64 = 1.0 / 64.0;
/// Distance above a boundary at which the shell ends, in units of half its ramp.
const SKIN: f64 = 2.0;
/// Interior of a translucent shell, relative to its boundary.
const INTERIOR: f64 = 0.04;
/// Position of the boundary to the background, relative to that of the strongest gradients.
const NEARER: f64 = 0.75;
/// Share of the voxels outside the background that materials must hold; with less, the field is smooth.
const FLAT: f64 = 0.08;
/// Share of the voxels outside the background, and of the range, that values above the brightest material take if they are one.
const TAIL: (f64, f64) = (0.03, 0.15);
/// Ratio of the radii of the parts above three quarters and one quarter of a smooth field's range from which it is one object.
const ONE_OBJECT: f64 = 0.7;
/// Radii of nested shells, relative to the radius of the visible part.
const SHELLS: [f64; 3] = [0.8, 0.55, 0.3];
/// Thickness of a shell in units of the distance to which opacities apply.
const THICKNESS: f64 = 3.0;

/// Finds the classes of a survey.
pub fn classes(survey: &Survey, modes: &[Mode]) -> Classes {
    let background = Background::of(survey, modes);
    let materials: Vec<&Mode> = modes.iter().filter(|mode| background.shows(mode)).collect();
    let foreground = 1.0 - background.share(survey);
    let flat: f64 = materials.iter().map(|mode| mode.share).sum();
    if materials.is_empty() || flat < FLAT * foreground {
        return smooth(survey, &background);
    }
    let cavity = modes.iter().find(|mode| background.has_below(mode)).map(|mode| (survey.value(0.0), survey.value(mode.to)));
    Classes { classes: bounded(survey, &background, &materials), are_shells: false, cavity }
}

/// What surrounds the object. Positions are bins.
struct Background {
    /// Range of values that are transparent.
    from: f64,
    to: f64,
    /// Position of the mode that is the background.
    peak: Option<f64>,
}

impl Background {
    fn of(survey: &Survey, modes: &[Mode]) -> Self {
        let on_faces =
            modes.iter().max_by(|a, b| a.face_share.total_cmp(&b.face_share)).filter(|mode| mode.face_share >= SURROUNDS);
        let lowest = modes.first().filter(|mode| mode.peak < survey.bins() as f64 / 2.0);
        let Some(mode) = on_faces.or(lowest) else { return Self { from: 0.0, to: 0.0, peak: None } };
        let noise = NOISE * deviation(survey, mode.peak);
        let near = NEAR * survey.bins() as f64;
        let embedding = |other: &&Mode| other.face_share > EMBEDS && (other.peak - mode.peak).abs() < near;
        let (mut from, mut to) = (mode.from.min(mode.peak - noise), mode.to.max(mode.peak + noise));
        for medium in modes.iter().filter(embedding) {
            (from, to) = (from.min(medium.from), to.max(medium.to));
        }
        let beyond = sum(&survey.counts[(to as usize).min(survey.bins())..]);
        if noise > 1.0 && beyond < SPECKS.0.max(SPECKS.1 * sum(&survey.counts)) {
            return Self { from: 0.0, to: 0.0, peak: None };
        }
        Self { from: from.max(0.0), to, peak: Some(mode.peak) }
    }

    /// Whether a mode is a material of the object.
    fn shows(&self, mode: &Mode) -> bool {
        mode.peak > self.to
    }

    /// Whether a mode is a cavity: below the background, and away from the faces.
    fn has_below(&self, mode: &Mode) -> bool {
        mode.peak < self.from && mode.face_share < ENCLOSED
    }

    /// Share of the voxels in the background.
    fn share(&self, survey: &Survey) -> f64 {
        sum(&survey.counts[self.from as usize..(self.to.ceil() as usize).min(survey.bins())]) / sum(&survey.counts).max(1.0)
    }
}

/// Standard deviation of the noise of flat voxels at a position, in bins.
fn deviation(survey: &Survey, position: f64) -> f64 {
    DEVIATION * survey.median_gradients[(position as usize).min(survey.bins() - 1)] * survey.bins() as f64
}

/// Position of the boundary between the feet of two materials: the top of their arc, where gradients are strongest.
fn boundary(survey: &Survey, from: f64, to: f64) -> f64 {
    let (mut weight, mut moment) = (0.0, 0.0);
    for bin in from as usize..(to as usize).min(survey.bins()) {
        let w = survey.median_gradients[bin].powi(4);
        (weight, moment) = (weight + w, moment + w * (bin as f64 + 0.5));
    }
    if weight > 0.0 { moment / weight } else { (from + to) / 2.0 }
}

/// Position of a boundary, and half the width of its ramp.
#[derive(Clone, Copy)]
struct Edge {
    at: f64,
    half: f64,
}

impl Edge {
    /// `least`: half the width, in bins, to which a ramp may reach into the two ranges.
    fn between(survey: &Survey, lower: (f64, f64), upper: (f64, f64), least: f64) -> Self {
        let at = boundary(survey, lower.1, upper.0);
        let distance = (upper.0 + upper.1 - lower.0 - lower.1) / 2.0;
        let half = (RAMP * distance).min((at - lower.1).max(least)).min((upper.0 - at).max(least));
        Self { at, half }
    }
}

impl Edge {
    /// The edge nearer to the background that ends at `end`: where parts are thinner than the resolution, values stay below a material's.
    fn nearer(self, end: f64) -> Self {
        let at = end + NEARER * (self.at - end);
        Self { at, half: self.half.min((at - end).max(0.5)) }
    }
}

/// The classes of materials that boundaries separate.
fn bounded(survey: &Survey, background: &Background, materials: &[&Mode]) -> Vec<Class> {
    let mut ranges: Vec<(f64, f64)> = materials.iter().map(|mode| (mode.from, mode.to)).collect();
    ranges.extend(tail(survey, background, materials));
    let mut edges = Vec::new();
    let mut lower = (background.from, background.to);
    for (n, &range) in ranges.iter().enumerate() {
        // The background stays transparent.
        let least = if n == 0 { ONE_VALUE } else { ONE_VALUE.max(LEAST_RAMP * survey.bins() as f64) };
        edges.push(Edge::between(survey, lower, range, least));
        lower = range;
    }
    if let [edge] = edges.as_mut_slice() {
        *edge = edge.nearer(background.to);
    }
    (0..ranges.len()).map(|n| class(survey, edges[n], edges.get(n + 1).copied())).collect()
}

/// Values above the brightest material, if they are many: a material without a mode of its own.
fn tail(survey: &Survey, background: &Background, materials: &[&Mode]) -> Option<(f64, f64)> {
    let (end, bins) = (materials.last()?.to, survey.bins() as f64);
    let outside = sum(&survey.counts) * (1.0 - background.share(survey));
    let many = sum(&survey.counts[end as usize..]) > TAIL.0 * outside;
    (many && bins - end > TAIL.1 * bins).then(|| (end + (bins - end) / 3.0, bins))
}

/// The class above an edge, up to the next one if there is another.
fn class(survey: &Survey, lower: Edge, upper: Option<Edge>) -> Class {
    let value = |position: f64| survey.value(position);
    let end = survey.bins() as f64;
    let mut solid = vec![(value(lower.at - lower.half), 0.0), (value(lower.at + lower.half), 1.0)];
    let mut shell =
        vec![(value(lower.at - lower.half), 0.0), (value(lower.at), 1.0), (value(lower.at + SKIN * lower.half), INTERIOR)];
    match upper {
        Some(upper) => {
            let ramp = [upper.at - upper.half, upper.at + upper.half].map(value);
            solid.extend([(ramp[0], 1.0), (ramp[1], 0.0)]);
            shell.extend([(ramp[0], INTERIOR), (ramp[1], 0.0)]);
        }
        None => {
            solid.push((value(end), 1.0));
            shell.push((value(end), INTERIOR));
        }
    }
    let begin = |edge: Edge| value(edge.at - edge.half);
    Class {
        colored: (begin(lower), upper.map_or(value(end), begin)),
        core: (value(lower.at + lower.half), upper.map_or(value(end), begin)),
        solid: ascending(solid),
        shell: ascending(shell),
    }
}

/// Makes values ascend where two edges are so near that their ramps overlap.
fn ascending(mut weights: Weights) -> Weights {
    for i in 1..weights.len() {
        weights[i].0 = weights[i].0.max(weights[i - 1].0);
    }
    weights
}

/// The classes of a field without materials: one, if it is one object, or nested shells.
fn smooth(survey: &Survey, background: &Background) -> Classes {
    let bins = survey.bins();
    let start = match background.peak {
        Some(_) => background.to.min(bins as f64 - 1.0),
        None => 0.1 * bins as f64,
    };
    // Radius of a ball of as many voxels as have values above a position.
    let radius = |position: f64| sum(&survey.counts[(position as usize).min(bins)..]).cbrt();
    let at = |share: f64| start + share * (bins as f64 - start);
    if radius(at(0.75)) > ONE_OBJECT * radius(at(0.25)) {
        let half = 0.2 * (bins as f64 - start);
        let edge = Edge { at: start + half * 1.25, half };
        return Classes { classes: vec![class(survey, edge, None)], are_shells: false, cavity: None };
    }
    let level = |share: f64| (start as usize..bins).find(|&bin| radius(bin as f64) <= share * radius(start)).unwrap_or(bins - 1);
    let mut levels: Vec<f64> = SHELLS.iter().map(|&share| (level(share) as f64 + 0.5).max(start + 1.0)).collect();
    levels.dedup_by(|b, a| *b - *a < 2.0);
    let class = |n: usize| {
        let at = levels[n];
        let end = levels.get(n + 1).copied().unwrap_or(bins as f64);
        let slope = survey.mean_gradients[(at as usize).min(bins - 1)] * bins as f64;
        let least = ONE_VALUE.max(LEAST_RAMP * bins as f64);
        let half = (THICKNESS / 2.0 * slope).clamp(least, (0.45 * (end - at)).max(least)).min((at - start).max(ONE_VALUE));
        let value = |position: f64| survey.value(position);
        let shell = vec![(value(at - half), 0.0), (value(at), 1.0), (value(at + half), INTERIOR / 2.0), (value(end), 0.0)];
        let solid = vec![(value(at - half), 0.0), (value(at + half), 1.0), (value(bins as f64), 1.0)];
        Class { colored: (value(at - half), value(end - half.min(end - at))), core: (value(at), value(end)), solid, shell }
    };
    Classes { classes: (0..levels.len()).map(class).collect(), are_shells: true, cavity: None }
}
