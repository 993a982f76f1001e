//! Files that are kept on disk, and addresses that differ in their queries.

use super::*;
use crate::url;

/// What is kept on disk is used only if the server says that it is still that, by a tag or a date.
#[test]
fn kept_files_are_those_of_the_server() {
    let place = tempfile::tempdir().unwrap();
    let cache = || -> &'static Cache { Box::leak(Box::new(Cache::new(place.path().join("kept"), 1 << 30))) };
    let version = Arc::new(Mutex::new(1));
    let current = version.clone();
    let server = Server::new(move |request| {
        let version = *current.lock().unwrap();
        let content = |text: &str| Some(format!("{text} {version} {}", request.path).into_bytes());
        match request.path.split('?').next().unwrap() {
            "/tagged" => Reply::kept(content("0123456789"), &format!("\"{version}\""), request),
            "/weak" => Reply::kept(content("weak"), &format!("W/\"{version}\""), request),
            path @ ("/dated" | "/fresh") => {
                let date = format!("Fri, 02 Jan 2026 00:00:0{version} GMT");
                if request.headers.get("if-modified-since") == Some(&date) {
                    return Reply::Answer(304, vec![], vec![]);
                }
                let now = if path == "/fresh" { date.clone() } else { "Fri, 02 Jan 2026 00:01:00 GMT".into() };
                Reply::Answer(200, vec![format!("Last-Modified: {date}"), format!("Date: {now}")], content("dated").unwrap())
            }
            "/secret" => {
                let tags = vec![format!("ETag: \"{version}\""), "Cache-Control: private, no-store".into()];
                Reply::Answer(200, tags, content("secret").unwrap())
            }
            "/refused" if version > 1 => Reply::status(403),
            "/refused" => Reply::kept(content("refused"), "\"1\"", request),
            _ => Reply::file(content("plain")),
        }
    });
    let (all, part) = (Span::All, Span::Part(2..5));
    let get = |path: &str, span: &Span| {
        let before = server.requests().len();
        // As another process does.
        let found = Http::new(PATIENCE, Some(cache())).get(Path::new(&format!("{}{path}", server.url)), span, None, 1 << 20);
        let asked = server.requests();
        assert_eq!(asked.len(), before + 1, "each is asked for");
        let is_conditional = ["if-none-match", "if-modified-since"].iter().any(|name| asked[before].headers.contains_key(*name));
        found.map(|found| (String::from_utf8(found.unwrap().bytes).unwrap(), is_conditional))
    };
    for (path, text) in [("/tagged", "0123456789"), ("/weak", "weak"), ("/dated", "dated")] {
        *version.lock().unwrap() = 1;
        let expected = |version: u32| format!("{text} {version} {path}");
        assert_eq!(get(path, &all).unwrap(), (expected(1), false));
        assert_eq!(get(path, &all).unwrap(), (expected(1), true));
        *version.lock().unwrap() = 2;
        assert_eq!(get(path, &all).unwrap(), (expected(2), true));
        assert_eq!(get(path, &all).unwrap(), (expected(2), true));
    }
    assert_eq!(get("/tagged", &part).unwrap(), ("234".into(), false));
    assert_eq!(get("/tagged", &part).unwrap(), ("234".into(), true));
    *version.lock().unwrap() = 1;
    for path in ["/fresh", "/secret", "/plain", "/tagged?v=1", "/tagged?v=2"] {
        for _ in 0..2 {
            let address = format!("{}{path}", server.url);
            let public = url::public(Path::new(&address)).into_owned();
            let found = Http::new(PATIENCE, Some(cache())).get(&public, &all, None, 1 << 20).unwrap().unwrap();
            let asked = server.requests().pop().unwrap();
            assert!(asked.path == path && String::from_utf8(found.bytes).unwrap().ends_with(path));
            assert!(!asked.headers.contains_key("if-none-match") && !asked.headers.contains_key("if-modified-since"), "{path}");
        }
    }
    // Who may read it no longer gets nothing.
    assert!(!get("/refused", &all).unwrap().1);
    *version.lock().unwrap() = 2;
    assert_eq!(get("/refused", &all).unwrap_err().kind(), io::ErrorKind::PermissionDenied);
    // Half a file is none.
    *version.lock().unwrap() = 1;
    for entry in std::fs::read_dir(cache().folder()).unwrap() {
        let path = entry.unwrap().path();
        let content = std::fs::read(&path).unwrap();
        std::fs::write(&path, &content[..content.len() - 1]).unwrap();
    }
    assert_eq!(get("/weak", &all).unwrap(), ("weak 1 /weak".into(), false));
}

/// Addresses that differ in their secrets only are different ones, whichever is asked for first.
#[test]
fn queries_tell_addresses_apart() {
    let server = Server::new(|request| Reply::file(Some(request.path.clone().into_bytes())));
    let address = |query: &str| format!("{}/q.zarr{query}", server.url);
    let all = ["?v=1", "?v=2", "?v=1", "?v=2&x=1"].map(|query| (query, url::public(Path::new(&address(query))).into_owned()));
    for (query, public) in all.iter().chain(all.iter().rev()) {
        assert!(!public.to_str().unwrap().contains('?'));
        // What is public stays as it is.
        let below = url::public(&public.join("0")).join("zarr.json");
        let found = Http::new(PATIENCE, None).get(&below, &Span::All, None, 1 << 20).unwrap().unwrap();
        assert_eq!(String::from_utf8(found.bytes).unwrap(), format!("/q.zarr/0/zarr.json{query}"));
    }
    assert!(all[0].1 == all[2].1 && all[0].1 == Path::new(&address("")) && all[1].1 == Path::new(&address("#2")));
}
