//! MP4 via `ffmpeg`.

use crate::viewport::Viewport;
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// MP4 codecs require even sizes: pad odd sizes by a black row or column.
const EVEN: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

/// A running `ffmpeg` process that receives raw pixels.
pub(super) struct Film {
    process: Child,
    /// Standard error of the process.
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
            // A new process group does not receive Ctrl-C. This process removes the file and closes the pipe instead.
            command.process_group(0);
        }
        let process = command.spawn().map_err(|e| match e.kind() {
            io::ErrorKind::NotFound => io::Error::new(
                io::ErrorKind::NotFound,
                "writing MP4 needs ffmpeg, which is not on the PATH: install it (Debian, Ubuntu: apt install ffmpeg; Fedora: dnf \
                 install \
                 ffmpeg-free; macOS: brew install ffmpeg), or write .gif or .apng",
            ),
            _ => io::Error::new(e.kind(), format!("ffmpeg does not start: {e}")),
        })?;
        Ok(Self { process, messages })
    }

    /// Writes a frame of RGB rows.
    pub fn add(&mut self, rgb: &[u8]) -> io::Result<()> {
        let input = self.process.stdin.as_mut().expect("stdin is piped");
        let written = input.write_all(rgb);
        // If ffmpeg has exited, its messages are more informative than the broken pipe.
        written.map_err(|e| if e.kind() == io::ErrorKind::BrokenPipe { self.ended() } else { e })
    }

    pub fn finish(mut self) -> io::Result<()> {
        drop(self.process.stdin.take());
        if self.process.wait()?.success() { Ok(()) } else { Err(self.ended()) }
    }

    /// Error of a process that ended early, with its messages.
    fn ended(&mut self) -> io::Error {
        drop(self.process.stdin.take());
        let status = self.process.wait().map_or_else(|e| e.to_string(), |status| status.to_string());
        let mut output = Vec::new();
        let read = self.messages.rewind().and_then(|()| (&self.messages).take(2000).read_to_end(&mut output));
        let output = String::from_utf8_lossy(&output).trim().replace('\n', "; ");
        match read {
            Ok(_) if !output.is_empty() => io::Error::other(format!("ffmpeg failed ({status}): {output}")),
            _ => io::Error::other(format!("ffmpeg failed ({status})")),
        }
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        // Ends the process of an abandoned animation; has no effect after a regular end.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
