//! Scenes of fields in JSON: a list of fields, or an object with the list `fields`. Each field is an object with the keys of `--with`, and
//! `file`. Without `file`, the first field is the volume of the command.

use super::spec::FieldSpec;
use crate::error::Error;
use crate::files;
use serde_json::{Map, Value};
use std::path::Path;

/// Largest file in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Reads at least one field.
///
/// # Errors
/// [`Error::Read`], or [`Error::Keys`] for a malformed scene.
pub(super) fn read(path: &Path) -> Result<Vec<FieldSpec>, Error> {
    let wrong = |problem: String| Error::Keys { path: path.into(), problem };
    let text = files::read_text(path, MAX_BYTES)?;
    let scene: Value = serde_json::from_str(&text).map_err(|e| wrong(format!("it is not JSON: {e}")))?;
    let list = match scene {
        Value::Array(list) => list,
        Value::Object(mut scene) => match scene.remove("fields") {
            Some(Value::Array(list)) if scene.is_empty() => list,
            Some(Value::Array(_)) => {
                let key = scene.keys().next().cloned().unwrap_or_default();
                return Err(wrong(format!("the scene has the unknown key {key:?}; it has \"fields\" alone")));
            }
            _ => return Err(wrong(r#"the scene has no list of fields: add "fields": [{"file": "…"}]"#.into())),
        },
        _ => return Err(wrong(r#"it is no scene: expected {"fields": [{"file": "…"}]}"#.into())),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut fields = Vec::new();
    for (n, field) in list.into_iter().enumerate() {
        let wrong = |problem: String| wrong(format!("field {}: {problem}", n + 1));
        let Value::Object(keys) = field else { return Err(wrong(r#"it is no object such as {"file": "…"}"#.into())) };
        let spec = spec_from(keys).map_err(wrong)?;
        if spec.file.is_none() && n > 0 {
            return Err(wrong(r#"it names no file: add "file": "…""#.into()));
        }
        fields.push(spec.relative_to(folder));
    }
    if fields.is_empty() {
        return Err(wrong("it has no fields".into()));
    }
    Ok(fields)
}

fn spec_from(keys: Map<String, Value>) -> Result<FieldSpec, String> {
    let mut spec = FieldSpec::default();
    for (key, value) in keys {
        let key = key.replace('_', "-");
        let text =
            text_of(&value).ok_or_else(|| format!("{key}: invalid value {value}; use a text, a number, or a list of numbers"))?;
        spec.set(&key, &text).map_err(|problem| format!("{key}: {problem}"))?;
    }
    Ok(spec)
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

    fn read_text(text: &str) -> Result<Vec<FieldSpec>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.json");
        std::fs::write(&path, text).unwrap();
        read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn scenes_have_the_keys_of_the_option() {
        let text = r##"{"fields": [{"color": "#ff0000"}, {"file": "b.nii", "opacity": [[0, 0], ["p99", 0.5]], "factor": 2, "visible": false}]}"##;
        let fields = read_text(text).unwrap();
        assert!(fields[0].file.is_none() && fields[0].chooses_transfer());
        assert!(fields[1].file.as_ref().unwrap().ends_with("b.nii") && fields[1].file.as_ref().unwrap().is_absolute());
        assert_eq!(read_text(r#"[{"file": "a.nii"}]"#).unwrap().len(), 1);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, problem) in [
            ("{", "not JSON"),
            ("3", "no scene"),
            ("[]", "no fields"),
            (r#"{"fields": 3}"#, "no list of fields"),
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
