//! FreeSurfer's surfaces (`lh.pial`), values of their points (`lh.thickness`), and labels of these (`lh.aparc.annot`), all with numbers of which
//! the highest byte is the first (<https://surfer.nmr.mgh.harvard.edu/fswiki/FileFormats>).

use super::{Cells, NO_LABEL, Per, PointData, Space, SurfaceArray, SurfaceFile, bytes_of};
use crate::error::Error;
use crate::volume::FREESURFER_TRIANGLES;
use glam::{DMat3, DVec3};
use std::collections::HashMap;
use std::path::Path;

/// Old surfaces of quadrangles and files of values have the same mark.
const VALUES: [u8; 3] = [0xff, 0xff, 0xff];
/// Tags behind the triangles: whether coordinates are the scanner's, and the volume that they belong to.
const REAL_RAS: i32 = 2;
const GEOMETRY: i32 = 20;
/// Of a colour table.
const COLOR_TABLE: i32 = 1;
const TABLE_VERSION: i32 = -2;

/// Reads a file piece by piece. Every piece is checked against what is left.
struct Pieces<'a>(&'a [u8]);

impl<'a> Pieces<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (piece, rest) = self.0.split_at_checked(count).ok_or("it is truncated")?;
        self.0 = rest;
        Ok(piece)
    }

    fn whole(&mut self) -> Result<i32, String> {
        self.take(4).map(|bytes| i32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn count(&mut self, what: &str) -> Result<usize, String> {
        let number = self.whole()?;
        usize::try_from(number).map_err(|_| format!("it declares {number} {what}"))
    }

    /// Numbers of four bytes.
    fn numbers(&mut self, count: usize) -> Result<impl Iterator<Item = [u8; 4]> + 'a, String> {
        let bytes = self.take(count.checked_mul(4).ok_or("it declares too many numbers")?)?;
        Ok(bytes.as_chunks().0.iter().copied())
    }

    fn line(&mut self) -> Option<&'a str> {
        let end = self.0.iter().position(|byte| *byte == b'\n')?;
        let line = std::str::from_utf8(&self.0[..end]).ok()?;
        self.0 = &self.0[end + 1..];
        Some(line)
    }

    /// Text behind its length, with a 0 at its end.
    fn name(&mut self) -> Result<String, String> {
        let length = self.count("letters")?;
        Ok(String::from_utf8_lossy(self.take(length)?).trim_end_matches('\0').into())
    }
}

pub(super) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let bytes = bytes_of(path)?;
    surface(&bytes).map_err(|problem| Error::volume(path, problem))
}

fn surface(bytes: &[u8]) -> Result<SurfaceFile, String> {
    let mut pieces = Pieces(bytes);
    if pieces.take(3)? != FREESURFER_TRIANGLES {
        let problem = "it is no surface of triangles: it has values or labels of points, to give beside a surface (data=FILE), or is an old \
                       surface to convert (mris_convert)";
        return Err(problem.into());
    }
    let header = pieces.line().ok_or("its header is damaged")?.to_owned();
    // An empty line, unless the creator's name has two lines.
    while !pieces.0.starts_with(b"\n") {
        pieces.line().ok_or("its header is damaged")?;
    }
    pieces.take(1)?;
    let [points, triangles] = [pieces.count("points")?, pieces.count("triangles")?];
    let numbers: Vec<f64> = pieces.numbers(points.saturating_mul(3))?.map(|bytes| f64::from(f32::from_be_bytes(bytes))).collect();
    let indices: Vec<u32> = pieces.numbers(triangles.saturating_mul(3))?.map(u32::from_be_bytes).collect();
    let place = Placement::of(pieces)?;
    let mut file = SurfaceFile { format: "FreeSurfer".into(), space: Some(Space::Ras), header, ..SurfaceFile::default() };
    file.points = numbers.as_chunks().0.iter().map(|point| place.turn * DVec3::from_array(*point) + place.centre).collect();
    file.triangles = Cells { points: indices.as_chunks().0.to_vec(), numbers: (0..triangles as u32).collect() };
    Ok(file)
}

/// From the coordinates of surfaces, whose origin is the middle of the volume, to those of its scanner.
struct Placement {
    turn: DMat3,
    centre: DVec3,
}

impl Placement {
    /// Reads what is behind the triangles.
    fn of(mut pieces: Pieces) -> Result<Self, String> {
        let (mut is_real, mut place) = (false, None);
        while let Ok(tag) = pieces.whole() {
            match tag {
                REAL_RAS => is_real = pieces.whole()? != 0,
                GEOMETRY => {
                    let mut values = HashMap::new();
                    for _ in 0..8 {
                        let (key, value) = pieces.line().and_then(|line| line.split_once('=')).ok_or("its volume is damaged")?;
                        values.insert(key.trim(), value.split('#').next().unwrap_or_default().trim());
                    }
                    place = Self::of_geometry(&values)?;
                }
                // The others hold no coordinates.
                _ => break,
            }
        }
        Ok(place.filter(|_| !is_real).unwrap_or(Self { turn: DMat3::IDENTITY, centre: DVec3::ZERO }))
    }

    /// The axes of a volume and its centre. Surfaces are placed as if the axes were left, inferior and anterior.
    fn of_geometry(values: &HashMap<&str, &str>) -> Result<Option<Self>, String> {
        if !values.get("valid").is_some_and(|valid| valid.starts_with('1')) {
            return Ok(None);
        }
        let vector = |key: &str| {
            let words =
                values.get(key).map(|text| text.split_ascii_whitespace().map(str::parse::<f64>).collect::<Result<Vec<_>, _>>());
            match words {
                Some(Ok(found)) if found.len() == 3 && found.iter().all(|n| n.is_finite()) => Ok(DVec3::from_slice(&found)),
                _ => Err(format!("its volume has no {key} of three numbers")),
            }
        };
        let axes = DMat3::from_cols(vector("xras")?, vector("yras")?, vector("zras")?);
        let standard = DMat3::from_cols(-DVec3::X, -DVec3::Z, DVec3::Y);
        Ok(Some(Self { turn: axes * standard.transpose(), centre: vector("cras")? }))
    }
}

/// Whether a file holds values or labels of points.
pub(super) fn has_point_data(path: &Path, bytes: &[u8]) -> bool {
    bytes.starts_with(&VALUES) || path.extension().is_some_and(|ending| ending == "annot")
}

/// Values of points, or labels with colours.
pub(super) fn point_data(path: &Path, bytes: &[u8]) -> Result<PointData, String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if bytes.starts_with(&VALUES) { values(bytes, name) } else { labels(bytes) }
}

fn values(bytes: &[u8], name: String) -> Result<PointData, String> {
    let mut pieces = Pieces(&bytes[VALUES.len()..]);
    let [points, _triangles, each] = [pieces.count("points")?, pieces.count("triangles")?, pieces.count("values per point")?];
    if each != 1 {
        return Err(format!("it has {each} values per point, or is an old surface of quadrangles: expected one value"));
    }
    let values = pieces.numbers(points)?.map(f32::from_be_bytes).collect();
    Ok(PointData { arrays: vec![SurfaceArray { name, components: 1, values: Per::Point(values) }], colors: None })
}

fn labels(bytes: &[u8]) -> Result<PointData, String> {
    let mut pieces = Pieces(bytes);
    let count = pieces.count("points")?;
    let pairs: Vec<[u8; 4]> = pieces.numbers(count.saturating_mul(2))?.collect();
    let mut labels = vec![0; count];
    for [point, label] in pairs.as_chunks().0 {
        let point = i32::from_be_bytes(*point);
        let at = usize::try_from(point).ok().and_then(|point| labels.get_mut(point));
        *at.ok_or_else(|| format!("it labels point {point} of {count}"))? = i32::from_be_bytes(*label);
    }
    let table = colors(&mut pieces)?;
    // Points without a label have the number 0, which has no entry.
    let color = |label: &i32| table.get(label).copied().unwrap_or(NO_LABEL);
    Ok(PointData { arrays: Vec::new(), colors: Some(labels.iter().map(color).collect()) })
}

/// Colours of labels, whose numbers are made of them.
fn colors(pieces: &mut Pieces) -> Result<HashMap<i32, [f32; 4]>, String> {
    let mut table = HashMap::new();
    if pieces.whole() != Ok(COLOR_TABLE) {
        return Err("it has no colour table".into());
    }
    let first = pieces.whole()?;
    let has_numbers = first < 0;
    if has_numbers && first != TABLE_VERSION {
        return Err(format!("its colour table has the version {}: expected 2", -i64::from(first)));
    }
    let entries = if has_numbers { pieces.count("labels")? } else { first as usize };
    pieces.name()?;
    let entries = if has_numbers { pieces.count("labels")? } else { entries };
    for _ in 0..entries {
        if has_numbers {
            pieces.whole()?;
        }
        pieces.name()?;
        let [red, green, blue, _transparency] = [pieces.whole()?, pieces.whole()?, pieces.whole()?, pieces.whole()?];
        let [r, g, b] = [red, green, blue].map(|c| c.clamp(0, 255));
        table.insert(r | g << 8 | b << 16, [r as f32 / 255.0, g as f32 / 255.0, b as f32 / 255.0, 1.0]);
    }
    Ok(table)
}
