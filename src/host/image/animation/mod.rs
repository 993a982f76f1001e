//! Animations.

mod film;
mod gif;
mod png;

use super::{Background, Frame};
use crate::error::Error;
use crate::files::Unfinished;
use crate::viewport::Viewport;
use film::Film;
use std::io;
use std::path::{Path, PathBuf};

/// Animation file formats.
///
/// ```
/// use layersplat::image::AnimationFormat;
/// use std::path::Path;
///
/// assert_eq!(AnimationFormat::from_path(Path::new("turn.gif")), Some(AnimationFormat::Gif));
/// assert_eq!(AnimationFormat::from_path(Path::new("turn")), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnimationFormat {
    /// Animated GIF: up to 256 colours per frame, opaque, looping.
    Gif,
    /// Animated PNG: 8-bit RGB, or RGBA with a transparent background, looping.
    Apng,
    /// MP4, encoded by the external program `ffmpeg`.
    Mp4,
}

impl AnimationFormat {
    /// Largest frame rate in frames per second, supported by all formats but GIF and by common players.
    pub const MAX_RATE: u32 = 120;
    /// Largest frame rate of a GIF. Delays are in hundredths of a second, and players slow down at delays below two of them.
    pub const MAX_GIF_RATE: u32 = 50;

    /// The format of a file extension: `.gif`, `.apng` or `.png`, `.mp4`.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "gif" => Some(AnimationFormat::Gif),
            "apng" | "png" => Some(AnimationFormat::Apng),
            "mp4" => Some(AnimationFormat::Mp4),
            _ => None,
        }
    }

    fn check(self, rate: u32, background: Background) -> Result<(), Error> {
        let (most, expected) = match self {
            AnimationFormat::Gif => (Self::MAX_GIF_RATE, "1 to 50 frames per second in a GIF"),
            _ => (Self::MAX_RATE, "1 to 120 frames per second"),
        };
        if !(1..=most).contains(&rate) {
            return Err(Error::OutOfRange { name: "rate", value: rate.to_string(), expected });
        }
        if background == Background::Transparent && self != AnimationFormat::Apng {
            let problem = "only animated PNG supports transparency: choose a colour, or write .apng".into();
            return Err(Error::Settings { field: "background", problem });
        }
        Ok(())
    }
}

/// An animation file, written frame by frame. The file appears only when it is [finished](Self::finish). Dropping an unfinished animation
/// leaves no file.
///
/// ```
/// use layersplat::image::Animation;
/// use layersplat::{Background, Frame, Viewport};
///
/// let folder = tempfile::tempdir().expect("a folder");
/// let (path, viewport) = (folder.path().join("blink.gif"), Viewport::new(2, 1)?);
/// let mut animation = Animation::create(&path, viewport, 2, 25, Background::BLACK)?;
/// for brightness in [0.0, 1.0] {
///     animation.add(&Frame::new(viewport, vec![[brightness; 4]; 2]))?;
/// }
/// animation.finish()?;
/// assert!(path.exists());
/// # Ok::<(), layersplat::Error>(())
/// ```
pub struct Animation {
    // Declared before the file, so that it is dropped first and does not write to a removed file.
    encoder: Encoder,
    unfinished: Unfinished,
    path: PathBuf,
    viewport: Viewport,
    background: Background,
    missing: u32,
}

enum Encoder {
    Gif(gif::Writer),
    Apng(png::Writer),
    Mp4(Film),
}

impl Animation {
    /// Creates an animation of `frames` frames at `rate` frames per second. The file extension determines the format.
    ///
    /// # Errors
    /// If the extension is unknown, the rate is out of range, `frames` is 0, the background is `Transparent` in a format without
    /// transparency, the file cannot be written, or `ffmpeg` is missing for `.mp4`.
    pub fn create(path: &Path, viewport: Viewport, frames: u32, rate: u32, background: Background) -> Result<Self, Error> {
        let Some(format) = AnimationFormat::from_path(path) else {
            let name = path.display().to_string();
            return Err(Error::UnknownName {
                what: "animation format",
                name,
                known: "a name ending in .gif, .apng or .mp4".into(),
            });
        };
        format.check(rate, background)?;
        if frames == 0 {
            return Err(Error::OutOfRange { name: "frames", value: "0".into(), expected: "at least 1" });
        }
        let failed = |e| Error::write(path, e);
        let (unfinished, file) = Unfinished::new(path).map_err(failed)?;
        let encoder = match format {
            AnimationFormat::Gif => gif::Writer::new(file, viewport, rate).map(Encoder::Gif),
            AnimationFormat::Apng => png::Writer::new(file, viewport, frames, rate, background).map(Encoder::Apng),
            AnimationFormat::Mp4 => Film::new(unfinished.path(), viewport, rate).map(Encoder::Mp4),
        };
        let encoder = encoder.map_err(failed)?;
        Ok(Self { encoder, unfinished, path: path.into(), viewport, background, missing: frames })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be written.
    ///
    /// # Panics
    /// If the frame has another size, or more frames are added than announced.
    pub fn add(&mut self, frame: &Frame) -> Result<(), Error> {
        assert_eq!([frame.width(), frame.height()], [self.viewport.width, self.viewport.height]);
        self.missing = self.missing.checked_sub(1).expect("no more frames than were announced");
        let rgba = frame.to_rgba8(self.background);
        let added = match &mut self.encoder {
            Encoder::Gif(writer) => writer.add(rgba),
            Encoder::Apng(writer) => writer.add(&rgba),
            Encoder::Mp4(film) => film.add(&rgb(&rgba)),
        };
        added.map_err(|e| Error::write(&self.path, e))
    }

    /// Completes the file and renames it to its final name.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be written.
    ///
    /// # Panics
    /// If frames are missing.
    pub fn finish(self) -> Result<(), Error> {
        assert_eq!(self.missing, 0, "frames are missing");
        let closed = match self.encoder {
            Encoder::Gif(writer) => writer.finish(),
            Encoder::Apng(writer) => writer.finish(),
            Encoder::Mp4(film) => film.finish(),
        };
        closed.and_then(|()| self.unfinished.finish()).map_err(|e| Error::write(&self.path, e))
    }
}

/// Drops the alpha channel.
fn rgb(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

fn other(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::other(error)
}

#[cfg(test)]
mod tests;
