//! Files that are read in parts: shards.

use super::*;

const SHARDS: [&str; 2] = ["zarr/3_shards_start.zarr", "zarr/3_shards_end.zarr"];

/// Opens a volume of shards from a server that answers requests for them as `fault` says, else as good servers do.
fn sharded(
    name: &str,
    fault: impl Fn(&Request, Vec<u8>) -> Option<Reply> + Send + Sync + 'static,
) -> (Server, Result<Volume<'static>, Error>) {
    let server = Server::new(move |request| {
        let content = file(&folder(), request);
        let faulty = content.clone().filter(|_| is_chunk(request)).and_then(|content| fault(request, content));
        faulty.unwrap_or_else(|| Reply::kept(content, "\"1\"", request))
    });
    let volume = Volume::open(format!("{}/{name}", server.url), &OpenOptions::default());
    (server, volume)
}

/// Each index is read once, and of the chunks those that are wanted.
#[test]
fn shards_are_read_in_parts() {
    for name in SHARDS {
        let (server, volume) = sharded(name, |_, _| None);
        assert_eq!(values(&volume.unwrap()), values(&by_path(name)));
        let asked: Vec<_> = server.requests().into_iter().filter(is_chunk).collect();
        assert!(asked.len() == 4 && asked.iter().all(|request| request.headers.contains_key("range")), "{asked:?}");
        assert_eq!(asked.iter().filter(|request| request.headers.contains_key("if-match")).count(), 2);
        // A chunk of four.
        let region = Some(VoxelBox { first: [1, 2, 1], dims: [2, 1, 1] });
        let (server, whole) = (Server::of_folder(folder()), by_path(name));
        let part = Volume::open(format!("{}/{name}", server.url), &OpenOptions { region, ..OpenOptions::default() }).unwrap();
        assert_eq!(values(&part), [whole.value(31), whole.value(32)]);
        let asked: Vec<_> =
            server.requests().into_iter().filter(is_chunk).map(|request| request.headers["range"].clone()).collect();
        assert_eq!(asked.len(), 2, "{asked:?}");
        assert_eq!(asked[0], if name == SHARDS[0] { "bytes=0-67" } else { "bytes=-68" });
        let (first, last) = asked[1].strip_prefix("bytes=").unwrap().split_once('-').unwrap();
        let len = last.parse::<u64>().unwrap() + 1 - first.parse::<u64>().unwrap();
        assert!(len < 40, "{len}");
    }
}

#[test]
fn servers_without_parts_give_all() {
    for name in SHARDS {
        let (server, volume) = sharded(name, |_, content| Some(Reply::file(Some(content))));
        assert_eq!(values(&volume.unwrap()), values(&by_path(name)));
        assert_eq!(server.requests().iter().filter(|request| is_chunk(request)).count(), 2);
        // Only after the index.
        let (_server, volume) = sharded(name, |request, content| (request.before > 0).then(|| Reply::file(Some(content))));
        assert_eq!(values(&volume.unwrap()), values(&by_path(name)));
    }
}

#[test]
fn wrong_parts_are_asked_for_again() {
    let said = |range: &str, body: &[u8]| Reply::Answer(206, vec![format!("Content-Range: {range}")], body.to_vec());
    type Fault = fn(&dyn Fn(&str, &[u8]) -> Reply, &[u8]) -> Reply;
    let faults: [(Fault, &str); 6] = [
        (|said, all| said("bytes 1-68/999", &all[..68]), "other bytes than it was asked for (bytes 1-68/999)"),
        (|said, all| said("bytes 0-0/*", &all[..1]), "other bytes than it was asked for (bytes 0-0/*)"),
        (|said, all| said("bytes 9-3/4", all), "other bytes than it was asked for (bytes 9-3/4)"),
        (|_, all| Reply::Answer(206, vec![], all.to_vec()), "other bytes than it was asked for (not said which)"),
        (|said, all| said("bytes 0-67/999", &all[..60]), "the server announces 60 bytes, where it has 68"),
        (
            |_, _| Reply::Raw(b"HTTP/1.1 206 P\r\nContent-Range: bytes 0-67/999\r\n\r\n12345".to_vec()),
            "the connection ended after 5 of 68 bytes",
        ),
    ];
    for (fault, sentence) in faults {
        let (_server, volume) = sharded(SHARDS[0], move |request, all| (request.before < 3).then(|| fault(&said, &all)));
        assert_eq!(values(&volume.unwrap()), values(&by_path(SHARDS[0])));
        let (_server, volume) = sharded(SHARDS[0], move |_, all| Some(fault(&said, &all)));
        let message = volume.unwrap_err().to_string();
        assert!(message.contains(sentence) && message.contains("(6 attempts)"), "{message}");
    }
    let (_server, volume) = sharded(SHARDS[0], |request, _| (request.before > 0).then(|| Reply::status(416)));
    let message = volume.unwrap_err().to_string();
    assert!(message.contains("fewer bytes than its index says"), "{message}");
}

/// A file that is written while it is read is read again, all of it; the second time that is an error.
#[test]
fn changed_shards_are_read_again() {
    let [_, name] = SHARDS;
    // The new file has no chunks: its index has the checksum of entries that are all ones.
    let emptied = |content: &[u8]| {
        let entries = vec![0xff; 64];
        let sum = crate::volume::format::zarr::crc32c::crc32c(&entries).to_le_bytes();
        [&content[..content.len() - 68], &entries, &sum].concat()
    };
    let is_first = |request: &Request| request.path.ends_with("c/0/0/0");
    let mut expected = values(&by_path(name));
    expected[..40].fill(0.0);
    for heeds in [true, false] {
        for tagged in [true, false] {
            let versioned = move |content: Vec<u8>, version: usize, request: &Request| {
                let mut request = request.clone();
                if !heeds {
                    request.headers.remove("if-match");
                }
                let Reply::Answer(status, lines, body) = Reply::kept(Some(content), &format!("\"{version}\""), &request) else {
                    unreachable!()
                };
                let lines = lines.into_iter().map(|line| if tagged { line } else { line.replace("ETag", "Last-Modified") });
                Reply::Answer(status, lines.collect(), body)
            };
            let (_server, volume) = sharded(name, move |request, content| {
                let version = is_first(request).then(|| request.before.min(1))?;
                Some(versioned(if version == 0 { content } else { emptied(&content) }, version, request))
            });
            assert_eq!(values(&volume.unwrap()), expected, "{heeds} {tagged}");
            let (server, volume) =
                sharded(name, move |request, content| is_first(request).then(|| versioned(content, request.before, request)));
            let message = volume.unwrap_err().to_string();
            assert!(message.contains("c/0/0/0: it changed while it was read"), "{message}");
            assert_eq!(server.requests().iter().filter(|request| is_first(request)).count(), 4);
        }
    }
    // Gone, too.
    let (_server, volume) = sharded(name, |request, _| (request.before % 2 == 1).then(|| Reply::file(None)));
    assert!(volume.unwrap_err().to_string().contains("changed while it was read"));
}
