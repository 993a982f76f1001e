//! Volumes that a page opens: one of those that the program offers, or a file that was dropped onto the page. The page sends names, never
//! paths.

use super::drops::Drops;
use super::host::Source;
use super::requests::OpenWanted;
use super::scene::SharedScene;
use super::served::Served;
use crate::error::Error;
use crate::files::Scratch;
use axum::body::{Body, HttpBody};
use axum::extract::{Request, State};
use axum::http::header::CONTENT_LENGTH;
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use std::future::poll_fn;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::fs::File;
use tokio::io::AsyncWriteExt;
use tokio::time::timeout;

/// Most bytes of a dropped file.
const MOST_BYTES: u64 = 8 << 30;
/// A page that sends nothing of its file for this long is given up.
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
/// Longest name of a dropped file in bytes.
const LONGEST_NAME: usize = 200;

/// Opens a volume. Takes as long as reading it. The error is a sentence for the page.
pub(super) fn open(served: &Served, scene: &SharedScene, wanted: &OpenWanted) -> Result<Arc<SharedScene>, String> {
    let dropped = match wanted {
        OpenWanted::Offered(_) => None,
        OpenWanted::Dropped(number) => {
            Some(served.drops.take(*number).ok_or("The file is gone, because another one was dropped. Drop it again.")?)
        }
    };
    let source = match (wanted, &dropped) {
        (OpenWanted::Offered(name), _) => Source::Offered(name),
        (_, dropped) => Source::File(&dropped.as_ref().expect("taken above").path),
    };
    // Messages name the file as the user does, without the temporary folder.
    let folder = dropped.as_ref().map(|dropped| format!("{}{}", dropped.folder.path().display(), std::path::MAIN_SEPARATOR));
    let sentence = |error: &Error| {
        let sentence = scene.host.sentence(error);
        folder.as_ref().map_or_else(|| sentence.clone(), |folder| sentence.replace(folder.as_str(), ""))
    };
    let (opening, host) = scene.host.open(&source).map_err(|error| sentence(&error))?;
    let held = dropped.map(|dropped| dropped.folder);
    let opened = SharedScene::new(opening, host).map_err(|error| sentence(&error))?;
    Ok(Arc::new(opened.numbered(served.scenes.next_number(), held)))
}

/// Receives a dropped file; answers with its number.
pub(super) async fn receive(State(served): State<Arc<Served>>, uri: Uri, request: Request) -> Response {
    match received(&served.drops, &uri, request).await {
        Ok(number) => number.to_string().into_response(),
        Err((status, sentence)) => (status, sentence).into_response(),
    }
}

type Refused = (StatusCode, String);

async fn received(drops: &Drops, uri: &Uri, request: Request) -> Result<u32, Refused> {
    let Ok(_only) = drops.arriving.try_acquire() else {
        return Err((
            StatusCode::TOO_MANY_REQUESTS,
            "Another file is still on its way. Drop this one again when it is there.".into(),
        ));
    };
    let name = uri.query().and_then(|query| query.strip_prefix("name=")).and_then(file_name);
    let name = name.ok_or((StatusCode::BAD_REQUEST, "The file's name has letters that a file cannot have here.".to_owned()))?;
    let too_large =
        || (StatusCode::PAYLOAD_TOO_LARGE, "The file has more than 8 GiB. Begin the command with it instead.".to_owned());
    let declared = request.headers().get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if declared.is_some_and(|bytes| bytes > MOST_BYTES) {
        return Err(too_large());
    }
    let no_room =
        |e: io::Error| (StatusCode::INSUFFICIENT_STORAGE, format!("The file cannot be kept on the server: {}.", e.kind()));
    let folder = Scratch::new().map_err(|_| no_room(io::ErrorKind::PermissionDenied.into()))?;
    let path = folder.path().join(name);
    let mut file = File::create(&path).await.map_err(no_room)?;
    let mut body: Body = request.into_body();
    let mut bytes = 0;
    loop {
        let frame = timeout(LONGEST_PAUSE, poll_fn(|context| Pin::new(&mut body).poll_frame(context))).await;
        let frame = match frame {
            Ok(None) => break,
            Ok(Some(Ok(frame))) => frame,
            _ => return Err((StatusCode::REQUEST_TIMEOUT, "The file did not arrive as a whole. Drop it again.".into())),
        };
        let Ok(data) = frame.into_data() else { continue };
        bytes += data.len() as u64;
        if bytes > MOST_BYTES {
            return Err(too_large());
        }
        file.write_all(&data).await.map_err(no_room)?;
    }
    // Otherwise the last bytes may be written later, or an error be lost.
    file.flush().await.map_err(no_room)?;
    Ok(drops.keep(folder, path))
}

/// A percent-encoded name without folders. Formats and sizes are recognised by names, so it is kept.
fn file_name(encoded: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = encoded.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let digits = [rest.next()?, rest.next()?];
                u8::from_str_radix(std::str::from_utf8(&digits).ok().filter(|_| digits[0] != b'+')?, 16).ok()?
            }
            byte => byte,
        });
    }
    let name = String::from_utf8(bytes).ok()?;
    let is_plain = !name.is_empty()
        && name.len() <= LONGEST_NAME
        && !name.starts_with('.')
        && !name.chars().any(|c| c.is_control() || "/\\:*?\"<>|%".contains(c));
    is_plain.then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_files_in_one_folder() {
        assert_eq!(file_name("head%20of_2x2x2_uint8.raw").as_deref(), Some("head of_2x2x2_uint8.raw"));
        assert_eq!(file_name("K%C3%B6pf.nrrd").as_deref(), Some("Köpf.nrrd"));
        let long = "a".repeat(201);
        for bad in
            ["", ".", "..", ".hidden", "a%2Fb", "..%2Fa", "a/b", "a%5Cb", "a%00", "%", "%4", "%+4", "%zz", "%FF", "C%3Aa", &long]
        {
            assert_eq!(file_name(bad), None, "{bad}");
        }
    }

    #[test]
    fn the_last_dropped_file_is_taken_once() {
        let drops = Drops::default();
        let put = || {
            let folder = Scratch::new().unwrap();
            let path = folder.path().join("a.raw");
            std::fs::write(&path, "a").unwrap();
            (drops.keep(folder, path.clone()), path)
        };
        let ((first, gone), (second, path)) = (put(), put());
        assert!(!gone.exists() && path.exists() && drops.take(first).is_none());
        let taken = drops.take(second).unwrap();
        assert!(drops.take(second).is_none() && path.exists());
        drop(taken);
        assert!(!path.exists());
    }
}
