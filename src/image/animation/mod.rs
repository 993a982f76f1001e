//! Frames one after the other, in one file.

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

/// File formats of moving pictures.
///
/// ```
/// use layersplat::image::AnimationFormat;
/// use std::path::Path;
///
/// assert_eq!(AnimationFormat::of(Path::new("turn.gif")), Some(AnimationFormat::Gif));
/// assert_eq!(AnimationFormat::of(Path::new("turn")), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AnimationFormat {
    /// Animated GIF: 256 colours per frame, chosen for it, without opacity; it begins again at its end.
    Gif,
    /// Animated PNG: 8-bit RGB, or RGBA on a transparent background; it begins again at its end.
    Apng,
    /// MP4, which `ffmpeg` makes, a program of its own.
    Mp4,
}

impl AnimationFormat {
    /// Frames per second that every format takes, and players keep to.
    pub const MAX_RATE: u32 = 120;
    /// Of a GIF, whose delays are hundredths of a second, and which players slow down if they are shorter than two of them.
    pub const MAX_GIF_RATE: u32 = 50;

    /// The format that a file name's ending asks for: `.gif`, `.apng` or `.png`, `.mp4`.
    pub fn of(path: &Path) -> Option<Self> {
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
            let problem = "only animated PNG knows opacity: choose a colour, or write .apng".into();
            return Err(Error::Settings { field: "background", problem });
        }
        Ok(())
    }
}

/// A file of moving pictures, written frame by frame. It appears when it is [finished](Self::finish), whole; one that is dropped before
/// leaves nothing.
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
    // Before the file, so that it is dropped first: nothing writes what is removed then.
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
    /// A file for so many `frames`, `rate` per second, in the format that its name's ending asks for.
    ///
    /// # Errors
    /// Of other endings, a rate that the format does not have, no frames at all, a `Transparent` background in a format without opacity,
    /// places that cannot be written, and of `.mp4` where there is no `ffmpeg` on the `PATH`.
    pub fn create(path: &Path, viewport: Viewport, frames: u32, rate: u32, background: Background) -> Result<Self, Error> {
        let Some(format) = AnimationFormat::of(path) else {
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
    /// # Panics
    /// If it is of another size, or one more than there were to be.
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

    /// Closes the file and gives it its name.
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

/// Opaque pixels without their opacity.
fn rgb(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

fn other(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::other(error)
}

#[cfg(test)]
mod tests;
