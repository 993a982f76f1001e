//! `layersplat view`.

mod address;
mod arguments;
mod first_fields;
mod given;
mod host;
mod open;
mod opening;
mod python;

use super::cameras::Cameras;
use super::command_line;
use super::options::Fit;
use super::orientation::OBLIQUE;
use super::processes::Processes;
use super::scene::{OpenedScene, SceneOptions};
use super::standard;
use crate::error::Error;
use crate::image::Background;
use crate::layers::Kernel;
use crate::renderer::Channel;
use crate::viewer::{Drawn, Look, Opening, PageCamera, Server, Stop, Time};
use crate::volume::{Contents, Sequence};
use address::AddressOptions;
use given::GivenOptions;
use host::PageHost;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneOptions,
    /// Further volumes of a sequence in time, in its order
    #[arg(value_name = "VOLUME", help_heading = "Volume")]
    more: Vec<PathBuf>,
    #[command(flatten)]
    address: AddressOptions,
}

impl Arguments {
    /// The volume as a sequence, if it has several steps and none is chosen.
    fn sequence(&self, processes: &Processes) -> Result<Option<Sequence>, Error> {
        let SceneOptions { volume, camera, bounds, channels, colors, labels, .. } = &self.scene;
        let is_several = !self.more.is_empty();
        if processes.counts().is_some() {
            let problem = "a sequence is shown by one process only: start layersplat without mpirun";
            return if is_several { Err(Error::volume(&volume.volume, problem)) } else { Ok(None) };
        }
        let is_one = !channels.are_given() && !colors.are_given() && !labels.is_given();
        if is_several && !is_one {
            let problem = "several fields, colours and labels are shown at one moment: name one volume";
            return Err(Error::Settings { field: "channels", problem: problem.into() });
        }
        if !is_several && (!is_one || volume.has_frame() || standard::is_input(&volume.volume)) {
            return Ok(None);
        }
        if !is_several && (volume.declares_labels(camera.size) || volume.declares_colors(camera.size)) {
            return Ok(None);
        }
        let sequence = volume.sequence(&self.more, None, Some(camera.size), bounds.memory)?;
        if sequence.len() == 1 {
            return Ok(None);
        }
        labels.masked_steps(sequence, volume.placement()).map(Some)
    }

    /// Whether the file has several channels, which are shown together since no option chooses. Those of a sequence are not: several fields
    /// are shown at one moment. `even_vectors`: also components of vectors.
    fn takes_all_channels(&self, even_vectors: bool) -> bool {
        let SceneOptions { volume, camera, bounds, channels, colors, labels, .. } = &self.scene;
        let is_chosen = !self.more.is_empty() || channels.are_given() || colors.are_given() || labels.is_given();
        if is_chosen || bounds.memory.is_some() {
            return false;
        }
        let several = |contents: &Contents| {
            (2..=Channel::MOST).contains(&contents.channels) && contents.frames == 1 && !contents.are_colors
        };
        let contents = volume.contents(camera.size).filter(|contents| several(contents) && (even_vectors || !contents.is_vector));
        contents.is_some() && !volume.declares_labels(camera.size)
    }

    /// Opens the volume, or the first step of a sequence.
    fn open(&self, processes: &Processes) -> Result<(OpenedScene, Option<Sequence>), Error> {
        let refuse = || {
            let problem = "the viewer draws no surfaces yet: use render, rotate or views".into();
            Err(Error::Settings { field: "surface", problem })
        };
        if self.scene.has_surfaces() {
            return refuse();
        }
        let sequence = self.sequence(processes)?;
        let scene = match &sequence {
            Some(sequence) => OpenedScene::open_sequence(&self.scene, processes, sequence, &[], None)?,
            None => OpenedScene::open(&self.scene, processes)?,
        };
        if scene.surfaces.is_empty() { Ok((scene, sequence)) } else { refuse() }
    }
}

pub(super) fn run(arguments: Arguments, processes: &Processes) -> Result<ExitCode, Error> {
    let ending = Ending::default();
    // Before OpenCL: LLVM's handlers, which PoCL installs, would end the process if these came after them.
    #[cfg(unix)]
    ending.listen();
    // Fails before the volume is read.
    arguments.address.check()?;
    let listener = arguments.address.bind()?;
    let admission = arguments.address.admission(&listener)?;
    let words = command_line::words();
    let (arguments, words) =
        if processes.counts().is_some() { (arguments, words) } else { opening::with_all_channels(arguments, words, false)? };
    let given = GivenOptions::of(words);
    let (scene, sequence) = arguments.open(processes)?;
    let offered = opening::offered_by(&arguments.scene.volume);
    let opening = opening_of(&arguments.scene, scene, sequence)?;
    if let Ok(program) = std::env::current_exe() {
        // PoCL draws no frame of any page while this process compiles.
        opening.device.set_compiler_command(move || std::process::Command::new(&program));
    }
    let host = PageHost::new(given, arguments.scene.device, &opening).offering(&offered);
    let server = Server::new(opening, Box::new(host), admission.access, listener)?;
    let opened = arguments.address.announce(&admission.address)?;
    ending.is_serving.store(true, Ordering::SeqCst);
    server.run(&ending.stop)?;
    // Removes the file that led the browser here.
    drop(opened);
    // Programs may still be built in the background.
    #[cfg(unix)]
    super::signals::exit_now(0);
    #[cfg(not(unix))]
    Ok(ExitCode::SUCCESS)
}

/// What a signal does: it ends the server cleanly, or the process if the server does not run yet.
#[derive(Clone, Default)]
struct Ending {
    stop: Stop,
    is_serving: Arc<AtomicBool>,
}

impl Ending {
    #[cfg(unix)]
    fn listen(&self) {
        let Self { stop, is_serving } = self.clone();
        super::signals::on_first(move |signal| match is_serving.load(Ordering::SeqCst) {
            true => stop.stop(),
            false => super::signals::exit_now(128 + signal),
        });
    }
}

/// The first view: that of `render` with the same options.
fn opening_of(options: &SceneOptions, mut scene: OpenedScene, sequence: Option<Sequence>) -> Result<Opening, Error> {
    let orientation = scene.orientation(&options.camera);
    let cameras = Cameras::new(&options.camera, &scene, Fit::Visible, orientation);
    let orbit = cameras.angles().or_all_of(OBLIQUE);
    let still = cameras.still(orbit);
    let camera = PageCamera::new(&still, orbit);
    let given = &options.camera;
    let camera_is_given = given.parallel_scale.is_some() || given.distance.is_some() || given.center.is_some();
    let mut look = look(options, &scene);
    // As in films, the light of the studio stays in the world, unless it was told to move with the camera.
    if look.studio.is_some() && !options.quality.light.moves_with_camera() {
        look = look.with_light_in_world(&still)?;
    }
    let (drawn, channels) = first_fields::drawn_of(&mut scene)?;
    look.channels = channels;
    drawn.kind().check(&scene.settings)?;
    let OpenedScene { volume, transfer, device, time_limit, overview, .. } = scene;
    let &Contents { channel, channels, magnitude, .. } = volume.contents();
    let is_one = channels > 1 && !magnitude && matches!(drawn, Drawn::One);
    let notes = is_one.then(|| {
        format!("This is channel {channel} of {channels}, from 0. Start with --channel N for another, or with --channels N,N")
    });
    let notes = notes.into_iter().collect();
    let time = sequence.zip(overview).map(|(sequence, overview)| Time { sequence, overview });
    Ok(Opening { volume, time, transfer, drawn, device, orientation, camera, camera_is_given, look, time_limit, notes })
}

fn look(options: &SceneOptions, scene: &OpenedScene) -> Look {
    let (lo, hi) = scene.values().range();
    let background = options.camera.background.unwrap_or(Background::BLACK);
    let look = Look::of(&scene.settings, background, (lo + hi) / 2.0, scene.volume.grid().dims());
    // The page does not change the kernel of ray casting.
    let kernel = options.quality.given_kernel().filter(|kernel| Kernel::OF_LAYERS.contains(kernel));
    Look { quality: options.quality.given_quality(), kernel, ..look }
}
