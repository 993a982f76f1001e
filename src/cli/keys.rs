//! Key cameras, and the way between them.

use super::scene::Cameras;
use super::view::View;
use crate::camera::{Camera, CameraPath, Key, Orbit, Projection};
use crate::error::Error;
use serde_json::{Map, Value};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes of the largest file.
const LARGEST: u64 = 1 << 24;
/// Orbits between two keys that pictures are fitted to.
const FITTED: u32 = 24;

/// Key cameras of a file: a JSON list of views, each with a time in seconds.
pub(super) struct Keys {
    path: PathBuf,
    keys: Vec<(f64, View)>,
}

impl Keys {
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = std::fs::File::open(path).map_err(|e| Error::read(path, e))?;
        let mut text = Vec::new();
        file.take(LARGEST + 1).read_to_end(&mut text).map_err(|e| Error::read(path, e))?;
        let wrong = |problem: String| Error::Keys { path: path.into(), problem };
        if text.len() as u64 > LARGEST {
            return Err(wrong(format!("it is larger than {LARGEST} bytes, and no list of key cameras")));
        }
        let list: Vec<Map<String, Value>> =
            serde_json::from_slice(&text).map_err(|e| wrong(format!("it is no JSON list of key cameras: {e}")))?;
        let key = |(n, mut fields): (usize, Map<String, Value>)| {
            let wrong = |problem| wrong(format!("key {}: {problem}", n + 1));
            let time = fields.remove("time").and_then(|time| time.as_f64());
            let time = time.ok_or_else(|| wrong(r#"it has no time: give "time": SECONDS"#.into()))?;
            Ok((time, View::of(fields).map_err(wrong)?))
        };
        let keys: Vec<(f64, View)> = list.into_iter().enumerate().map(key).collect::<Result<_, Error>>()?;
        if keys.len() < 2 {
            return Err(wrong(format!("it has {} key cameras: give at least 2", keys.len())));
        }
        if let Some(n) = (1..keys.len()).find(|&n| keys[n].0 <= keys[n - 1].0) {
            return Err(wrong(format!("key {}: its time, {}, is not after {}", n + 1, keys[n].0, keys[n - 1].0)));
        }
        Ok(Self { path: path.into(), keys })
    }

    /// Seconds from the first to the last.
    pub fn duration(&self) -> f64 {
        self.keys[self.keys.len() - 1].0 - self.keys[0].0
    }

    /// Cameras along the way, evenly in time, from the first key to the last.
    pub fn cameras(&self, cameras: &Cameras, base: Orbit, frames: u32) -> Result<Vec<Camera>, Error> {
        let wrong =
            |n: usize, problem: String| Error::Keys { path: self.path.clone(), problem: format!("key {}: {problem}", n + 1) };
        let shared = self.sharing(cameras, base);
        let key = |(n, (time, view)): (usize, &(f64, View))| {
            let camera = view.camera(&shared, base).map_err(|problem| wrong(n, problem))?;
            Ok(Key { time: *time, camera, orbit: view.orbit(base) })
        };
        let keys: Vec<Key> = self.keys.iter().enumerate().map(key).collect::<Result<_, Error>>()?;
        let path = CameraPath::new(keys).map_err(|e| Error::Keys { path: self.path.clone(), problem: e.to_string() })?;
        let (from, to) = path.span();
        let last = f64::from(frames.max(2) - 1);
        Ok((0..frames).map(|n| path.at(from + (to - from) * f64::from(n) / last)).collect())
    }

    /// What keys do not say is the same for all of them: point in the middle, scale and distance fit what is visible on the way.
    fn sharing<'a>(&self, cameras: &Cameras<'a>, base: Orbit) -> Cameras<'a> {
        let orbits: Vec<Orbit> = self.keys.iter().filter_map(|(_, view)| view.orbit(base)).collect();
        let between =
            orbits.windows(2).flat_map(|pair| (0..FITTED).map(|n| mixed(pair[0], pair[1], f64::from(n) / f64::from(FITTED))));
        let Some(fitted) = cameras.sequence(between.chain(orbits.last().copied())).first().copied() else {
            return cameras.clone();
        };
        let mut options = cameras.options().clone();
        options.center = Some(fitted.focal_point);
        match fitted.projection {
            Projection::Parallel { scale } => options.parallel_scale = Some(scale),
            Projection::Perspective { .. } => options.distance = Some(fitted.position.distance(fitted.focal_point)),
        }
        cameras.with(options)
    }
}

fn mixed(a: Orbit, b: Orbit, t: f64) -> Orbit {
    let mix = |a: f64, b: f64| a + (b - a) * t;
    Orbit { azimuth: mix(a.azimuth, b.azimuth), elevation: mix(a.elevation, b.elevation), roll: mix(a.roll, b.roll) }
}
