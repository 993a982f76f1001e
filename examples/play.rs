//! Plays a sequence, and prints how long reading, uploading and drawing take alone and together.
//!
//!     cargo run --release --example play -- FILE… [x|z]
//!
//! The layer axis, z by default, is that along which the camera looks. Times are medians in milliseconds, of all steps.

use layersplat::volume::Sequence;
use layersplat::{
    Camera, Device, DeviceChoice, Error, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::time::Instant;

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
    let mut renderer = Renderer::new(&Device::open(&DeviceChoice::Default)?, &first, &transfer)?;
    renderer.render(&camera, viewport, &settings)?;

    let steps: Vec<usize> = (0..sequence.len()).collect();
    let (mut read, mut uploaded, mut drawn) = (Vec::new(), Vec::new(), Vec::new());
    for &step in &steps {
        let volume = timed(&mut read, || sequence.step(step))?;
        timed(&mut uploaded, || renderer.set_volume(&volume))?;
        timed(&mut drawn, || renderer.render(&camera, viewport, &settings))?;
    }

    let started = Instant::now();
    for volume in sequence.play(steps.clone()) {
        let volume: Volume = volume?;
        renderer.set_volume(&volume)?;
        renderer.render(&camera, viewport, &settings)?;
    }
    let frame = started.elapsed().as_secs_f64() * 1e3 / steps.len() as f64;

    let [read, uploaded, drawn] = [read, uploaded, drawn].map(median);
    let possible = read.max(uploaded + drawn);
    println!("{} steps, layer axis {}", steps.len(), if along_x { "x" } else { "z" });
    println!("read {read:.1} ms, upload {uploaded:.1} ms, draw {drawn:.1} ms (with all that a new step needs on the device)");
    println!("played: {frame:.1} ms per frame, {:.2} of the speed of the slower thread alone", possible / frame);
    Ok(())
}

/// Adds the time of some work in milliseconds.
fn timed<T>(times: &mut Vec<f64>, work: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let result = work();
    times.push(started.elapsed().as_secs_f64() * 1e3);
    result
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
