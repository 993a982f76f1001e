//! Servers that misbehave: each gives the right voxels or a sentence.

use super::server::{Reply, Request, Server, file};
use super::*;
use crate::error::Error;
use crate::volume::{ChannelDescription, Labels, OpenOptions, Volume, VoxelBox};
use glam::DVec3;

mod kept;
mod parts;

/// Files of other programs, with what they hold.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/formats/files")
}

const NAME: &str = "zarr/split.zarr";

fn values(volume: &Volume) -> Vec<f64> {
    (0..volume.grid().voxel_count()).map(|i| volume.value(i)).collect()
}

fn by_path(name: &str) -> Volume<'static> {
    Volume::open(folder().join(name), &OpenOptions::default()).unwrap()
}

/// Opens a volume of several chunks from a server that answers what `fault` says, else the files.
fn opened(fault: impl Fn(&Request) -> Option<Reply> + Send + Sync + 'static) -> (Server, Result<Volume<'static>, Error>) {
    let server = Server::new(move |request| fault(request).unwrap_or_else(|| Reply::file(file(&folder(), request))));
    let volume = Volume::open(format!("{}/{NAME}", server.url), &OpenOptions::default());
    (server, volume)
}

/// Whether a request is for a chunk.
fn is_chunk(request: &Request) -> bool {
    request.path.rsplit('/').next().is_some_and(|name| name.starts_with(|c: char| c.is_ascii_digit()))
}

#[track_caller]
fn is_right(opened: Result<Volume<'static>, Error>) {
    assert_eq!(values(&opened.unwrap()), values(&by_path(NAME)));
}

#[track_caller]
fn is_refused(opened: Result<Volume<'static>, Error>, sentence: &str) {
    let message = opened.unwrap_err().to_string();
    assert!(message.contains(sentence) && message.contains(NAME), "{message}");
}

#[test]
fn every_volume_is_the_same_by_path_and_by_address() {
    let server = Server::of_folder(folder());
    let mut count = 0;
    for kind in ["zarr", "channels", "conventions", "labels"] {
        for entry in std::fs::read_dir(folder().join(kind)).unwrap() {
            let name = format!("{kind}/{}", entry.unwrap().file_name().to_str().unwrap());
            let url = format!("{}/{name}", server.url);
            let options = OpenOptions::default();
            let path = folder().join(&name);
            let (Ok(expected), true) = (Volume::open(&path, &options), name.ends_with(".zarr")) else { continue };
            let found = Volume::open(&url, &options);
            // A group that only a list of its members leads into.
            if name.ends_with("3_several.zarr") || name.contains("conventions/") && found.is_err() {
                assert!(found.unwrap_err().to_string().contains("web servers have no lists"), "{name}");
                continue;
            }
            let found = found.unwrap();
            assert_eq!((found.grid(), found.contents(), found.name()), (expected.grid(), expected.contents(), expected.name()));
            assert_eq!(values(&found), values(&expected), "{name}");
            assert_eq!(
                ChannelDescription::of_file(&url, &options).unwrap(),
                ChannelDescription::of_file(&path, &options).unwrap()
            );
            assert_eq!(Labels::are_declared(Path::new(&url), &options).unwrap(), Labels::are_declared(&path, &options).unwrap());
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
    // Metadata are fetched once, however many ask.
    let twice = |request: &Request| request.before > 0 && !is_chunk(request);
    assert_eq!(server.requests().iter().filter(|request| twice(request)).count(), 0);
}

#[test]
fn groups_are_found_by_what_they_state() {
    let files = folder();
    let image = move |path: &str| std::fs::read(files.join("zarr/ome_04.zarr").join(path)).ok();
    let server = Server::new(move |request| {
        let answer = match request.path.as_str() {
            "/raw/.zgroup" | "/plate/.zgroup" | "/plate/B/2/.zgroup" | "/labels/.zgroup" => {
                Some(br#"{"zarr_format":2}"#.to_vec())
            }
            "/raw/.zattrs" => Some(br#"{"bioformats2raw.layout":3}"#.to_vec()),
            "/plate/.zattrs" => Some(br#"{"plate":{"wells":[{"path":"../x"},{"path":"B/2"}]}}"#.to_vec()),
            "/plate/B/2/.zattrs" => Some(br#"{"well":{"images":[{"path":"0"}]}}"#.to_vec()),
            "/labels/.zattrs" => Some(br#"{"labels":["0"]}"#.to_vec()),
            path => ["/raw/0/", "/plate/B/2/0/", "/labels/0/", "/raw/1/"].iter().find_map(|base| image(path.strip_prefix(base)?)),
        };
        // As object stores that do not list.
        answer.map_or(Reply::status(403), |content| Reply::file(Some(content)))
    });
    let expected = values(&by_path("zarr/ome_04.zarr"));
    for (group, array) in [("raw", None), ("raw", Some("1")), ("plate", None), ("labels", None), ("plate", Some("B/2/0"))] {
        let options = OpenOptions { array: array.map(Into::into), ..OpenOptions::default() };
        assert_eq!(values(&Volume::open(format!("{}/{group}", server.url), &options).unwrap()), expected, "{group} {array:?}");
    }
    let options = OpenOptions { array: Some("7".into()), ..OpenOptions::default() };
    let message = Volume::open(format!("{}/raw", server.url), &options).unwrap_err().to_string();
    assert!(message.contains("whose arrays are 0, 1"), "{message}");
    assert!(server.requests().iter().all(|request| !request.path.contains("..")));
}

/// Metadata that a group has of what is below it are not asked for.
#[test]
fn consolidated_metadata_spare_requests() {
    let name = "zarr/ome_05.zarr";
    let read = |file: &str| {
        serde_json::from_slice::<serde_json::Value>(&std::fs::read(folder().join(name).join(file)).unwrap()).unwrap()
    };
    let mut group = read("zarr.json");
    let levels: Vec<String> = ["s0", "s1"].map(String::from).into();
    let below =
        levels.iter().map(|level| (level.clone(), read(&format!("{level}/zarr.json")))).collect::<serde_json::Map<_, _>>();
    group["consolidated_metadata"] = serde_json::json!({"kind": "inline", "must_understand": false, "metadata": below});
    let server = Server::new(move |request| match request.path.strip_suffix("ome_05.zarr/zarr.json") {
        Some(_) => Reply::file(Some(group.to_string().into_bytes())),
        None => Reply::file(file(&folder(), request)),
    });
    let volume = Volume::open(format!("{}/{name}", server.url), &OpenOptions::default()).unwrap();
    assert_eq!(values(&volume), values(&by_path(name)));
    let asked: Vec<_> = server.requests().into_iter().filter(|request| !is_chunk(request)).map(|request| request.path).collect();
    assert_eq!(asked, [format!("/{name}/zarr.json")]);
}

#[test]
fn what_passes_is_tried_again() {
    for status in [408, 429, 500, 502, 503, 504] {
        let (server, volume) = opened(move |request| (request.before < 3).then(|| Reply::status(status)));
        is_right(volume);
        assert!(server.requests().iter().any(|request| request.before == 3));
    }
    let resets = [b"".to_vec(), b"HTTP/1.1 2".to_vec(), b"HTTP/1.1 200 OK\r\nContent-Length: 80000\r\n\r\n12345".to_vec()];
    for bytes in resets {
        let (_server, volume) = opened(move |request| (request.before < 3).then(|| Reply::Raw(bytes.clone())));
        is_right(volume);
    }
    let (_server, volume) = opened(|request| (is_chunk(request) && request.before == 0).then_some(Reply::Silence));
    is_right(volume);
}

#[test]
fn what_does_not_pass_is_said() {
    for (status, sentence) in [
        (503, "the server answers with 503 (6 attempts)"),
        (418, "the server answers with 418"),
        (403, "the server refuses it (403)"),
        (401, "the server refuses it (401)"),
    ] {
        let (server, volume) = opened(move |request| is_chunk(request).then(|| Reply::status(status)));
        is_refused(volume, sentence);
        // The others are not asked for.
        let asked = server.requests().iter().filter(|request| is_chunk(request)).count();
        assert!(status == 503 || asked <= AT_ONCE, "{asked}");
    }
    let (_server, volume) = opened(|request| is_chunk(request).then_some(Reply::Silence));
    is_refused(volume, "the server does not answer in time (6 attempts)");
    let cut = b"HTTP/1.1 200 OK\r\nContent-Length: 30\r\n\r\n12345";
    let (_server, volume) = opened(move |request| is_chunk(request).then(|| Reply::Raw(cut.to_vec())));
    is_refused(volume, "the connection ended");
    let volume = Volume::open(format!("http://127.0.0.1:1/{NAME}"), &OpenOptions::default());
    is_refused(volume, "the connection failed");
    let lookup = ureq::Error::Io(io::Error::other("failed to lookup address information: Name or service not known"));
    assert!(matches!(failure(&lookup), Failure::Passing(problem, _) if problem.contains("is not found: correct its name")));
}

#[test]
fn wrong_lengths_are_noticed() {
    // The declared size bounds what is taken, whatever is sent.
    let (_server, volume) = opened(|request| is_chunk(request).then(|| Reply::Answer(200, vec![], vec![0; 1 << 20])));
    is_refused(volume, "may have at most");
    let endless = [b"HTTP/1.1 200 OK\r\n\r\n".to_vec(), vec![0; 1 << 20]].concat();
    let (_server, volume) = opened(move |request| is_chunk(request).then(|| Reply::Raw(endless.clone())));
    is_refused(volume, "may have at most");
    for body in [vec![], vec![1; 7], b"<html>Log in first</html>".to_vec()] {
        let (_server, volume) = opened(move |request| is_chunk(request).then(|| Reply::Answer(200, vec![], body.clone())));
        is_refused(volume, "truncated or damaged");
    }
    let packed = vec!["Content-Encoding: br".into()];
    let (_server, volume) = opened(move |request| is_chunk(request).then(|| Reply::Answer(200, packed.clone(), vec![1])));
    is_refused(volume, "in the encoding \"br\"");
    // Memory is taken in steps, and never for more than the metadata allow.
    let endless = [b"HTTP/1.1 200 OK\r\n\r\n".to_vec(), vec![b' '; (2 * STEP + 1) as usize]].concat();
    let server = Server::new(move |_| Reply::Raw(endless.clone()));
    let (http, long) = (Http::new(PATIENCE, None), PathBuf::from(format!("{}/x", server.url)));
    assert_eq!(http.get(&long, &Span::All, None, 3 * STEP).unwrap().map(|found| found.bytes.len() as u64), Some(2 * STEP + 1));
    assert_eq!(http.get(&long, &Span::All, None, 2 * STEP).unwrap_err().kind(), io::ErrorKind::InvalidData);
    assert_eq!(server.requests().len(), 2);
    // Chunks of transfer, whose length is not known before.
    let (_server, volume) = opened(|request| {
        let content = file(&folder(), request)?;
        let head = format!("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n{:x}\r\n", content.len());
        Some(Reply::Raw([head.as_bytes(), &content, b"\r\n0\r\n\r\n"].concat()))
    });
    is_right(volume);
}

#[test]
fn redirects_are_followed_to_their_end() {
    let elsewhere = Server::of_folder(folder());
    let base = elsewhere.url.clone();
    let redirect = |status, to: String| Some(Reply::Answer(status, vec![format!("Location: {to}")], vec![]));
    for status in [301, 302, 303, 307, 308] {
        let base = base.clone();
        is_right(opened(move |request| redirect(status, format!("{base}{}", request.path))).1);
    }
    is_right(
        opened(move |request| if request.path.contains("hop") { None } else { redirect(302, "hop/../x".into()) }).1.or_else(
            // Of a folder that does not exist here, so that only the metadata fail.
            |e| if e.to_string().contains("no Zarr array") { Ok(by_path(NAME)) } else { Err(e) },
        ),
    );
    is_refused(opened(move |request| redirect(302, request.path.clone())).1, "more than 5 times");
    for to in ["file:///etc/passwd", "", "ftp://h/x"] {
        is_refused(opened(move |_| redirect(302, to.into())).1, "to no web address");
    }
    is_refused(opened(|_| Some(Reply::Answer(301, vec![], vec![]))).1, "to no web address");
}

#[test]
fn chunks_that_are_missing_or_refused() {
    // Not stored: the fill value, as in folders.
    let (_server, volume) = opened(|request| is_chunk(request).then(|| Reply::status(404)));
    assert!(values(&volume.unwrap()).iter().all(|&value| value == 0.0));
    let server = Server::new(|request| match is_chunk(request) && !request.path.ends_with("0.0.0") {
        true => Reply::status(403),
        false => Reply::file(file(&folder(), request)),
    });
    let url = format!("{}/{NAME}", server.url);
    is_refused(Volume::open(&url, &OpenOptions::default()), "the server refuses it (403)");
    let filled = Volume::open(&url, &OpenOptions { fills_refused: true, ..OpenOptions::default() }).unwrap();
    let (filled, expected) = (values(&filled), values(&by_path(NAME)));
    assert!(filled.iter().zip(&expected).all(|(filled, expected)| *filled == 0.0 || filled == expected));
    assert!(filled.iter().any(|&value| value != 0.0));
}

/// Object stores that do not list refuse what is not there; a wrong password is no hole.
#[test]
fn refused_files_may_be_missing_ones() {
    let server = Server::new(|request| file(&folder(), request).map_or(Reply::status(403), |content| Reply::file(Some(content))));
    for name in [NAME, "zarr/ome_04.zarr"] {
        let found = Volume::open(format!("{}/{name}", server.url), &OpenOptions::default());
        assert_eq!(values(&found.unwrap()), values(&by_path(name)));
    }
    let message = Volume::open(format!("{}/none.zarr", server.url), &OpenOptions::default()).unwrap_err().to_string();
    assert!(message.contains("none.zarr/zarr.json") && message.contains("refuses it (403)"), "{message}");
    let server = Server::new(|request| match is_chunk(request) {
        true => Reply::status(401),
        false => Reply::file(file(&folder(), request)),
    });
    let options = OpenOptions { fills_refused: true, ..OpenOptions::default() };
    is_refused(Volume::open(format!("{}/{NAME}", server.url), &options), "the server refuses it (401)");
}

#[test]
fn secrets_reach_their_server_and_nobody_else() {
    let elsewhere = Server::of_folder(folder());
    let base = elsewhere.url.clone();
    let server = Server::new(move |request| {
        let known = request.headers.get("authorization").is_some_and(|value| value == "Basic VXNlcjc6cCBzcw==");
        let path = request.path.strip_suffix("?token=T1&x=y");
        match path {
            Some(path) if known && is_chunk(request) => Reply::Answer(302, vec![format!("Location: {base}{path}")], vec![]),
            Some(_) if known => Reply::file(file(&folder(), request)),
            _ => Reply::status(403),
        }
    });
    let host = server.url.trim_start_matches("http://");
    let url = format!("http://User7:p%20ss@{host}/{NAME}?token=T1&x=y");
    is_right(Volume::open(&url, &OpenOptions::default()));
    let requests = elsewhere.requests();
    assert!(!requests.is_empty());
    assert!(requests.iter().all(|request| !request.headers.contains_key("authorization") && !request.path.contains("token")));
    let missing = format!("http://User7:p%20ss@{host}/missing.zarr?token=T1&x=y");
    for options in [OpenOptions::default(), OpenOptions { frame: Some(7), ..OpenOptions::default() }] {
        for url in [&missing, &url] {
            let message = format!("{:?}", Volume::open(url, &options));
            assert!(!["token", "T1", "p%20ss", "User7"].iter().any(|secret| message.contains(secret)), "{message}");
        }
    }
}

#[test]
fn addresses_are_escaped_and_redirects_resolved() {
    let of = |text: &str| Address::new(Path::new(text)).unwrap();
    let none = HashMap::new();
    assert_eq!(of("https://h:8/a b/%20/ü?#.zarr").target(&none), "https://h:8/a%20b/%20/%C3%BC%3F%23.zarr");
    let regions = HashMap::from([("b".to_owned(), "eu-west-2".to_owned()), ("b.c".to_owned(), "x".to_owned())]);
    assert_eq!(of("s3://b/k/0").target(&regions), "https://b.s3.eu-west-2.amazonaws.com/k/0");
    assert_eq!(of("S3://b.c/k/0").target(&regions), "https://s3.x.amazonaws.com/b.c/k/0");
    assert_eq!(of("s3://other/k").target(&none), "https://other.s3.amazonaws.com/k");
    for (to, expected) in [
        ("/x", Some("https://h/x")),
        ("x#y", Some("https://h/a/x")),
        ("//g/x", Some("https://g/x")),
        ("http://g", Some("http://g")),
        ("data:x", None),
    ] {
        assert_eq!(redirected("https://h/a/b?c=/d", to).as_deref(), expected);
    }
    assert_eq!(unescaped("a%20%zz%"), b"a %zz%");
}

#[test]
fn servers_are_waited_for_longer_each_time() {
    let http =
        Http::new(Patience { backoff: Duration::from_millis(100), longest_backoff: Duration::from_secs(1), ..PATIENCE }, None);
    for (number, named, expected) in
        [(1, 0, 50..=150), (2, 0, 100..=300), (3, 0, 200..=600), (9, 0, 1000..=1000), (1, 60, 1000..=1000)]
    {
        let waited = http.wait(number, Some(Duration::from_secs(named))).as_millis();
        assert!(expected.contains(&waited), "{number}: {waited} ms");
    }
    let http = Http::new(Patience { answer: Duration::from_secs(2), ..PATIENCE }, None);
    for (slowest, expected) in
        [(0, [2000, 2000, 4000, 16000]), (10, [500, 500, 4000, 16000]), (3000, [12000, 12000, 12000, 16000])]
    {
        *lock(&http.slowest) = Duration::from_millis(slowest);
        assert_eq!([0, 1, 2, 4].map(|number| http.longest_answer(number).as_millis()), expected);
    }
}

/// All regions of a volume of eight chunks, in another order of axes than its own, have the voxels of the whole.
#[test]
fn regions_read_their_chunks_only() {
    let path = folder().join("zarr/3_turned.zarr");
    let whole = by_path("zarr/3_turned.zarr");
    let [x, y, z] = whole.grid().dims();
    let sides = |n: usize| (0..n).flat_map(move |first| (1..=n - first).map(move |len| (first, len)));
    for ((a, wide), (b, high), (c, deep)) in sides(x).flat_map(|x| sides(y).flat_map(move |y| sides(z).map(move |z| (x, y, z)))) {
        let region = Some(VoxelBox { first: [a, b, c], dims: [wide, high, deep] });
        let part = Volume::open(&path, &OpenOptions { region, ..OpenOptions::default() }).unwrap();
        let first = DVec3::new(a as f64, b as f64, c as f64);
        assert_eq!(part.grid().origin(), whole.grid().index_to_world().transform_point3(first));
        let expected = |i| {
            let [i, j, k] = part.grid().place(i);
            whole.value(a + i + x * (b + j + y * (c + k)))
        };
        assert_eq!(part.grid().dims(), [wide, high, deep]);
        assert!(values(&part).into_iter().enumerate().all(|(i, value)| value == expected(i)), "{region:?}");
    }
    let server = Server::of_folder(folder());
    let url = format!("{}/zarr/3_turned.zarr", server.url);
    let region = Some(VoxelBox { first: [4, 0, 2], dims: [1; 3] });
    let options = OpenOptions { region, ..OpenOptions::default() };
    let part = Volume::open(&url, &options).unwrap();
    assert_eq!(values(&part), [whole.value(4 + x * y * 2)]);
    let chunks: Vec<_> = server.requests().into_iter().filter(is_chunk).map(|request| request.path).collect();
    assert_eq!(chunks, ["/zarr/3_turned.zarr/c/1/0/1"]);
    let beyond = OpenOptions { region: Some(VoxelBox { first: [x, 0, 0], dims: [1; 3] }), ..OpenOptions::default() };
    for (source, options, sentence) in [
        (url.into(), beyond, "region: begins at 5 along x, where the finest level has voxels 0 to 4"),
        (folder().join("nrrd/rgb.nrrd"), options, "region: not supported"),
    ] {
        let message = Volume::open(source, &options).unwrap_err().to_string();
        assert!(message.contains(sentence), "{message}");
    }
}
