//! Popping: the pictures of both layer axes, forced on the same view at exactly 45° in voxel units.

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

/// How much differences are enlarged in the pictures.
const TIMES: f32 = 16.0;
/// Sub-layers of the method with some.
const SUB_LAYERS: u32 = 4;

/// The methods, layered ones per pixel: no warp blurs what they differ by.
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

/// PSNR between the two axes' pictures, and of the first to the truth.
struct Popped {
    between: f64,
    truth: f64,
}

pub(super) fn run(laboratory: &Laboratory, page: &mut Page) -> Result<(), Error> {
    page.paragraph(
        "Azimuth 45° in voxel units, elevation 0°, unshaded: once with layer axis x, once with z. PSNR in dB (RGB) between the \
         two pictures, and after the stroke that of the first to the converged integral of Eq. 2. Layered renderers per pixel. A \
         blurred picture pops less: look at both numbers.",
    );
    let (mut rows, mut gains) = (Vec::new(), Vec::new());
    let mut pictures = None;
    for source in &laboratory.library.found {
        laboratory.bar.set_message(format!("popping: {}", source.name));
        let (popped, differences) = pop(laboratory, source)?;
        let gain = popped[2].between - popped[1].between;
        gains.push(gain);
        let cells = popped.iter().map(|p| format!("{} / {}", decibels(p.between), decibels(p.truth)));
        rows.push([vec![source.name.clone()], cells.collect(), vec![format!("{gain:+.1}")]].concat());
        if source.name == laboratory.library.shown().name {
            pictures = Some(differences);
        }
        laboratory.bar.inc(1);
    }
    let head = [vec!["data set, between / truth"], methods().map(|m| m.0).to_vec(), vec!["κ gains"]].concat();
    page.table(&head, &rows);
    let mean = gains.iter().sum::<f64>() / gains.len() as f64;
    page.paragraph(&format!("κ gains {mean:.1} dB in the mean."));
    if let Some(differences) = pictures {
        let names = methods().map(|m| m.0).join(", ");
        let caption =
            format!("{}: difference of the two axes' pictures, times {TIMES}: {names}", laboratory.library.shown().name);
        page.sheet("popping.png", &caption, &differences, 3)?;
    }
    Ok(())
}

/// The view whose direction has equal components along x and z, in voxels.
fn diagonal_view(grid: &Grid) -> Orbit {
    let spacing = grid.spacing();
    Orbit { azimuth: spacing.x.atan2(spacing.z).to_degrees(), elevation: 0.0, roll: 0.0 }
}

fn pop(laboratory: &Laboratory, source: &Source) -> Result<(Vec<Popped>, Vec<Frame>), Error> {
    let set = source.open()?;
    let mut bench = Bench::new(laboratory, &set)?;
    let view = diagonal_view(set.volume.grid());
    let truth = bench.truth(view, Kernel::Cubic)?;
    let (mut popped, mut differences) = (Vec::new(), Vec::new());
    for (_, settings) in methods() {
        let mut along =
            |axis| bench.unshaded(view, &Settings { algorithm: settings.algorithm.along(LayerAxis::Forced(axis)), ..settings });
        let [x, z] = [along(Axis::X)?, along(Axis::Z)?];
        popped.push(Popped { between: psnr(&x, &z), truth: psnr(&x, &truth) });
        differences.push(enlarged_difference(&x, &z, TIMES));
    }
    Ok((popped, differences))
}
