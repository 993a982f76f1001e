//! `layersplat paper`: reproduces the experiments of Schlegel & Pajarola. Each writes pictures and a Markdown page.

mod data_sets;
mod figures;
mod page;
mod plot;
mod popping;
mod systems;
mod table1;

use super::options::DeviceOptions;
use super::progress;
use super::{check, parse, report};
use crate::check::Family;
use crate::device::Device;
use crate::error::Error;
use crate::viewport::Viewport;
use clap::ValueEnum;
use data_sets::Library;
use indicatif::ProgressBar;
use page::Page;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Experiment to run
    #[arg(value_name = "EXPERIMENT")]
    what: What,
    /// Folder for pages and pictures; created if missing
    #[arg(short, long, default_value = "paper", value_name = "DIR")]
    out: PathBuf,
    /// Folder with the paper's data sets; if it has none of them, built-in volumes are used
    #[arg(long, env = "LAYERSPLAT_VOLUMES", value_name = "DIR")]
    volumes: Option<PathBuf>,
    /// Folder with a transfer function NAME.json per data set [default: folder transfer beside --volumes]
    #[arg(long, value_name = "DIR")]
    transfers: Option<PathBuf>,
    /// Number of frames of the timed turn
    #[arg(long, default_value_t = 125, value_parser = clap::value_parser!(u32).range(1..=100_000), value_name = "N")]
    frames: u32,
    /// Size of the pictures in pixels
    #[arg(long, default_value = "512x512", value_parser = parse::viewport, value_name = "WxH", allow_hyphen_values = true)]
    size: Viewport,
    #[command(flatten)]
    device: DeviceOptions,
    /// Print the report as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Frame rates and fidelity of the four systems
    Table1,
    /// Splats with and without κ
    Fig2,
    /// Linear α and the exponential
    Fig3,
    /// Curves of 1 − α and e^−τ
    Fig4,
    /// The four systems with a transparent transfer function
    Fig5,
    /// Both layer axes for the same view at 45°
    Popping,
    /// All experiments
    All,
}

impl What {
    /// The experiments to run, in the paper's order.
    fn experiments(self) -> Vec<What> {
        match self {
            What::All => vec![What::Table1, What::Fig2, What::Fig3, What::Fig4, What::Fig5, What::Popping],
            one => vec![one],
        }
    }

    fn title(self) -> &'static str {
        match self {
            What::Table1 => "Table 1: frame rates and fidelity",
            What::Fig2 => "Fig. 2: what κ corrects",
            What::Fig3 => "Fig. 3: linear α and the exponential",
            What::Fig4 => "Fig. 4: 1 − α and e^−τ",
            What::Fig5 => "Fig. 5: a transparent transfer function in all four renderers",
            What::Popping => "Popping: both layer axes at 45°",
            What::All => "The paper's experiments",
        }
    }

    fn file(self) -> &'static str {
        match self {
            What::Table1 => "table1",
            What::Fig2 => "fig2",
            What::Fig3 => "fig3",
            What::Fig4 => "fig4",
            What::Fig5 => "fig5",
            What::Popping => "popping",
            What::All => "README",
        }
    }

    /// Steps of the experiment's progress bar.
    fn steps(self, library: &Library) -> u32 {
        let sets = library.found.len() as u32;
        match self {
            What::Table1 => sets * table1::STEPS,
            What::Fig2 | What::Fig3 | What::Popping => sets,
            What::Fig4 | What::Fig5 => 1,
            What::All => 0,
        }
    }
}

/// The environment of all experiments.
struct Laboratory<'a> {
    device: Device,
    library: Library,
    /// Description of each data set and its transfer function.
    descriptions: Vec<String>,
    frames: u32,
    size: Viewport,
    out: &'a Path,
    bar: ProgressBar,
}

#[derive(Serialize)]
struct Written {
    pages: Vec<String>,
    data_sets: Vec<String>,
    missing: Vec<String>,
    device: String,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let library = Library::new(arguments.volumes.as_deref(), arguments.transfers.as_deref())?;
    let descriptions = library.check()?;
    page::sheet_size(arguments.size)?;
    let device = Device::open(&arguments.device.choice())?;
    // The experiments use nearly all families.
    check::require(&device, &Family::ALL.into(), &arguments.device)?;
    std::fs::create_dir_all(&arguments.out).map_err(|e| Error::write(&arguments.out, e))?;
    let experiments = arguments.what.experiments();
    let bar = progress::steps(experiments.iter().map(|what| what.steps(&library)).sum(), "starting");
    let laboratory =
        Laboratory { device, library, descriptions, frames: arguments.frames, size: arguments.size, out: &arguments.out, bar };
    let mut pages = Vec::new();
    for &what in &experiments {
        let mut page = Page::new(what.title(), &laboratory);
        match what {
            What::Table1 => table1::run(&laboratory, &mut page)?,
            What::Fig2 => figures::kappa(&laboratory, &mut page)?,
            What::Fig3 => figures::extinction(&laboratory, &mut page)?,
            What::Fig4 => figures::curves(&laboratory, &mut page)?,
            What::Fig5 => figures::systems(&laboratory, &mut page)?,
            What::Popping => popping::run(&laboratory, &mut page)?,
            What::All => {}
        }
        pages.push(page.write(what.file())?);
    }
    if arguments.what == What::All {
        let mut index = Page::new(What::All.title(), &laboratory);
        for what in &experiments {
            index.line(&format!("- [{}]({}.md)", what.title(), what.file()));
        }
        pages.push(index.write(What::All.file())?);
    }
    laboratory.bar.finish_and_clear();
    let written = Written {
        pages: pages.iter().map(|page| page.display().to_string()).collect(),
        data_sets: laboratory.library.found.iter().map(|set| set.name.clone()).collect(),
        missing: laboratory.library.missing.iter().map(|name| name.to_string()).collect(),
        device: laboratory.device.info().name.clone(),
    };
    report(arguments.json, &written, || written.pages.join("\n"))?;
    Ok(ExitCode::SUCCESS)
}
