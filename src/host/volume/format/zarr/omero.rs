//! OME-Zarr's metadata of channels (<https://ngff.openmicroscopy.org/0.5/#omero-md>).

use crate::volume::{ChannelDescription, colors};
use serde_json::Value;

/// Limit of channels.
const MOST: usize = 1 << 16;

/// The channels of `omero`; none if it is missing.
pub(super) fn channels(omero: &Value) -> Result<Vec<ChannelDescription>, String> {
    match &omero["channels"] {
        Value::Null => Ok(Vec::new()),
        Value::Array(channels) if channels.len() <= MOST => channels.iter().map(channel).collect(),
        _ => Err(format!("its omero metadata have no list of up to {MOST} channels: correct or remove them")),
    }
}

fn channel(metadata: &Value) -> Result<ChannelDescription, String> {
    let wrong = |key: &str, expected: &str| {
        format!("its omero metadata have a channel with {key} {}: expected {expected}", metadata[key])
    };
    let color = match &metadata["color"] {
        Value::Null => None,
        text => {
            Some(text.as_str().and_then(colors::from_hex).ok_or_else(|| wrong("color", "six hexadecimal digits, as 00FF00"))?)
        }
    };
    let window = &metadata["window"];
    let window = match (&window["start"], &window["end"]) {
        (Value::Null, Value::Null) => None,
        (start, end) => {
            let ends = start.as_f64().zip(end.as_f64()).filter(|(start, end)| start <= end);
            Some(ends.ok_or_else(|| wrong("window", "numbers start and end, ascending"))?)
        }
    };
    let active = match &metadata["active"] {
        Value::Null => true,
        active => active.as_bool().ok_or_else(|| wrong("active", "true or false"))?,
    };
    let name = metadata["label"].as_str().map(str::trim).filter(|name| !name.is_empty()).map(Into::into);
    // Equal ends show nothing.
    let window = window.filter(|(start, end)| start < end);
    Ok(ChannelDescription { name, color, window, active })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn channels_have_what_is_stated() {
        let full = json!({"active": false, "color": "00ff00", "label": "GFP", "window": {"start": 10, "end": 1200.5, "min": 0, "max": 65535}});
        let found = channels(&json!({"channels": [full, {}, {"window": {"start": 3, "end": 3}, "label": " "}]})).unwrap();
        let first = ChannelDescription {
            name: Some("GFP".into()),
            color: Some([0.0, 1.0, 0.0]),
            window: Some((10.0, 1200.5)),
            active: false,
        };
        assert_eq!(found, [first, ChannelDescription::default(), ChannelDescription::default()]);
        assert_eq!(channels(&Value::Null).unwrap(), []);
        for (bad, expected) in [
            (json!({"channels": 3}), "no list"),
            (json!({"channels": [{"color": "green"}]}), "with color \"green\": expected six hexadecimal digits"),
            (json!({"channels": [{"color": 5}]}), "with color 5"),
            (json!({"channels": [{"window": {"start": 9, "end": 3}}]}), "expected numbers start and end"),
            (json!({"channels": [{"window": {"start": 9}}]}), "expected numbers start and end"),
            (json!({"channels": [{"active": "yes"}]}), "expected true or false"),
        ] {
            let message = channels(&bad).unwrap_err();
            assert!(message.contains(expected), "{bad}: {message}");
        }
    }
}
