//! Where the frames of a sequence go: into one file, or a folder.

use super::options::CameraOptions;
use crate::error::Error;
use crate::image::{Animation, AnimationFormat, Background, Frame};
use std::path::{Path, PathBuf};

/// Endings of files that frames are not written to: a folder of such a name is not what was meant.
const OTHER_FILES: [&str; 9] = ["jpg", "jpeg", "exr", "npy", "webp", "webm", "mov", "mkv", "avi"];

/// A file or a folder that takes frames.
pub(super) enum Film {
    File(Box<Animation>),
    Folder { folder: PathBuf, frames: u32, taken: usize, background: Option<Background> },
}

impl Film {
    /// Files by their ending; what else there is, or is not yet, is a folder.
    pub fn create(output: &Path, options: &CameraOptions, frames: u32, rate: u32) -> Result<Self, Error> {
        let ending = output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let file = !output.is_dir();
        if file && AnimationFormat::from_path(output).is_some() {
            let background = options.background.unwrap_or(Background::BLACK);
            let animation = Animation::create(output, options.size, frames, rate, background)?;
            return Ok(Self::File(Box::new(animation)));
        }
        if file && ending.is_some_and(|ending| OTHER_FILES.contains(&ending.as_str())) {
            let known = "a name ending in .gif, .apng or .mp4, or a folder".into();
            return Err(Error::UnknownName { what: "format of a sequence", name: output.display().to_string(), known });
        }
        if output.exists() && file {
            return Err(Error::write(output, std::io::Error::other("it exists and is no folder")));
        }
        Ok(Self::Folder { folder: output.into(), frames, taken: 0, background: options.background })
    }

    pub fn add(&mut self, frame: &Frame) -> Result<(), Error> {
        match self {
            Self::File(animation) => animation.add(frame),
            Self::Folder { folder, frames, taken, background } => {
                if *taken == 0 {
                    std::fs::create_dir_all(&*folder).map_err(|e| Error::write(folder, e))?;
                }
                let name = frame_name(*taken, *frames);
                *taken += 1;
                frame.save(folder.join(name), *background)
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

/// `frame_0000.png` and so on, with as many digits as the last one needs, so that names sort as numbers do.
fn frame_name(n: usize, frames: u32) -> String {
    let digits = (frames - 1).to_string().len().max(4);
    format!("frame_{n:0digits$}.png")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_sort_as_numbers_do() {
        assert_eq!((frame_name(0, 1), frame_name(9999, 10_000)), ("frame_0000.png".into(), "frame_9999.png".into()));
        for frames in [1, 125, 10_000, 10_001, 100_000] {
            let names: Vec<String> = (0..frames as usize).map(|n| frame_name(n, frames)).collect();
            assert!(names.is_sorted(), "{frames}");
        }
        assert_eq!(frame_name(9, 10_001), "frame_00009.png");
    }
}
