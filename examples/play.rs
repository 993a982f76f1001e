//! Plays a sequence, and prints how long reading, uploading and drawing take alone and together.
//!
//!     cargo run --release --example play -- FILE… [x|z]
//!
//! The layer axis, z by default, is that along which the camera looks. Every ten steps are played in three ways, by turns: one thing after the
//! other; read ahead on another thread ([`Sequence::play`]); and read and uploaded ahead. Times are medians over all steps, in milliseconds.

use layersplat::renderer::UploadedVolume;
use layersplat::volume::Sequence;
use layersplat::{Camera, Device, DeviceChoice, Error, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport};
use std::collections::BTreeMap;
use std::sync::mpsc::sync_channel;
use std::time::Instant;

/// Steps that are played in one way before the next.
const TURN: usize = 10;

/// Times by what was done.
#[derive(Default)]
struct Times(BTreeMap<&'static str, Vec<f64>>);

impl Times {
    fn add(&mut self, what: &'static str, milliseconds: f64) {
        self.0.entry(what).or_default().push(milliseconds);
    }

    fn of<T>(&mut self, what: &'static str, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let result = work();
        self.add(what, started.elapsed().as_secs_f64() * 1e3);
        result
    }

    fn median(&self, what: &str) -> f64 {
        let mut times = self.0[what].clone();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }
}

fn main() -> Result<(), Error> {
    let mut files: Vec<String> = std::env::args().skip(1).collect();
    let along_x = files.last().is_some_and(|last| last == "x");
    files.retain(|file| !["x", "z"].contains(&file.as_str()));
    let sequence = Sequence::open(&files, &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&sequence.overview()?);
    let first = sequence.step(0)?;
    let viewport = Viewport::new(512, 512)?;
    let orbit = Orbit { azimuth: if along_x { 80.0 } else { 10.0 }, elevation: 10.0, roll: 0.0 };
    let camera = Camera::fit_parallel(first.grid().centre(), first.grid().diagonal(), viewport, orbit);
    let settings = Settings::default();
    let device = Device::open(&DeviceChoice::Default)?;
    let mut renderer = Renderer::new(&device, &first, &transfer)?;
    renderer.render(&camera, viewport, &settings)?;

    let steps: Vec<usize> = (0..sequence.len()).collect();
    let mut times = Times::default();
    for steps in steps.chunks(TURN) {
        for &step in steps {
            let volume = times.of("read", || sequence.step(step))?;
            times.of("upload", || renderer.set_volume(&volume))?;
            times.of("draw", || renderer.render(&camera, viewport, &settings))?;
        }
        renderer.measure(true);
        for &step in steps {
            renderer.set_volume(&sequence.step(step)?)?;
            let (_, report) = renderer.render(&camera, viewport, &settings)?;
            for (stage, milliseconds) in report.measured.unwrap_or_default().stages {
                times.add(stage, milliseconds);
            }
        }
        renderer.measure(false);
        let mut playback = sequence.play(steps.to_vec());
        for _ in steps {
            times.of("played", || {
                renderer.set_volume(&playback.next().expect("a step")?)?;
                renderer.render(&camera, viewport, &settings)
            })?;
        }
        std::thread::scope(|threads| -> Result<(), Error> {
            let (sender, receiver) = sync_channel(0);
            let (sequence, device) = (&sequence, &device);
            threads.spawn(move || {
                for volume in sequence.play(steps.to_vec()) {
                    if sender.send(volume.and_then(|volume| UploadedVolume::new(device, &volume))).is_err() {
                        break;
                    }
                }
            });
            for _ in steps {
                times.of("uploaded ahead", || {
                    renderer.set_uploaded_volume(&receiver.recv().expect("a step")?)?;
                    renderer.render(&camera, viewport, &settings)
                })?;
            }
            Ok(())
        })?;
    }

    println!("{} steps, layer axis {}", steps.len(), if along_x { "x" } else { "z" });
    for (what, _) in times.0.iter().filter(|(what, _)| !["played", "uploaded ahead"].contains(what)) {
        println!("  {what}: {:.1} ms", times.median(what));
    }
    let possible = times.median("read").max(times.median("upload") + times.median("draw"));
    for what in ["played", "uploaded ahead"] {
        let frame = times.median(what);
        println!("{what}: {frame:.1} ms per frame, {:.2} of 1 / max(read, upload + draw)", possible / frame);
    }
    Ok(())
}
