//! Popping: pictures of the same view with both layer axes, at exactly 45° in voxel units.

use super::Laboratory;
use super::data_sets::Source;
use super::page::{Page, decibels, enlarged_difference, psnr};
use super::systems::Bench;
use crate::camera::Orbit;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::{Axis, Correction, Kernel};
use crate::settings::{Algorithm, Classification, Evaluation, LayerAxis, Layered, Settings};
use crate::volume::Grid;

/// Magnification of differences in the pictures.
const TIMES: f32 = 16.0;
/// Number of sub-layers of the method "four sub-layers".
const SUB_LAYERS: u32 = 4;

/// The compared methods. Layered ones render per pixel, so that no warp blurs the differences.
fn methods() -> [(&'static str, Settings); 5] {
    let layered = |classification| Settings {
        algorithm: Layered { classification, evaluation: Evaluation::Direct, ..Layered::default() }.into(),
        ..Settings::default()
    };
    let post = |correction| layered(Classification::Post(correction));
    [
        ("axis-sheets", Settings { algorithm: Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }, ..Settings::default() }),
        ("without κ", post(Correction::None)),
        ("κ", post(Correction::Constant)),
        ("four sub-layers", post(Correction::SubLayers(SUB_LAYERS))),
        ("pre-integrated", layered(Classification::Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 })),
    ]
}

/// PSNR in dB.
struct Popping {
    /// Between the pictures of the two layer axes.
    between: f64,
    /// Between the first picture and the converged integral.
    truth: f64,
}

pub(super) fn run(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    page.paragraph(
        "Azimuth 45° in voxel units, elevation 0°, unshaded, with layer axis x and with layer axis z. PSNR in dB (RGB) between the \
         two pictures, and after the slash of the first picture to the converged integral of Eq. 2. Layered renderers per pixel. \
         Blurred pictures pop less, so both numbers matter.",
    );
    let (mut rows, mut gains) = (Vec::new(), Vec::new());
    let mut pictures = None;
    for source in &laboratory.library.found {
        laboratory.bar.set_message(format!("popping: {}", source.name));
        let (methods, differences) = measure(laboratory, source)?;
        let gain = methods[2].between - methods[1].between;
        gains.push(gain);
        let cells = methods.iter().map(|p| format!("{} / {}", decibels(p.between), decibels(p.truth)));
        rows.push([vec![source.name.clone()], cells.collect(), vec![format!("{gain:+.1}")]].concat());
        if source.name == laboratory.library.shown().name {
            pictures = Some(differences);
        }
        laboratory.bar.inc(1);
    }
    let head = [vec!["data set, between / truth"], methods().map(|m| m.0).to_vec(), vec!["κ gains"]].concat();
    page.table(&head, &rows);
    let mean = gains.iter().sum::<f64>() / gains.len() as f64;
    page.paragraph(&format!("κ gains {mean:.1} dB on average."));
    if let Some(differences) = pictures {
        let names = methods().map(|m| m.0).join(", ");
        let caption =
            format!("{}: difference between the pictures of both axes, times {TIMES}: {names}", laboratory.library.shown().name);
        page.sheet("popping.png", &caption, &differences, 3)?;
    }
    Ok(())
}

/// The view whose direction has equal components along x and z, in voxels.
fn diagonal_view(grid: &Grid) -> Orbit {
    let spacing = grid.spacing();
    Orbit { azimuth: spacing.x.atan2(spacing.z).to_degrees(), elevation: 0.0, roll: 0.0 }
}

/// PSNR and magnified difference of each method on a data set.
fn measure(laboratory: &Laboratory, source: &Source) -> Result<(Vec<Popping>, Vec<Frame>), Error> {
    let set = source.open()?;
    let mut bench = Bench::new(laboratory, &set)?;
    let view = diagonal_view(set.volume.grid());
    let truth = bench.truth(view, Kernel::Cubic)?;
    let (mut measured, mut differences) = (Vec::new(), Vec::new());
    for (_, settings) in methods() {
        let mut render =
            |axis| bench.unshaded(view, &Settings { algorithm: settings.algorithm.along(LayerAxis::Forced(axis)), ..settings });
        let [x, z] = [render(Axis::X)?, render(Axis::Z)?];
        measured.push(Popping { between: psnr(&x, &z), truth: psnr(&x, &truth) });
        differences.push(enlarged_difference(&x, &z, TIMES));
    }
    Ok((measured, differences))
}
