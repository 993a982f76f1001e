//! Volumes that a page opens: offered ones, and files that are dropped onto it.

use crate::client::{Page, Viewer};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;

/// A folder with a subfolder for temporary files.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("temporary")).unwrap();
    folder
}

/// A cube of voxels that grow along x.
fn voxels(side: usize) -> Vec<u8> {
    (0..side * side * side).map(|n| (n % side * 255 / (side - 1)) as u8).collect()
}

/// Drops a file with these headers; returns the answer.
fn drop_with(viewer: &Viewer, name: &str, headers: &str, bytes: &[u8]) -> String {
    let host = viewer.host();
    let mut stream = viewer.connect();
    let head = format!(
        "POST /drop?name={name} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {}\r\n{headers}\r\n",
        bytes.len()
    );
    stream.write_all(head.as_bytes()).unwrap();
    // The server may refuse before it has read everything.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let _ = std::io::Read::read_to_end(&mut stream, &mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

fn drop_file(viewer: &Viewer, name: &str, bytes: &[u8]) -> String {
    let own = format!("Origin: http://{}\r\nCookie: {}\r\n", viewer.host(), viewer.cookie());
    drop_with(viewer, name, &own, bytes)
}

/// Drops a file and opens it; returns the first message of its volume, or the problem.
pub fn open_dropped(viewer: &Viewer, page: &mut Page, name: &str, bytes: &[u8]) -> Value {
    let answer = drop_file(viewer, name, bytes);
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    let number: u32 = answer.rsplit("\r\n\r\n").next().unwrap().trim().parse().unwrap_or_else(|_| panic!("{answer}"));
    open(page, json!({ "dropped": number }))
}

fn open(page: &mut Page, volume: Value) -> Value {
    page.send(&json!({ "type": "open", "volume": volume }));
    loop {
        match page.next(&["hello", "problem"]) {
            crate::client::Message::Text(text) => {
                if text["type"] == "hello" {
                    page.hello = text.clone();
                }
                return text;
            }
            crate::client::Message::Picture(_) => {}
            crate::client::Message::Closed(code) => panic!("closed with {code}"),
        }
    }
}

fn temporary(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("temporary")).unwrap().count()
}

#[test]
fn dropped_files_are_shown_and_removed() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16"]);
    let (mut page, mut other) = (viewer.page(), viewer.page());
    let first = page.hello.clone();
    let hello = open_dropped(&viewer, &mut page, "my%20cube_9x9x9_uint8.raw", &voxels(9));
    assert_eq!(
        (&hello["volume"]["name"], &hello["volume"]["dims"]),
        (&json!("my cube_9x9x9_uint8.raw"), &json!([9, 9, 9])),
        "{hello}"
    );
    assert_ne!(hello["scene"], first["scene"]);
    page.send(&page.view(1, 0.0, true));
    assert!(page.picture().pixels().pixels().any(|p| p.0[0] > 20));
    page.shown();
    // Its command names the file, without the folder.
    page.send(&json!({ "type": "command", "camera": page.hello["camera"], "width": 8, "height": 8, "samples": 1 }));
    let line = page.text("command")["line"].as_str().unwrap().to_owned();
    assert!(line.contains("render 'my cube_9x9x9_uint8.raw'") && !line.contains("temporary"), "{line}");
    // Other pages keep their volume; new ones show the last one.
    other.send(&other.view(2, 0.0, true));
    assert_eq!(other.picture().id, 2);
    other.shown();
    assert_eq!(viewer.page().hello["volume"]["name"], "my cube_9x9x9_uint8.raw");
    assert_eq!(temporary(folder.path()), 1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let kept = std::fs::read_dir(folder.path().join("temporary")).unwrap().next().unwrap().unwrap().path();
        assert_eq!((mode(&kept), mode(&kept.join("my cube_9x9x9_uint8.raw"))), (0o700, 0o600), "others cannot read a scan");
    }
    // The next file replaces it, and the first one is removed.
    let hello = open_dropped(&viewer, &mut page, "b_5x5x5_uint8.raw", &voxels(5));
    assert_eq!(hello["volume"]["dims"], json!([5, 5, 5]));
    while temporary(folder.path()) > 1 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    #[cfg(unix)]
    {
        let mut viewer = viewer;
        assert!(viewer.interrupt().success());
        assert_eq!(temporary(folder.path()), 0, "nothing is left at the end");
    }
}

#[test]
fn files_that_are_no_volumes_say_so_without_a_path() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    for (name, bytes) in [
        ("notes.txt", &b"nothing"[..]),
        ("cube_9x9x9_uint8.raw", b"short"),
        ("cube.raw", b"no size"),
        ("a.nrrd", b"NRRD0004\ntype: uint8\n"),
        ("a.mhd", b"ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = /etc/passwd\n"),
    ] {
        let problem = open_dropped(&viewer, &mut page, name, bytes);
        let sentence = problem["sentence"].as_str().unwrap_or_else(|| panic!("{name}: {problem}"));
        assert!(!sentence.contains(folder.path().to_str().unwrap()) && !sentence.contains(".layersplat-"), "{sentence}");
    }
    assert_eq!(temporary(folder.path()), 0, "files that cannot be opened are removed");
    // The volume is still there.
    page.send(&page.view(1, 0.0, true));
    assert_eq!(page.picture().id, 1);
}

#[test]
fn files_of_others_are_refused() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16"]);
    let (host, cookie) = (viewer.host(), viewer.cookie());
    for headers in [
        String::new(),
        format!("Origin: http://{host}\r\n"),
        format!("Cookie: {cookie}\r\n"),
        format!("Origin: http://evil.example\r\nCookie: {cookie}\r\n"),
        format!("Origin: null\r\nCookie: {cookie}\r\n"),
    ] {
        let answer = drop_with(&viewer, "a_2x2x2_uint8.raw", &headers, &[1; 8]);
        assert!(answer.starts_with("HTTP/1.1 403"), "{headers}: {answer}");
    }
    for name in ["", ".", "..%2Fescaped.raw", "a%2Fb.raw", ".hidden", "a%00b", "%zz", "a%E2%80%AEwar.gpj"] {
        let answer = drop_file(&viewer, name, &[1; 8]);
        assert!(answer.starts_with("HTTP/1.1 400"), "{name}: {answer}");
    }
    let own = format!("Origin: http://{host}\r\nCookie: {cookie}\r\n");
    let request = format!(
        "POST /drop?name=a.raw HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: 99999999999\r\n{own}\r\n"
    );
    assert!(viewer.raw(&request).starts_with("HTTP/1.1 413"));
    assert_eq!(temporary(folder.path()), 0);
    // A file that stops in the middle is given up with its connection.
    let mut stream = viewer.connect();
    let request = format!("POST /drop?name=a.raw HTTP/1.1\r\nHost: {host}\r\nContent-Length: 1000\r\n{own}\r\nhalf");
    stream.write_all(request.as_bytes()).unwrap();
    while temporary(folder.path()) == 0 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(drop_file(&viewer, "b_2x2x2_uint8.raw", &[1; 8]).starts_with("HTTP/1.1 429"), "one file at a time");
    drop(stream);
    while temporary(folder.path()) > 0 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(drop_file(&viewer, "b_2x2x2_uint8.raw", &[1; 8]).starts_with("HTTP/1.1 200"));
}

/// Drops several files and opens them; returns the first message of their volume, or the problem.
fn open_several<N: AsRef<str>, B: AsRef<[u8]>>(viewer: &Viewer, page: &mut Page, folder: &str, files: &[(N, B)]) -> Value {
    let mut to = String::new();
    for (name, bytes) in files {
        let answer = drop_file(viewer, &format!("{}&in={folder}{to}", name.as_ref()), bytes.as_ref());
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        to = format!("&to={}", answer.rsplit("\r\n\r\n").next().unwrap().trim());
    }
    open(page, json!({ "dropped": to[4..].parse::<u32>().unwrap() }))
}

/// Headers find the voxels that are dropped with them, and no other file of the server.
#[test]
fn a_header_and_its_voxels_are_one_volume() {
    let folder = folder();
    std::fs::write(folder.path().join("secret.raw"), [9; 27]).unwrap();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    let headers = [
        ("a.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 3 3 3\nElementType = MET_UCHAR\nElementDataFile = NAME\n"),
        ("a.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nencoding: raw\ndata file: NAME\n"),
        ("a.bov", "DATA_FILE: NAME\nDATA_SIZE: 3 3 3\nDATA_FORMAT: BYTE\n"),
    ];
    let voxels: Vec<u8> = (1..=27).collect();
    let secret = folder.path().join("secret.raw").display().to_string();
    for (name, text) in headers {
        let header = |named: &str| text.replace("NAME", named);
        for order in [[0, 1], [1, 0]] {
            let files = [(name, header("a.raw").into_bytes()), ("a.raw", voxels.clone())];
            let hello = open_several(&viewer, &mut page, "a", &order.map(|n| files[n].clone()));
            assert_eq!((&hello["volume"]["name"], &hello["volume"]["dims"]), (&json!(name), &json!([3, 3, 3])), "{hello}");
            assert_eq!((hello["histogram"]["lowest"].as_f64(), hello["histogram"]["highest"].as_f64()), (Some(1.0), Some(27.0)));
        }
        for (named, words) in [
            ("b.raw", "names the file b.raw, which is not beside it: give both together"),
            ("../../../secret.raw", "names ../../../secret.raw: change that to the name of a file beside the header"),
            (&secret, "change that to the name of a file beside the header"),
        ] {
            let problem = open_several(&viewer, &mut page, "a", &[(name, header(named).as_bytes()), ("a.raw", &voxels)]);
            assert!(problem["sentence"].as_str().is_some_and(|sentence| sentence.contains(words)), "{problem}");
        }
        let problem = open_dropped(&viewer, &mut page, name, header("a.raw").as_bytes());
        assert!(problem["sentence"].as_str().unwrap().contains("a.raw, which is not beside it"), "{problem}");
    }
    let two = ["a.mhd", "b.mhd", "a.raw"].map(|name| (name, b"any"));
    let problem = open_several(&viewer, &mut page, "a", &two);
    assert_eq!(problem["sentence"], "These are several volumes: a.mhd, b.mhd. Drop one of them, with its voxels.");
    let files = [("a.json", b"{}".to_vec()), ("a_3x3x3_uint8.raw", voxels)];
    let hello = open_several(&viewer, &mut page, "a", &files);
    assert_eq!((&hello["volume"]["name"], &hello["notes"]), (&json!("a_3x3x3_uint8.raw"), &json!(["Not read: a.json"])));
}

/// Slices that are dropped together are one volume.
#[test]
fn several_files_are_slices_of_a_volume() {
    let folder = folder();
    let viewer = Viewer::start_in(Some(folder.path()), &["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    let slice = |n: usize| {
        let mut png = Vec::new();
        let slice = image::GrayImage::from_fn(6, 5, |x, _| image::Luma([(x * 50) as u8]));
        slice.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
        (format!("slice_{n}.png"), png)
    };
    let hello = open_several(&viewer, &mut page, "My%20series", &[0, 1, 2, 3].map(slice));
    assert_eq!((&hello["volume"]["name"], &hello["volume"]["dims"]), (&json!("My series"), &json!([6, 5, 4])), "{hello}");
    let refused = |query: &str| drop_file(&viewer, query, &[1]);
    assert!(refused("a.png&in=..%2Fb").starts_with("HTTP/1.1 400") && refused("a.png&in=b&to=99").starts_with("HTTP/1.1 409"));
}

/// While a volume is unpacked, other pages draw, and it can be given up.
#[test]
fn opening_shows_progress_and_can_be_given_up() {
    let folder = folder();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    (0..256).for_each(|_| packed.write_all(&[0; 1 << 20]).unwrap());
    std::fs::write(folder.path().join("large_1024x1024x256_uint8.raw.gz"), packed.finish().unwrap()).unwrap();
    let viewer = Viewer::start_in(Some(folder.path()), &[]);
    let (mut page, mut other) = (viewer.page(), viewer.page());
    page.send(&json!({ "type": "open", "volume": { "offered": "large_1024x1024x256_uint8.raw.gz" } }));
    let progress = page.text("opening");
    assert!(progress["stage"] == "reading" && progress["done"].as_f64().is_some_and(|done| done < 1.0), "{progress}");
    assert!(!progress.to_string().contains("large"), "no path of the server");
    other.send(&other.view(1, 0.0, true));
    assert_eq!(other.picture().id, 1);
    page.send(&json!({ "type": "cancel_open" }));
    loop {
        let told = page.text("opening");
        if told["stage"] == "cancelled" {
            break;
        }
    }
    page.send(&page.view(1, 0.0, true));
    assert_eq!(page.picture().id, 1, "the volume is that of before");
    assert_eq!(open(&mut page, json!({ "offered": "builtin:cube" }))["volume"]["name"], "builtin:cube");
}

#[test]
fn volumes_of_the_folder_are_offered_if_none_is_named() {
    let folder = folder();
    std::fs::write(folder.path().join("cube_9x9x9_uint8.raw"), voxels(9)).unwrap();
    std::fs::write(folder.path().join("notes.txt"), "nothing").unwrap();
    std::fs::write(folder.path().join("temporary/secret_2x2x2_uint8.raw"), [1; 8]).unwrap();
    let viewer = Viewer::start_in(Some(folder.path()), &[]);
    let mut page = viewer.page();
    let offered = page.hello["offered"].as_array().unwrap().clone();
    let has = |name: &str| offered.iter().any(|offered| offered["name"] == name);
    assert!(has("cube_9x9x9_uint8.raw") && has("builtin:torus-knot") && !has("notes.txt"), "{offered:?}");
    let hello = open(&mut page, json!({ "offered": "cube_9x9x9_uint8.raw" }));
    assert_eq!(hello["volume"]["dims"], json!([9, 9, 9]), "{hello}");
    assert_eq!(hello["offered"].as_array(), Some(&offered));
    assert_eq!(open(&mut page, json!({ "offered": "builtin:cube" }))["volume"]["name"], "builtin:cube");
    for name in ["notes.txt", "temporary/secret_2x2x2_uint8.raw", "../x", "/etc/passwd", ""] {
        let problem = open(&mut page, json!({ "offered": name }));
        assert!(problem["sentence"].as_str().unwrap().contains("offered"), "{problem}");
    }
    // A command with a volume offers nothing else.
    let viewer = Viewer::start_in(Some(folder.path()), &["cube_9x9x9_uint8.raw"]);
    let mut page = viewer.page();
    assert_eq!(page.hello["offered"], json!([]));
    assert_eq!(open(&mut page, json!({ "offered": "builtin:cube" }))["type"], "problem");
}
