//! A server process, and a client that speaks raw HTTP and WebSocket.

use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for an answer; only a hang reaches it.
const PATIENCE: Duration = Duration::from_secs(120);
/// The status of a WebSocket that is closed because too many pages are open.
const TRY_AGAIN_LATER: u16 = 1013;
/// SIGINT among the ignored signals of a process.
#[cfg(unix)]
const SIGINT_BIT: u64 = 1 << 1;
/// Bytes before a picture.
const HEADER: usize = 20;

/// `layersplat view`, ended with the test.
pub struct Viewer {
    pub process: Child,
    pub address: SocketAddr,
    pub token: String,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Viewer {
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_in(None, arguments)
    }

    /// In a folder, whose subfolder `temporary` is for temporary files.
    pub fn start_in(folder: Option<&Path>, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        if let Some(folder) = folder {
            command.current_dir(folder).env("TMPDIR", folder.join("temporary"));
        }
        command.arg("view").args(arguments).arg("--no-browser").env_remove("SSH_CONNECTION");
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        // Read to its end, so that the viewer never waits for it.
        let mut stderr = process.stderr.take().unwrap();
        let messages = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            stderr.read_to_end(&mut bytes).map(|_| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
        });
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let Some((page, token)) = line.trim().split_once("?token=") else {
            panic!("no address: {line} {:?} {}", process.wait(), messages.join().unwrap_or_default());
        };
        let address = page.strip_prefix("http://").and_then(|p| p.strip_suffix('/')).unwrap().parse().unwrap();
        Self { process, address, token: token.into() }
    }

    /// Ends the server as Ctrl-C does, or by SIGTERM where this process was started with SIGINT ignored, as shells do in the background.
    #[cfg(unix)]
    pub fn interrupt(&mut self) -> ExitStatus {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let ignored = ignored.map_or(0, |bits| u64::from_str_radix(bits.trim(), 16).unwrap());
        let signal = if ignored & SIGINT_BIT == 0 { "-INT" } else { "-TERM" };
        assert!(Command::new("kill").args([signal, &self.process.id().to_string()]).status().unwrap().success());
        self.process.wait().unwrap()
    }

    pub fn host(&self) -> String {
        self.address.to_string()
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends a request as it is, and reads the answer until the connection ends.
    pub fn raw(&self, request: &str) -> String {
        let mut stream = self.connect();
        // The server may refuse and close before it has read everything.
        let _ = stream.write_all(request.as_bytes());
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// A GET with the right `Host` and these further headers.
    pub fn get(&self, path: &str, headers: &str) -> String {
        self.raw(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n{headers}\r\n", self.host()))
    }

    /// The cookie that the token is exchanged for.
    pub fn cookie(&self) -> String {
        let answer = self.get(&format!("/?token={}", self.token), "");
        let line = answer.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap_or_else(|| panic!("{answer}"));
        line.split(';').next().unwrap().to_owned()
    }

    /// The request for a WebSocket with these headers.
    pub fn upgrade(&self, headers: &str) -> String {
        format!(
            "GET /socket HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{headers}\r\n"
        )
    }

    /// A page: its WebSocket after the first message. Waits while closed pages still have their places.
    pub fn page(&self) -> Page {
        let begun = Instant::now();
        loop {
            let mut page = Page { stream: self.socket(), hello: Value::Null };
            match page.receive() {
                Message::Text(hello) => {
                    page.hello = hello;
                    return page;
                }
                Message::Closed(TRY_AGAIN_LATER) if begun.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(50)),
                other => panic!("{other:?}"),
            }
        }
    }

    fn socket(&self) -> TcpStream {
        let (host, cookie) = (self.host(), self.cookie());
        let mut stream = self.connect();
        let request = self.upgrade(&format!("Host: {host}\r\nOrigin: http://{host}\r\nCookie: {cookie}\r\n"));
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            answer.push(byte[0]);
        }
        assert!(answer.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&answer));
        stream
    }

    /// Resident memory of the server in bytes.
    #[cfg(target_os = "linux")]
    pub fn resident_bytes(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10
    }
}

/// What a page receives.
#[derive(Debug)]
pub enum Message {
    Text(Value),
    Picture(Picture),
    Closed(u16),
}

#[derive(Debug)]
pub struct Picture {
    pub step: u8,
    pub is_png: bool,
    pub id: u32,
    pub width: u32,
    pub height: u32,
    pub bytes: Vec<u8>,
}

pub struct Page {
    pub stream: TcpStream,
    pub hello: Value,
}

impl Page {
    pub fn send(&mut self, request: &Value) {
        self.send_frame(0x81, request.to_string().as_bytes()).unwrap();
    }

    /// Sends a frame with a first byte of its own.
    pub fn send_frame(&mut self, first: u8, payload: &[u8]) -> std::io::Result<()> {
        let mut frame = vec![first];
        match payload.len() {
            length @ ..126 => frame.push(0x80 | length as u8),
            length @ ..65_536 => {
                frame.push(0x80 | 126);
                frame.extend((length as u16).to_be_bytes());
            }
            length => {
                frame.push(0x80 | 127);
                frame.extend((length as u64).to_be_bytes());
            }
        }
        let mask = [1, 2, 3, 4];
        frame.extend(mask);
        frame.extend(payload.iter().zip(mask.iter().cycle()).map(|(byte, mask)| byte ^ mask));
        self.stream.write_all(&frame)
    }

    pub fn receive(&mut self) -> Message {
        loop {
            let Ok((kind, payload)) = self.frame() else { return Message::Closed(0) };
            match kind {
                1 => return Message::Text(serde_json::from_slice(&payload).unwrap()),
                2 => return Message::Picture(Picture::new(&payload)),
                8 => return Message::Closed(payload.get(..2).map_or(0, |code| u16::from_be_bytes([code[0], code[1]]))),
                // Pings.
                _ => {}
            }
        }
    }

    fn frame(&mut self) -> std::io::Result<(u8, Vec<u8>)> {
        let mut head = [0; 2];
        self.stream.read_exact(&mut head)?;
        let length = match head[1] {
            126 => {
                let mut length = [0; 2];
                self.stream.read_exact(&mut length)?;
                u64::from(u16::from_be_bytes(length))
            }
            127 => {
                let mut length = [0; 8];
                self.stream.read_exact(&mut length)?;
                u64::from_be_bytes(length)
            }
            length => length.into(),
        };
        let mut payload = vec![0; length as usize];
        self.stream.read_exact(&mut payload)?;
        Ok((head[0] & 15, payload))
    }

    /// The next text of a type; pictures before it are acknowledged.
    pub fn text(&mut self, kind: &str) -> Value {
        loop {
            match self.receive() {
                Message::Text(text) if text["type"] == kind => return text,
                Message::Text(_) => {}
                Message::Picture(_) => self.shown(),
                Message::Closed(code) => panic!("closed with {code} before {kind}"),
            }
        }
    }

    /// The next message that is a picture or a text of one of these types; pictures are acknowledged.
    pub fn next(&mut self, kinds: &[&str]) -> Message {
        loop {
            match self.receive() {
                Message::Text(text) if !kinds.iter().any(|kind| text["type"] == *kind) => {}
                Message::Picture(picture) => {
                    if picture.step < 5 {
                        self.shown();
                    }
                    return Message::Picture(picture);
                }
                other => return other,
            }
        }
    }

    /// The next picture; texts before it are dropped, but for problems.
    pub fn picture(&mut self) -> Picture {
        loop {
            match self.receive() {
                Message::Picture(picture) => return picture,
                Message::Text(text) => assert_ne!(text["type"], "problem", "{text}"),
                Message::Closed(code) => panic!("closed with {code} before a picture"),
            }
        }
    }

    /// Asserts that no picture comes for half a second; the server may still say that programs are ready.
    pub fn gets_no_picture(&mut self) {
        self.stream.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
        loop {
            match self.receive() {
                Message::Closed(_) => break,
                Message::Picture(picture) => panic!("a picture too many: {picture:?}"),
                Message::Text(_) => {}
            }
        }
        self.stream.set_read_timeout(Some(PATIENCE)).unwrap();
    }

    /// The last picture of a refinement.
    pub fn refined(&mut self) -> Picture {
        loop {
            let picture = self.picture();
            self.shown();
            if picture.step == 4 {
                return picture;
            }
        }
    }

    pub fn shown(&mut self) {
        self.send(&serde_json::json!({ "type": "shown" }));
    }

    /// A view from the first camera, turned by some degrees.
    pub fn view(&self, id: u32, turned: f64, moving: bool) -> Value {
        let mut camera = self.hello["camera"].clone();
        camera["azimuth"] = (camera["azimuth"].as_f64().unwrap() + turned).into();
        serde_json::json!({ "type": "view", "id": id, "camera": camera, "width": 96, "height": 64, "moving": moving })
    }
}

impl Picture {
    fn new(message: &[u8]) -> Self {
        let number = |at: usize| u32::from_le_bytes(message[at..at + 4].try_into().unwrap());
        Self {
            step: message[0],
            is_png: message[1] == 1,
            id: number(4),
            width: number(8),
            height: number(12),
            bytes: message[HEADER..].to_vec(),
        }
    }

    pub fn pixels(&self) -> image::RgbaImage {
        let image = image::load_from_memory(&self.bytes).unwrap().into_rgba8();
        assert_eq!((image.width(), image.height()), (self.width, self.height));
        image
    }
}
