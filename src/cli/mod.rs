//! The command line: a thin skin over the library.

mod algorithm;
mod bench;
mod blending;
mod check;
mod compare;
mod convert;
mod devices;
mod examples;
mod fields;
mod film;
mod info;
mod keys;
mod many;
mod notice;
mod options;
mod paper;
mod parse;
mod processes;
mod progress;
mod render;
mod rotate;
mod scene;
mod shell;
#[cfg(unix)]
mod signals;
mod standard;
mod studio;
mod transfer;
mod tune;
mod view;
mod viewer;
mod views;

#[cfg(feature = "mpi")]
use crate::error::DistributedError;
use crate::error::Error;
use clap::{ArgAction, Parser, Subcommand};
use processes::Processes;
use serde::Serialize;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

/// Volume rendering by layered splatting, on any OpenCL device.
#[derive(Parser)]
#[command(name = "layersplat", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Tell on standard error what is done; twice, in detail
    #[arg(short, long, global = true, action = ArgAction::Count, display_order = 1000)]
    verbose: u8,
}

#[derive(Subcommand)]
enum Command {
    /// Render a volume to a picture
    #[command(after_help = examples::RENDER)]
    Render(render::Arguments),
    /// Render a full turn about the y axis, or a way through key cameras, to numbered PNGs, GIF, APNG or MP4
    #[command(after_help = examples::ROTATE)]
    Rotate(rotate::Arguments),
    /// Render a contact sheet: volume from six sides and two corners, labelled
    #[command(after_help = examples::VIEWS)]
    Views(views::Arguments),
    /// Tell dimensions, type, range and histogram of a volume
    #[command(after_help = examples::INFO)]
    Info(info::Arguments),
    /// List, show, convert and write transfer functions
    #[command(after_help = examples::TRANSFER)]
    Transfer(transfer::Arguments),
    /// Write a volume to a file of another format, voxels in the type that they have
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Arguments),
    /// List platforms and devices, with the tuning that would be used
    #[command(after_help = examples::DEVICES)]
    Devices(devices::Arguments),
    /// Tell how far two pictures differ
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Arguments),
    /// Time a full turn about the y axis
    #[command(after_help = examples::BENCH)]
    Bench(bench::Arguments),
    /// Measure which tuning values this device is fastest with, and print them
    #[command(after_help = examples::TUNE)]
    Tune(tune::Arguments),
    /// Repeat the experiments of the paper
    #[command(after_help = examples::PAPER)]
    Paper(paper::Arguments),
    /// Print what a shell completes this command's words with
    #[command(after_help = examples::COMPLETIONS)]
    Completions(shell::Completions),
    /// Write manual pages
    #[command(after_help = examples::MAN)]
    Man(shell::ManPages),
    /// What other commands start to check a device
    #[command(name = check::child::NAME, hide = true)]
    CheckDevice(check::child::Arguments),
}

/// Runs the command line of this process. Exit code 2 for a bad command line, 1 for anything else that fails.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    log(cli.verbose);
    #[cfg(unix)]
    signals::let_files_be_finished();
    // What checks a device is a process of its own, whoever started it.
    let processes = if matches!(cli.command, Command::CheckDevice(_)) { Ok(Processes::alone()) } else { Processes::start() };
    let processes = match processes {
        Ok(processes) => processes,
        Err(error) => return Processes::alone().fail(&fields::with_options(&error), &error, exit_code(&error)),
    };
    if processes.leads() {
        progress::show_tasks();
    }
    let done = match cli.command {
        Command::Render(arguments) => render::run(&arguments, &processes),
        Command::Rotate(arguments) => rotate::run(&arguments, &processes),
        Command::Bench(arguments) => bench::run(&arguments, &processes),
        // The others are for one.
        _ if !processes.leads() => Ok(ExitCode::SUCCESS),
        Command::Views(arguments) => views::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Transfer(arguments) => transfer::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Tune(arguments) => tune::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::man_pages(&arguments),
        Command::CheckDevice(arguments) => check::child::run(&arguments),
    };
    done.unwrap_or_else(|error| processes.fail(&fields::with_options(&error), &error, exit_code(&error)))
}

/// Warnings, or what --verbose or RUST_LOG ask for, to standard error.
fn log(verbose: u8) {
    let wanted = ["warn", "layersplat=info,warn", "layersplat=debug,warn"][usize::from(verbose.min(2))];
    let filter =
        tracing_subscriber::EnvFilter::try_from_default_env().ok().filter(|_| verbose == 0).unwrap_or_else(|| wanted.into());
    // Colours for those who look at a terminal, unless they would rather have none (no-color.org).
    let unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let colors = std::io::stderr().is_terminal() && !unwanted;
    let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colors);
    builder.without_time().with_target(false).init();
}

/// 2 where the command line itself is at fault.
fn exit_code(error: &Error) -> u8 {
    match error {
        Error::OutOfRange { .. }
        | Error::UnknownName { .. }
        | Error::Settings { .. }
        | Error::Camera { .. }
        | Error::MemoryBudget { .. } => 2,
        #[cfg(feature = "mpi")]
        Error::Distributed(DistributedError::Rank { own: Some(own), .. }) => exit_code(own),
        _ => 1,
    }
}

/// Prints a report: as one line of JSON, or as text.
fn report(json: bool, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<(), Error> {
    use std::io::{ErrorKind, Write};
    let line = if json { serde_json::to_string(value).expect("reports are plain data") } else { text() };
    let mut out = std::io::stdout();
    match writeln!(out, "{}", line.trim_end()).and_then(|()| out.flush()) {
        // A reader that went away (`| head`) is no error of ours.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"), e)),
        _ => Ok(()),
    }
}
