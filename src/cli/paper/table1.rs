//! Table 1: frame rates of the four systems and how near they are to the integral, also at equal fidelity.

use super::super::bench::median;
use super::Laboratory;
use super::data_sets::{PaperRow, Source};
use super::page::{Page, decibels, psnr};
use super::systems::{Bench, LAYERED, SYSTEMS, VIEW, layered};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Density, Interpolation};
use crate::renderer::{Algorithm, Settings};

/// Parts of a turn: systems take turns at them.
const PARTS: u32 = 5;
/// Frames that a setting is timed with where fidelities are to be equal.
const SHORT_TURN: u32 = 25;
/// Steps of the progress bar per data set: truths, default settings, equal fidelities.
pub(super) const STEPS: u64 = 3 + PARTS as u64 + 1;

/// What was measured of one data set.
struct Measured {
    name: String,
    paper: Option<PaperRow>,
    dims: [usize; 3],
    splats: u64,
    milliseconds: [f64; 4],
    own: [f64; 4],
    cubic: [f64; 4],
    equal: Vec<Equal>,
}

/// Two systems at settings that come equally near to their own integrals.
struct Equal {
    what: String,
    psnr: [f64; 2],
    milliseconds: [f64; 2],
}

pub(super) fn run(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    let measured: Vec<Measured> =
        laboratory.library.found.iter().map(|source| measure(laboratory, source)).collect::<Result<_, Error>>()?;
    let name = |m: &Measured| m.name.clone();

    page.paragraph(&format!(
        "A full turn of {} frames about y at elevation 20°, shaded, finished 8-bit pictures, default settings. Frames per second \
         from the median frame; systems took turns at fifths of the turn. In brackets, where the paper has it, its own number.",
        laboratory.frames
    ));
    let rows: Vec<Vec<String>> = measured
        .iter()
        .map(|m| {
            let [x, y, z] = m.dims;
            let splats = match m.paper {
                Some(paper) => format!("{} ({})", m.splats, paper.splats),
                None => m.splats.to_string(),
            };
            let mut row = vec![name(m), format!("{x}×{y}×{z}"), splats];
            row.extend((0..4).map(|i| with_paper(1e3 / m.milliseconds[i], m.paper.and_then(|paper| paper.fps[i]))));
            row
        })
        .collect();
    page.table(&["data set", "voxels", "effective splats", "axis-sheets", "view-sheets", "layered", "slicing"], &rows);

    page.paragraph("How many times faster than each of the others layered is.");
    let rows: Vec<Vec<String>> = measured
        .iter()
        .map(|m| {
            let ratio = |i: usize| {
                let paper = m.paper.and_then(|p| Some(p.fps[LAYERED]? / p.fps[i]?));
                with_paper(m.milliseconds[i] / m.milliseconds[LAYERED], paper)
            };
            vec![name(m), ratio(0), ratio(1), ratio(3)]
        })
        .collect();
    page.table(&["data set", "axis-sheets", "view-sheets", "slicing"], &rows);

    page.paragraph(
        "Fidelity in dB (RGB, unshaded, azimuth 72°, elevation 20°): to the converged integral of the system's own kernel, and to \
         that of the paper's cubic (Eq. 2). Both by `--algorithm raycast --step 0.0625` with that kernel.",
    );
    let both = |m: &Measured, i: usize| format!("{} / {}", decibels(m.own[i]), decibels(m.cubic[i]));
    let rows: Vec<Vec<String>> =
        measured.iter().map(|m| [vec![name(m)], (0..4).map(|i| both(m, i)).collect()].concat()).collect();
    page.table(&["data set, own / Eq. 2", "axis-sheets", "view-sheets", "layered", "slicing"], &rows);

    page.paragraph(&format!(
        "At equal fidelity: the cheapest settings that come as near to their own integral as the other system at its default. \
         Median of {SHORT_TURN} frames."
    ));
    let rows: Vec<Vec<String>> = measured
        .iter()
        .flat_map(|m| {
            m.equal.iter().map(|e| {
                let [a, b] = e.milliseconds;
                vec![
                    name(m),
                    e.what.clone(),
                    format!("{} : {}", decibels(e.psnr[0]), decibels(e.psnr[1])),
                    format!("{a:.2} : {b:.2}"),
                    format!("{:.1}", b / a),
                ]
            })
        })
        .collect();
    page.table(&["data set", "layered : other", "dB", "ms", "layered is faster by"], &rows);
    Ok(())
}

fn with_paper(own: f64, paper: Option<f64>) -> String {
    match paper {
        Some(paper) => format!("{own:.1} ({paper:.1})"),
        None => format!("{own:.1}"),
    }
}

fn measure(laboratory: &Laboratory, source: &Source) -> Result<Measured, Error> {
    let bar = &laboratory.bar;
    bar.set_message(format!("table 1: {}", source.name));
    let set = source.open()?;
    let mut bench = Bench::new(laboratory, &set)?;
    let mut truths = Vec::new();
    for kernel in [Interpolation::Trilinear, Interpolation::Tricubic, Interpolation::Gaussian] {
        truths.push(bench.truth(VIEW, kernel)?);
        bar.inc(1);
    }
    let (mut own, mut cubic) = ([0.0; 4], [0.0; 4]);
    for (i, system) in SYSTEMS.iter().enumerate() {
        let picture = bench.unshaded(VIEW, &system.settings())?;
        own[i] = psnr(&picture, &truths[system.kernel as usize]);
        cubic[i] = psnr(&picture, &truths[Interpolation::Tricubic as usize]);
    }
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
    })
}

/// Median milliseconds of each system.
fn at_defaults(laboratory: &Laboratory, bench: &mut Bench) -> Result<[f64; 4], Error> {
    let frames = laboratory.frames;
    let mut times: [Vec<f64>; 4] = Default::default();
    for system in SYSTEMS {
        // Kernels, layouts and lists of every layer axis.
        bench.times(&system.settings(), 0, frames.min(8), frames.min(8))?;
    }
    for part in 0..PARTS {
        let [from, to] = [part, part + 1].map(|p| p * frames / PARTS);
        for (system, times) in SYSTEMS.iter().zip(&mut times) {
            times.extend(bench.times(&system.settings(), from, to, frames)?);
        }
        laboratory.bar.inc(1);
    }
    Ok(times.map(median))
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

/// Layered against view-sheets and slicing, each as near to its own integral as the other at its default.
fn equal_fidelities(bench: &mut Bench, truths: &[Frame], own: &[f64; 4]) -> Result<Vec<Equal>, Error> {
    let mut equal = Vec::new();
    let mut candidates = Vec::new();
    for (name, settings) in layered_settings() {
        let fidelity = psnr(&bench.unshaded(VIEW, &settings)?, &truths[Interpolation::Tricubic as usize]);
        candidates.push((name, fidelity, settings));
    }
    let timed = |bench: &mut Bench, settings: &Settings| -> Result<f64, Error> {
        bench.times(settings, 0, 4, 4)?;
        Ok(median(bench.times(settings, 0, SHORT_TURN, SHORT_TURN)?))
    };
    let mut priced = Vec::new();
    for (name, fidelity, settings) in candidates {
        priced.push((name, fidelity, timed(bench, &settings)?));
    }
    for i in [1, 3] {
        let system = SYSTEMS[i];
        let other = timed(bench, &system.settings())?;
        let cheapest = priced.iter().filter(|p| p.1 >= own[i]).min_by(|a, b| a.2.total_cmp(&b.2));
        if let Some((name, fidelity, ms)) = cheapest {
            let what = format!("{name} : {}", system.name);
            equal.push(Equal { what, psnr: [*fidelity, own[i]], milliseconds: [*ms, other] });
        }
        let standard = timed(bench, &SYSTEMS[LAYERED].settings())?;
        for step in [4.0, 3.0, 2.0, 1.5, 1.0, 0.75, 0.5, 0.35, 0.25, 0.125] {
            let algorithm = match system.settings().algorithm {
                Algorithm::ViewSheets { .. } => Algorithm::ViewSheets { sheet_distance: step },
                _ => Algorithm::Slicing { step },
            };
            let settings = Settings { algorithm, ..system.settings() };
            let fidelity = psnr(&bench.unshaded(VIEW, &settings)?, &truths[system.kernel as usize]);
            if fidelity >= own[LAYERED] {
                let what = format!("standard : {} {step} apart", system.name);
                let milliseconds = [standard, timed(bench, &settings)?];
                equal.push(Equal { what, psnr: [own[LAYERED], fidelity], milliseconds });
                break;
            }
        }
    }
    Ok(equal)
}
