//! PLY, text and binary of both byte orders (<http://paulbourke.net/dataformats/ply/>).

mod body;
mod header;

use super::{Cells, Per, Space, SurfaceArray, SurfaceFile, bytes_of};
use crate::error::Error;
use crate::volume::ScalarType;
use body::Body;
use glam::{DVec3, Vec3};
use header::{Element, Header};
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let bytes = bytes_of(path)?;
    let header = Header::parse(&bytes).map_err(|problem| Error::volume(path, problem))?;
    let comments = header.comments.join("; ");
    let format = format!("PLY, {}", header.coding);
    let mut file = SurfaceFile { format, space: Space::of_header(&comments), header: comments, ..SurfaceFile::default() };
    let mut body = Body::new(&bytes[header.first..], header.coding);
    let wrong = |element: &Element, problem: String| Error::volume(path, format!("its element {}: {problem}", element.name));
    for element in &header.elements {
        body.check(element).map_err(|problem| wrong(element, problem))?;
        let read = match element.name.as_str() {
            "vertex" => points(&mut file, &mut body, element),
            "face" | "tristrips" => faces(&mut file, &mut body, element),
            _ => body.columns(element, &mut |_| Ok(())).map(|_| ()),
        };
        read.map_err(|problem| wrong(element, problem))?;
    }
    Ok(file)
}

/// Values of the scalar properties of an element.
type Columns<'a> = Vec<(&'a str, ScalarType, Vec<f64>)>;

/// Takes the columns of these names out of all, if all are there.
fn taken<'a, const N: usize>(columns: &mut Columns<'a>, names: [&str; N]) -> Option<[(ScalarType, Vec<f64>); N]> {
    names.iter().all(|name| columns.iter().any(|(other, ..)| other == name)).then(|| {
        names.map(|name| {
            let at = columns.iter().position(|(other, ..)| *other == name).unwrap_or(0);
            let (_, scalar, values) = columns.remove(at);
            (scalar, values)
        })
    })
}

fn points(file: &mut SurfaceFile, body: &mut Body, element: &Element) -> Result<(), String> {
    let mut columns = body.columns(element, &mut |_| Ok(()))?;
    let [x, y, z] = taken(&mut columns, ["x", "y", "z"]).ok_or("it has no x, y and z")?;
    let zipped = |[x, y, z]: [Vec<f64>; 3]| x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z));
    file.points = zipped([x.1, y.1, z.1]).collect();
    let normals = taken(&mut columns, ["nx", "ny", "nz"]);
    file.normals = normals.map(|[x, y, z]| zipped([x.1, y.1, z.1]).map(|normal| normal.as_vec3()).collect::<Vec<Vec3>>());
    file.colors = colors(&mut columns).map(Per::Point);
    file.arrays.extend(columns.into_iter().map(|column| array(column, Per::Point)));
    Ok(())
}

fn faces(file: &mut SurfaceFile, body: &mut Body, element: &Element) -> Result<(), String> {
    let (mut number, are_strips) = (file.triangles.numbers.last().map_or(0, |last| last + 1), element.name == "tristrips");
    let triangles: &mut Cells<[u32; 3]> = &mut file.triangles;
    let mut points = Vec::new();
    let mut columns = body.columns(element, &mut |list| {
        points.clear();
        for index in list {
            match *index {
                index if index >= 0.0 && index <= f64::from(u32::MAX) && index.fract() == 0.0 => points.push(index as u32),
                -1.0 if are_strips => {
                    triangles.add_strip(&points, number);
                    points.clear();
                }
                index => return Err(format!("cell {number} has point {index}: points count from 0")),
            }
        }
        if are_strips {
            triangles.add_strip(&points, number)
        } else {
            triangles.add_polygon(&points, number)
        }
        number += 1;
        Ok(())
    })?;
    if are_strips {
        return Ok(());
    }
    if let Some(colors) = colors(&mut columns).filter(|_| file.colors.is_none()) {
        file.colors = Some(Per::Cell(colors));
    }
    file.arrays.extend(columns.into_iter().map(|column| array(column, Per::Cell)));
    Ok(())
}

/// Colours, of which integers are fractions of the largest one.
fn colors(columns: &mut Columns) -> Option<Vec<[f32; 4]>> {
    let rgb = taken(columns, ["red", "green", "blue"]);
    let rgb = rgb.or_else(|| taken(columns, ["diffuse_red", "diffuse_green", "diffuse_blue"]))?;
    let alpha = taken(columns, ["alpha"]).map(|[alpha]| alpha);
    let scaled = |(scalar, values): (ScalarType, Vec<f64>)| {
        let largest = match scalar {
            ScalarType::Float32 | ScalarType::Float64 => 1.0,
            ScalarType::Uint16 | ScalarType::Int16 => f64::from(u16::MAX),
            _ => f64::from(u8::MAX),
        };
        let share = move |value: f64| if value.is_nan() { 0.0 } else { (value / largest).clamp(0.0, 1.0) as f32 };
        values.into_iter().map(share)
    };
    let [red, green, blue] = rgb.map(scaled);
    let mut colors: Vec<_> = red.zip(green).zip(blue).map(|((red, green), blue)| [red, green, blue, 1.0]).collect();
    if let Some(alpha) = alpha {
        colors.iter_mut().zip(scaled(alpha)).for_each(|(color, alpha)| color[3] = alpha);
    }
    Some(colors)
}

fn array((name, _, values): (&str, ScalarType, Vec<f64>), per: fn(Vec<f32>) -> Per<f32>) -> SurfaceArray {
    SurfaceArray { name: name.into(), components: 1, values: per(values.into_iter().map(|value| value as f32).collect()) }
}
