//! Processes that MPI started together: teams, each of which renders a picture at a time.

use crate::camera::Camera;
use crate::cli::options::VolumeOptions;
use crate::cli::standard::is_input;
use crate::distributed::mpi::{self, Threading, environment::Universe};
use crate::distributed::{DistributedError, Group, bytes_in_parts, check_view};
use crate::error::Error;
use crate::image::Frame;
use crate::memory;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::{Description, Together, Volume};
use clap::Args;
use std::cell::OnceCell;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

/// Bytes of memory per byte of voxels that a process needs to render a volume alone: on the host and on the device, in two layouts.
const NEEDED: u64 = 4;

/// How long others wait with what they have to say where they end before the first one.
const FIRST_SPEAKS: Duration = Duration::from_millis(500);
/// As Rust ends a process.
const PANICKED: u8 = 101;

/// How pictures are shared out.
#[derive(Args, Clone)]
#[command(next_help_heading = "Device")]
pub(in crate::cli) struct TeamOptions {
    /// Under mpirun, processes that render a picture together, each a part of the volume, while others render other pictures [default: of
    /// sequences as many as the volume needs memory of, of single pictures all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ranks_per_picture: Option<u32>,
}

/// The processes of a run.
#[derive(Clone)]
pub(in crate::cli) struct Processes {
    /// Once there are teams. It ends before MPI does.
    team: Rc<OnceCell<Team>>,
    world: Option<World>,
}

/// Those that render a picture together with this process.
struct Team {
    group: Group,
    teams: usize,
    /// Processes of a team.
    each: usize,
    /// Which of the teams this is; more than there are of those that have no picture.
    number: usize,
}

#[derive(Clone)]
struct World {
    group: Group,
    /// MPI ends with it.
    _universe: Rc<Universe>,
}

impl Processes {
    /// Starts MPI where it started this process.
    pub fn start() -> Result<Self, Error> {
        if super::started().is_none() {
            return Ok(Self::alone());
        }
        let (universe, _) = mpi::initialize_with_threading(Threading::Serialized).expect("MPI is initialised here alone");
        let group = Group::new(&universe.world())?;
        let usual = std::panic::take_hook();
        // Others would wait for this one, and MPI's end for them.
        std::panic::set_hook(Box::new(move |panic| {
            usual(panic);
            Group::abort(PANICKED);
        }));
        Ok(Self { world: Some(World { group, _universe: Rc::new(universe) }), ..Self::alone() })
    }

    /// Where the command is one of a process.
    pub fn alone() -> Self {
        Self { world: None, team: Rc::default() }
    }

    /// What the command ends with where it fails: on all processes, with the message of one.
    pub fn fail(self, message: &str, error: &Error, code: u8) -> ExitCode {
        let Some(World { group, .. }) = &self.world else {
            eprintln!("layersplat: {message}");
            return ExitCode::from(code);
        };
        // What a team has agreed on, all of it know; the others wait for what will not come.
        let agreed = matches!(error, Error::Distributed(DistributedError::Rank { .. }));
        let Some(team) = self.team.get().map(|team| &team.group).filter(|_| agreed) else {
            // What all find out for themselves the first one says, and ends the others before they do.
            if !group.leads() {
                std::thread::sleep(FIRST_SPEAKS);
            }
            eprintln!("layersplat: {message}");
            Group::abort(code);
        };
        if team.leads() {
            eprintln!("layersplat: {message}");
        }
        // That of the process that failed.
        let code = team.max(code.into()) as u8;
        if team.size() < group.size() {
            Group::abort(code);
        }
        ExitCode::from(code)
    }

    /// Whether this process writes what all have made.
    pub fn leads(&self) -> bool {
        self.world.as_ref().is_none_or(|world| world.group.leads())
    }

    /// Whether this process has its team's pictures.
    pub fn leads_team(&self) -> bool {
        self.team().is_none_or(Group::leads)
    }

    /// How many processes there are, and how many teams.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.world.as_ref().map(|world| (world.group.size(), self.teams()))
    }

    fn teams(&self) -> usize {
        self.team.get().map_or(1, |team| team.teams)
    }

    /// The others of the team, if it has any: they share the volume.
    pub fn team(&self) -> Option<&Group> {
        self.team.get().map(|team| &team.group).filter(|team| team.size() > 1)
    }

    /// Makes teams, once, for so many pictures of a volume: of as few processes as have the memory for it.
    pub fn make_teams(
        &self,
        options: &TeamOptions,
        volume: &VolumeOptions,
        size: Viewport,
        pictures: usize,
    ) -> Result<(), Error> {
        let Some(World { group, .. }) = &self.world else { return Ok(()) };
        let per_process = memory::available() / group.on_this_machine() as u64;
        let bytes = bytes_in_parts(&volume.volume, &volume.options(Some(size))?);
        let needed = bytes.map_or(1, |bytes| (NEEDED * bytes).div_ceil(per_process.max(1)));
        // All processes must come to the same, whatever memory each has found.
        let needed = group.max(needed);
        let all = group.size();
        let each = match options.ranks_per_picture {
            Some(each) => (each as usize).clamp(1, all),
            None if pictures == 1 => all,
            // What would be idle helps.
            None => (needed as usize).clamp(1, all).max(all / pictures.max(1)),
        };
        // Those that are left over have no picture.
        let (teams, number) = ((all / each).min(pictures).max(1), group.rank() / each);
        let told = bytes.map_or("which cannot be read in parts".into(), |bytes| format!("of {bytes} bytes"));
        if self.leads() {
            tracing::info!(
                "{all} processes in {teams} teams of {each}, each for a picture at a time: the volume, {told}, needs the memory of \
                 {needed}, with {per_process} bytes each"
            );
        }
        self.team.get_or_init(|| Team { group: group.split(number), teams, each, number });
        Ok(())
    }

    /// Does what need not be done by several at once: first by one of a team, then by the others.
    pub fn in_turn(&self, mut done: impl FnMut() -> Result<(), Error>) -> Result<(), Error> {
        let Some(Team { group: team, .. }) = self.team.get() else { return done() };
        let first = if team.leads() { done() } else { Ok(()) };
        team.agree(first)?;
        team.agree(if team.leads() { Ok(()) } else { done() })
    }

    /// What a process has come to, if all of its team have.
    pub fn agree<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        match self.team.get() {
            Some(team) => team.group.agree(result),
            None => result,
        }
    }

    /// Opens a volume, of which each process of a team reads its part.
    pub fn open(&self, options: &VolumeOptions, size: Option<Viewport>, most: Option<u64>) -> Result<Volume<'static>, Error> {
        if self.counts().is_some_and(|(processes, _)| processes > 1) && is_input(&options.volume) {
            let problem = "standard input is the first process's alone: name a file, which all of them can read".into();
            return Err(Error::Settings { field: "volume", problem });
        }
        let Some(team) = self.team() else { return self.agree(options.open(size, most)) };
        if most.is_some() {
            let problem =
                "a volume that several processes share is not streamed as well: leave it out, or choose --ranks-per-picture 1";
            return Err(Error::Settings { field: "memory", problem: problem.into() });
        }
        options.with_background(team.open(&options.volume, &options.options(size)?)?)
    }

    /// Refuses views that the processes of a team cannot share.
    pub fn check_views(
        &self,
        volume: &Description,
        cameras: &[Camera],
        size: Viewport,
        settings: &Settings,
    ) -> Result<(), Error> {
        let unshared = |e: Error| {
            let problem = format!("processes cannot share this view: {e}; or choose --ranks-per-picture 1");
            Error::Settings { field: "processes", problem }
        };
        if self.team().is_none() {
            return Ok(());
        }
        cameras.iter().try_for_each(|camera| check_view(volume, camera, size, settings).map_err(unshared))
    }

    /// Whether picture `n` of several is this team's.
    pub fn owns(&self, n: usize) -> bool {
        self.team.get().is_none_or(|team| n % team.teams == team.number)
    }

    /// Picture `n`, on the leader of all: drawn by its team, whose leader has it. All call it, in the order of the pictures.
    pub fn collected(&self, n: usize, frame: Option<Frame>, size: Viewport) -> Option<Frame> {
        let Some(World { group, .. }) = &self.world else { return frame };
        let owner = n % self.teams();
        if owner == 0 {
            return frame;
        }
        if group.leads() {
            let bytes = group.receive(owner * self.team.get().map_or(1, |team| team.each));
            let mut samples = vec![[0f32; 4]; size.pixels()];
            samples.as_flattened_mut().iter_mut().zip(bytes.chunks_exact(4)).for_each(|(number, bytes)| {
                *number = f32::from_ne_bytes(bytes.try_into().expect("four bytes"));
            });
            return Some(Frame::new(size, samples));
        }
        if let Some(frame) = frame {
            group.send(0, bytemuck::cast_slice(frame.pixels()));
        }
        None
    }

    /// Numbers of all processes, one after the other.
    pub fn gathered(&self, numbers: Vec<f64>) -> Vec<f64> {
        self.world.as_ref().map_or(numbers.clone(), |world| world.group.gather(&numbers))
    }

    /// Gives all what the leader has read.
    pub fn told(&self, read: impl FnOnce() -> Result<Vec<u8>, Error>) -> Result<Vec<u8>, Error> {
        let Some(World { group, .. }) = &self.world else { return read() };
        let mut bytes = group.agree(if group.leads() { read() } else { Ok(Vec::new()) })?;
        group.broadcast(0, &mut bytes);
        Ok(bytes)
    }

    /// Waits for all.
    pub fn wait(&self) {
        self.world.iter().for_each(|world| world.group.wait());
    }
}
