//! Several processes started by MPI, in teams. Each team renders a picture at a time.

use crate::camera::Camera;
use crate::cli::options::VolumeOptions;
use crate::cli::standard::is_input;
use crate::distributed::mpi::{self, Threading, environment::Universe};
use crate::distributed::{DistributedError, Group, bytes_in_parts, check_view};
use crate::error::Error;
use crate::image::Frame;
use crate::memory;
use crate::panics;
use crate::renderer::SeenVolume;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::{Collective, Volume};
use clap::Args;
use std::cell::OnceCell;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

/// Bytes of memory per byte of voxels that a process needs to render a volume alone: on the host and on the device, in two
/// layouts.
const MEMORY_FACTOR: u64 = 4;

/// Delay before processes other than the leader print an error, so that the leader reports common errors once.
const LEADER_HEAD_START: Duration = Duration::from_millis(500);
/// Exit code of a panic in Rust.
const PANICKED: u8 = 101;

/// Distribution of pictures among processes.
#[derive(Args, Clone)]
#[command(next_help_heading = "Device")]
pub(in crate::cli) struct TeamOptions {
    /// MPI processes that share a picture, each with a part of the volume [default: as few as memory allows; single pictures:
    /// all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ranks_per_picture: Option<u32>,
}

/// The processes of a run.
#[derive(Clone)]
pub(in crate::cli) struct Processes {
    /// Set by `make_teams`. Declared first, because it must be dropped before MPI is finalised.
    team: Rc<OnceCell<Team>>,
    world: Option<World>,
}

/// The processes that render a picture together with this one.
struct Team {
    group: Group,
    /// Number of teams.
    teams: usize,
    /// Processes per team.
    each: usize,
    /// Index of this team. Processes left over have indices of `teams` or more and render nothing.
    number: usize,
}

#[derive(Clone)]
struct World {
    group: Group,
    /// Finalises MPI when dropped.
    _universe: Rc<Universe>,
}

impl Processes {
    /// Initialises MPI if this process was started by it.
    pub fn start() -> Result<Self, Error> {
        if super::started().is_none() {
            return Ok(Self::alone());
        }
        let (universe, _) = mpi::initialize_with_threading(Threading::Serialized).expect("MPI is initialised only here");
        let group = Group::new(&universe.world())?;
        let default_hook = std::panic::take_hook();
        // Aborts all processes: the others would wait for this one forever.
        std::panic::set_hook(Box::new(move |panic| {
            default_hook(panic);
            if !panics::are_caught() {
                Group::abort(PANICKED);
            }
        }));
        Ok(Self { world: Some(World { group, _universe: Rc::new(universe) }), ..Self::alone() })
    }

    /// A run with a single process.
    pub fn alone() -> Self {
        Self { world: None, team: Rc::default() }
    }

    /// Prints the message once, ends all processes, and returns the exit code of the command.
    pub fn fail(self, message: &str, error: &Error, code: u8) -> ExitCode {
        let Some(World { group, .. }) = &self.world else {
            eprintln!("layersplat: {message}");
            return ExitCode::from(code);
        };
        // All processes of the team know an agreed error. Other teams do not, and would wait.
        let agreed = matches!(error, Error::Distributed(DistributedError::Rank { .. }));
        let Some(team) = self.team.get().map(|team| &team.group).filter(|_| agreed) else {
            // If every process finds the same error, the leader prints it and ends the others before they print it.
            if !group.leads() {
                std::thread::sleep(LEADER_HEAD_START);
            }
            eprintln!("layersplat: {message}");
            Group::abort(code);
        };
        if team.leads() {
            eprintln!("layersplat: {message}");
        }
        // The exit code of the process that failed.
        let code = team.max(code.into()) as u8;
        if team.size() < group.size() {
            Group::abort(code);
        }
        ExitCode::from(code)
    }

    /// Whether this process leads all others: it writes output and reports.
    pub fn leads(&self) -> bool {
        self.world.as_ref().is_none_or(|world| world.group.leads())
    }

    /// Whether this process leads its team: it receives the team's pictures.
    pub fn leads_team(&self) -> bool {
        self.team().is_none_or(Group::leads)
    }

    /// Number of processes and of teams. `None` without MPI.
    pub fn counts(&self) -> Option<(usize, usize)> {
        self.world.as_ref().map(|world| (world.group.size(), self.teams()))
    }

    fn teams(&self) -> usize {
        self.team.get().map_or(1, |team| team.teams)
    }

    /// The team, if it has several processes. They share the volume.
    pub fn team(&self) -> Option<&Group> {
        self.team.get().map(|team| &team.group).filter(|team| team.size() > 1)
    }

    /// Forms teams for a number of pictures. By default, a team has as few processes as have the memory for the volume. Only the
    /// first call has an effect.
    pub fn make_teams(
        &self,
        options: &TeamOptions,
        volume: &VolumeOptions,
        size: Viewport,
        pictures: usize,
    ) -> Result<(), Error> {
        let Some(World { group, .. }) = &self.world else { return Ok(()) };
        let per_process = memory::available() / group.on_this_machine() as u64;
        let bytes = bytes_in_parts(&volume.volume, &volume.opening(Some(size))?);
        let needed = bytes.map_or(1, |bytes| (MEMORY_FACTOR * bytes).div_ceil(per_process.max(1)));
        // Available memory may differ, but all processes must form the same teams.
        let needed = group.max(needed);
        let all = group.size();
        let each = match options.ranks_per_picture {
            Some(each) => (each as usize).clamp(1, all),
            None if pictures == 1 => all,
            // With fewer pictures than teams, teams grow so that no process is idle.
            None => (needed as usize).clamp(1, all).max(all / pictures.max(1)),
        };
        let (teams, number) = ((all / each).min(pictures).max(1), group.rank() / each);
        let volume_size = bytes.map_or("which cannot be read in parts".into(), |bytes| format!("of {bytes} bytes"));
        if self.leads() {
            tracing::info!(
                "{all} processes in {teams} teams of {each}; each team renders a picture at a time. The volume, {volume_size}, needs the \
                 memory of {needed} processes with {per_process} bytes each"
            );
        }
        self.team.get_or_init(|| Team { group: group.split(number), teams, each, number });
        Ok(())
    }

    /// Runs `work` on the leader of the team first, then on its other processes. Then the others find cached results.
    pub fn in_turn(&self, mut work: impl FnMut() -> Result<(), Error>) -> Result<(), Error> {
        let Some(Team { group: team, .. }) = self.team.get() else { return work() };
        let first = if team.leads() { work() } else { Ok(()) };
        team.agree(first)?;
        team.agree(if team.leads() { Ok(()) } else { work() })
    }

    /// Returns this process's result if all processes of the team succeeded, else an error on all of them.
    pub fn agree<T>(&self, result: Result<T, Error>) -> Result<T, Error> {
        match self.team.get() {
            Some(team) => team.group.agree(result),
            None => result,
        }
    }

    /// Opens a volume. Each process of a team reads its part.
    pub fn open(&self, options: &VolumeOptions, size: Option<Viewport>, memory: Option<u64>) -> Result<Volume<'static>, Error> {
        if self.counts().is_some_and(|(processes, _)| processes > 1) && is_input(&options.volume) {
            let problem = "only one process can read standard input: use a file, which all processes can read".into();
            return Err(Error::Settings { field: "volume", problem });
        }
        let Some(team) = self.team() else { return self.agree(options.open(size, memory)) };
        if memory.is_some() {
            let problem =
                "a volume that several processes share cannot be streamed: omit the limit, or use --ranks-per-picture 1";
            return Err(Error::Settings { field: "memory", problem: problem.into() });
        }
        options.with_background(team.open(&options.volume, &options.opening(size)?)?)
    }

    /// Fails for views that the processes of a team cannot share.
    pub fn check_views(&self, seen: SeenVolume, cameras: &[Camera], size: Viewport, settings: &Settings) -> Result<(), Error> {
        let unshared = |e: Error| {
            let problem = format!("processes cannot share this view: {e}; or use --ranks-per-picture 1");
            Error::Settings { field: "processes", problem }
        };
        if self.team().is_none() {
            return Ok(());
        }
        cameras.iter().try_for_each(|camera| check_view(seen, camera, size, settings).map_err(unshared))
    }

    /// Whether this team renders picture `n`.
    pub fn owns(&self, n: usize) -> bool {
        self.team.get().is_none_or(|team| n % team.teams == team.number)
    }

    /// Sends picture `n` from the leader of its team to the leader of all, which returns it. All processes must call this in the
    /// order of the pictures.
    pub fn collect(&self, n: usize, frame: Option<Frame>, size: Viewport) -> Option<Frame> {
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

    /// Concatenates the numbers of all processes.
    pub fn gather(&self, numbers: Vec<f64>) -> Vec<f64> {
        self.world.as_ref().map_or(numbers.clone(), |world| world.group.gather(&numbers))
    }

    /// Calls `read` on the leader and broadcasts the bytes to all processes.
    pub fn broadcast(&self, read: impl FnOnce() -> Result<Vec<u8>, Error>) -> Result<Vec<u8>, Error> {
        let Some(World { group, .. }) = &self.world else { return read() };
        let mut bytes = group.agree(if group.leads() { read() } else { Ok(Vec::new()) })?;
        group.broadcast(0, &mut bytes);
        Ok(bytes)
    }

    /// Waits until all processes call this.
    pub fn wait(&self) {
        self.world.iter().for_each(|world| world.group.wait());
    }
}
