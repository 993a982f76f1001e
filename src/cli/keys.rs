//! Key cameras and the path between them.

use super::cameras::Cameras;
use super::json_view::View;
use crate::camera::{Camera, CameraPath, Key, Orbit, Projection};
use crate::error::Error;
use crate::volume::steps_along;
use serde_json::{Map, Value};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file in bytes.
const MAX_BYTES: u64 = 1 << 24;
/// Orbits sampled between two keys to fit the pictures.
const FIT_SAMPLES: u32 = 24;

/// Key cameras from a file: a JSON list of views, each with a time in seconds, and possibly a frame of a sequence.
pub(super) struct Keys {
    path: PathBuf,
    keys: Vec<(f64, View)>,
    /// Number of the key, time and frame of each key that has a frame.
    frames: Vec<(usize, f64, f64)>,
}

impl Keys {
    /// Reads at least two key cameras with ascending times.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Keys`] for a malformed list.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = std::fs::File::open(path).map_err(|e| Error::read(path, e))?;
        let mut text = Vec::new();
        file.take(MAX_BYTES + 1).read_to_end(&mut text).map_err(|e| Error::read(path, e))?;
        let wrong = |problem: String| Error::Keys { path: path.into(), problem };
        if text.len() as u64 > MAX_BYTES {
            return Err(wrong(format!("it is larger than {MAX_BYTES} bytes, too large for a list of key cameras")));
        }
        let list: Vec<Map<String, Value>> =
            serde_json::from_slice(&text).map_err(|e| wrong(format!("it is not a JSON list of key cameras: {e}")))?;
        let mut frames = Vec::new();
        let key = |(n, mut fields): (usize, Map<String, Value>)| {
            let wrong = |problem| wrong(format!("key {}: {problem}", n + 1));
            let time = fields.remove("time").and_then(|time| time.as_f64());
            let time = time.ok_or_else(|| wrong(r#"it has no time: add "time": SECONDS"#.into()))?;
            if let Some(frame) = fields.remove("frame") {
                let not_one = || wrong(format!("its frame is {frame}: expected a number from 0"));
                frames.push((n, time, frame.as_f64().filter(|frame| *frame >= 0.0).ok_or_else(not_one)?));
            }
            Ok((time, View::from_fields(fields).map_err(wrong)?))
        };
        let keys: Vec<(f64, View)> = list.into_iter().enumerate().map(key).collect::<Result<_, Error>>()?;
        if keys.len() < 2 {
            return Err(wrong(format!("it has {} key cameras: at least 2 are needed", keys.len())));
        }
        if let Some(n) = (1..keys.len()).find(|&n| keys[n].0 <= keys[n - 1].0) {
            return Err(wrong(format!("key {}: its time, {}, is not after {}", n + 1, keys[n].0, keys[n - 1].0)));
        }
        Ok(Self { path: path.into(), keys, frames })
    }

    /// Time from the first to the last key in seconds.
    pub fn duration(&self) -> f64 {
        self.keys[self.keys.len() - 1].0 - self.keys[0].0
    }

    /// Whether keys have frames of a sequence.
    pub fn have_frames(&self) -> bool {
        !self.frames.is_empty()
    }

    /// The step of a sequence of `steps` that each of `count` pictures shows: linear in time between the frames of keys, rounded to the
    /// nearest step, and constant before the first and after the last key that has a frame.
    ///
    /// # Errors
    /// [`Error::Keys`] for a frame that the sequence does not have.
    pub fn steps(&self, count: u32, steps: usize) -> Result<Vec<usize>, Error> {
        let last = steps - 1;
        if let Some((n, _, frame)) = self.frames.iter().find(|(_, _, frame)| *frame > last as f64) {
            let problem = format!("key {}: its frame, {frame}, is not in the sequence, whose frames are 0 to {last}", n + 1);
            return Err(Error::Keys { path: self.path.clone(), problem });
        }
        let frames: Vec<(f64, f64)> = self.frames.iter().map(|&(_, time, frame)| (time, frame)).collect();
        let start = self.keys[0].0;
        Ok(steps_along(&frames, start, start + self.duration(), count))
    }

    /// Cameras along the path, evenly spaced in time from the first key to the last.
    pub fn cameras(&self, cameras: &Cameras, default: Orbit, frames: u32) -> Result<Vec<Camera>, Error> {
        let wrong =
            |n: usize, problem: String| Error::Keys { path: self.path.clone(), problem: format!("key {}: {problem}", n + 1) };
        let shared = self.with_shared_fit(cameras, default);
        let key = |(n, (time, view)): (usize, &(f64, View))| {
            let camera = view.camera(&shared, default).map_err(|problem| wrong(n, problem))?;
            Ok(Key { time: *time, camera, orbit: view.orbit(cameras, default) })
        };
        let keys: Vec<Key> = self.keys.iter().enumerate().map(key).collect::<Result<_, Error>>()?;
        let path = CameraPath::new(keys).map_err(|e| Error::Keys { path: self.path.clone(), problem: e.to_string() })?;
        Ok(path.in_frame(cameras.orientation().frame()).evenly(frames))
    }

    /// Values for what keys omit, equal for all keys: centre, scale and distance fit the visible part along the whole path.
    fn with_shared_fit(&self, cameras: &Cameras, default: Orbit) -> Cameras {
        let orbits: Vec<Orbit> = self.keys.iter().filter_map(|(_, view)| view.orbit(cameras, default)).collect();
        let mix = |pair: &[Orbit], n: u32| interpolate(pair[0], pair[1], f64::from(n) / f64::from(FIT_SAMPLES));
        let between = orbits.windows(2).flat_map(|pair| (0..FIT_SAMPLES).map(move |n| mix(pair, n)));
        let Some(fitted) = cameras.sequence(between.chain(orbits.last().copied())).first().copied() else {
            return cameras.clone();
        };
        let mut options = cameras.options().clone();
        options.center = Some(fitted.focal_point);
        match fitted.projection {
            Projection::Parallel { scale } => options.parallel_scale = Some(scale),
            Projection::Perspective { .. } => options.distance = Some(fitted.position.distance(fitted.focal_point)),
        }
        cameras.with_options(options)
    }
}

fn interpolate(a: Orbit, b: Orbit, t: f64) -> Orbit {
    let mix = |a: f64, b: f64| a + (b - a) * t;
    Orbit { azimuth: mix(a.azimuth, b.azimuth), elevation: mix(a.elevation, b.elevation), roll: mix(a.roll, b.roll) }
}
