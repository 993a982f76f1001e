//! MP4, by `ffmpeg`.

use crate::viewport::Viewport;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// What the codecs of MP4 take: even sides; a row or column of black is added where they are odd.
const EVEN: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

/// A running `ffmpeg`, which takes raw pixels.
pub(super) struct Film {
    process: Child,
    /// What it complains about.
    messages: File,
}

impl Film {
    pub fn new(path: &Path, viewport: Viewport, rate: u32) -> io::Result<Self> {
        let messages = tempfile::tempfile()?;
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{}x{}", viewport.width, viewport.height), "-framerate", &rate.to_string()]);
        command.args(["-i", "-", "-an", "-vf", EVEN, "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", "-y"]);
        command.arg(path).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(messages.try_clone()?);
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt;
            // Ctrl-C is for us: its file is removed then, and its input ends.
            command.process_group(0);
        }
        let process = command.spawn().map_err(|e| match e.kind() {
            io::ErrorKind::NotFound => io::Error::new(
                io::ErrorKind::NotFound,
                "MP4 is made by ffmpeg, which is not on the PATH: install it (Debian, Ubuntu: apt install ffmpeg; Fedora: dnf install \
                 ffmpeg-free; macOS: brew install ffmpeg), or write .gif or .apng",
            ),
            _ => io::Error::new(e.kind(), format!("ffmpeg does not start: {e}")),
        })?;
        Ok(Self { process, messages })
    }

    /// Rows of RGB.
    pub fn add(&mut self, rgb: &[u8]) -> io::Result<()> {
        let input = self.process.stdin.as_mut().expect("it is piped");
        let written = input.write_all(rgb);
        // Where it went away, what it said tells more than the broken pipe.
        written.map_err(|e| if e.kind() == io::ErrorKind::BrokenPipe { self.ended() } else { e })
    }

    pub fn finish(mut self) -> io::Result<()> {
        drop(self.process.stdin.take());
        if self.process.wait()?.success() { Ok(()) } else { Err(self.ended()) }
    }

    /// Why it ended before its time.
    fn ended(&mut self) -> io::Error {
        drop(self.process.stdin.take());
        let status = self.process.wait().map_or_else(|e| e.to_string(), |status| status.to_string());
        let mut said = Vec::new();
        let read = self.messages.rewind().and_then(|()| (&self.messages).take(2000).read_to_end(&mut said));
        let said = String::from_utf8_lossy(&said).trim().replace('\n', "; ");
        match read {
            Ok(_) if !said.is_empty() => io::Error::other(format!("ffmpeg failed ({status}): {said}")),
            _ => io::Error::other(format!("ffmpeg failed ({status})")),
        }
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // Of a film that was given up; one that has ended is not there to be killed.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
