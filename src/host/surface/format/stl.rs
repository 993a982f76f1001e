//! STL, text and binary (<https://en.wikipedia.org/wiki/STL_(file_format)>). Its normals are not read: the order of a triangle's points says
//! which side is the front, and programs write normals of 0 or wrong ones.

use super::{Cells, Space, SurfaceFile, bytes_of};
use crate::error::Error;
use crate::volume::{STL_BYTES, stl_triangles};
use foldhash::fast::RandomState;
use glam::DVec3;
use std::collections::HashMap;
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let bytes = bytes_of(path)?;
    let wrong = |problem: String| Error::volume(path, problem);
    let [before, each] = STL_BYTES;
    let count = stl_triangles(&bytes);
    let expected = before + each * u64::from(count);
    let found = bytes.len() as u64;
    // Binary files may begin with `solid`, too.
    let is_text =
        expected != found && bytes.trim_ascii_start().starts_with(b"solid") && !bytes[..bytes.len().min(512)].contains(&0);
    let (format, header, corners) = if is_text {
        let line = bytes.trim_ascii_start().split(|byte| is_line_end(*byte)).next().unwrap_or_default();
        ("STL, text", line.get(5..).unwrap_or_default(), text(&bytes, wrong)?)
    } else {
        if found < before {
            return Err(wrong(format!("{found} bytes are too few for an STL file: it is empty or truncated")));
        }
        if expected > found {
            let problem = format!("it declares {count} triangles, which are {expected} bytes, and has {found}: it is truncated");
            return Err(wrong(problem));
        }
        if expected < found {
            let path = path.display();
            tracing::warn!("{path}: it declares {count} triangles: {} bytes behind them are not read", found - expected);
        }
        ("STL, binary", &bytes[..80], binary(&bytes[before as usize..expected as usize]))
    };
    let header = String::from_utf8_lossy(header).trim_matches(['\0', ' ', '\r', '\t']).to_owned();
    if corners.triangles.is_empty() {
        return Err(wrong("it has no triangles".into()));
    }
    let mut file = SurfaceFile { format: format.into(), space: Space::of_header(&header), header, ..SurfaceFile::default() };
    let numbers = (0..corners.triangles.len() as u32).collect();
    (file.points, file.triangles) = (corners.points, Cells { points: corners.triangles, numbers });
    Ok(file)
}

/// Corners of triangles, of which equal ones are one point.
#[derive(Default)]
struct Corners {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    known: HashMap<[u32; 3], u32, RandomState>,
}

impl Corners {
    fn add(&mut self, triangle: [[f32; 3]; 3]) {
        let index = |point: [f32; 3]| {
            // −0 is 0.
            let point = point.map(|coordinate| coordinate + 0.0);
            let bits = point.map(f32::to_bits);
            if let Some(index) = self.known.get(&bits) {
                return *index;
            }
            let index = self.points.len() as u32;
            self.points.push(DVec3::from_array(point.map(f64::from)));
            self.known.insert(bits, index);
            index
        };
        self.triangles.push(triangle.map(index));
    }
}

fn binary(bytes: &[u8]) -> Corners {
    let (triangles, _) = bytes.as_chunks::<50>();
    let mut corners = Corners { triangles: Vec::with_capacity(triangles.len()), ..Corners::default() };
    for triangle in triangles {
        let number = |n: usize| f32::from_le_bytes([0, 1, 2, 3].map(|i| triangle[12 + 4 * n + i]));
        corners.add([0, 3, 6].map(|n| [n, n + 1, n + 2].map(number)));
    }
    corners
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Reads the triangles of all solids. Their facets may have more than three points: they become fans.
fn text(bytes: &[u8], wrong: impl Fn(String) -> Error) -> Result<Corners, Error> {
    let mut corners = Corners::default();
    // Points of the facet so far, and whether its solid has ended.
    let (mut facet, mut is_complete): (Vec<[f32; 3]>, bool) = (Vec::new(), false);
    for (n, line) in bytes.split(|byte| *byte == b'\n').flat_map(|line| line.split(|byte| *byte == b'\r')).enumerate() {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let number = |word: Option<&[u8]>| std::str::from_utf8(word?).ok()?.parse().ok();
                let point = [words.next(), words.next(), words.next()].map(number);
                let [Some(x), Some(y), Some(z)] = point else {
                    let line = String::from_utf8_lossy(&line[..line.len().min(80)]).trim().to_owned();
                    return Err(wrong(format!("line {n}, '{line}', is no vertex of three numbers")));
                };
                facet.push([x, y, z]);
            }
            b"endfacet" => {
                let [first, rest @ ..] = facet.as_slice() else { continue };
                rest.windows(2).for_each(|edge| corners.add([*first, edge[0], edge[1]]));
                facet.clear();
            }
            b"solid" => is_complete = false,
            b"endsolid" => is_complete = true,
            b"facet" | b"outer" | b"endloop" => {}
            other => {
                let word = String::from_utf8_lossy(&other[..other.len().min(40)]).into_owned();
                return Err(wrong(format!("line {n} begins with '{word}': expected facet, vertex or endsolid; it is damaged")));
            }
        }
    }
    if !is_complete || !facet.is_empty() {
        return Err(wrong("it ends before its last solid does: it is truncated".into()));
    }
    Ok(corners)
}
