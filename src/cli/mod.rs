//! The command line: a thin layer over the library.

mod address_info;
mod algorithm;
mod bench;
mod blending;
#[cfg(feature = "viewer")]
mod browser;
mod cache;
mod cameras;
mod channels;
mod check;
mod colors;
mod command_line;
mod compare;
mod compiling;
mod convert;
mod devices;
mod examples;
mod film;
mod info;
mod json_view;
mod keys;
mod labels;
mod levels;
mod many;
mod names;
mod notice;
mod numbers;
mod option_names;
mod options;
mod orientation;
mod paper;
mod parse;
mod pictures;
mod processes;
mod progress;
mod remarks;
mod render;
mod rotate;
mod scene;
mod scene_renderer;
mod shell;
mod shown_steps;
#[cfg(unix)]
mod signals;
mod slice;
mod standard;
mod surface_info;
mod surfaces;
mod time;
mod transfer;
mod tune;
mod values;
mod views;

#[cfg(feature = "mpi")]
use crate::error::DistributedError;
use crate::error::Error;
use crate::panics;
use crate::url;
use clap::{ArgAction, Parser, Subcommand};
use processes::Processes;
use serde::Serialize;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

/// Turns volume data (CT, MRI, microscopy, simulations) into pictures and films
#[derive(Parser)]
#[command(name = "layersplat", version, propagate_version = true, after_help = examples::FIRST)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Show progress messages (-vv: more)
    #[arg(short, long, global = true, action = ArgAction::Count, display_order = 1000)]
    verbose: u8,
}

#[derive(Subcommand)]
enum Command {
    /// Render a volume to a picture
    #[command(after_help = examples::RENDER)]
    Render(render::Arguments),
    /// Show a volume in the browser, to turn it and to change how it looks by hand
    #[cfg(feature = "viewer")]
    #[command(after_help = examples::VIEW)]
    View(browser::Arguments),
    /// Render a turn around the vertical axis, or a camera path, to numbered PNGs, GIF, APNG or MP4
    #[command(after_help = examples::ROTATE)]
    Rotate(rotate::Arguments),
    /// Render a contact sheet of eight labelled views: six sides and two corners
    #[command(after_help = examples::VIEWS)]
    Views(views::Arguments),
    /// Draw a slice through a volume, along any plane
    #[command(after_help = examples::SLICE)]
    Slice(slice::Arguments),
    /// Show dimensions, type, range and histogram of a volume
    #[command(after_help = examples::INFO)]
    Info(info::Arguments),
    /// List, show, plot and convert transfer functions
    #[command(after_help = examples::TRANSFER)]
    Transfer(transfer::Arguments),
    /// Convert a volume to another file format; keeps the voxel type
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Arguments),
    /// List OpenCL devices with their tuning, or check what they draw
    #[command(after_help = examples::DEVICES)]
    Devices(devices::Arguments),
    /// Show how much of volumes at URLs is kept on disk, and where, or remove it
    #[command(after_help = examples::CACHE)]
    Cache(cache::Arguments),
    /// Compare two pictures
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Arguments),
    /// Measure frame times over a turn around the y axis
    #[command(after_help = examples::BENCH)]
    Bench(bench::Arguments),
    /// Find the fastest tuning values of a device
    #[command(after_help = examples::TUNE)]
    Tune(tune::Arguments),
    /// Reproduce the experiments of the paper
    #[command(after_help = examples::PAPER)]
    Paper(paper::Arguments),
    /// Print shell completions
    #[command(after_help = examples::COMPLETIONS)]
    Completions(shell::Completions),
    /// Write manual pages
    #[command(after_help = examples::MAN)]
    Man(shell::ManPages),
    /// Check a device in a separate process; other commands start this
    #[command(name = check::child::NAME, hide = true)]
    CheckDevice(check::child::Arguments),
}

impl Command {
    /// Whether the command has its own way to end at a signal.
    #[cfg(unix)]
    fn ends_itself(&self) -> bool {
        #[cfg(feature = "viewer")]
        return matches!(self, Command::View(_));
        #[cfg(not(feature = "viewer"))]
        false
    }
}

/// Runs the command line of this process. Exit code 2 means a bad command line, 1 any other failure.
pub fn main() -> ExitCode {
    let cli = Cli::from_arguments();
    log(cli.verbose);
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !panics::are_caught() {
            report(panic);
        }
    }));
    #[cfg(unix)]
    if !cli.command.ends_itself() {
        signals::exit_after_writes();
    }
    // A device check always runs as a single process, even if its parent runs under MPI.
    let processes = if matches!(cli.command, Command::CheckDevice(_)) { Ok(Processes::alone()) } else { Processes::start() };
    let processes = match processes {
        Ok(processes) => processes,
        Err(error) => return Processes::alone().fail(&option_names::with_options(&error), &error, exit_code(&error)),
    };
    if processes.leads() {
        progress::show_tasks();
    }
    let result = match cli.command {
        Command::Render(arguments) => render::run(&arguments, &processes),
        Command::Rotate(arguments) => rotate::run(&arguments, &processes),
        Command::Bench(arguments) => bench::run(&arguments, &processes),
        // The remaining commands run on the leader only.
        _ if !processes.leads() => Ok(ExitCode::SUCCESS),
        #[cfg(feature = "viewer")]
        Command::View(arguments) => browser::run(arguments, &processes),
        Command::Views(arguments) => views::run(&arguments),
        Command::Slice(arguments) => slice::run(&arguments),
        Command::Info(arguments) if url::is_url(&arguments.volume.volume) => address_info::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Transfer(arguments) => transfer::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Cache(arguments) => cache::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Tune(arguments) => tune::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::man_pages(&arguments),
        Command::CheckDevice(arguments) => check::child::run(&arguments),
    };
    result.unwrap_or_else(|error| processes.fail(&option_names::with_options(&error), &error, exit_code(&error)))
}

/// Logs to standard error: warnings by default, else the level of --verbose or RUST_LOG.
fn log(verbose: u8) {
    let level = ["warn", "layersplat=info,warn", "layersplat=debug,warn"][usize::from(verbose.min(2))];
    let asked = std::env::var("RUST_LOG").ok().filter(|_| verbose == 0).and_then(|text| text.parse::<Targets>().ok());
    let targets = asked.unwrap_or_else(|| level.parse().expect("levels above are valid"));
    // See no-color.org.
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let colors = std::io::stderr().is_terminal() && !no_color;
    let layer = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).with_ansi(colors).without_time().with_target(false);
    tracing_subscriber::registry().with(layer.with_filter(targets)).init();
}

/// 2 if the command line caused the error, else 1.
fn exit_code(error: &Error) -> u8 {
    match error {
        Error::OutOfRange { .. }
        | Error::Argument { .. }
        | Error::UnknownName { .. }
        | Error::Settings { .. }
        | Error::Camera { .. }
        | Error::MemoryBudget { .. }
        | Error::LightMemory { .. } => 2,
        #[cfg(feature = "mpi")]
        Error::Distributed(DistributedError::Rank { own: Some(own), .. }) => exit_code(own),
        _ => 1,
    }
}

/// Prints a report to standard output, as one line of JSON or as text.
fn report(json: bool, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<(), Error> {
    use std::io::{ErrorKind, Write};
    let line = if json { serde_json::to_string(value).expect("reports are plain data") } else { text() };
    let mut out = std::io::stdout();
    match writeln!(out, "{}", line.trim_end()).and_then(|()| out.flush()) {
        // A closed pipe (`| head`) is not an error.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"), e)),
        _ => Ok(()),
    }
}
