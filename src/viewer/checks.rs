//! Checks of messages that need neither volume nor device.

use super::requests::{Request, saved_size, shown_size, transfer_function};
use crate::error::Error;
use crate::transfer::{FileFormat, TransferFunction};
use std::path::Path;

impl Request {
    /// Checks sizes, numbers and limits.
    ///
    /// # Errors
    /// What is wrong and what is expected.
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Request::View(view) => shown_size(view.width, view.height).map(drop),
            Request::Slices(slices) => slices.check(),
            Request::Look { look } => look.check(),
            Request::Fit { width, height, .. } => shown_size(*width, *height).map(drop),
            Request::Save { width, height, samples, .. } | Request::Command { width, height, samples, .. } => {
                saved_size(*width, *height, *samples).map(drop)
            }
            Request::Film(film) => film.check().map(drop),
            Request::Pick(pick) => pick.check(),
            Request::Transfer { .. }
            | Request::Shown {}
            | Request::Named { .. }
            | Request::Read { .. }
            | Request::Write { .. }
            | Request::CancelFilm { .. }
            | Request::CancelOpen {}
            | Request::Open { .. } => Ok(()),
        }
    }
}

/// Reads a message of a page and does all with it that needs neither volume nor device. `None` if it is none. For fuzzing.
#[doc(hidden)]
pub fn check_message(message: &str) -> Option<Result<(), Error>> {
    let request: Request = serde_json::from_str(message).ok()?;
    Some(request.check().and_then(|()| match request {
        Request::Transfer { colors, opacities, .. } => transfer_function(colors, opacities).map(drop),
        Request::Read { name, text, .. } => TransferFunction::from_text(&text, &name).map(drop),
        Request::Write { name, .. } => FileFormat::from_path(Path::new(&name)).map(drop),
        _ => Ok(()),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = r#"{"azimuth":1,"elevation":2,"roll":3,"center":[4,5,6],"projection":{"parallel_scale":7}}"#;

    fn messages() -> Vec<String> {
        vec![
            format!(r#"{{"type":"view","id":1,"camera":{CAMERA},"width":8,"height":9,"moving":true}}"#),
            format!(r#"{{"type":"save","camera":{CAMERA},"width":8,"height":9,"samples":2}}"#),
            format!(r#"{{"type":"pick","id":1,"camera":{CAMERA},"height":9,"x":0.5,"y":-0.5}}"#),
            format!(
                r#"{{"type":"film","id":1,"keys":[{{"time":0,"camera":{CAMERA}}},{{"time":1,"camera":{CAMERA}}}],"width":8,"height":9,"samples":1,"rate":25,"format":"gif"}}"#
            ),
            r#"{"type":"transfer","colors":[[0,[1,1,1]],[9,[0,0.5,1]]],"opacities":[[0,0.5],[3,1]]}"#.into(),
            r#"{"type":"read","name":"a.csv","text":"0,0,0,0,0\n9,1,0.5,0.25,0.75\n"}"#.into(),
            r#"{"type":"open","volume":{"offered":"builtin:cube"}}"#.into(),
            r#"{"type":"cancel_film","id":3}"#.into(),
        ]
    }

    /// Damaged messages are refused or checked, and nothing panics. `fuzz/run viewer_message` goes on with this for hours.
    #[test]
    fn damaged_messages_are_refused() {
        assert!(messages().iter().all(|message| matches!(check_message(message), Some(Ok(())))), "undamaged ones are not");
        let pieces = ["1e308", "-1", "null", "[]", "{}", "\"", "4294967296", "1e999", "\\u0000", ",", "9".repeat(400).leak()];
        // A generator of Marsaglia's: damage is the same in every run.
        let mut state = 2463534242u32;
        let mut random = move |below: usize| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state as usize % below
        };
        let mut refused = 0;
        for n in 0..20_000 {
            let mut message = messages()[n % messages().len()].clone().into_bytes();
            for _ in 0..1 + random(3) {
                let (at, end) = (random(message.len()), random(12));
                let end = (at + end).min(message.len());
                message.splice(at..end, pieces[random(pieces.len())].bytes());
            }
            let Ok(text) = String::from_utf8(message) else { continue };
            refused += usize::from(!matches!(check_message(&text), Some(Ok(()))));
        }
        assert!(refused > 10_000, "{refused}");
    }
}
