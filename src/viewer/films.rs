//! Films along key cameras, and the commands that make the same ones.

use super::annotated::annotated;
use super::drawn::CurrentLook;
use super::drawn::PageRenderer;
use super::host::FilmWanted;
use super::keeper::{Maker, Order};
use super::page_camera::{PageCamera, PageProjection};
use super::replies::{FilmState, Format, Picture, Reply, Step};
use super::requests::{Film, FilmFormat, FilmKey, saved_size};
use super::saving::{TRANSFER_NAME, files_of_others, names_of_others, saved_look, without_path};
use crate::camera::{CameraPath, Key};
use crate::error::Error;
use crate::files::Scratch;
use crate::image::Animation;
use crate::transfer::FileFormat;
use crate::viewport::Viewport;
use crate::volume::steps_along;
use serde_json::json;
use std::io::{self, Read};
use std::path::Path;

/// Most key cameras of a film.
const MOST_KEYS: usize = 200;
/// Longest film in seconds.
const LONGEST: f64 = 600.0;
/// Most pixels of all pictures of a film together: 1000 of a megapixel.
const MOST_PIXELS: u64 = 1 << 30;
/// Bytes of a film per message. Pictures of the page are sent between them.
const PART: usize = 256 << 10;
/// Name of the key cameras' file beside the command.
const KEYS_NAME: &str = "layersplat-keys.json";

impl FilmFormat {
    fn file_name(self) -> &'static str {
        match self {
            FilmFormat::Gif => "layersplat.gif",
            FilmFormat::Apng => "layersplat.apng",
            FilmFormat::Mp4 => "layersplat.mp4",
        }
    }

    fn of_message(self) -> Format {
        match self {
            FilmFormat::Gif => Format::Gif,
            FilmFormat::Apng => Format::Apng,
            FilmFormat::Mp4 => Format::Mp4,
        }
    }
}

impl Film {
    /// Size of the finished pictures.
    ///
    /// # Errors
    /// If the film is too large or too long, or its times do not ascend.
    pub fn check(&self) -> Result<Viewport, Error> {
        let refuse = |name, value: String, expected| Err(Error::OutOfRange { name, value, expected });
        let size = saved_size(self.width, self.height, self.samples)?;
        if !(2..=MOST_KEYS).contains(&self.keys.len()) {
            return refuse("keys", self.keys.len().to_string(), "2 to 200 key cameras");
        }
        let ascend =
            self.keys.windows(2).all(|pair| pair[1].time > pair[0].time) && self.keys.iter().all(|key| key.time.is_finite());
        if !ascend || self.duration() > LONGEST {
            return refuse("keys", "these times".into(), "ascending times, at most 600 seconds apart");
        }
        if !(1..=120).contains(&self.rate) {
            return refuse("rate", self.rate.to_string(), "1 to 120 pictures per second; GIF up to 50");
        }
        let pixels = size.pixels() as u64 * u64::from(self.frames());
        if pixels > MOST_PIXELS {
            let expected = "at most 1000 pictures of a megapixel, or as many smaller ones: choose a lower rate, size or duration";
            return refuse("frames", format!("{} of {}x{}", self.frames(), size.width, size.height), expected);
        }
        Ok(size)
    }

    fn duration(&self) -> f64 {
        match self.keys.as_slice() {
            [first, .., last] => last.time - first.time,
            _ => 0.0,
        }
    }

    /// Number of pictures, as of `layersplat rotate --keys`.
    fn frames(&self) -> u32 {
        (self.duration() * f64::from(self.rate)).round() as u32 + 1
    }

    /// The step that each picture shows, as of `layersplat rotate --keys`.
    fn steps(&self) -> Vec<usize> {
        let keys: Vec<(f64, f64)> = self.keys.iter().map(|key| (key.time, key.frame as f64)).collect();
        steps_along(&keys, keys[0].0, keys[0].0 + self.duration(), self.frames())
    }

    /// The step of the first picture.
    pub fn first_step(&self) -> usize {
        self.keys[0].frame
    }

    /// The key cameras as a file of `--keys`, with frames for a sequence.
    fn keys_text(&self, is_sequence: bool) -> String {
        let key = |key: &FilmKey| {
            let PageCamera { azimuth, elevation, roll, center, projection } = key.camera;
            let mut view =
                json!({ "time": key.time, "azimuth": azimuth, "elevation": elevation, "roll": roll, "center": center });
            match projection {
                PageProjection::ParallelScale(scale) => view["parallel_scale"] = scale.into(),
                PageProjection::Perspective([field_of_view, distance]) => {
                    (view["perspective"], view["distance"]) = (field_of_view.into(), distance.into());
                }
            }
            if is_sequence {
                view["frame"] = key.frame.into();
            }
            format!("  {view}")
        };
        format!("[\n{}\n]\n", self.keys.iter().map(key).collect::<Vec<_>>().join(",\n"))
    }
}

impl Maker {
    /// Draws a film as `layersplat rotate --keys` does, and sends it in parts.
    pub(super) fn film(&self, order: &Order, renderer: &mut PageRenderer, film: &Film) -> Result<(), Error> {
        let (scene, size, steps) = (&self.scene, film.check()?, film.steps());
        film.keys.iter().try_for_each(|key| scene.check_step(key.frame))?;
        let key = |key: &FilmKey| Ok(Key { time: key.time, camera: scene.camera(&key.camera)?, orbit: Some(key.camera.orbit()) });
        let keys: Vec<Key> = film.keys.iter().map(key).collect::<Result<_, Error>>()?;
        let cameras = CameraPath::new(keys)?.in_frame(scene.frame()).evenly(film.frames());
        let look = saved_look(&order.look);
        let mut settings = scene.host.settings(&look, None)?;
        // As in `layersplat rotate`, lights stay where the first camera sees them, unless they were told to move with the camera.
        if !look.is_lit_from_camera() {
            settings = settings.with_light_in_world(&cameras[0])?;
        }
        let rendered = Viewport::new(size.width * film.samples, size.height * film.samples)?;
        for camera in &cameras {
            scene.host.require_checked(camera, rendered, &settings)?;
        }
        self.say_film(order, film, size);
        let folder = Scratch::new()?;
        let path = folder.path().join(film.format.file_name());
        let mut animation = Animation::create(&path, size, film.frames(), film.rate, look.background()?).map_err(without_path)?;
        let progress = |state, done| self.outgoing.reply(&Reply::Film { id: film.id, state, done, of: film.frames() });
        let mut changes = steps.clone();
        changes.dedup();
        let mut played = scene.play(changes.split_off(1));
        for (n, camera) in cameras.iter().enumerate() {
            progress(FilmState::Drawing, n as u32);
            if let Some(played) = played.as_mut().filter(|_| n > 0 && steps[n] != steps[n - 1]) {
                renderer.set_volume(&played.next().expect("a step is read for every change")?)?;
            }
            let (Some(frame), _) = renderer.render(camera, rendered, &settings)? else { return Ok(()) };
            let frame = if film.samples > 1 { frame.averaged(film.samples)? } else { frame };
            animation
                .add(&annotated(frame, scene, CurrentLook { look: &look, ..order.now() }, camera, settings.blend, false)?)
                .map_err(without_path)?;
        }
        animation.finish().map_err(without_path)?;
        self.send_parts(&path, film, size)?;
        progress(FilmState::Complete, film.frames());
        Ok(())
    }

    /// Sends the command, its key cameras and its transfer function.
    fn say_film(&self, order: &Order, film: &Film, size: Viewport) {
        let wanted = FilmWanted {
            look: &saved_look(&order.look),
            size,
            samples: film.samples,
            rate: film.rate,
            output: film.format.file_name(),
            keys: KEYS_NAME,
            transfer: TRANSFER_NAME,
            others: &names_of_others(&order.transfers),
            length_units: self.scene.length_units(),
        };
        let line = self.scene.host.film_command_line(&wanted);
        let transfer_text = order.transfers[0].to_text(FileFormat::ParaView);
        self.outgoing.reply(&Reply::FilmCommand {
            id: film.id,
            line: line.as_deref(),
            keys_name: KEYS_NAME,
            keys_text: &film.keys_text(self.scene.steps() > 1),
            transfer_name: TRANSFER_NAME,
            transfer_text: &transfer_text,
            more: &files_of_others(&order.transfers),
        });
    }

    fn send_parts(&self, path: &Path, film: &Film, size: Viewport) -> Result<(), Error> {
        let failed = |e: io::Error| Error::read(Path::new("the film"), e);
        let mut file = std::fs::File::open(path).map_err(failed)?;
        loop {
            let mut bytes = Vec::with_capacity(PART);
            file.by_ref().take(PART as u64).read_to_end(&mut bytes).map_err(failed)?;
            if bytes.is_empty() {
                return Ok(());
            }
            if self.keeper.is_cancelled() {
                return Err(Error::Cancelled { stage: "film" });
            }
            let format = film.format.of_message();
            self.outgoing.picture(&Picture { step: Step::Part, format, id: film.id, size, milliseconds: 0.0, bytes });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(times: &[f64]) -> Film {
        let camera = PageCamera {
            azimuth: 1.0,
            elevation: 0.0,
            roll: 0.0,
            center: [0.0; 3],
            projection: PageProjection::Perspective([30.0, 9.0]),
        };
        let keys = times.iter().map(|&time| FilmKey { time, camera, frame: 0 }).collect();
        Film { id: 1, keys, width: 64, height: 48, samples: 1, rate: 25, format: FilmFormat::Gif }
    }

    #[test]
    fn films_are_bounded() {
        let good = film(&[0.0, 0.5, 2.0]);
        assert_eq!((good.check().unwrap().width, good.frames()), (64, 51));
        assert!(good.keys_text(false).contains(r#""distance":9.0"#) && good.keys_text(false).starts_with("[\n"));
        assert!(good.keys_text(true).contains(r#""frame":0"#) && !good.keys_text(false).contains("frame"));
        let mut timed = film(&[0.0, 1.0]);
        timed.keys[1].frame = 5;
        assert_eq!((timed.steps().len(), timed.steps()[12], timed.steps()[25]), (26, 2, 5));
        for bad in [
            film(&[0.0]),
            film(&[0.0, 0.0]),
            film(&[0.0, f64::NAN]),
            film(&[0.0, f64::INFINITY]),
            film(&[-1e308, 1e308]),
            film(&[0.0, 601.0]),
            film(&(0..201).map(f64::from).collect::<Vec<_>>()),
            Film { rate: 0, ..film(&[0.0, 1.0]) },
            Film { rate: u32::MAX, ..film(&[0.0, 1.0]) },
            Film { samples: 17, ..film(&[0.0, 1.0]) },
            Film { width: 8192, height: 8192, ..film(&[0.0, 1.0]) },
        ] {
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }
}
