//! Volumes that a page opens: one of those that the program offers, or a file that was dropped onto the page. The page sends names, never
//! paths.

use super::drops::{Dropped, Drops};
use super::host::{RawLayout, Source};
use super::outgoing::{Message, text};
use super::replies::{Reply, Stage};
use super::requests::OpenWanted;
use super::scene::SharedScene;
use super::served::{Served, aside};
use crate::error::Error;
use crate::files::Scratch;
use crate::progress::{self, Observer};
use axum::body::{Body, HttpBody};
use axum::extract::{Request, State};
use axum::http::header::CONTENT_LENGTH;
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use std::future::poll_fn;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::fs::File;
use tokio::io::AsyncWriteExt;
use tokio::sync::mpsc;
use tokio::time::timeout;

const GONE: &str = "The file is gone, because another one was dropped. Drop it again.";
/// Most files that are dropped at once.
const MOST_FILES: usize = 10_000;
/// Most bytes of dropped files.
const MOST_BYTES: u64 = 8 << 30;
/// A page that sends nothing of its file for this long is given up.
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
/// Time between two messages about a volume that is being opened.
const STEP: Duration = Duration::from_millis(100);
/// Longest name of a dropped file in bytes.
const LONGEST_NAME: usize = 200;

/// A volume that is being opened, between the thread that opens it and its page.
pub(super) struct Progress {
    tell: mpsc::Sender<Opened>,
    is_cancelled: AtomicBool,
    last: Mutex<Option<Instant>>,
}

/// What comes of a volume that is being opened.
pub(super) enum Opened {
    Progress(Message),
    Scene(Arc<SharedScene>),
    /// The sentence of an error.
    Problem(String),
    Cancelled,
}

impl Progress {
    pub fn new(tell: mpsc::Sender<Opened>) -> Arc<Self> {
        Arc::new(Self { tell, is_cancelled: AtomicBool::new(false), last: Mutex::default() })
    }

    /// Ends the opening soon.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Opens a volume, and tells what came of it. Takes as long as reading it.
    pub fn open(self: &Arc<Self>, served: &Served, scene: &SharedScene, wanted: &OpenWanted) {
        let opened = progress::observed(self.clone(), || catch_unwind(AssertUnwindSafe(|| self.opened(served, scene, wanted))));
        let opened = match opened {
            _ if self.is_cancelled() => Opened::Cancelled,
            Ok(Ok(scene)) => Opened::Scene(scene),
            Ok(Err(sentence)) => Opened::Problem(sentence),
            // Otherwise the page would wait for ever.
            Err(_) => Opened::Problem("The server failed while it opened this. Its messages say more.".into()),
        };
        // The page may be gone.
        if matches!(opened, Opened::Problem(_)) {
            // Other problems of a page say nothing of the volume that is on its way.
            let _ = self.tell.blocking_send(Opened::Progress(text(&Reply::Opening { stage: Stage::Failed, done: None })));
        }
        let _ = self.tell.blocking_send(opened);
    }

    /// Opens a volume. The error is a sentence for the page, which gets none if it was cancelled.
    fn opened(&self, served: &Served, scene: &SharedScene, wanted: &OpenWanted) -> Result<Arc<SharedScene>, String> {
        let dropped = match wanted {
            OpenWanted::Offered(_) => None,
            OpenWanted::Dropped(number) | OpenWanted::Raw { dropped: number, .. } => {
                Some(served.drops.take(*number).ok_or(GONE)?)
            }
        };
        let path = dropped.as_ref().map(Dropped::path).transpose()?;
        let layout = if let OpenWanted::Raw { layout, .. } = wanted { *layout } else { RawLayout::default() };
        let source = match (wanted, &path) {
            (OpenWanted::Offered(name), _) => Source::Offered(name),
            (_, path) => Source::File(path.as_ref().expect("taken above"), layout),
        };
        // Messages name the file as the user does, without the temporary folder.
        let folder = dropped.as_ref().map(Dropped::hidden);
        let sentence = |error: &Error| {
            let sentence = scene.host.sentence(error);
            folder.as_ref().map_or_else(|| sentence.clone(), |folder| sentence.replace(folder.as_str(), ""))
        };
        let (mut opening, host) = scene.host.open(&source).map_err(|error| sentence(&error))?;
        opening.notes.extend(dropped.as_ref().and_then(Dropped::note));
        if self.is_cancelled() {
            return Err(String::new());
        }
        let held = dropped.map(Dropped::into_folder);
        let opened = SharedScene::new(opening, host).map_err(|error| sentence(&error))?;
        Ok(Arc::new(opened.after(scene, served.scenes.next_number(), held)))
    }
}

impl Observer for Progress {
    fn step(&self, what: &str, done: u64, total: u64) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_some_and(|last| last.elapsed() < STEP) {
            return;
        }
        *last = Some(Instant::now());
        // The file's name stays here: it has folders of this machine.
        let stage = if what.starts_with("reading") { Stage::Reading } else { Stage::Looking };
        let done = (total > 0).then(|| done as f64 / total as f64);
        // A page that takes nothing misses a step.
        let _ = self.tell.try_send(Opened::Progress(text(&Reply::Opening { stage, done })));
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
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
    let value = |key: &str| uri.query().unwrap_or_default().split('&').find_map(|pair| pair.strip_prefix(key)?.strip_prefix('='));
    let bad = || (StatusCode::BAD_REQUEST, "The file's name has letters that a file cannot have here. Rename it.".to_owned());
    let name = value("name").and_then(file_name).ok_or_else(bad)?;
    let of_several = value("in").map(|folder| file_name(folder).ok_or_else(bad)).transpose()?;
    // The drop that the file belongs to, if it is not the first of several. It is lost if the file does not arrive.
    let number = value("to").map(|number| number.parse::<u32>().map_err(|_| bad())).transpose()?;
    let begun = number.map(|number| drops.take(number).ok_or((StatusCode::CONFLICT, GONE.to_owned()))).transpose()?;
    let too_large =
        || (StatusCode::PAYLOAD_TOO_LARGE, "The file has more than 8 GiB. Begin the command with it instead.".to_owned());
    let declared = request.headers().get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if declared.is_some_and(|bytes| bytes > MOST_BYTES) {
        return Err(too_large());
    }
    let no_room =
        |e: io::Error| (StatusCode::INSUFFICIENT_STORAGE, format!("The file cannot be kept on the server: {}.", e.kind()));
    let no_folder = || no_room(io::ErrorKind::PermissionDenied.into());
    let dropped = match begun {
        Some(begun) => begun,
        None => drops.begin(aside(Scratch::new).await.and_then(Result::ok).ok_or_else(no_folder)?, of_several),
    };
    if dropped.files.len() == MOST_FILES {
        let sentence = format!("These are more than {MOST_FILES} files. Begin the command with their folder instead.");
        return Err((StatusCode::PAYLOAD_TOO_LARGE, sentence));
    }
    let create = move || (dropped.create(&name), name, dropped);
    let (created, name, mut dropped) = aside(create).await.ok_or_else(no_folder)?;
    let mut file = File::from_std(created.map_err(no_room)?);
    let mut body: Body = request.into_body();
    loop {
        let frame = timeout(LONGEST_PAUSE, poll_fn(|context| Pin::new(&mut body).poll_frame(context))).await;
        let frame = match frame {
            Ok(None) => break,
            Ok(Some(Ok(frame))) => frame,
            _ => return Err((StatusCode::REQUEST_TIMEOUT, "The file did not arrive as a whole. Drop it again.".into())),
        };
        let Ok(data) = frame.into_data() else { continue };
        dropped.bytes += data.len() as u64;
        if dropped.bytes > MOST_BYTES {
            return Err(too_large());
        }
        file.write_all(&data).await.map_err(no_room)?;
    }
    // Otherwise the last bytes may be written later, or an error be lost.
    file.flush().await.map_err(no_room)?;
    dropped.files.push(name);
    Ok(drops.keep(dropped))
}

/// Whether a name has characters that change the order in which others are shown, so that it looks like another one.
pub fn reorders(name: &str) -> bool {
    name.contains(|c| matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'))
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
        && !name.chars().any(|c| c.is_control() || "/\\:*?\"<>|%".contains(c))
        && !reorders(&name);
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
        for bad in [
            "",
            ".",
            "..",
            ".hidden",
            "a%2Fb",
            "..%2Fa",
            "a/b",
            "a%5Cb",
            "a%00",
            "%",
            "%4",
            "%+4",
            "%zz",
            "%FF",
            "C%3Aa",
            "a%E2%80%AEdrrn.gpj",
            &long,
        ] {
            assert_eq!(file_name(bad), None, "{bad}");
        }
    }

    #[test]
    fn the_last_dropped_file_is_taken_once() {
        let drops = Drops::default();
        let put = || {
            let folder = Scratch::new().unwrap();
            let mut dropped = drops.begin(folder, None);
            dropped.create("a.raw").unwrap();
            dropped.files.push("a.raw".into());
            let path = dropped.path().unwrap();
            (drops.keep(dropped), path)
        };
        let ((first, gone), (second, path)) = (put(), put());
        assert!(!gone.exists() && path.exists() && drops.take(first).is_none());
        let taken = drops.take(second).unwrap();
        assert!(drops.take(second).is_none() && path.exists());
        drop(taken);
        assert!(!path.exists());
    }

    #[test]
    fn several_files_are_slices_or_a_header_and_its_voxels() {
        let drops = Drops::default();
        let opened = |files: &[&str]| {
            let mut dropped = drops.begin(Scratch::new().unwrap(), Some("series".into()));
            dropped.files = files.iter().map(|&name| name.into()).collect();
            let path = dropped.path().map(|path| path.strip_prefix(dropped.hidden()).unwrap().display().to_string());
            (path, dropped.note())
        };
        let read = |path: &str| (Ok(path.to_owned()), None);
        assert_eq!(opened(&["a.dcm", "b.dcm"]), read("series"));
        assert_eq!(opened(&["brain.img", "brain.HDR"]), read("series/brain.HDR"));
        assert_eq!(opened(&["a.vti", "run.pvd", "b.vti"]), read("series/run.pvd"));
        assert_eq!(opened(&["a.json"]), read("series/a.json"));
        let beside = Some("Not read: a.json".to_owned());
        assert_eq!(opened(&["a.json", "a.nii.gz"]), (Ok("series/a.nii.gz".into()), beside.clone()));
        assert_eq!(opened(&["a.json", "a.dcm", "b.dcm"]), (Ok("series".into()), beside));
        let refused =
            "These are several volumes: a.nii, b.nii. Drop one of them. Steps in time are shown by 'layersplat view A B'.";
        assert_eq!(opened(&["a.nii", "b.nii"]), (Err(refused.into()), None));
        assert_eq!(opened(&["a.dcm", "mask.nii"]), read("series"));
        let refused = "These are several volumes: 1.mhd, 2.mhd, 3.mhd, 4.mhd and 1 more. Drop one of them, with its voxels.";
        assert_eq!(opened(&["1.mhd", "a.raw", "2.mhd", "3.mhd", "4.mhd", "5.mhd"]), (Err(refused.into()), None));
    }
}
