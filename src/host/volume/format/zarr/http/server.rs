//! A web server for tests, which misbehaves as it is told.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// A request.
#[derive(Clone, Debug)]
pub struct Request {
    /// Path and query, as sent.
    pub path: String,
    /// Lower-case names and values.
    pub headers: HashMap<String, String>,
    /// How many requests had this path before.
    pub before: usize,
}

/// What a request gets.
pub enum Reply {
    /// Status, further header lines, body.
    Answer(u16, Vec<String>, Vec<u8>),
    /// These bytes, then the end of the connection.
    Raw(Vec<u8>),
    /// Nothing, while the client waits.
    Silence,
}

impl Reply {
    /// A file, or that there is none.
    pub fn file(content: Option<Vec<u8>>) -> Self {
        content.map_or(Self::Answer(404, Vec::new(), Vec::new()), |content| Self::Answer(200, Vec::new(), content))
    }

    /// A file as servers give it that know parts and versions.
    pub fn kept(content: Option<Vec<u8>>, tag: &str, request: &Request) -> Self {
        let Some(content) = content else { return Self::file(None) };
        let (header, tagged) = (|name: &str| request.headers.get(name).map(String::as_str), vec![format!("ETag: {tag}")]);
        if header("if-match").is_some_and(|wanted| wanted != tag) {
            return Self::status(412);
        }
        if header("if-none-match") == Some(tag) {
            return Self::Answer(304, tagged, Vec::new());
        }
        let Some((first, last)) = header("range").and_then(|range| range.strip_prefix("bytes=")?.split_once('-')) else {
            return Self::Answer(200, tagged, content);
        };
        let len = content.len();
        let part = match (first.parse::<usize>(), last.parse::<usize>()) {
            (Ok(first), Ok(last)) => first..len.min(last + 1),
            (Ok(first), _) => first..len,
            (_, last) => len.saturating_sub(last.unwrap())..len,
        };
        if part.is_empty() {
            return Self::status(416);
        }
        let said = format!("Content-Range: bytes {}-{}/{len}", part.start, part.end - 1);
        Self::Answer(206, [tagged, vec![said]].concat(), content[part].to_vec())
    }

    pub fn status(status: u16) -> Self {
        Self::Answer(status, Vec::new(), b"<html>a page about it</html>".to_vec())
    }
}

type Answers = dyn Fn(&Request) -> Reply + Send + Sync;

/// A server on a port of its own; it ends with the process.
pub struct Server {
    /// Its address, without a slash at the end.
    pub url: String,
    requests: Arc<Mutex<Vec<Request>>>,
}

impl Server {
    pub fn new(answer: impl Fn(&Request) -> Reply + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let (answer, requests): (Arc<Answers>, _) = (Arc::new(answer), Arc::new(Mutex::default()));
        let log = Arc::clone(&requests);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let (answer, log) = (answer.clone(), log.clone());
                // A client may go at any time.
                std::thread::spawn(move || serve(&stream, &*answer, &log));
            }
        });
        Self { url, requests }
    }

    /// The files of a folder, of which nothing stays in the cache of who runs the tests.
    pub fn of_folder(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        Self::new(move |request| match Reply::kept(file(&folder, request), "\"1\"", request) {
            Reply::Answer(status, mut lines, body) => {
                lines.push("Cache-Control: no-store".into());
                Reply::Answer(status, lines, body)
            }
            other => other,
        })
    }

    pub fn requests(&self) -> Vec<Request> {
        self.requests.lock().unwrap().clone()
    }
}

/// The file below a folder that a request names.
pub fn file(folder: &std::path::Path, request: &Request) -> Option<Vec<u8>> {
    std::fs::read(folder.join(request.path.split('?').next()?.trim_start_matches('/'))).ok()
}

fn serve(stream: &TcpStream, answer: &Answers, log: &Mutex<Vec<Request>>) -> Option<()> {
    let mut from = BufReader::new(stream);
    let mut to = stream;
    loop {
        let mut line = String::new();
        from.read_line(&mut line).ok().filter(|&len| len > 0)?;
        let path = line.split(' ').nth(1)?.to_owned();
        let mut headers = HashMap::new();
        loop {
            let mut line = String::new();
            from.read_line(&mut line).ok()?;
            let Some((name, value)) = line.trim_end().split_once(": ") else { break };
            headers.insert(name.to_lowercase(), value.to_owned());
        }
        let request = {
            let mut all = log.lock().ok()?;
            let before = all.iter().filter(|earlier| earlier.path == path).count();
            all.push(Request { path, headers, before });
            all.last().cloned()?
        };
        match answer(&request) {
            Reply::Answer(status, mut lines, body) => {
                if status != 304 {
                    lines.push(format!("Content-Length: {}", body.len()));
                }
                to.write_all(format!("HTTP/1.1 {status} Status\r\n{}\r\n\r\n", lines.join("\r\n")).as_bytes()).ok()?;
                to.write_all(&body).ok()?;
            }
            Reply::Raw(bytes) => {
                to.write_all(&bytes).ok()?;
                return Some(());
            }
            Reply::Silence => {
                // Until the client closes the connection.
                let _ = from.read(&mut [0]);
                return Some(());
            }
        }
    }
}
