//! What pages cannot do to the server and to each other.

use crate::client::{Message, Viewer};
use serde_json::json;
use std::io::{Read, Write};
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
