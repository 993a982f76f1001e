//! Wavefront OBJ, with the colours of its materials (<http://paulbourke.net/dataformats/obj/>). Textures and curves are not read. `tobj` reads
//! lines of three points as triangles.

use super::{Cells, Per, Space, SurfaceFile, bytes_of};
use crate::error::Error;
use foldhash::fast::RandomState;
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::path::{Component, Path};

/// Faces before the first material, and those of unknown ones.
const NO_MATERIAL: [f32; 4] = [0.8, 0.8, 0.8, 1.0];
/// Letters of a statement that messages quote.
const QUOTED: usize = 60;

pub(super) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let bytes = bytes_of(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let joined = if text.contains("\\\n") || text.contains("\\\r\n") {
        text.replace("\\\r\n", " ").replace("\\\n", " ").into()
    } else {
        text
    };
    let mut file = Obj::default();
    for statement in joined.lines() {
        file.add(statement, path).map_err(|problem| {
            let quoted: String = statement.trim().chars().take(QUOTED).collect();
            Error::volume(path, format!("'{quoted}': {problem}"))
        })?;
    }
    Ok(file.finished())
}

/// A point of a face, and its normal.
type Corner = (u32, Option<u32>);

#[derive(Default)]
struct Obj {
    points: Vec<DVec3>,
    colors: Vec<[f32; 4]>,
    normals: Vec<Vec3>,
    /// Corners of all faces, where each face begins, and its number among the cells.
    corners: Vec<Corner>,
    faces: Vec<(usize, u32)>,
    lines: Cells<Box<[u32]>>,
    vertices: Cells<u32>,
    /// Colours of cells, once there is a material.
    cell_colors: Vec<[f32; 4]>,
    cells: u32,
    materials: HashMap<String, [f32; 4]>,
    material: Option<[f32; 4]>,
    comments: Vec<String>,
}

impl Obj {
    fn add(&mut self, statement: &str, path: &Path) -> Result<(), String> {
        let mut words = statement.split_ascii_whitespace();
        let rest = |word: &str| statement.trim_start()[word.len()..].trim();
        match words.next() {
            Some("v") => self.add_point(&numbers(words)?),
            Some("vn") => match numbers(words)?[..] {
                [x, y, z] => {
                    self.normals.push(DVec3::new(x, y, z).as_vec3());
                    Ok(())
                }
                _ => Err("expected three numbers".into()),
            },
            Some("f") => {
                let begin = self.corners.len();
                for word in words {
                    self.corners.push(self.corner(word)?);
                }
                self.faces.push((begin, self.cells));
                self.add_cell()
            }
            Some("l") => {
                let points = words.map(|word| self.corner(word).map(|corner| corner.0)).collect::<Result<Box<[u32]>, _>>()?;
                if points.len() > 1 {
                    self.lines.add(points, self.cells);
                }
                self.add_cell()
            }
            Some("p") => {
                for word in words {
                    let point = self.corner(word)?.0;
                    self.vertices.add(point, self.cells);
                }
                self.add_cell()
            }
            Some("usemtl") => {
                let name = rest("usemtl");
                let color = self.materials.get(name).copied();
                if color.is_none() {
                    tracing::warn!("{}: its material '{name}' is not defined: faces of it are grey", path.display());
                }
                if self.material.is_none() {
                    self.cell_colors.resize(self.cells as usize, NO_MATERIAL);
                }
                self.material = Some(color.unwrap_or(NO_MATERIAL));
                Ok(())
            }
            Some("mtllib") => {
                self.add_materials(rest("mtllib"), path);
                Ok(())
            }
            Some(comment) if comment.starts_with('#') => {
                if self.points.is_empty() {
                    self.comments.push(statement.trim_start_matches(['#', ' ']).trim().into());
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// A place, possibly with a weight or with red, green and blue.
    fn add_point(&mut self, numbers: &[f64]) -> Result<(), String> {
        let (place, color) = match *numbers {
            [x, y, z] | [x, y, z, _] => ([x, y, z], None),
            [x, y, z, r, g, b] => ([x, y, z], Some([r, g, b])),
            _ => return Err("expected three numbers, or six with a colour".into()),
        };
        if let Some([r, g, b]) = color.map(|color| color.map(|c| c.max(0.0) as f32)) {
            self.colors.push([r, g, b, 1.0]);
        }
        self.points.push(place.into());
        Ok(())
    }

    /// The point and the normal of `POINT`, `POINT/TEXTURE`, `POINT//NORMAL` or `POINT/TEXTURE/NORMAL`, which count from 1, or back from −1.
    fn corner(&self, word: &str) -> Result<Corner, String> {
        let index = |text: &str, count: usize, what: &str| {
            let number: i64 = text.parse().map_err(|_| format!("'{text}' is no number of a {what}"))?;
            let index = if number < 0 { count as i64 + number } else { number - 1 };
            let valid = (0..count as i64).contains(&index);
            if valid { Ok(index as u32) } else { Err(format!("it has {what} {number} of {count} that are before it")) }
        };
        let mut parts = word.split('/');
        let point = index(parts.next().unwrap_or_default(), self.points.len(), "point")?;
        let normal = parts.nth(1).filter(|text| !text.is_empty());
        Ok((point, normal.map(|text| index(text, self.normals.len(), "normal")).transpose()?))
    }

    fn add_cell(&mut self) -> Result<(), String> {
        self.cells = self.cells.checked_add(1).ok_or("there are too many cells")?;
        self.cell_colors.extend(self.material);
        Ok(())
    }

    /// Reads the colours of a material library in the folder of the file.
    fn add_materials(&mut self, name: &str, path: &Path) {
        let beside = Path::new(name);
        let is_within = beside.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        let library = path.with_file_name("").join(beside);
        let text = match is_within.then(|| bytes_of(&library)) {
            Some(Ok(bytes)) => bytes,
            Some(Err(problem)) => return tracing::warn!("{}: its materials are not read: {problem}", path.display()),
            None => return tracing::warn!("{}: its materials {name} are not beside it, and are not read", path.display()),
        };
        let (mut current, mut has_textures) = (None, false);
        for line in String::from_utf8_lossy(&text).lines() {
            let mut words = line.split_ascii_whitespace();
            let key = words.next().unwrap_or_default();
            if key == "newmtl" {
                let name = line.trim_start()[key.len()..].trim().to_owned();
                self.materials.insert(name.clone(), NO_MATERIAL);
                current = Some(name);
            }
            has_textures |= key.eq_ignore_ascii_case("map_kd");
            let Some(color) = current.as_ref().and_then(|name| self.materials.get_mut(name)) else { continue };
            let numbers = words.map_while(|word| word.parse().ok()).filter(|n: &f32| n.is_finite()).map(|n| n.clamp(0.0, 1.0));
            match (key, &numbers.collect::<Vec<_>>()[..]) {
                ("Kd", [r, g, b]) => color[..3].copy_from_slice(&[*r, *g, *b]),
                ("Kd", [grey]) => color[..3].fill(*grey),
                ("d", [opacity]) => color[3] = *opacity,
                ("Tr", [transparency]) => color[3] = 1.0 - *transparency,
                _ => {}
            }
        }
        if has_textures {
            tracing::warn!("{}: its textures are not drawn, only the colours of its materials", path.display());
        }
    }

    fn finished(self) -> SurfaceFile {
        let comments = self.comments.join("; ");
        let mut file =
            SurfaceFile { format: "OBJ".into(), space: Space::of_header(&comments), header: comments, ..SurfaceFile::default() };
        // Some programs write bytes.
        let largest = if self.colors.iter().flatten().any(|c| *c > 1.0) { 255.0 } else { 1.0 };
        let share = |[r, g, b, _]: [f32; 4]| [r, g, b, largest].map(|c| (c / largest).min(1.0));
        let colors = Some(self.colors).filter(|colors| colors.len() == self.points.len() && !colors.is_empty());
        let colors = colors.map(|colors| colors.into_iter().map(share).collect::<Vec<_>>());
        let has_normals = self.lines.points.is_empty()
            && self.vertices.points.is_empty()
            && self.corners.iter().all(|(_, normal)| normal.is_some());
        // Points that have several normals become several.
        let (mut used, mut known) = (Vec::new(), HashMap::<Corner, u32, RandomState>::default());
        let mut place = |corner: Corner| match has_normals {
            true => *known.entry(corner).or_insert_with(|| {
                used.push(corner);
                used.len() as u32 - 1
            }),
            false => corner.0,
        };
        let ends = self.faces.iter().skip(1).map(|face| face.0).chain([self.corners.len()]);
        for ((begin, number), end) in self.faces.iter().zip(ends) {
            let points: Vec<u32> = self.corners[*begin..end].iter().map(|corner| place(*corner)).collect();
            file.triangles.add_polygon(&points, *number);
        }
        (file.lines, file.vertices) = (self.lines, self.vertices);
        let mut colors = colors;
        file.points = self.points;
        if has_normals && !used.is_empty() {
            file.normals = Some(used.iter().map(|(_, normal)| self.normals[normal.unwrap_or(0) as usize]).collect());
            file.points = used.iter().map(|(point, _)| file.points[*point as usize]).collect();
            colors = colors.map(|colors| used.iter().map(|(point, _)| colors[*point as usize]).collect());
        }
        let of_cells = Some(self.cell_colors).filter(|_| self.material.is_some());
        file.colors = colors.map(Per::Point).or(of_cells.map(Per::Cell));
        file
    }
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec<f64>, String> {
    words.map(|word| word.parse().map_err(|_| format!("'{word}' is no number"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<SurfaceFile, String> {
        let mut file = Obj::default();
        file.materials.insert("red one".into(), [1.0, 0.0, 0.0, 0.5]);
        text.lines().try_for_each(|line| file.add(line, Path::new("a.obj")))?;
        Ok(file.finished())
    }

    const POINTS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn faces_count_from_one_or_back() {
        for faces in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/7 2/8 3/9 4/1"] {
            let file = parsed(&format!("{POINTS}{faces}\nl 1 3 4\np 2 3")).unwrap();
            assert_eq!(file.triangles.points, [[0, 1, 2], [0, 2, 3]], "{faces}");
            assert_eq!(
                (&file.lines.points[0][..], &file.vertices.points[..], file.points.len()),
                (&[0, 2, 3][..], &[1, 2][..], 4)
            );
            assert_eq!(file.vertices.numbers, [2, 2]);
        }
    }

    #[test]
    fn points_with_several_normals_are_split() {
        let file = parsed(&format!("{POINTS}vn 0 0 1\nvn 0 0 -1\nf 1//1 2//1 3//1\nf 1//2 4//2 3//2")).unwrap();
        assert_eq!((file.points.len(), file.triangles.points[1]), (6, [3, 4, 5]));
        let normals = file.normals.unwrap();
        assert_eq!((normals[0].z, normals[3].z, file.points[3], file.points[4]), (1.0, -1.0, DVec3::ZERO, DVec3::Y));
        // Not all corners have one.
        assert_eq!(parsed(&format!("{POINTS}vn 0 0 1\nf 1//1 2//1 3//1\nf 1 4 3")).unwrap().normals, None);
    }

    #[test]
    fn materials_and_points_have_colours() {
        let file = parsed(&format!("{POINTS}f 1 2 3\nusemtl red one\nf 1 3 4\nusemtl other\nf 1 2 4")).unwrap();
        assert_eq!(file.colors, Some(Per::Cell(vec![NO_MATERIAL, [1.0, 0.0, 0.0, 0.5], NO_MATERIAL])));
        for one in [1, 255] {
            let file = parsed(&format!("v 0 0 0 {one} 0 0\nv 1 0 0 0 {one} 0\nv 0 1 0 0 -2 {one}\nf 1 2 3")).unwrap();
            let expected = vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
            assert_eq!(file.colors, Some(Per::Point(expected)), "{one}");
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (statement, problem) in [
            ("f 1 2 5", "it has point 5 of 4 that are before it"),
            ("f 0 1 2", "it has point 0 of 4"),
            ("f -5 1 2", "it has point -5 of 4"),
            ("f 1 x 2", "'x' is no number of a point"),
            ("f 1//1 2//1 3//1", "it has normal 1 of 0"),
            ("v 1 2", "expected three numbers"),
            ("v 1 2 x", "'x' is no number"),
            ("vn 1 2", "expected three numbers"),
        ] {
            let message = parsed(&format!("{POINTS}{statement}")).unwrap_err();
            assert!(message.contains(problem), "{statement}: {message}");
        }
    }
}
