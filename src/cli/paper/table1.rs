//! Table 1: frame rates and fidelity of the four systems, at default settings and at equal fidelity.

use super::super::bench::median;
use super::Laboratory;
use super::data_sets::{PaperRow, Source};
use super::page::{Page, decibels, psnr};
use super::systems::{Bench, LAYERED, OTHERS, PAPER_SYSTEMS, QUALITIES, SLICING, SYSTEMS, System, VIEW, VIEW_SHEETS, layered};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Density, Kernel};
use crate::settings::{Algorithm, Settings};
use std::collections::HashMap;

/// Parts of a turn. Systems alternate between parts, so that all see the same load of the machine.
const PARTS: u32 = 5;
/// Frames per setting in the search for equal fidelity.
const SHORT_TURN: u32 = 25;
/// Steps of the progress bar per data set: ground truths, default settings, equal fidelity.
pub(super) const STEPS: u32 = 3 + PARTS + 1;

/// Measurements on one data set.
struct Measured {
    name: String,
    paper: Option<PaperRow>,
    dims: [usize; 3],
    splats: u64,
    /// Median frame time by system.
    milliseconds: Vec<f64>,
    /// PSNR to the integral of the system's own kernel, by system.
    own: Vec<f64>,
    /// PSNR to the integral of the paper's cubic (Eq. 2), by system.
    cubic: Vec<f64>,
    equal: Vec<EqualFidelity>,
    /// Shaded pictures of the paper's systems.
    pictures: Vec<Frame>,
}

/// Two systems at settings of equal fidelity to the integrals of their own kernels.
struct EqualFidelity {
    what: String,
    psnr: [f64; 2],
    /// `None` if one system does not reach the other's fidelity.
    milliseconds: Option<[f64; 2]>,
}

pub(super) fn run(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    let measured: Vec<Measured> =
        laboratory.library.found.iter().map(|source| measure(laboratory, source)).collect::<Result<_, Error>>()?;
    frame_rates(laboratory, page, &measured);
    ratios(page, &measured);
    fidelities(page, &measured);
    equal(page, &measured);
    let names = SYSTEMS[..PAPER_SYSTEMS].iter().map(|system| system.name).collect::<Vec<_>>().join(", ");
    for m in &measured {
        let caption = format!("{}: {names}, at default settings", m.name);
        page.sheet(&format!("table1_{}.png", m.name.replace('@', "_")), &caption, &m.pictures, 2)?;
    }
    Ok(())
}

/// Adds a table with a row per data set: its name, the cells of `own`, and a cell for each system.
fn by_system(
    page: &mut Page,
    head: &[&str],
    measured: &[Measured],
    own: impl Fn(&Measured) -> Vec<String>,
    cell: impl Fn(&Measured, usize) -> String,
) {
    let head: Vec<&str> = head.iter().copied().chain(SYSTEMS.iter().map(|system| system.name)).collect();
    let row = |m: &Measured| {
        let cells = (0..SYSTEMS.len()).map(|i| cell(m, i));
        std::iter::once(m.name.clone()).chain(own(m)).chain(cells).collect()
    };
    page.table(&head, &measured.iter().map(row).collect::<Vec<_>>());
}

fn frame_rates(laboratory: &Laboratory, page: &mut Page, measured: &[Measured]) {
    page.paragraph(&format!(
        "Frames per second, from the median of {} frames of a full turn around y at elevation 20°, shaded, up to the finished 8-bit \
         picture, with default settings. Systems alternated every fifth of the turn. The paper's own numbers are in parentheses.",
        laboratory.frames
    ));
    let own = |m: &Measured| {
        let [x, y, z] = m.dims;
        let splats = m.paper.map_or(m.splats.to_string(), |paper| format!("{} ({})", m.splats, paper.splats));
        vec![format!("{x}×{y}×{z}"), splats]
    };
    by_system(page, &["data set", "voxels", "effective splats"], measured, own, |m, i| {
        with_paper(1e3 / m.milliseconds[i], m.paper.and_then(|paper| *paper.fps.get(i)?))
    });
}

fn ratios(page: &mut Page, measured: &[Measured]) {
    page.paragraph("Speed-up of layered over the other systems, at its default quality (`standard`) and two others.");
    let ratio = |m: &Measured, quality: usize, other: usize| {
        let paper = m.paper.and_then(|p| Some(p.fps[LAYERED]? / p.fps[other]?)).filter(|_| quality == LAYERED);
        with_paper(m.milliseconds[other] / m.milliseconds[quality], paper)
    };
    let row = |m: &Measured, quality: usize| {
        let cells = OTHERS.map(|other| ratio(m, quality, other));
        [vec![m.name.clone(), SYSTEMS[quality].name.into()], cells.into()].concat()
    };
    let rows: Vec<Vec<String>> = measured.iter().flat_map(|m| QUALITIES.map(|quality| row(m, quality))).collect();
    let head = [["data set", "faster than"].as_slice(), &OTHERS.map(|other| SYSTEMS[other].name)].concat();
    page.table(&head, &rows);
}

fn fidelities(page: &mut Page, measured: &[Measured]) {
    page.paragraph(
        "Fidelity in dB (RGB, unshaded, azimuth 72°, elevation 20°) to the converged integral of the system's own kernel, and to \
         that of the paper's cubic (Eq. 2). Both are rendered by `--algorithm raycast --step 0.0625 --shading off --early-termination off` with \
         that `--kernel`.",
    );
    by_system(
        page,
        &["data set, own / Eq. 2"],
        measured,
        |_| Vec::new(),
        |m, i| format!("{} / {}", decibels(m.own[i]), decibels(m.cubic[i])),
    );
}

fn equal(page: &mut Page, measured: &[Measured]) {
    page.paragraph(&format!(
        "At equal fidelity: first the fastest settings of layered that reach the fidelity of the other system at its defaults, then the \
         coarsest settings of the other system that reach the fidelity of `standard`. Medians of {SHORT_TURN} frames."
    ));
    let row = |m: &Measured, e: &EqualFidelity| {
        let [times, ratio] = match e.milliseconds {
            Some([a, b]) => [format!("{a:.2} : {b:.2}"), format!("{:.1}", b / a)],
            None => ["not reached".into(), "–".into()],
        };
        vec![m.name.clone(), e.what.clone(), format!("{} : {}", decibels(e.psnr[0]), decibels(e.psnr[1])), times, ratio]
    };
    let rows: Vec<Vec<String>> = measured.iter().flat_map(|m| m.equal.iter().map(|e| row(m, e))).collect();
    page.table(&["data set", "layered : other", "dB", "ms", "layered is faster by"], &rows);
}

fn with_paper(own: f64, paper: Option<f64>) -> String {
    match paper {
        Some(paper) => format!("{own:.1} ({paper:.1})"),
        None => format!("{own:.1}"),
    }
}

/// Converged integrals by kernel.
type Truths = HashMap<Kernel, Frame>;

fn measure(laboratory: &Laboratory, source: &Source) -> Result<Measured, Error> {
    let bar = &laboratory.bar;
    bar.set_message(format!("table 1: {}", source.name));
    let set = source.open()?;
    let mut bench = Bench::new(laboratory, &set)?;
    let mut truths = Truths::new();
    for kernel in [Kernel::Linear, Kernel::Cubic, Kernel::Gaussian] {
        truths.insert(kernel, bench.truth(VIEW, kernel)?);
        bar.inc(1);
    }
    let (mut own, mut cubic) = (Vec::new(), Vec::new());
    for system in SYSTEMS {
        let picture = bench.unshaded(VIEW, &system.settings())?;
        own.push(psnr(&picture, &truths[&system.kernel]));
        cubic.push(psnr(&picture, &truths[&Kernel::Cubic]));
    }
    let pictures =
        SYSTEMS[..PAPER_SYSTEMS].iter().map(|system| bench.picture(VIEW, &system.settings())).collect::<Result<_, Error>>()?;
    let milliseconds = at_defaults(laboratory, &mut bench)?;
    let equal = equal_fidelities(&mut bench, &truths, &own)?;
    bar.inc(1);
    Ok(Measured {
        name: source.name.clone(),
        paper: source.paper,
        dims: set.volume.grid().dims(),
        splats: set.transfer.effective_splats(&set.volume),
        milliseconds,
        own,
        cubic,
        equal,
        pictures,
    })
}

/// Median frame time of each system in milliseconds.
fn at_defaults(laboratory: &Laboratory, bench: &mut Bench) -> Result<Vec<f64>, Error> {
    let frames = laboratory.frames;
    let mut times = vec![Vec::new(); SYSTEMS.len()];
    for system in SYSTEMS {
        // Warm-up: builds kernels, layouts and lists of every layer axis.
        bench.times(&system.settings(), 0, frames.min(8), frames.min(8))?;
    }
    for part in 0..PARTS {
        let [from, to] = [part, part + 1].map(|p| p * frames / PARTS);
        for (system, times) in SYSTEMS.iter().zip(&mut times) {
            times.extend(bench.times(&system.settings(), from, to, frames)?);
        }
        laboratory.bar.inc(1);
    }
    Ok(times.into_iter().map(median).collect())
}

/// Layered settings from coarse to fine.
fn layered_settings() -> Vec<(String, Settings)> {
    let densities =
        [("draft", Density::Fixed(1)), ("standard", Density::Relaxed), ("high", Density::Fine), ("lattice 3", Density::Fixed(3))];
    let all = densities.into_iter().flat_map(|(name, density)| {
        (1..=3).map(move |samples| (format!("{name}, {samples} per layer"), layered(density, samples)))
    });
    all.collect()
}

/// Compares layered with view-sheets and slicing.
fn equal_fidelities(bench: &mut Bench, truths: &Truths, own: &[f64]) -> Result<Vec<EqualFidelity>, Error> {
    let mut ladder = Vec::new();
    for (name, settings) in layered_settings() {
        let fidelity = psnr(&bench.unshaded(VIEW, &settings)?, &truths[&Kernel::Cubic]);
        ladder.push((name, fidelity, short_turn(bench, &settings)?));
    }
    let mut equal = Vec::new();
    for other in [VIEW_SHEETS, SLICING] {
        let system = SYSTEMS[other];
        let fastest = ladder.iter().filter(|rung| rung.1 >= own[other]).min_by(|a, b| a.2.total_cmp(&b.2));
        let nearest = ladder.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let (name, fidelity, ms) = fastest.or(nearest).expect("the ladder has rungs");
        let milliseconds = match fastest {
            Some(_) => Some([*ms, short_turn(bench, &system.settings())?]),
            None => None,
        };
        equal.push(EqualFidelity { what: format!("{name} : {}", system.name), psnr: [*fidelity, own[other]], milliseconds });

        let (distance, fidelity, settings) = coarsest(bench, system, &truths[&system.kernel], own[LAYERED])?;
        let milliseconds = match fidelity >= own[LAYERED] {
            true => Some([short_turn(bench, &SYSTEMS[LAYERED].settings())?, short_turn(bench, &settings)?]),
            false => None,
        };
        let what = format!("standard : {} at distance {distance}", system.name);
        equal.push(EqualFidelity { what, psnr: [own[LAYERED], fidelity], milliseconds });
    }
    Ok(equal)
}

/// The largest distance of sheets or slices at which a system reaches the fidelity `wanted`, or else the smallest distance.
/// Returns distance, fidelity and settings.
fn coarsest(bench: &mut Bench, system: System, truth: &Frame, wanted: f64) -> Result<(f64, f64, Settings), Error> {
    const FINEST: f64 = 0.125;
    for distance in [4.0, 3.0, 2.0, 1.5, 1.25, 1.0, 0.75, 0.5, 0.35, 0.25, FINEST] {
        let algorithm = match system.settings().algorithm {
            Algorithm::ViewSheets { .. } => Algorithm::ViewSheets { sheet_distance: distance },
            _ => Algorithm::Slicing { step: distance },
        };
        let settings = Settings { algorithm, ..system.settings() };
        let fidelity = psnr(&bench.unshaded(VIEW, &settings)?, truth);
        if fidelity >= wanted || distance == FINEST {
            return Ok((distance, fidelity, settings));
        }
    }
    unreachable!("the finest distance is the last")
}

/// Median frame time of a short turn in milliseconds.
fn short_turn(bench: &mut Bench, settings: &Settings) -> Result<f64, Error> {
    bench.times(settings, 0, 4, 4)?;
    Ok(median(bench.times(settings, 0, SHORT_TURN, SHORT_TURN)?))
}
