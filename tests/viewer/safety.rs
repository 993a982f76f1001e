//! Access to the viewer: token, cookie, `Host` and `Origin`.

use crate::client::{Message, Viewer};
use std::io::{Read, Write};

const SMALL: [&str; 1] = ["builtin:hydrogen@16"];

/// An upgrade after whose refusal the connection ends.
fn closing(upgrade: String) -> String {
    upgrade.replace("Connection: Upgrade", "Connection: Upgrade, close")
}

fn status(answer: &str) -> &str {
    answer.get(9..12).unwrap_or("none")
}

#[test]
fn the_token_is_exchanged_for_a_cookie_and_leaves_the_address() {
    let viewer = Viewer::start(&SMALL);
    let answer = viewer.get(&format!("/?token={}", viewer.token), "");
    assert_eq!(status(&answer), "200");
    let cookie = answer.lines().find(|line| line.starts_with("set-cookie: ")).unwrap();
    for part in ["layersplat-", "HttpOnly", "SameSite=Strict", "Path=/"] {
        assert!(cookie.contains(part), "{cookie}");
    }
    // The script keeps the view after #, which no server sees.
    assert!(
        answer.contains("/enter.js") && answer.contains("content=\"0;url=/\"") && !answer.contains(&viewer.token),
        "{answer}"
    );
    assert!(!cookie.contains(&viewer.token));
    let cookie = format!("Cookie: {}\r\n", viewer.cookie());
    for path in ["/", "/main.js", "/style.css", "/enter.js"] {
        assert_eq!(status(&viewer.get(path, &cookie)), "200", "{path}");
    }
    for path in ["/etc/passwd", "/../Cargo.toml", "/index.html/..", "/MAIN.JS"] {
        assert_eq!(status(&viewer.get(path, &cookie)), "404", "{path}");
    }
}

#[test]
fn requests_without_access_are_refused() {
    let viewer = Viewer::start(&SMALL);
    let (host, good) = (viewer.host(), format!("Cookie: {}\r\n", viewer.cookie()));
    let wrong = good.replace(&good[good.len() - 6..good.len() - 2], "0000");
    let wrong_token = format!("/?token={}", "0".repeat(viewer.token.len()));
    for (path, headers) in
        [("/", ""), ("/main.js", ""), ("/socket", ""), ("/", wrong.as_str()), (wrong_token.as_str(), ""), ("/?token=", "")]
    {
        let answer = viewer.get(path, headers);
        assert_eq!(status(&answer), "403", "{path} {headers}: {answer}");
        assert!(!answer.contains("set-cookie") && !answer.contains(&viewer.token));
    }
    // A page of another site, and a foreign name that was bound to this address.
    for (host, origin) in [
        (host.as_str(), "http://evil.example"),
        (host.as_str(), "null"),
        (host.as_str(), "http://127.0.0.1:1"),
        ("evil.example", "http://evil.example"),
        ("127.0.0.1.evil.example", "http://127.0.0.1.evil.example"),
    ] {
        let answer = viewer.raw(&closing(viewer.upgrade(&format!("Host: {host}\r\nOrigin: {origin}\r\n{good}"))));
        assert!(["403", "421"].contains(&status(&answer)), "{host} {origin}: {answer}");
    }
    let answer = viewer.raw(&closing(viewer.upgrade(&format!("Host: {host}\r\n{good}"))));
    assert_eq!(status(&answer), "403", "a WebSocket without Origin");
    let answer = viewer.raw(&closing(viewer.upgrade(&format!("Host: {host}\r\nOrigin: http://{host}\r\n"))));
    assert_eq!(status(&answer), "403", "a WebSocket without cookie");
    for request in
        ["GET / HTTP/1.1\r\nConnection: close\r\n\r\n", "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\nConnection: close\r\n\r\n"]
    {
        assert!(["400", "421"].contains(&status(&viewer.raw(request))), "{request}");
    }
    // Another port is another tunnel to the same server.
    let request = format!("GET / HTTP/1.1\r\nHost: localhost:9\r\nConnection: close\r\n{good}\r\n");
    assert_eq!(status(&viewer.raw(&request)), "200");
}

#[test]
fn every_answer_has_the_headers() {
    let viewer = Viewer::start(&SMALL);
    let good = format!("Cookie: {}\r\n", viewer.cookie());
    for (path, headers) in [("/", good.as_str()), ("/main.js", &good), ("/none", &good), ("/", "")] {
        let answer = viewer.get(path, headers);
        for header in [
            "content-security-policy: default-src 'none'; script-src 'self';",
            "frame-ancestors 'none'",
            "x-content-type-options: nosniff",
            "referrer-policy: no-referrer",
            "cache-control: no-store",
        ] {
            assert!(answer.contains(header), "{path}: {answer}");
        }
        assert!(!answer.contains("access-control") && !answer.contains("unsafe"), "{answer}");
    }
    let request = |method: &str| format!("{method} / HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n{good}\r\n", viewer.host());
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        assert_eq!(status(&viewer.raw(&request(method))), "405", "{method}");
    }
}

#[test]
fn cookies_of_other_runs_do_not_open_this_one() {
    let (first, second) = (Viewer::start(&SMALL), Viewer::start(&SMALL));
    assert_ne!(first.token, second.token);
    let foreign = format!("Cookie: {}; {}\r\n", first.cookie(), "other=1");
    assert_eq!(status(&second.get("/", &foreign)), "403");
    // One browser keeps both, since cookies do not know ports.
    let both = format!("Cookie: {}; {}\r\n", first.cookie(), second.cookie());
    assert_eq!((status(&first.get("/", &both)), status(&second.get("/", &both))), ("200", "200"));
}

#[test]
fn the_page_names_no_path_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cube_8x8x8_uint8.raw");
    std::fs::write(&path, vec![100; 512]).unwrap();
    let transfer = folder.path().join("curve.csv");
    std::fs::write(&transfer, "0,0,0,0,0\n200,1,1,1,0.5\n").unwrap();
    let viewer = Viewer::start(&[path.to_str().unwrap(), "--transfer", transfer.to_str().unwrap()]);
    let mut page = viewer.page();
    let folder = folder.path().to_str().unwrap();
    assert!(!page.hello.to_string().contains(folder), "{}", page.hello);
    assert_eq!(
        (page.hello["volume"]["name"].as_str(), page.hello["transfer"]["name"].as_str()),
        (Some("cube_8x8x8_uint8.raw"), Some("curve.csv"))
    );
    page.send(&serde_json::json!({ "type": "command", "camera": page.hello["camera"], "width": 8, "height": 8, "samples": 1 }));
    let command = page.text("command");
    assert!(!command.to_string().contains(folder), "{command}");
    page.send(&serde_json::json!({ "type": "read", "name": "/etc/passwd", "text": "no curve" }));
    let problem = page.text("problem");
    assert!(!problem.to_string().contains("root:"), "{problem}");
}

#[test]
fn what_is_no_request_ends_the_page_only() {
    let viewer = Viewer::start(&SMALL);
    let mut other = viewer.page();
    let large = vec![b' '; (1 << 20) + 1];
    let frames: [(&str, u8, &[u8]); 7] = [
        ("no JSON", 0x81, b"hello"),
        ("another type", 0x81, br#"{"type":"open","path":"/etc/passwd"}"#),
        ("binary", 0x82, b"{}"),
        ("no UTF-8", 0x81, &[0xff, 0xfe]),
        ("reserved bits", 0xf1, b"{}"),
        ("a reserved kind", 0x83, b"{}"),
        ("too large", 0x81, &large),
    ];
    for (what, first, payload) in frames {
        let mut page = viewer.page();
        // The server may end the connection before it has read all.
        let _ = page.send_frame(first, payload);
        loop {
            match page.receive() {
                Message::Closed(_) => break,
                Message::Text(text) => assert_ne!(text["type"], "problem", "{what}"),
                Message::Picture(_) => panic!("{what}"),
            }
        }
    }
    // Unmasked frames are no frames of browsers.
    let mut page = viewer.page();
    page.stream.write_all(&[0x81, 2, b'{', b'}']).unwrap();
    let mut rest = Vec::new();
    let _ = page.stream.read_to_end(&mut rest);
    other.send(&other.view(1, 0.0, true));
    assert_eq!(other.picture().id, 1);
}

#[test]
fn other_addresses_need_a_token_file_and_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("token");
    std::fs::write(&token, "0123456789abcdef0123456789abcdef\n").unwrap();
    let token = token.to_str().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let output = command.args(["view", "--no-browser", "builtin:cube@8"]).args(arguments).output().unwrap();
        assert!(!output.status.success() && output.stdout.is_empty());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(run(&["--listen", "0.0.0.0"]).contains("--token-file"));
    assert!(run(&["--listen", "0.0.0.0", "--token-file", token]).contains("--host"));
    assert!(run(&["--listen", "0.0.0.0", "--token-file", token, "--host", "http://a/"]).contains("scheme"));
    assert!(run(&["--token-file", "/missing"]).contains("/missing"));
    for host in ["name:80", "fe80::1", "[fe80::1", "a b"] {
        assert!(run(&["--host", host]).contains("omit scheme, port and path"), "{host}");
    }
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let said = run(&["--port", &taken.local_addr().unwrap().port().to_string()]);
    assert!(said.contains("--port") && said.contains("another program"), "{said}");
    assert!(run(&["--listen", "192.0.2.1", "--token-file", token, "--host", "a"]).contains("--listen"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        for (mode, warns) in [(0o644, true), (0o600, false)] {
            std::fs::set_permissions(token, std::fs::Permissions::from_mode(mode)).unwrap();
            // Ends after the token was read.
            let said = run(&["--token-file", token, "--time-limit", "1", "--channel", "7"]);
            assert_eq!(said.contains("chmod 600"), warns, "{said}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn any_loopback_address_works() {
    let viewer = Viewer::start(&["builtin:cube@8", "--listen", "127.0.0.2"]);
    assert_eq!(viewer.address.ip().to_string(), "127.0.0.2");
    assert_eq!(status(&viewer.get("/", &format!("Cookie: {}\r\n", viewer.cookie()))), "200");
}
