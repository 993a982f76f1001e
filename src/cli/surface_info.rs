//! `layersplat info` of a surface.

use super::numbers::shortened;
use super::surfaces::{Place, position};
use crate::error::Error;
use crate::surface::{Per, Shape, Surface, SurfaceArray, SurfaceFile};
use crate::volume::Grid;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

#[derive(Serialize)]
struct Info {
    format: String,
    points: usize,
    /// Also those of polygons and strips.
    triangles: usize,
    /// Whether the triangles are closed.
    closed: Option<bool>,
    lines: usize,
    /// Points that are shown as spheres.
    single_points: usize,
    bounds: [[f64; 3]; 2],
    normals: bool,
    /// What has colours.
    colors: Option<&'static str>,
    arrays: Vec<ArrayReport>,
    /// The axes of a patient, if the file states them.
    space: Option<&'static str>,
    header: String,
}

/// A surface beside a volume.
#[derive(Serialize)]
pub(super) struct PlaceReport {
    name: String,
    points: usize,
    cells: usize,
    /// Without points there are none.
    bounds: Option<[[f64; 3]; 2]>,
    /// Whether its bounds meet those of the volume.
    meets_volume: bool,
    #[serde(skip)]
    described: String,
}

impl PlaceReport {
    pub fn new(surface: &Surface, grid: &Grid) -> Self {
        let (points, cells, place) = (surface.shape().points(), surface.shape().cells(), Place::of(surface, grid));
        let kind = match surface.shape() {
            Shape::Triangles(_) => "triangles",
            Shape::Spheres(_) => "spheres",
            Shape::Tubes(_) => "lines",
        };
        let where_ = place.as_ref().map_or("has no points".into(), Place::to_string);
        Self {
            name: surface.name.clone(),
            points,
            cells,
            bounds: place.as_ref().map(|place| place.bounds.corners()),
            meets_volume: place.is_some_and(|place| place.meets),
            described: format!("{cells} {kind} of {points} points, {where_}"),
        }
    }

    pub fn line(&self) -> String {
        format!("surface   {}: {}", self.name, self.described)
    }
}

#[derive(Serialize)]
struct ArrayReport {
    name: String,
    of: &'static str,
    components: usize,
    /// Of the values, or of the magnitude of several components.
    range: Option<[f32; 2]>,
}

fn owner<T>(per: &Per<T>) -> &'static str {
    if matches!(per, Per::Point(_)) { "points" } else { "cells" }
}

impl ArrayReport {
    fn new(array: &SurfaceArray) -> Self {
        Self { name: array.name.clone(), of: owner(&array.values), components: array.components, range: array.range() }
    }

    fn line(&self) -> String {
        let Self { name, of, components, .. } = self;
        let magnitude = if *components > 1 { format!(", {components} components of magnitude") } else { ",".into() };
        let range = self.range.map_or("without values".into(), |range| {
            let [lo, hi] = range.map(|value| shortened(f64::from(value)));
            format!("{lo} to {hi}")
        });
        format!("array     {name} of {of}{magnitude} {range}")
    }
}

pub(super) fn run(path: &Path, json: bool) -> Result<ExitCode, Error> {
    let file = SurfaceFile::read(path)?;
    let info = Info {
        format: file.format.clone(),
        points: file.points.len(),
        triangles: file.triangles.points.len(),
        closed: file.is_closed(),
        lines: file.lines.points.len(),
        single_points: file.vertices.points.len(),
        bounds: file.bounds().map(|corner| corner.to_array()),
        normals: file.normals.is_some(),
        colors: file.colors.as_ref().map(owner),
        arrays: file.arrays.iter().map(ArrayReport::new).collect(),
        space: file.space.map(|space| space.name()),
        header: file.header,
    };
    super::report(json, &info, || text(path, &info))?;
    Ok(ExitCode::SUCCESS)
}

fn text(path: &Path, info: &Info) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [lowest, highest] = info.bounds.map(position);
    let mut lines = vec![name, format!("format    {}", info.format), format!("points    {}", info.points)];
    if let Some(closed) = info.closed {
        lines.push(format!("triangles {}, {}", info.triangles, if closed { "closed" } else { "not closed" }));
    }
    let some = |count: usize, line: &str| (count > 0).then(|| format!("{line}{count}"));
    lines.extend(some(info.lines, "lines     ").into_iter().chain(some(info.single_points, "spheres   ")));
    lines.push(format!("bounds    {lowest} to {highest}"));
    lines.extend(info.normals.then(|| "normals   of points".into()));
    lines.extend(info.colors.map(|of| format!("colours   of {of}")));
    lines.extend(info.arrays.iter().map(ArrayReport::line));
    lines.push(match info.space {
        Some("LPS") => "space     LPS, of the file: becomes RAS, alone or beside volumes that state a patient".into(),
        Some(space) => format!("space     {space}, of the file"),
        None => "space     not stated: coordinates are those of the world, unless space=LPS is given".into(),
    });
    lines.extend((!info.header.is_empty()).then(|| format!("header    {}", info.header)));
    lines.join("\n")
}
