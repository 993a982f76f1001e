//! Figures 2 to 5.

use super::Laboratory;
use super::data_sets::Source;
use super::page::{Page, decibels, enlarged_difference, psnr};
use super::plot::{Series, svg};
use super::systems::{Bench, PAPER_SYSTEMS, SYSTEMS, VIEW};
use crate::camera::{Camera, Orbit};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Correction, Kernel};
use crate::renderer::Renderer;
use crate::settings::{Classification, Evaluation, Layered, Settings};
use crate::transfer::{Extinction, TransferFunction};
use crate::viewport::Viewport;
use crate::volume::{OpenOptions, Volume};

/// Samples per layer at which the extinction model dominates the error.
const FINE_SAMPLES: u32 = 3;
/// Magnification of differences in the pictures.
const TIMES: f32 = 16.0;

/// Compares settings on every data set: a table of fidelities, and for one data set shaded pictures of the first two settings
/// with their difference.
fn compare(
    laboratory: &Laboratory,
    page: &mut Page,
    figure: &str,
    view: Orbit,
    settings: &[(&str, Settings)],
) -> Result<(), Error> {
    let mut rows = Vec::new();
    for source in &laboratory.library.found {
        laboratory.bar.set_message(format!("{figure}: {}", source.name));
        let set = source.open()?;
        let mut bench = Bench::new(laboratory, &set)?;
        let truth = bench.truth(view, Kernel::Cubic)?;
        let mut row = vec![source.name.clone()];
        for (_, settings) in settings {
            row.push(decibels(psnr(&bench.unshaded(view, settings)?, &truth)));
        }
        rows.push(row);
        if source.name == laboratory.library.shown().name {
            let [a, b] = [bench.picture(view, &settings[0].1)?, bench.picture(view, &settings[1].1)?];
            let difference = enlarged_difference(&a, &b, TIMES);
            let caption = format!("{}: {}, {}, and their difference times {TIMES}", source.name, settings[0].0, settings[1].0);
            page.sheet(&format!("{figure}.png"), &caption, &[a, b, difference], 3)?;
        }
        laboratory.bar.inc(1);
    }
    page.paragraph("PSNR in dB (RGB, unshaded) to the converged integral of Eq. 2:");
    let head: Vec<&str> = std::iter::once("data set").chain(settings.iter().map(|s| s.0)).collect();
    page.table(&head, &rows);
    Ok(())
}

/// Post-classified splats per pixel with exact footprints.
fn splatted(correction: Correction) -> Settings {
    Settings {
        algorithm: Layered {
            classification: Classification::Post(correction),
            evaluation: Evaluation::Direct,
            ..Layered::default()
        }
        .into(),
        ..Settings::default()
    }
}

/// Pre-integrated layers per pixel.
fn preintegrated(samples_per_layer: u32) -> Settings {
    let classification = Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer };
    Settings {
        algorithm: Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() }.into(),
        ..Settings::default()
    }
}

/// Fig. 2: with and without κ.
pub(super) fn kappa(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    page.paragraph(
        "Every voxel is splatted once, into its own layer. Left with κ, as in the paper, then without: the parts of kernels that \
         reach into neighbouring layers are lost. Per pixel, exact footprints, one sample per layer.",
    );
    let settings = [
        ("with κ", splatted(Correction::Constant)),
        ("without κ", splatted(Correction::None)),
        ("pre-integrated (needs no κ)", preintegrated(1)),
    ];
    compare(laboratory, page, "fig2", VIEW, &settings)
}

/// Fig. 3: linear α and the exponential.
pub(super) fn extinction(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    page.paragraph(
        "One sample per layer with κ, as in the paper. The last two columns are pre-integrated with three samples per layer, where the \
         extinction model dominates the error. The view is along the diagonal of cubic voxels, where a ray passes √3 voxels in each layer. With \
         α = 1 − e^−τ, the linear form min(1, α·Δt) agrees with the exponential 1 − e^−τΔt at Δt = 1 only.",
    );
    let view = Orbit { azimuth: 45.0, elevation: 35.264, roll: 0.0 };
    let linear = |settings| Settings { extinction: Extinction::Linear, ..settings };
    let (coarse, fine) = (splatted(Correction::Constant), preintegrated(FINE_SAMPLES));
    let settings = [
        ("linear α", linear(coarse)),
        ("exponential", coarse),
        ("linear, three samples per layer", linear(fine)),
        ("exponential, three samples per layer", fine),
    ];
    compare(laboratory, page, "fig3", view, &settings)
}

/// Fig. 4 (a): transmittance curves, with points measured on a homogeneous cube.
pub(super) fn curves(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    const MOST: f64 = 2.0;
    const BLUE: &str = "#145ab4";
    const RED: &str = "#c8461e";
    laboratory.bar.set_message("fig4");
    let curve = |f: fn(f64) -> f64| (0..=100).map(|i| f64::from(i) / 100.0 * MOST).map(|x| (x, f(x))).collect();
    let exponential: fn(f64) -> f64 = |x| (-x).exp();
    let linear: fn(f64) -> f64 = |x| (1.0 - x).max(0.0);
    let difference: fn(f64) -> f64 = |x| (-x).exp() - (1.0 - x).max(0.0);
    let mut rows = Vec::new();
    let mut measured = [Vec::new(), Vec::new()];
    for i in 1..=10 {
        let x = f64::from(i) / 10.0 * MOST;
        let found = [
            layer_transmittance(laboratory, x, Extinction::Exponential)?,
            layer_transmittance(laboratory, x, Extinction::Linear)?,
        ];
        for (points, &t) in measured.iter_mut().zip(&found) {
            points.push((x, t));
        }
        let cells = [x, exponential(x), found[0], linear(x), found[1]];
        rows.push(cells.iter().map(|c| format!("{c:.4}")).collect());
    }
    let [by_exponential, by_linear] = measured;
    let line = |name, color, points| Series { name, color, points, measured: false };
    let dots = |name, color, points| Series { name, color, points, measured: true };
    let series = [
        line("e^−τΔt", BLUE, curve(exponential)),
        line("max(0, 1 − τΔt)", RED, curve(linear)),
        line("difference", "#787878", curve(difference)),
        dots("measured, exponential", BLUE, by_exponential),
        dots("measured, linear", RED, by_linear),
    ];
    let drawing = svg([MOST, 1.0], ["τΔt", "transmittance of a layer"], &series);
    page.drawing(
        "fig4.svg",
        "Transmittance of one layer: e^−τΔt, the first two terms of its series, and their difference",
        &drawing,
    )?;
    page.paragraph("Measured: centre pixel of a homogeneous cube of two layers, per layer.");
    page.table(&["τΔt", "e^−τΔt", "measured", "1 − τΔt", "measured"], &rows);
    laboratory.bar.inc(1);
    Ok(())
}

/// Transmittance per layer of a homogeneous cube, viewed along an axis. `x` is the extinction (or α) of a layer times its
/// thickness.
fn layer_transmittance(laboratory: &Laboratory, x: f64, extinction: Extinction) -> Result<f64, Error> {
    const ALPHA: f64 = 0.05;
    let volume = Volume::open("builtin:cube@2", &OpenOptions::default())?;
    let (_, value) = volume.range();
    let points = vec![(0.0, 0.0), (value / 2.0, 0.0), (value / 2.0, ALPHA), (value, ALPHA)];
    let transfer = TransferFunction::new("cube", vec![(0.0, [1.0; 3])], points)?;
    let per_unit = match extinction {
        Extinction::Exponential => transfer.extinction(value),
        Extinction::Linear => ALPHA,
    };
    let settings = Settings { extinction, shading: None, unit_distance: Some(per_unit / x), ..splatted(Correction::Constant) };
    let size = Viewport::new(1, 1)?;
    let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), size, Orbit::default());
    let early = Settings { early_termination: false, ..settings };
    let (frame, _) = Renderer::new(&laboratory.device, &volume, &transfer)?.render(&camera, size, &early)?;
    Ok((1.0 - f64::from(frame.pixel(0, 0)[3])).max(0.0).sqrt())
}

/// Fig. 5: the four systems with a transparent transfer function.
pub(super) fn systems(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    /// Factor of the opacities.
    const FADED: f64 = 0.25;
    let source: &Source = laboratory.library.shown();
    laboratory.bar.set_message(format!("fig5: {}", source.name));
    let mut set = source.open()?;
    set.transfer = set.transfer.faded(FADED)?;
    let mut bench = Bench::new(laboratory, &set)?;
    let truth = bench.truth(VIEW, Kernel::Cubic)?;
    let (mut pictures, mut rows): (Vec<Frame>, Vec<Vec<String>>) = Default::default();
    for system in &SYSTEMS[..PAPER_SYSTEMS] {
        pictures.push(bench.picture(VIEW, &system.settings())?);
        let own = bench.truth(VIEW, system.kernel)?;
        let unshaded = bench.unshaded(VIEW, &system.settings())?;
        rows.push(vec![system.name.into(), decibels(psnr(&unshaded, &own)), decibels(psnr(&unshaded, &truth))]);
    }
    let names = SYSTEMS[..PAPER_SYSTEMS].iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
    let caption = format!("{} with its opacities times {FADED}: {names}", source.name);
    page.sheet("fig5.png", &caption, &pictures, 2)?;
    page.paragraph("PSNR in dB (RGB, unshaded) to the converged integral of the system's own kernel and of Eq. 2:");
    page.table(&["system", "own kernel", "Eq. 2"], &rows);
    laboratory.bar.inc(1);
    Ok(())
}
