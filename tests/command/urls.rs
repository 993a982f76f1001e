//! Volumes by URL.

// Other tests need other answers.
#[allow(dead_code)]
#[path = "../../src/host/volume/format/zarr/http/server.rs"]
mod server;

use crate::common::command::{json as report, layersplat, refused};
use serde_json::json;
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
    assert!(report(f, &["render", "builtin:cube@8", "--size", "9x9", "--mask", &labels, "-o", "w.npy"]).is_object());
    refused(f, &["render", &url], 1, &["refuses it (403)", &url]);
    refused(f, &["view", &url, "--no-browser"], 1, &["refuses it (403)", &url]);
}

#[test]
fn info_reads_metadata_only() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let server = Server::of_folder(files());
    let url = format!("{}/zarr/ome_04.zarr", server.url);
    let info = report(f, &["info", &url]);
    assert_eq!(
        info["levels"],
        json!([
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
    let info = report(f, &[&["info", path.to_str().unwrap()], &region[..]].concat());
    assert_eq!(info["dims"], json!([2, 2, 1]));
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

/// Side of the chunks of pyramids.
const CHUNK: usize = 32;

/// Writes a smooth blob, `size` voxels wide, at three levels.
fn write_pyramid(folder: &Path, size: usize) {
    let put = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    };
    let levels = [0, 1, 2].map(|n| {
        let (times, count) = (1 << n, size >> n);
        let (shape, chunks) = ([count; 3], [CHUNK; 3]);
        let array = json!({"zarr_format": 2, "shape": shape, "chunks": chunks, "dtype": "|u1", "compressor": null, "filters": null,
            "order": "C", "fill_value": 0});
        put(&format!("{n}/.zarray"), array.to_string().as_bytes());
        let first = (times as f64 - 1.0) / 2.0;
        let along = |i: usize| {
            let from_centre = (times * i) as f64 + first - (size as f64 - 1.0) / 2.0;
            (-from_centre.powi(2) / (size as f64 / 6.0).powi(2)).exp()
        };
        let along: Vec<f64> = (0..count).map(along).collect();
        for chunk in 0..(count / CHUNK).pow(3) {
            let of = |n: usize, of: usize| [n % of, n / of % of, n / of / of];
            let [x, y, z] = of(chunk, count / CHUNK);
            let value = |[i, j, k]: [usize; 3]| along[x * CHUNK + i] * along[y * CHUNK + j] * along[z * CHUNK + k];
            let voxels: Vec<u8> = (0..CHUNK.pow(3)).map(|n| (200.0 * value(of(n, CHUNK))).round() as u8).collect();
            put(&format!("{n}/{z}.{y}.{x}"), &voxels);
        }
        let (scale, translation) = ([times; 3], [first; 3]);
        let steps = json!([{"type": "scale", "scale": scale}, {"type": "translation", "translation": translation}]);
        json!({"path": n.to_string(), "coordinateTransformations": steps})
    });
    put(".zgroup", br#"{"zarr_format": 2}"#);
    let axes = ["z", "y", "x"].map(|name| json!({"name": name, "type": "space"}));
    put(".zattrs", json!({"multiscales": [{"version": "0.4", "axes": axes, "datasets": levels}]}).to_string().as_bytes());
}

/// Floats of a picture, and what is told of the level.
fn floats(folder: &Path, volume: &str, more: &[&str]) -> (Vec<f32>, String) {
    let output = layersplat(folder, &[&["render", volume, "-v", "-o", "a.npy"], more].concat());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{told}");
    let bytes = std::fs::read(folder.join("a.npy")).unwrap();
    // Version 1.0 of the format: the length of the header is in its bytes 8 and 9.
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    (bytes[header..].chunks_exact(4).map(|float| f32::from_le_bytes(float.try_into().unwrap())).collect(), told)
}

/// Cameras, transfer functions, opacities and shading are those of the data set.
#[test]
fn all_levels_have_one_look() {
    /// Differences of the mean brightness, as a share: the issue's limit. The blob loses less by its coarsest voxels.
    const SAME: f64 = 0.01;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_pyramid(&f.join("blob"), 128);
    let server = Server::of_folder(f.to_owned());
    let [path, url] = [f.join("blob").to_str().unwrap().to_owned(), format!("{}/blob", server.url)];
    let mean = |volume: &str, level: &str, more: &[&str]| {
        let (floats, _) = floats(f, volume, &[&["--level", level, "--size", "64x64"], more].concat());
        floats.into_iter().map(f64::from).sum::<f64>()
    };
    let by_gradients = ["--transfer", "grey", "--gradient-opacity", "0:0,4:1"];
    for more in [&[][..], &["--transfer", "fire", "--shading", "off"], &by_gradients, &["--iso", "p98"], &["--memory", "8MB"]] {
        let finest = mean(&path, "0", more);
        for level in ["1", "2"] {
            let share = mean(&path, level, more) / finest;
            assert!((share - 1.0).abs() < SAME, "{more:?}: level {level} has {share} of the brightness");
        }
        assert_eq!(mean(&url, "0", more), finest, "{more:?}");
    }
    // What a unit distance of the level would give.
    let of_level = mean(&path, "2", &["--transfer", "fire", "--shading", "off", "--unit-distance", "4"]);
    assert!(of_level < 0.9 * mean(&path, "2", &["--transfer", "fire", "--shading", "off"]), "{of_level}");
}

/// Writers round sizes of levels down, so the coarsest may end before the finest.
#[test]
fn views_reach_the_end_of_the_finest_level() {
    const WIDTH: usize = 4159;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let levels = [0, 1, 2, 3, 4, 5, 6].map(|n| {
        let times = 1 << n;
        std::fs::create_dir_all(f.join(format!("long/{n}"))).unwrap();
        // Without chunks, all voxels have the fill value.
        let array = json!({"zarr_format": 2, "shape": [64, 64, WIDTH / times], "chunks": [64, 64, CHUNK], "dtype": "|u1", "compressor": null,
            "filters": null, "order": "C", "fill_value": 200});
        std::fs::write(f.join(format!("long/{n}/.zarray")), array.to_string()).unwrap();
        let (scale, first) = (json!([1, 1, times]), json!([0, 0, (times as f64 - 1.0) / 2.0]));
        let steps = json!([{"type": "scale", "scale": scale}, {"type": "translation", "translation": first}]);
        json!({"path": n.to_string(), "coordinateTransformations": steps})
    });
    std::fs::write(f.join("long/.zgroup"), r#"{"zarr_format": 2}"#).unwrap();
    let axes = ["z", "y", "x"].map(|name| json!({"name": name, "type": "space"}));
    let image = json!({"multiscales": [{"version": "0.4", "axes": axes, "datasets": levels}]});
    std::fs::write(f.join("long/.zattrs"), image.to_string()).unwrap();
    let look = ["--transfer", "grey", "--transfer-range", "0,255", "--opacity", "0:0,255:0.5", "--size", "64x64"];
    let (seen, told) =
        floats(f, "long", &[&look[..], &["--center", "4150,32,32", "--parallel-scale", "16", "--azimuth", "0"]].concat());
    assert!(told.contains("level 0 of 7, 41x64x64"), "{told}");
    // Two pixels per voxel: voxels 4156 and 4162, which is behind the last.
    let opacity = |column: usize| seen[4 * (32 * 64 + column) + 3];
    assert!(opacity(44) > 0.9 && opacity(56) == 0.0, "{} {}", opacity(44), opacity(56));
}

/// Views read the coarsest level that has a voxel per pixel, of which only what they show, and show the same as of all voxels.
#[test]
fn views_choose_what_is_read() {
    /// Of samples of two lattices, which lie at other places: a part is drawn from another centre.
    const SAME: f32 = 4e-3;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_pyramid(&f.join("blob"), 128);
    let server = Server::of_folder(f.to_owned());
    let [path, url] = [f.join("blob").to_str().unwrap().to_owned(), format!("{}/blob", server.url)];
    let is_chunk = |path: &str| path.split_once("/0/").is_some_and(|(_, name)| name.starts_with(|c: char| c.is_ascii_digit()));
    let chunks = || server.requests().iter().filter(|request| is_chunk(&request.path)).count();
    // Half the height of the picture in voxels of level 0, and what is read at 64 × 64 pixels.
    for (scale, more, told) in [
        ("128", &[][..], "level 2 of 3, 32x32x32"),
        ("64", &[], "level 1 of 3, 64x64x64"),
        ("64", &["--oversample", "2"], "level 0 of 3, 128x128x128"),
        ("8", &[], "level 0 of 3, 50x50x128"),
        ("8", &["--perspective", "20", "--distance", "60"], "level 0 of 3"),
        ("8", &["--crop", ":,:,50:70"], "level 0 of 3, 50x50x53"),
        ("8", &["--clip", "0,0,63.5,0,0,1"], "level 0 of 3, 50x50x81"),
        ("8", &["--shadows", "on"], "level 0 of 3, 128x128x128"),
    ] {
        let scale = if more.contains(&"--perspective") { vec![] } else { vec!["--parallel-scale", scale] };
        let view = [&["--size", "64x64", "--center", "63.5,63.5,63.5", "--azimuth", "0"], &scale[..], more].concat();
        let (seen, found) = floats(f, &path, &view);
        assert!(found.contains(told), "{view:?}: {found}");
        let level = &found[found.rfind("blob: level ").map(|at| at + 12).unwrap()..][..1];
        let (all, _) = floats(f, &path, &[&view[..], &["--level", level]].concat());
        let apart = seen.iter().zip(&all).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart <= SAME && seen.iter().any(|&float| float > 0.1), "{view:?}: pictures differ by {apart}");
        if scale.contains(&"8") && more.is_empty() {
            assert_eq!(floats(f, &url, &view).0, seen);
            assert_eq!(chunks(), 2 * 2 * 4);
            // One with fewer bytes.
            let (_, told) = floats(f, &url, &[&view[..], &["--download", "300kB"]].concat());
            assert!(told.contains("using level 1"), "{told}");
        }
    }
}

/// What is read by URL is kept for the next command, which asks whether it is still that.
#[test]
fn what_is_read_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let server = Server::new(|request| Reply::kept(file(&files(), request), "\"1\"", request));
    let url = format!("{}/zarr/3_shards_end.zarr", server.url);
    let run = |arguments: &[&str]| {
        let before = server.requests().len();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let output = command.args(arguments).current_dir(f).env("XDG_CACHE_HOME", f.join("caches")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let asked = server.requests().split_off(before);
        let told = asked.iter().filter(|request| request.headers.contains_key("if-none-match")).count();
        (String::from_utf8(output.stdout).unwrap(), asked.len(), told)
    };
    let convert = |name: &str, more: &[&str]| {
        let (_, asked, told) = run(&[&["convert", &url, name], more].concat());
        (std::fs::read(f.join(name)).unwrap(), asked, told)
    };
    let kept = || serde_json::from_str::<serde_json::Value>(&run(&["cache", "--json"]).0).unwrap();
    assert_eq!((&kept()["files"], &kept()["bytes"]), (&0.into(), &0.into()));
    let (picture, asked, told) = convert("off.nrrd", &["--no-cache"]);
    assert!(asked == 5 && told == 0 && kept()["files"] == 0 && !f.join("caches/layersplat/downloads").exists());
    assert_eq!(convert("cold.nrrd", &[]), (picture.clone(), 5, 0));
    assert_eq!(kept()["files"], 5);
    assert_eq!(convert("warm.nrrd", &[]), (picture.clone(), 5, 5));
    assert_eq!(convert("warm.nrrd", &["--no-cache"]), (picture, 5, 0));
    let (text, ..) = run(&["cache"]);
    assert!(text.contains("caches/layersplat/downloads: 5 files, ") && text.contains("of at most 10 GB"), "{text}");
    let (text, ..) = run(&["cache", "--clear"]);
    assert!(text.contains("removed 5 files") && kept()["files"] == 0, "{text}");
}
