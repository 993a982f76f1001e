//! A minute at a viewer: what a user does, frame by frame, after the programs for it were built ahead.

use crate::changes::{cropped, opaque, orbit, zoomed};
use crate::milliseconds;
use crate::scene::{Scene, device, viewport};
use layersplat::device::ProgramBuilds;
use layersplat::renderer::ExpectedFrames;
use layersplat::settings::{Light, Lights, Settings, Shading};
use layersplat::{Background, Camera, Error, Quality, Renderer, TransferFunction, glam::DVec3};
use std::process::Command;
use std::time::Instant;

/// Frames of each turn.
const TURN: usize = 72;
/// How many times larger the view becomes, from far to near.
const FAR_TO_NEAR: (f64, f64) = (0.3, 12.0);
/// Longest that a frame may take beyond its drawing time, in milliseconds.
const LONGEST_PAUSE: f64 = 100.0;

/// When programs are built.
#[derive(Clone, Copy, PartialEq)]
pub enum Compiles {
    /// Before the first frame.
    Before,
    /// While frames are drawn, compiled by another process.
    Beside,
    /// The same, and frames are drawn by general programs meanwhile.
    BesideGeneral,
    /// While frames are drawn.
    InThisProcess,
}

/// Frames of one kind of action.
struct Part {
    name: &'static str,
    frames: Vec<(Camera, Settings, TransferFunction)>,
}

/// Numbers from `from` to `to`, evenly, both included.
fn evenly(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |n| from + (to - from) * n as f64 / (count - 1) as f64)
}

/// Ten of them: of other opacities, of other values, and opaque.
fn transfer_functions(scene: &Scene) -> Vec<TransferFunction> {
    let own = &scene.transfer;
    let (lowest, highest) = own.range();
    let faded = [0.1, 0.3, 0.6, 0.9].map(|factor| own.faded(factor).expect("a factor below 1"));
    let moved = evenly(0.05, 0.25, 5).map(|share| {
        let by = share * (highest - lowest);
        own.stretched(lowest + by, highest - by).expect("a shorter range")
    });
    faded.into_iter().chain(moved).chain([opaque(scene)]).collect()
}

/// The settings that the script goes through: what a viewer says it may need.
fn settings(scene: &Scene) -> [Settings; 6] {
    let standard = Settings::default();
    let draft = Quality::Draft.settings();
    let lights = Lights::new(&[
        Light { strength: 0.7, ..Light::AT_CAMERA },
        Light { strength: 0.5, ..Light::towards(DVec3::new(1.0, 1.0, 0.5)) },
    ])
    .expect("two lights");
    let two_lights = Settings { shading: Some(Shading { lights, ..Shading::default() }), ..standard };
    let unlit = Settings { shading: None, ..standard };
    let crop = Settings { clipping: cropped(scene), ..standard };
    [standard, draft, two_lights, unlit, crop, Settings { clipping: cropped(scene), ..draft }]
}

fn script(scene: &Scene) -> Vec<Part> {
    let [standard, draft, two_lights, unlit, crop, _] = settings(scene);
    let own = || scene.transfer.clone();
    let view = |azimuth| orbit(scene, azimuth, 0.0);
    let seen = |name, cameras: &mut dyn Iterator<Item = Camera>, settings: Settings| Part {
        name,
        frames: cameras.map(|camera| (camera, settings, own())).collect(),
    };
    let grid = scene.volume.grid();
    let raised = |elevation| {
        let orbit = layersplat::Orbit { azimuth: 30.0, elevation, roll: 0.0 };
        Camera::fit_parallel(grid.centre(), grid.diagonal(), viewport(), orbit)
    };
    let (far, near) = FAR_TO_NEAR;
    vec![
        seen("turn about y", &mut evenly(0.0, 360.0, TURN).map(view), standard),
        seen("turn over the top", &mut evenly(0.0, 90.0, TURN / 3).map(raised), standard),
        Part {
            name: "ten transfer functions",
            frames: transfer_functions(scene).into_iter().map(|transfer| (view(30.0), standard, transfer)).collect(),
        },
        Part {
            name: "lights on and off",
            frames: [two_lights, unlit, standard, unlit, two_lights].map(|settings| (view(30.0), settings, own())).into(),
        },
        seen("crop, and turn", &mut evenly(0.0, 120.0, TURN / 3).map(view), crop),
        seen(
            "zoom from far to near",
            &mut evenly(far.ln(), near.ln(), TURN / 3).map(|zoom| zoomed(view(30.0), zoom.exp())),
            standard,
        ),
        seen("turn in draft", &mut evenly(0.0, 360.0, TURN).map(view), draft),
        seen("roll", &mut evenly(0.0, 90.0, TURN / 4).map(|roll| orbit(scene, 30.0, roll)), standard),
    ]
}

/// Goes through the script: Prints what each part made the user wait for.
pub fn minute(scene: &Scene, compiles: Compiles) {
    let device = device();
    if matches!(compiles, Compiles::Beside | Compiles::BesideGeneral) {
        let program = std::env::current_exe().expect("this program");
        device.set_compiler_command(move || Command::new(&program));
    }
    let mut renderer = Renderer::new(&device, &scene.volume, &scene.transfer).expect("a renderer");
    renderer.use_general_programs(compiles == Compiles::BesideGeneral);
    let began = Instant::now();
    let expected = ExpectedFrames::new(&settings(scene), viewport()).with_parallel_views().with_any_transfer_function();
    let builds = renderer.warm_up(&expected, |built| assert!(!matches!(built, Err(Error::Build { .. })), "programs that build"));
    if compiles == Compiles::Before {
        builds.wait();
    }
    let told = |builds: &ProgramBuilds| {
        let (built, all) = builds.progress();
        let all = all.map_or("kernels that are being found".into(), |all| format!("{all} kernels"));
        println!("{built} of {all} built after {:.1} s\n", began.elapsed().as_secs_f64());
    };
    told(&builds);
    println!("| part | frames | drawing, the slowest | pause, the longest | pauses of more than {LONGEST_PAUSE} ms |");
    println!("|---|---|---|---|---|");
    for Part { name, frames } in script(scene) {
        let (mut slowest, mut longest, mut pauses) = (0.0_f64, 0.0_f64, 0);
        for (camera, settings, transfer) in &frames {
            renderer.set_transfer_function(transfer);
            let [first, drawing] = frame_times(&mut renderer, camera, settings);
            slowest = slowest.max(drawing);
            longest = longest.max(first - drawing);
            pauses += usize::from(first - drawing > LONGEST_PAUSE);
        }
        println!("| {name} | {} | {slowest:.0} ms | {longest:.0} ms | {pauses} |", frames.len());
    }
    println!();
    told(&builds);
}

/// The first drawing of a frame, and the faster one of two more, in milliseconds.
fn frame_times(renderer: &mut Renderer, camera: &Camera, settings: &Settings) -> [f64; 2] {
    let mut draw = || {
        milliseconds(|| {
            renderer.render_rgba8(camera, viewport(), settings, Background::BLACK).expect("a frame");
        })
    };
    let first = draw();
    [first, draw().min(draw())]
}
