//! Volumes by URL.

// Other tests need other answers.
#[allow(dead_code)]
#[path = "../../src/host/volume/format/zarr/http/server.rs"]
mod server;

use crate::common::command::{json, layersplat, refused};
use server::{Reply, Server, file};
use std::path::{Path, PathBuf};

fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files")
}

/// Files of a folder, for those who know the token.
fn guarded() -> Server {
    Server::new(|request| match request.path.strip_suffix("?token=T1") {
        Some(_) => Reply::file(file(&files(), request)),
        None => Reply::status(403),
    })
}

#[test]
fn pictures_are_those_of_the_path_and_hold_no_token() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let path = files().join("channels/omero_04.zarr").to_str().unwrap().to_owned();
    let server = guarded();
    let url = format!("{}/channels/omero_04.zarr", server.url);
    let secret = format!("{}?token=T1", url.replace("//", "//me:word@"));
    let picture = |volume: &str, name: &str, more: &[&str]| {
        let given = [&["render", volume, "--size", "24x18", "--json", "-v", "-o", name], more].concat();
        let output = layersplat(f, &given);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let told = [output.stdout, output.stderr].concat();
        (std::fs::read(f.join(name)).unwrap(), told)
    };
    for more in [&["--channel", "1"][..], &["--channels", "0,1"]] {
        assert_eq!(picture(&path, "path.npy", more).0, picture(&secret, "url.npy", more).0);
    }
    let (png, told) = picture(&secret, "url.png", &["--channel", "0"]);
    for bytes in [png, told] {
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains("T1") && !text.contains("me:word"), "{text}");
    }
    let png = std::fs::read(f.join("url.png")).unwrap();
    assert!(String::from_utf8_lossy(&png).contains(&format!("layersplat render {url}")));
    // A range of a step with its labels, and slices, read as files are.
    let labels = format!("{}/labels/cells_04.zarr/labels/cells?token=T1", server.url);
    assert!(json(f, &["render", "builtin:cube@8", "--size", "9x9", "--mask", &labels, "-o", "w.npy"]).is_object());
    refused(f, &["render", &url], 1, &["refuses it (403)", &url]);
    refused(f, &["view", &url, "--no-browser"], 1, &["refuses it (403)", &url]);
}

#[test]
fn info_reads_metadata_only() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let server = Server::of_folder(files());
    let url = format!("{}/zarr/ome_04.zarr", server.url);
    let info = json(f, &["info", &url]);
    assert_eq!(
        info["levels"],
        serde_json::json!([
            {"dims": [5, 4, 3], "chunk": [5, 4, 2], "chunks": 2, "bytes": 120},
            {"dims": [2, 2, 3], "chunk": [5, 4, 2], "chunks": 2, "bytes": 24}
        ])
    );
    assert_eq!((&info["picture_level"], &info["url"]), (&0.into(), &url.as_str().into()));
    let text = String::from_utf8(layersplat(f, &["info", &url]).stdout).unwrap();
    assert!(text.contains("level 1   2x2x3 in 2 chunks of 5x4x2, 24 bytes"), "{text}");
    let names: Vec<String> = server.requests().into_iter().map(|request| request.path).collect();
    assert!(names.iter().all(|name| name.contains("/.z") || name.ends_with("/zarr.json")), "{names:?}");
}

#[test]
fn downloads_are_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let server = Server::of_folder(files());
    let [image, array] = ["zarr/ome_04.zarr", "zarr/split.zarr"].map(|name| format!("{}/{name}", server.url));
    let levels = |more: &[&str]| {
        let output = layersplat(f, &[&["render", &image, "--size", "9x9", "-o", "a.npy"], more].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, told) = levels(&[]);
    assert!(code == Some(0) && !told.contains("using level"), "{told}");
    let (code, told) = levels(&["--download", "100"]);
    assert!(code == Some(0) && told.contains("using level 1 of 2") && told.contains("download"), "{told}");
    refused(f, &["render", &image, "--download", "100", "--level", "0"], 2, &["level 0", "120", "--download BYTES"]);
    refused(f, &["render", &image, "--download", "10"], 2, &["level 1", "24", "--download BYTES"]);
    refused(f, &["render", &array, "--download", "10"], 2, &["24000", "--download BYTES"]);
    // A region has fewer.
    let region = ["--region", "1:3,:2,2:"];
    let path = files().join("zarr/ome_04.zarr");
    let info = json(f, &[&["info", path.to_str().unwrap()], &region[..]].concat());
    assert_eq!(info["dims"], serde_json::json!([2, 2, 1]));
    assert!(
        layersplat(
            f,
            &[&["render", &image, "--size", "9x9", "--download", "8", "--level", "0", "-o", "b.npy"], &region[..]].concat()
        )
        .status
        .success()
    );
    refused(f, &["info", "builtin:cube@4", "--region", "a"], 2, &["--region", "X0:X1"]);
    refused(f, &["info", "builtin:cube@4", "--region", ":,:,:"], 2, &["--region X0:X1", "files only"]);
}

/// Chunks that a server refuses are an error, or holes of which a message tells.
#[test]
fn refused_chunks_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let server = Server::new(|request| match request.path.ends_with("/1.0.0") {
        true => Reply::status(403),
        false => Reply::file(file(&files(), request)),
    });
    let url = format!("{}/zarr/split.zarr", server.url);
    let render = ["render", &url, "--size", "9x9", "-o", "a.npy"];
    refused(f, &render, 1, &["split.zarr/1.0.0", "refuses it (403)"]);
    let output = layersplat(f, &[&render[..], &["--missing", "fill"]].concat());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && told.contains("refused 1 of 2 chunks"), "{told}");
}
