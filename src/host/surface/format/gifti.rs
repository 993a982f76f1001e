//! GIFTI: surfaces (`.surf.gii`), values (`.func.gii`, `.shape.gii`) and labels (`.label.gii`) of their points
//! (<https://www.nitrc.org/projects/gifti>). Coordinates are those of the space that the file's matrix leads to.

use super::{Cells, NO_LABEL, Per, PointData, Space, SurfaceArray, SurfaceFile, bytes_of};
use crate::error::Error;
use crate::memory;
use crate::volume::vtk::encoded::BASE64;
use crate::volume::{Endian, Numbers, ScalarType};
use base64::Engine;
use flate2::read::ZlibDecoder;
use glam::{DMat4, DVec3};
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

const POINTS: &str = "NIFTI_INTENT_POINTSET";
const TRIANGLES: &str = "NIFTI_INTENT_TRIANGLE";
const LABELS: &str = "NIFTI_INTENT_LABEL";
const COLORS: [&str; 2] = ["NIFTI_INTENT_RGB_VECTOR", "NIFTI_INTENT_RGBA_VECTOR"];

/// An array of a file.
#[derive(Default)]
struct Array {
    attributes: HashMap<String, String>,
    /// Names and values.
    metadata: Vec<[String; 2]>,
    /// The space of its coordinates, and 16 numbers that lead to another.
    space: String,
    matrix: String,
    data: String,
}

#[derive(Default)]
struct Document {
    arrays: Vec<Array>,
    /// Colours of labels.
    labels: HashMap<i64, [f32; 4]>,
}

impl Document {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut document = Self::default();
        let mut reader = quick_xml::Reader::from_reader(bytes);
        let (mut buffer, mut tags, mut text) = (Vec::new(), Vec::new(), String::new());
        let mut name = String::new();
        loop {
            buffer.clear();
            match reader.read_event_into(&mut buffer).map_err(|e| format!("its XML is damaged: {e}"))? {
                Event::Start(tag) => {
                    document.begin(&tag);
                    tags.push(tag.local_name().as_ref().to_vec());
                    text.clear();
                }
                Event::Empty(tag) => document.begin(&tag),
                Event::Text(words) => text.push_str(&String::from_utf8_lossy(&words)),
                Event::CData(words) => text.push_str(&String::from_utf8_lossy(&words)),
                Event::End(_) => {
                    let tag = tags.pop().unwrap_or_default();
                    let text = std::mem::take(&mut text);
                    let Some(array) = document.arrays.last_mut() else { continue };
                    match tag.as_slice() {
                        b"Name" => name = text.trim().into(),
                        b"Value" => array.metadata.push([std::mem::take(&mut name), text.trim().into()]),
                        b"DataSpace" => array.space = text,
                        b"MatrixData" => array.matrix = text,
                        b"Data" => array.data = text,
                        _ => {}
                    }
                }
                Event::Eof if tags.is_empty() => return Ok(document),
                Event::Eof => return Err("it is truncated".into()),
                _ => {}
            }
        }
    }

    fn begin(&mut self, tag: &BytesStart) {
        let attributes = || {
            let pairs = tag.attributes().filter_map(Result::ok);
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            pairs.map(|pair| (text(pair.key.as_ref()), text(&pair.value))).collect::<HashMap<_, _>>()
        };
        match tag.local_name().as_ref() {
            b"DataArray" => self.arrays.push(Array { attributes: attributes(), ..Array::default() }),
            b"Label" => {
                let found = attributes();
                let share = |key: &str, missing| {
                    found.get(key).and_then(|text| text.parse().ok()).map_or(missing, |c: f32| c.clamp(0.0, 1.0))
                };
                let key = found.get("Key").or(found.get("Index")).and_then(|key| key.parse().ok());
                if let Some(key) = key {
                    self.labels.insert(key, [share("Red", 0.0), share("Green", 0.0), share("Blue", 0.0), share("Alpha", 1.0)]);
                }
            }
            _ => {}
        }
    }

    fn of_intent(&self, intent: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.get("Intent") == intent)
    }

    /// Values, colours and labels of points.
    fn point_data(&self, path: &Path, points: usize) -> Result<PointData, String> {
        let mut found = PointData { arrays: Vec::new(), colors: None };
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        for (n, array) in self.arrays.iter().enumerate() {
            let intent = array.get("Intent");
            if [POINTS, TRIANGLES].contains(&intent) {
                continue;
            }
            let (numbers, [count, components]) = (array.numbers(path)?, array.dims()?);
            if points > 0 && count != points {
                return Err(format!("array {n} has {count} entries for {points} points"));
            }
            if intent == LABELS && components == 1 {
                let color = |label: &f64| self.labels.get(&(*label as i64)).copied().unwrap_or(NO_LABEL);
                found.colors = Some(numbers.iter().map(color).collect());
            } else if COLORS.contains(&intent) && matches!(components, 3 | 4) {
                let scale = if array.get("DataType") == "NIFTI_TYPE_UINT8" { 255.0 } else { 1.0 };
                let color = |of: &[f64]| [0, 1, 2, 3].map(|i| of.get(i).map_or(1.0, |c| (c / scale).clamp(0.0, 1.0) as f32));
                found.colors = Some(numbers.chunks_exact(components).map(color).collect());
            } else {
                let own = array.metadata.iter().find(|[name, value]| name == "Name" && !value.is_empty());
                let name = own.map_or_else(|| format!("{file}, {n}"), |[_, name]| name.clone());
                let values = Per::Point(numbers.iter().map(|number| *number as f32).collect());
                found.arrays.push(SurfaceArray { name, components, values });
            }
        }
        Ok(found)
    }
}

impl Array {
    fn get(&self, name: &str) -> &str {
        self.attributes.get(name).map_or("", String::as_str)
    }

    /// Entries, and numbers per entry.
    fn dims(&self) -> Result<[usize; 2], String> {
        let number = |name: &str| self.get(name).parse::<usize>().map_err(|_| format!("an array has no whole {name}"));
        let dims = (0..number("Dimensionality")?.min(7)).map(|n| number(&format!("Dim{n}"))).collect::<Result<Vec<_>, _>>()?;
        let [first, rest @ ..] = &dims[..] else { return Err("an array has no dimensions".into()) };
        let components = rest.iter().try_fold(1usize, |n, dim| n.checked_mul(*dim)).filter(|n| *n > 0);
        Ok([*first, components.ok_or("an array has no numbers, or too many")?])
    }

    fn scalar(&self) -> Result<ScalarType, String> {
        let name = self.get("DataType");
        let known = name.strip_prefix("NIFTI_TYPE_").map(str::to_ascii_lowercase);
        known
            .and_then(|name| name.parse().ok())
            .ok_or_else(|| format!("an array has the type {name}: expected NIFTI_TYPE_FLOAT32 or its like"))
    }

    /// Its numbers, entry by entry.
    fn numbers(&self, path: &Path) -> Result<Vec<f64>, String> {
        let ([entries, components], scalar) = (self.dims()?, self.scalar()?);
        let count = entries.checked_mul(components).ok_or("an array has too many numbers")?;
        let most = (count as u64).checked_mul(8).ok_or("an array has too many numbers")?;
        memory::require(&path.display().to_string(), most).map_err(|e| e.to_string())?;
        let numbers = match self.get("Encoding") {
            "ASCII" => {
                let words = self.data.split_ascii_whitespace().take(count.saturating_add(1));
                words
                    .map(|word| word.parse().map_err(|_| format!("'{word}' is no number")))
                    .collect::<Result<Vec<f64>, String>>()?
            }
            "Base64Binary" => self.decoded(scalar, self.bytes()?),
            "GZipBase64Binary" => {
                let (mut bytes, wanted) = (Vec::new(), (count * scalar.bytes()) as u64);
                let unpacked = ZlibDecoder::new(&self.bytes()?[..]).take(wanted.saturating_add(1)).read_to_end(&mut bytes);
                unpacked.map_err(|e| format!("an array is truncated or damaged: {e}"))?;
                self.decoded(scalar, bytes)
            }
            "ExternalFileBinary" => {
                return Err(format!(
                    "its data are in {}: convert it to one file (gifti_tool -encoding GZIP)",
                    self.get("ExternalFileName")
                ));
            }
            other => return Err(format!("an array has the encoding {other}: expected ASCII, Base64Binary or GZipBase64Binary")),
        };
        if numbers.len() != count {
            return Err(format!("an array has {} numbers of {count} that it declares", numbers.len().min(count + 1)));
        }
        if self.get("ArrayIndexingOrder") == "ColumnMajorOrder" && components > 1 {
            return Ok((0..count).map(|n| numbers[n % components * entries + n / components]).collect());
        }
        Ok(numbers)
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        let letters: Vec<u8> = self.data.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
        BASE64.decode(letters).map_err(|e| format!("its base64 is damaged: {e}"))
    }

    fn decoded(&self, scalar: ScalarType, bytes: Vec<u8>) -> Vec<f64> {
        let endian = if self.get("Endian") == "BigEndian" { Endian::Big } else { Endian::Little };
        let numbers = Numbers::new(&bytes, scalar, endian);
        (0..numbers.count()).map(|n| numbers.stored(n)).collect()
    }

    /// From its coordinates to the world. Older files of FreeSurfer have the identity, and state the centre of their volume.
    fn placement(&self) -> Result<DMat4, String> {
        let numbers = self.matrix.split_ascii_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>();
        let matrix = match numbers.as_deref() {
            Ok([]) => DMat4::IDENTITY,
            Ok(rows) if rows.len() == 16 => DMat4::from_cols_slice(rows).transpose(),
            _ => return Err("its matrix has other than 16 numbers".into()),
        };
        if !matrix.is_finite() || matrix.row(3) != glam::DVec4::W {
            return Err("its matrix is not affine".into());
        }
        let centre = ["VolGeomC_R", "VolGeomC_A", "VolGeomC_S"].map(|key| {
            let stated = self.metadata.iter().find(|[name, _]| name == key);
            stated.and_then(|[_, value]| value.trim().parse::<f64>().ok()).unwrap_or(0.0)
        });
        let is_unplaced = matrix == DMat4::IDENTITY && !self.space.contains("SCANNER");
        Ok(if is_unplaced { DMat4::from_translation(centre.into()) } else { matrix })
    }
}

pub(super) fn read(path: &Path) -> Result<SurfaceFile, Error> {
    let bytes = bytes_of(path)?;
    surface(path, &bytes).map_err(|problem| Error::volume(path, problem))
}

fn surface(path: &Path, bytes: &[u8]) -> Result<SurfaceFile, String> {
    let document = Document::parse(bytes)?;
    let lacks = "it has no points: it holds values of points, to give beside a surface (data=FILE)";
    let array = document.of_intent(POINTS).ok_or(lacks)?;
    let placement = array.placement()?;
    let mut file = SurfaceFile { format: "GIFTI".into(), space: Some(Space::Ras), ..SurfaceFile::default() };
    let of_three = |array: &Array| match array.dims()?[1] {
        3 => array.numbers(path),
        other => Err(format!("its points or triangles have {other} numbers: expected 3")),
    };
    file.points = of_three(array)?.as_chunks().0.iter().map(|p| placement.transform_point3(DVec3::from_array(*p))).collect();
    file.header = array
        .metadata
        .iter()
        .filter(|[name, _]| name.starts_with("Anatomical"))
        .map(|[_, value]| value.as_str())
        .collect::<Vec<_>>()
        .join(", ");
    if let Some(array) = document.of_intent(TRIANGLES) {
        let index = |n: &f64| {
            if (0.0..f64::from(u32::MAX)).contains(n) { Ok(*n as u32) } else { Err(format!("a triangle has point {n}")) }
        };
        let indices = of_three(array)?.iter().map(index).collect::<Result<Vec<u32>, _>>()?;
        let triangles = indices.as_chunks().0.to_vec();
        file.triangles = Cells { numbers: (0..triangles.len() as u32).collect(), points: triangles };
    }
    let data = document.point_data(path, file.points.len())?;
    (file.arrays, file.colors) = (data.arrays, data.colors.map(Per::Point));
    Ok(file)
}

/// Whether a file is one of GIFTI.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    start.windows(6).any(|part| part == b"<GIFTI")
}

/// Values, colours or labels of points.
pub(super) fn point_data(path: &Path, bytes: &[u8]) -> Result<PointData, String> {
    Document::parse(bytes)?.point_data(path, 0)
}
