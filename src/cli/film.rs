//! Output of a sequence: an animation file, or a folder of numbered pictures.

use super::options::CameraOptions;
use crate::error::Error;
use crate::image::{Animation, AnimationFormat, Background, Encoding, Frame, ImageFormat};
use std::path::{Path, PathBuf};

/// Unsupported file name extensions. A folder with such a name is surely not intended.
const OTHER_FILES: [&str; 11] = ["jpg", "jpeg", "tif", "tiff", "exr", "npy", "webp", "webm", "mov", "mkv", "avi"];

/// Destination of the frames.
pub(super) enum Film {
    File(Box<Animation>),
    Folder { folder: PathBuf, frames: u32, written: usize, background: Option<Background>, encoding: Encoding },
}

impl Film {
    /// Creates a file if the extension is that of an animation, else a folder. The folder itself is created with the first frame.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for the extension of another file format, [`Error::Settings`] for an encoding that animations or PNG do not
    /// have, [`Error::Write`] if the output exists and is not a folder.
    pub fn create(output: &Path, options: &CameraOptions, encoding: Encoding, frames: u32, rate: u32) -> Result<Self, Error> {
        let extension = output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let is_file = !output.is_dir();
        if is_file && AnimationFormat::from_path(output).is_some() {
            if let Some(field) = encoding.first_given() {
                let problem = "animations have rounded 8-bit colours and no resolution: omit it, or write a folder of pictures";
                return Err(Error::Settings { field, problem: problem.into() });
            }
            let background = options.background.unwrap_or(Background::BLACK);
            let animation = Animation::create(output, options.size, frames, rate, background)?;
            return Ok(Self::File(Box::new(animation)));
        }
        if is_file && extension.is_some_and(|extension| OTHER_FILES.contains(&extension.as_str())) {
            let known = "a name ending in .gif, .apng or .mp4, or a folder".into();
            return Err(Error::UnknownName { what: "format of a sequence", name: output.display().to_string(), known });
        }
        if output.exists() && is_file {
            return Err(Error::write(output, std::io::Error::other("it exists and is not a folder")));
        }
        encoding.check(ImageFormat::Png)?;
        Ok(Self::Folder { folder: output.into(), frames, written: 0, background: options.background, encoding })
    }

    pub fn add(&mut self, frame: &Frame) -> Result<(), Error> {
        match self {
            Self::File(animation) => animation.add(frame),
            Self::Folder { folder, frames, written, background, encoding } => {
                if *written == 0 {
                    std::fs::create_dir_all(&*folder).map_err(|e| Error::write(folder, e))?;
                }
                let name = frame_name(*written, *frames);
                *written += 1;
                frame.save_encoded(folder.join(name), *background, encoding, None)
            }
        }
    }

    pub fn finish(self) -> Result<(), Error> {
        match self {
            Self::File(animation) => animation.finish(),
            Self::Folder { .. } => Ok(()),
        }
    }
}

/// `frame_0000.png` and so on, with enough digits for the last frame, so that names sort by number.
fn frame_name(n: usize, frames: u32) -> String {
    let digits = (frames - 1).to_string().len().max(4);
    format!("frame_{n:0digits$}.png")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_sort_by_number() {
        assert_eq!((frame_name(0, 1), frame_name(9999, 10_000)), ("frame_0000.png".into(), "frame_9999.png".into()));
        for frames in [1, 125, 10_000, 10_001, 100_000] {
            let names: Vec<String> = (0..frames as usize).map(|n| frame_name(n, frames)).collect();
            assert!(names.is_sorted(), "{frames}");
        }
        assert_eq!(frame_name(9, 10_001), "frame_00009.png");
    }
}
