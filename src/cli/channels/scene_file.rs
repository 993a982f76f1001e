//! Scenes in JSON: a list of fields, or an object with the lists `fields` and `surfaces`. Each field is an object with the keys of `--with`,
//! and `file`; without `file`, the first field is the volume of the command. Surfaces have the keys of `--surface`, and `file`.

use super::spec::{FieldSpec, Pairs};
use crate::error::Error;
use crate::files;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Largest file in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// What a scene names.
#[derive(Default)]
pub(super) struct SceneFile {
    /// None only if it has surfaces.
    pub fields: Vec<FieldSpec>,
    pub surfaces: Vec<SceneSurface>,
}

/// A surface of a scene.
pub(in crate::cli) struct SceneSurface {
    scene: PathBuf,
    /// Counted from 1, for messages.
    number: usize,
    pub keys: Pairs,
}

impl SceneSurface {
    /// The error of a problem with its keys.
    pub fn error(&self, problem: &str) -> Error {
        Error::Keys { path: self.scene.clone(), problem: format!("surface {}: {problem}", self.number) }
    }

    /// A name of a file, which is relative to that of the scene.
    pub fn path(&self, name: &Path) -> PathBuf {
        self.scene.parent().unwrap_or(Path::new("")).join(name)
    }
}

/// Reads at least one field or surface.
///
/// # Errors
/// [`Error::Read`], or [`Error::Keys`] for a malformed scene.
pub(super) fn read(path: &Path) -> Result<SceneFile, Error> {
    let wrong = |problem: String| Error::Keys { path: path.into(), problem };
    let text = files::read_text(path, MAX_BYTES)?;
    let scene: Value = serde_json::from_str(&text).map_err(|e| wrong(format!("it is not JSON: {e}")))?;
    let mut lists = match scene {
        Value::Array(fields) => Map::from_iter([("fields".into(), Value::Array(fields))]),
        Value::Object(lists) => lists,
        _ => return Err(wrong(r#"it is no scene: expected {"fields": [{"file": "…"}]}"#.into())),
    };
    let mut list = |name: &str| match lists.remove(name) {
        None => Ok(None),
        Some(Value::Array(list)) => Ok(Some(list)),
        Some(_) => Err(wrong(format!(r#"its {name} are no list: expected "{name}": [{{"file": "…"}}]"#))),
    };
    let (fields, surfaces) = (list("fields")?, list("surfaces")?);
    if let Some(key) = lists.keys().next() {
        return Err(wrong(format!("the scene has the unknown key {key:?}; its keys are \"fields\" and \"surfaces\"")));
    }
    if fields.is_none() && surfaces.is_none() {
        return Err(wrong(r#"the scene has no list of fields: add "fields": [{"file": "…"}]"#.into()));
    }
    let keys = |what: &str, n: usize, value: Value| {
        let wrong = |problem: String| wrong(format!("{what} {}: {problem}", n + 1));
        let Value::Object(keys) = value else { return Err(wrong(r#"it is no object such as {"file": "…"}"#.into())) };
        pairs_from(keys).map_err(wrong)
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene = SceneFile::default();
    for (n, field) in fields.into_iter().flatten().enumerate() {
        let mut spec = FieldSpec::default();
        for (key, value) in keys("field", n, field)? {
            spec.set(&key, &value).map_err(|problem| wrong(format!("field {}: {key}: {problem}", n + 1)))?;
        }
        if spec.file.is_none() && n > 0 {
            return Err(wrong(format!(r#"field {}: it names no file: add "file": "…""#, n + 1)));
        }
        scene.fields.push(spec.relative_to(folder));
    }
    for (n, surface) in surfaces.into_iter().flatten().enumerate() {
        scene.surfaces.push(SceneSurface { scene: path.into(), number: n + 1, keys: keys("surface", n, surface)? });
    }
    if scene.fields.is_empty() && scene.surfaces.is_empty() {
        return Err(wrong("it has no fields".into()));
    }
    Ok(scene)
}

/// Keys and values as options write them.
fn pairs_from(keys: Map<String, Value>) -> Result<Pairs, String> {
    let pair = |(key, value): (String, Value)| {
        let key = key.replace('_', "-");
        let text =
            text_of(&value).ok_or_else(|| format!("{key}: invalid value {value}; use a text, a number, or a list of numbers"))?;
        Ok((key, text))
    };
    keys.into_iter().map(pair).collect()
}

/// A value as options write it: `[1, 2]` is `1,2`, and `[[1, 0], [2, 0.5]]` is `1:0,2:0.5`.
fn text_of(value: &Value) -> Option<String> {
    let joined = |list: &[Value], separator: &str| {
        let words: Option<Vec<_>> = list
            .iter()
            .map(|item| match item {
                Value::Number(number) => Some(number.to_string()),
                Value::String(text) => Some(text.clone()),
                _ => None,
            })
            .collect();
        words.map(|words| words.join(separator))
    };
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(on) => Some(if *on { "on" } else { "off" }.into()),
        Value::Array(list) if list.iter().all(Value::is_array) && !list.is_empty() => {
            let pairs: Option<Vec<_>> = list.iter().map(|pair| joined(pair.as_array()?, ":")).collect();
            pairs.map(|pairs| pairs.join(","))
        }
        Value::Array(list) => joined(list, ","),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<SceneFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.json");
        std::fs::write(&path, text).unwrap();
        read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn scenes_have_the_keys_of_the_option() {
        let text = r##"{"fields": [{"color": "#ff0000"}, {"file": "b.nii", "opacity": [[0, 0], ["p99", 0.5]], "factor": 2, "visible": false}]}"##;
        let fields = read_text(text).unwrap().fields;
        assert!(fields[0].file.is_none() && fields[0].chooses_transfer());
        assert!(fields[1].file.as_ref().unwrap().ends_with("b.nii") && fields[1].file.as_ref().unwrap().is_absolute());
        assert_eq!(read_text(r#"[{"file": "a.nii"}]"#).unwrap().fields.len(), 1);
        let scene = read_text(r#"{"surfaces": [{"file": "a.stl", "opacity": 0.4, "clip": false}]}"#).unwrap();
        let expected = [("clip", "off"), ("file", "a.stl"), ("opacity", "0.4")].map(|(key, value)| (key.into(), value.into()));
        assert!(scene.fields.is_empty() && scene.surfaces[0].keys == expected);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, problem) in [
            ("{", "not JSON"),
            ("3", "no scene"),
            ("[]", "no fields"),
            ("{}", "no list of fields"),
            (r#"{"fields": 3}"#, "its fields are no list"),
            (r#"{"surfaces": [{"file": {}}]}"#, "surface 1: file: invalid value"),
            (r#"{"fields": [], "camera": 1}"#, "unknown key"),
            (r#"[{"file": "a"}, {}]"#, "field 2: it names no file"),
            (r#"[{"file": "a", "sise": 1}]"#, "field 1: sise: unknown key"),
            (r#"[{"file": "a", "factor": {}}]"#, "factor: invalid value"),
            ("[3]", "field 1: it is no object"),
        ] {
            let message = read_text(text).err().unwrap();
            assert!(message.contains(problem), "{text}: {message}");
        }
    }
}
