//! What pages cannot do to the server and to each other.

#[cfg(unix)]
use crate::client::Page;
use crate::client::{Message, Viewer};
use serde_json::json;
use std::io::{Read, Write};
#[cfg(unix)]
use std::path::PathBuf;
use std::time::Duration;

const HYDROGEN: [&str; 1] = ["builtin:hydrogen@24"];

#[test]
fn silent_connections_do_not_disturb_others() {
    let viewer = Viewer::start(&HYDROGEN);
    // More than there are places.
    let silent: Vec<_> = (0..600).map(|_| viewer.connect()).collect();
    let mut half = viewer.connect();
    half.write_all(b"GET / HTTP/1.1\r\nHost: lo").unwrap();
    let mut page = viewer.page();
    page.send(&page.view(1, 0.0, true));
    assert_eq!(page.picture().id, 1);
    drop(silent);
    // A request that does not end is ended.
    let mut rest = Vec::new();
    half.read_to_end(&mut rest).unwrap();
}

#[test]
fn a_page_that_never_acknowledges_gets_two_pictures() {
    let viewer = Viewer::start(&HYDROGEN);
    let (mut page, mut other) = (viewer.page(), viewer.page());
    // The first picture is awaited: views that arrive faster than pictures are drawn are one picture.
    page.send(&page.view(0, 0.0, true));
    assert_eq!(page.picture().id, 0);
    for id in 1..100 {
        page.send(&page.view(id, f64::from(id), true));
    }
    assert!(page.picture().id > 0);
    page.gets_no_picture();
    other.send(&other.view(5, 0.0, true));
    assert_eq!(other.picture().id, 5);
    // The newest view is drawn as soon as there is an acknowledgement.
    page.send(&page.view(100, 1.0, true));
    page.shown();
    assert_eq!(page.picture().id, 100);
}

/// Pages refine one after another. Those that take no pictures, or go away, hold up no other.
#[test]
fn pages_that_take_nothing_hold_up_no_refinement() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut pages: Vec<_> = (0..4).map(|_| viewer.page()).collect();
    for (page, id) in pages.iter_mut().zip(1..) {
        page.send(&page.view(id, 0.0, false));
    }
    let mut silent = pages.remove(0);
    assert_eq!([silent.picture(), silent.picture()].map(|picture| picture.step), [1, 2]);
    // Goes away while it is refined.
    drop(pages.remove(0));
    for (page, id) in pages.iter_mut().zip(3..) {
        assert_eq!(page.refined().id, id);
    }
    silent.shown();
    silent.shown();
    assert_eq!(silent.refined().id, 1);
}

#[test]
fn a_page_that_closes_in_a_frame_does_not_disturb_others() {
    let viewer = Viewer::start(&HYDROGEN);
    for n in 0..12 {
        let mut page = viewer.page();
        page.send(&json!({ "type": "view", "id": 1, "camera": page.hello["camera"], "width": 1500, "height": 1500, "moving": n % 2 == 0 }));
    }
    let mut page = viewer.page();
    page.send(&page.view(3, 0.0, false));
    assert_eq!(page.picture().id, 3);
}

#[test]
fn pages_floods_and_sizes_are_bounded() {
    let viewer = Viewer::start(&HYDROGEN);
    let mut pages: Vec<_> = (0..24).map(|_| viewer.page()).collect();
    let host = viewer.host();
    let request = viewer.upgrade(&format!("Host: {host}\r\nOrigin: http://{host}\r\nCookie: {}\r\n", viewer.cookie()));
    let answer = viewer.raw(&request);
    assert!(answer.contains("Too many pages"), "{answer}");
    for (width, height) in [(0u32, 5u32), (5000, 5000), (4_000_000_000, 4_000_000_000)] {
        let camera = pages[0].hello["camera"].clone();
        for kind in [
            json!({ "type": "fit" }),
            json!({ "type": "save", "samples": 16 }),
            json!({ "type": "view", "id": 1, "moving": false }),
        ] {
            let mut request = kind;
            (request["camera"], request["width"], request["height"]) = (camera.clone(), json!(width), json!(height));
            pages[0].send(&request);
            let problem = pages[0].text("problem");
            assert!(problem["sentence"].as_str().unwrap().contains("viewport"), "{problem}");
        }
    }
    let flooding = &mut pages[1];
    let ended = (0..100_000).any(|_| flooding.send_frame(0x81, br#"{"type":"shown"}"#).is_err());
    assert!(ended, "a flood ends the page");
    // Its place is free again.
    drop(pages.remove(1));
    viewer.page();
}

/// Resident memory after many frames and pages is that after a few.
#[cfg(target_os = "linux")]
#[test]
fn memory_is_flat() {
    /// Frames and pages of each half.
    const FRAMES: u32 = 150;
    const PAGES: usize = 6;
    /// Heap pages that an allocator keeps, and the buffers of one more session.
    const ALLOWED: f64 = 1.1;
    let viewer = Viewer::start(&HYDROGEN);
    let used = |viewer: &Viewer| {
        for _ in 0..PAGES {
            let mut page = viewer.page();
            for id in 0..FRAMES / PAGES as u32 {
                page.send(&page.view(id, f64::from(id), id % 5 != 4));
                page.picture();
                page.shown();
            }
        }
        std::thread::sleep(Duration::from_millis(500));
        viewer.resident_bytes()
    };
    used(&viewer);
    let (first, second) = (used(&viewer), used(&viewer));
    assert!((second as f64) < first as f64 * ALLOWED, "{first} and then {second} bytes");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_it_cleanly() {
    let mut viewer = Viewer::start(&HYDROGEN);
    let mut page = viewer.page();
    page.send(
        &json!({ "type": "view", "id": 1, "camera": page.hello["camera"], "width": 1500, "height": 1500, "moving": false }),
    );
    assert_eq!(viewer.interrupt().code(), Some(0));
    while !matches!(page.receive(), Message::Closed(_)) {}
}

/// A file that gives nothing, and keeps those waiting who open it, until it is released.
#[cfg(unix)]
struct Stuck(PathBuf);

#[cfg(unix)]
impl Stuck {
    fn new(path: PathBuf) -> Self {
        let _ = std::fs::remove_file(&path);
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        Self(path)
    }

    /// Ends, for all who read the file, now and later.
    fn release(self) {
        std::thread::spawn(move || while std::fs::File::options().write(true).open(&self.0).is_ok() {});
    }
}

/// Asks a page for what a connection answers without voxels or files, for a picture, and for what other threads of the page answer.
#[cfg(unix)]
fn answers(viewer: &Viewer, page: &mut Page, id: u32) {
    assert!(viewer.get("/main.js", &format!("Cookie: {}\r\n", viewer.cookie())).starts_with("HTTP/1.1 200"));
    page.send(&json!({ "type": "fit", "camera": page.hello["camera"], "width": 0, "height": 5 }));
    page.text("problem");
    page.send(&page.view(id, 0.0, true));
    while page.picture().id != id {
        page.shown();
    }
    page.shown();
    let camera = page.hello["camera"].clone();
    page.send(&json!({ "type": "command", "camera": camera, "width": 8, "height": 8, "samples": 1 }));
    page.text("command");
    page.send(&json!({ "type": "named", "field": 0, "kind": "map", "name": page.hello["maps"][0]["name"] }));
    page.text("transfer");
}

/// A folder with headers, whose voxels are in other files.
#[cfg(unix)]
fn folder_of_headers(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("temporary")).unwrap();
    for name in names {
        let text = format!("NDims = 3\nDimSize = 8 8 8\nElementType = MET_UCHAR\nElementDataFile = {name}.raw\n");
        std::fs::write(folder.path().join(name), text).unwrap();
        std::fs::write(folder.path().join(format!("{name}.raw")), [[0; 256], [200; 256]].concat()).unwrap();
    }
    folder
}

/// No thread that carries connections waits for a file that is opened: while one gives nothing, twenty pages are answered.
#[cfg(unix)]
#[test]
fn nobody_waits_for_a_file_that_another_page_opens() {
    const NAME: &str = "stuck.mhd";
    let folder = folder_of_headers(&[NAME]);
    let stuck = Stuck::new(folder.path().join(NAME).with_extension("mhd.raw"));
    let viewer = Viewer::start_in(Some(folder.path()), &[]);
    let (mut page, mut others) = (viewer.page(), (1..20).map(|_| viewer.page()).collect::<Vec<_>>());
    page.send(&json!({ "type": "open", "volume": { "offered": NAME } }));
    // Its own page, too.
    answers(&viewer, &mut page, 1);
    others.iter_mut().zip(2..).for_each(|(other, id)| answers(&viewer, other, id));
    answers(&viewer, &mut viewer.page(), 1);
    page.send(&json!({ "type": "open", "volume": { "offered": "builtin:cube" } }));
    assert!(page.text("problem")["sentence"].as_str().unwrap().contains("is being opened"));
    page.send(&json!({ "type": "cancel_open" }));
    answers(&viewer, &mut page, 3);
    stuck.release();
    while page.text("opening")["stage"] != "cancelled" {}
}

/// The same for questions that take passes over voxels, and for steps that are read to be drawn. Only the page that asks for them waits.
#[cfg(unix)]
#[test]
fn nobody_waits_for_what_another_page_surveys() {
    let names = ["a.mhd", "b.mhd", "c.mhd"];
    let folder = folder_of_headers(&names);
    let viewer = Viewer::start_in(Some(folder.path()), &names);
    let (mut fitting, mut stepping) = (viewer.page(), viewer.page());
    let stuck = Stuck::new(folder.path().join(names[2]).with_extension("mhd.raw"));
    let fit = json!({ "type": "fit", "camera": fitting.hello["camera"], "width": 8, "height": 8 });
    // One is being answered, the others wait.
    (0..20).for_each(|_| fitting.send(&fit));
    let refused = fitting.text("problem");
    assert!(refused["sentence"].as_str().unwrap().contains("too many requests wait"), "{refused}");
    fitting.send(&fitting.view(1, 0.0, true));
    let Message::Picture(picture) = fitting.next(&[]) else { panic!("pictures of the page do not wait") };
    assert_eq!(picture.id, 1);
    let mut look = stepping.hello["look"].clone();
    look["frame"] = json!(2);
    stepping.send(&json!({ "type": "look", "look": look }));
    stepping.send(&stepping.view(1, 0.0, true));
    stepping.send(&json!({ "type": "fit", "camera": stepping.hello["camera"], "width": 0, "height": 5 }));
    stepping.text("problem");
    let mut others: Vec<Page> = (2..20).map(|_| viewer.page()).collect();
    others.iter_mut().zip(2..).for_each(|(other, id)| answers(&viewer, other, id));
    // Pages may be closed meanwhile.
    drop(stepping);
    answers(&viewer, &mut viewer.page(), 1);
    stuck.release();
    // The file is damaged now.
    while !fitting.text("problem")["sentence"].as_str().unwrap().contains(names[2]) {}
}
