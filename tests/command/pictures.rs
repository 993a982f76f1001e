//! The command and its pictures: rotations, comparisons, and failed writes.

use crate::common::command::*;
use crate::common::{device, random_bytes, scaled, viewport};
use layersplat::color::{Curve, Exposure, Tone};
use layersplat::framing::{Fixed, Framing};
use layersplat::settings::{Blend, Look};
use layersplat::{Background, Camera, OpenOptions, Orbit, Projection, Renderer, Settings, TransferFunction, Volume};
use std::io::Write;
use std::path::Path;
use std::process::Command;

const DIMS: [usize; 3] = [14, 12, 10];
/// Colour of lines and text over black.
const INK: [u8; 3] = [236; 3];
const NAME: &str = "plain_14x12x10_uint8.raw";

/// A volume without symmetry.
fn write_volume(folder: &Path) -> Volume<'static> {
    std::fs::write(folder.join(NAME), random_bytes(DIMS, 7)).unwrap();
    Volume::open(folder.join(NAME), &OpenOptions::default()).unwrap()
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

fn run(folder: &Path, arguments: &str) -> Option<i32> {
    layersplat(folder, &words(arguments)).status.code()
}

fn decoded(path: &Path) -> Vec<u8> {
    image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).into_rgba8().into_raw()
}

/// Camera of an orbit that fits.
type Fitted<'a> = &'a dyn Fn(Orbit) -> Camera;

/// Size of a camera's view: half its height, or the distance of the eye.
fn reach(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Parallel { scale } => scale,
        Projection::Perspective { .. } => camera.position.distance(camera.focal_point),
    }
}

/// Frame k of n is the picture from azimuth + 360°·k/n; all frames share one framing.
#[test]
fn each_frame_of_a_turn_is_seen_from_its_own_side() {
    const FRAMES: usize = 4;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let volume = write_volume(f);
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let size = viewport(36, 28);
    let (centre, diagonal) = (volume.grid().centre(), volume.grid().diagonal());
    let framing = Framing::visible(&volume, &transfer, None);
    let around = Fixed { centre: Some(framing.centre()), ..Fixed::default() };
    let views: [(&str, [f64; 3], Fitted); 4] = [
        ("--azimuth 30 --elevation -10 --roll 15 --fit volume", [30.0, -10.0, 15.0], &|orbit| {
            Camera::fit_parallel(centre, diagonal, size, orbit)
        }),
        // The default elevation is 20°.
        ("--azimuth -50", [-50.0, 20.0, 0.0], &|orbit| framing.parallel(orbit, size, around)),
        ("--elevation 0 --perspective 40", [0.0; 3], &|orbit| framing.perspective(orbit, size, 40.0, around)),
        // Its sky and its lights stay in the world where the first camera sees them.
        ("--look studio --azimuth 15", [15.0, 20.0, 0.0], &|orbit| framing.parallel(orbit, size, around)),
    ];
    for (arguments, [azimuth, elevation, roll], camera) in views {
        let turn = format!("rotate {NAME} --frames {FRAMES} --size 36x28 --transfer fire -o turn {arguments}");
        assert_eq!(run(f, &turn), Some(0), "{arguments}");
        let side = |k: usize| Orbit { azimuth: azimuth + 90.0 * k as f64, elevation, roll };
        let cameras: Vec<Camera> = (0..FRAMES).map(|k| camera(side(k))).collect();
        // All frames use the size of the frame that needs most.
        let largest = cameras.iter().map(reach).fold(0.0, f64::max);
        let mut settings = Settings::default();
        if arguments.contains("studio") {
            settings = settings.with_look(Look::Studio).with_light_in_world(&cameras[0]).unwrap();
        }
        let mut shown: Vec<Vec<u8>> = Vec::new();
        for (k, camera) in cameras.into_iter().enumerate() {
            let camera = match camera.projection {
                Projection::Parallel { .. } => scaled(camera, largest),
                Projection::Perspective { .. } => {
                    let to_eye = (camera.position - camera.focal_point).normalize();
                    Camera { position: camera.focal_point + to_eye * largest, ..camera }
                }
            };
            let (frame, _) = renderer.render(&camera, size, &settings).unwrap();
            let found = decoded(&f.join(format!("turn/frame_{k:04}.png")));
            assert!(found == frame.with_curve(settings.curve()).to_rgba8(Background::BLACK), "{arguments}: frame {k} differs");
            assert!(!shown.contains(&found), "{arguments}: frame {k} repeats a previous one");
            shown.push(found);
        }
    }
    assert_eq!(names(&f.join("turn")).len(), FRAMES);
}

/// Without a transfer function, projections of values use grey ramps, which are reported. Named transfer functions and windows win.
#[test]
fn projections_of_values_are_grey() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let volume = write_volume(f);
    let framing = Framing::whole(&volume);
    let size = viewport(36, 28);
    let picture = |transfer: &TransferFunction, blend| {
        let camera = framing.parallel(Orbit { azimuth: 30.0, ..Orbit::default() }, size, Fixed::default());
        let mut renderer = Renderer::new(&device(), &volume, transfer).unwrap();
        renderer.render(&camera, size, &Settings { blend, ..Settings::default() }).unwrap().0.to_rgba8(Background::BLACK)
    };
    let (ramp, inverted) = (TransferFunction::grey_ramp(&volume), TransferFunction::inverted_grey_ramp(&volume));
    for (name, blend, transfer) in
        [("maximum", Blend::Maximum, &ramp), ("average", Blend::Average, &ramp), ("minimum", Blend::Minimum, &inverted)]
    {
        let render = format!("render {NAME} --size 36x28 --azimuth 30 --elevation 0 -o a.png --blend {name}");
        let done = layersplat(f, &words(&render));
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(done.status.success() && said.contains(&format!("transfer function: {}", transfer.name())), "{said}");
        let found = decoded(&f.join("a.png"));
        assert!(found == picture(transfer, blend), "{name}: not the library's picture");
        assert!(found.chunks_exact(4).all(|p| p[0] == p[1] && p[1] == p[2]) && found[..3] == [0; 3], "{name}: not grey on black");
        for chosen in ["--transfer grey", "--window 128,256"] {
            let said = layersplat(f, &words(&format!("{render} {chosen}"))).stderr;
            assert!(!String::from_utf8(said).unwrap().contains("grey ramp"), "{chosen}");
            assert!(decoded(&f.join("a.png")) != found, "{chosen} changes nothing");
        }
    }
    let fire = TransferFunction::builtin("fire", &volume).unwrap();
    assert!(picture(&fire, Blend::Maximum) != picture(&ramp, Blend::Maximum));
}

/// Limits that a picture just satisfies, and just violates.
#[test]
fn comparisons_succeed_and_fail_where_they_must() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_volume(f);
    for (name, azimuth) in [("a.npy", "0"), ("b.npy", "10")] {
        json(f, &["render", NAME, "--size", "20x16", "--transfer", "fire", "-o", name, "--azimuth", azimuth]);
    }
    for same in ["compare a.npy a.npy --min-psnr 1000", "compare b.npy b.npy --max-difference 0 --min-psnr 1000"] {
        assert_eq!(run(f, same), Some(0), "{same}");
    }
    let found = json(f, &["compare", "a.npy", "b.npy"]);
    let (psnr, difference) = (found["psnr"].as_f64().unwrap(), found["max_difference"].as_f64().unwrap());
    assert!((3.0..60.0).contains(&psnr) && (0.01..1.0).contains(&difference), "{found}");
    // Manual calculation: red, green and blue of all pixels, with a peak of 1.
    let [a, b] = ["a.npy", "b.npy"].map(|name| layersplat::image::read_image(&f.join(name)).unwrap());
    let pairs = a.pixels().iter().zip(b.pixels());
    let errors: Vec<f64> = pairs.flat_map(|(p, q)| [0, 1, 2].map(|c| (f64::from(p[c]) - f64::from(q[c])).powi(2))).collect();
    let by_hand = -10.0 * (errors.iter().sum::<f64>() / errors.len() as f64).log10();
    assert!((psnr - by_hand).abs() < 1e-9, "{psnr}, not {by_hand}");
    for (limits, code) in [
        (format!("--min-psnr {psnr}"), 0),
        (format!("--min-psnr {}", psnr + 1e-6), 1),
        (format!("--max-difference {difference}"), 0),
        (format!("--max-difference {}", difference - 1e-6), 1),
        // Violating one limit is enough.
        (format!("--max-difference {difference} --min-psnr {}", psnr + 1e-6), 1),
        (format!("--max-difference {} --min-psnr {psnr}", difference - 1e-6), 1),
    ] {
        assert_eq!(run(f, &format!("compare a.npy b.npy {limits}")), Some(code), "{limits}");
    }
}

/// gzip files may have several members. A header may end inside one.
#[test]
fn gzip_files_of_several_members() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_volume(f);
    let bytes = random_bytes(DIMS, 7);
    let zipped = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let pieces: Vec<Vec<u8>> = [&bytes[..1], &[], &bytes[1..700], &bytes[700..]].map(zipped).into();
    std::fs::write(f.join("pieces_14x12x10_uint8.raw.gz"), pieces.concat()).unwrap();
    let with_header: Vec<Vec<u8>> =
        [&[9; 20][..], &[[9; 5].as_slice(), &bytes[..300]].concat(), &bytes[300..]].map(zipped).into();
    std::fs::write(f.join("header_14x12x10_uint8.raw.gz"), with_header.concat()).unwrap();
    let picture = |volume: &str| {
        let render = format!("render {volume} --size 24x20 --transfer fire -o a.npy");
        assert_eq!(run(f, &render), Some(0), "{volume}");
        std::fs::read(f.join("a.npy")).unwrap()
    };
    let expected = picture(NAME);
    assert!(picture("pieces_14x12x10_uint8.raw.gz") == expected, "pieces");
    assert!(picture("header_14x12x10_uint8.raw.gz --header-bytes 25") == expected, "a header");
    // A missing and an extra member are detected.
    for (name, pieces) in [("less", pieces[..3].concat()), ("more", [pieces.concat(), pieces[0].clone()].concat())] {
        let name = format!("{name}_14x12x10_uint8.raw.gz");
        std::fs::write(f.join(&name), pieces).unwrap();
        refused(f, &["render", &name, "-o", "b.npy"], 1, &["1680"]);
    }
}

/// A partial write followed by an error or a panic.
#[test]
fn a_write_that_fails_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.npy");
    std::fs::write(&path, "old").unwrap();
    let written = layersplat::image::write_whole(&path, |out| {
        out.write_all(&[1; 100_000])?;
        Err(std::io::Error::other("the disk is full"))
    });
    assert!(written.unwrap_err().to_string().contains("old.npy"));
    let panicked = std::panic::catch_unwind(|| {
        layersplat::image::write_whole(&path, |out| {
            out.write_all(&[1; 100_000])?;
            panic!("of this test");
        })
    });
    assert!(panicked.is_err());
    assert_eq!((names(folder.path()), std::fs::read(&path).unwrap()), (vec!["old.npy".to_owned()], b"old".to_vec()));
    layersplat::image::write_whole(&path, |out| out.write_all(b"new")).unwrap();
    assert_eq!((names(folder.path()), std::fs::read(&path).unwrap()), (vec!["old.npy".to_owned()], b"new".to_vec()));
}

/// A failed write of the command, caused by a file size limit.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_does_not_fit_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_volume(f);
    let render = |script: &str, azimuth: &str, output: &str| {
        let script = format!("{script} exec \"$0\" render {NAME} --size 700x500 --transfer fire --azimuth {azimuth} -o {output}");
        Command::new("sh").current_dir(f).args(["-c", &script, env!("CARGO_BIN_EXE_layersplat")]).output().unwrap()
    };
    assert!(render("", "0", "a.npy").status.success());
    let old = std::fs::read(f.join("a.npy")).unwrap();
    let before = names(f);
    // 4000 shell blocks, of 512 or 1024 bytes, hold any kernel, but not the 5 600 000 bytes of the picture. A process that does not ignore
    // SIGXFSZ would be killed.
    let limited = "trap '' XFSZ; ulimit -f 4000;";
    for output in ["a.npy", "b.npy"] {
        let done = render(limited, "40", output);
        let message = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(1), "{message}");
        assert!(message.contains(output) && message.contains("too large"), "{message}");
        assert_eq!(names(f), before, "{output}");
        assert!(std::fs::read(f.join("a.npy")).unwrap() == old, "{output}: the old picture was changed");
    }
    assert!(render("", "40", "a.npy").status.success());
    assert!(std::fs::read(f.join("a.npy")).unwrap() != old, "the same picture from another side");
}

/// Files of every format and encoding hold the library's picture, also on standard output, in contact sheets and in folders of frames.
#[test]
fn pictures_are_encoded_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    write_volume(f);
    let scene = format!("{NAME} --transfer fire --size 36x28 --no-metadata");
    let render = |more: &str| {
        let done = layersplat(f, &words(&format!("render {scene} {more}")));
        assert!(done.status.success(), "{more}: {}", String::from_utf8_lossy(&done.stderr));
        done.stdout
    };
    render("-o plain.npy");
    render("-o plain.png");
    let plain = layersplat::image::read_image(&f.join("plain.npy")).unwrap();
    for name in ["a.tif", "a.webp"] {
        render(&format!("-o {name}"));
        assert_eq!(decoded(&f.join(name)), decoded(&f.join("plain.png")), "{name}");
        let ending = &name[2..];
        assert!(render(&format!("-o {ending}:-")) == std::fs::read(f.join(name)).unwrap(), "{name} on standard output");
        assert_eq!(run(f, &format!("compare {name} plain.png --max-difference 0")), Some(0));
    }
    // Where 8 bits are off by up to half a step of 255, 16 bits are off by half a step of 65535.
    for name in ["deep.png", "deep.tif"] {
        render(&format!("-o {name} --bits 16 --dpi 150"));
        let found =
            layersplat::image::read_image(&f.join(name)).unwrap().compare(&plain.clone().over(Background::BLACK)).unwrap();
        assert!(found.max_difference < 0.6 / 65_535.0, "{name}: {}", found.max_difference);
    }
    // The studio: floats stay linear.
    render("-o linear.npy --look studio");
    let linear = layersplat::image::read_image(&f.join("linear.npy")).unwrap();
    for (options, stops, tone) in [("", 0.0, Tone::Shoulder), ("--exposure 1 --tone none", 1.0, Tone::None)] {
        render(&format!("-o shown.png --look studio {options}"));
        let curve = Curve { linear: Some(Exposure { stops, tone }), gamma: 1.0 };
        let expected = linear.clone().with_curve(curve).to_rgba8(Background::BLACK);
        assert_eq!(decoded(&f.join("shown.png")), expected, "{options}");
    }
    // Annotations keep their colours beside it, and in files of floats they are in linear light, too.
    let wide = scene.replace("36x28", "160x120");
    let draw = |name: &str, more: &str| assert_eq!(run(f, &format!("render {wide} -o {name} {more}")), Some(0), "{more}");
    let legend = "--legend --legend-place over --axes";
    let [lit, plain_over] = ["--look studio", ""].map(|look| {
        draw("over.png", &format!("{legend} {look}"));
        decoded(&f.join("over.png"))
    });
    let inked: Vec<usize> = (0..plain_over.len() / 4).filter(|n| plain_over[4 * n..][..3] == INK).collect();
    assert!(inked.len() > 20 && inked.iter().all(|n| lit[4 * n..][..3] == INK), "{}", inked.len());
    draw("over.npy", &format!("--look studio {legend}"));
    draw("alone.npy", "--look studio");
    let [over, alone] = ["over.npy", "alone.npy"].map(|name| layersplat::image::read_image(&f.join(name)).unwrap());
    let ink = layersplat::color::linear(f64::from(INK[0]) / 255.0) as f32;
    assert!(inked.iter().all(|&n| over.pixels()[n][..3] == [ink; 3]));
    let same = over.pixels().iter().zip(alone.pixels()).filter(|(a, b)| a == b && b[3] > 0.0).count();
    assert!(same > alone.pixels().len() / 5, "{same} pixels of the volume are as they were");
    // One picture of a contact sheet has the legend; all have the curve once.
    assert_eq!(run(f, &format!("views {wide} -o sides-legend.png --look studio --legend --legend-place over")), Some(0));
    assert_eq!(run(f, &format!("views {wide} -o sides.png --look studio")), Some(0));
    let [with, without] = ["sides-legend.png", "sides.png"].map(|name| decoded(&f.join(name)));
    let column = |n: usize| n % (4 * 160) / 160;
    let differ =
        |c: usize| (0..with.len() / 4).filter(|&n| column(n) == c && with[4 * n..][..4] != without[4 * n..][..4]).count();
    assert!((1..160 * 120 / 2).contains(&differ(3)) && (0..3).all(|c| differ(c) == 0), "{:?}", [0, 1, 2, 3].map(differ));
    // Gamma is for integers.
    render("-o raised.npy --gamma 2");
    render("-o raised.png --gamma 2");
    let raised = |name: &str| layersplat::image::read_image(&f.join(name)).unwrap();
    assert_eq!(raised("raised.npy"), plain);
    assert_eq!(
        decoded(&f.join("raised.png")),
        plain.clone().with_curve(Curve { linear: None, gamma: 2.0 }).to_rgba8(Background::BLACK)
    );
    assert_ne!(decoded(&f.join("raised.png")), decoded(&f.join("plain.png")));
    for (command, folder, file) in [("rotate --frames 2", "turned", "/frame_0001.png"), ("views", "sides.png", "")] {
        assert_eq!(run(f, &format!("{command} {scene} -o {folder}")), Some(0));
        assert_eq!(run(f, &format!("{command} {scene} --gamma 2 -o raised-{folder}")), Some(0));
        assert_ne!(raised(&format!("raised-{folder}{file}")), raised(&format!("{folder}{file}")), "{command}");
    }
    render("-o dithered.png --dither");
    let [dithered, rounded] = ["dithered.png", "plain.png"].map(|name| decoded(&f.join(name)));
    let steps: Vec<u8> = dithered.iter().zip(&rounded).map(|(a, b)| a.abs_diff(*b)).collect();
    assert!(steps.iter().all(|&step| step <= 1) && steps.contains(&1));
    // The resolution, in pixels per metre.
    let has_resolution = |name: &str| std::fs::read(f.join(name)).unwrap().windows(4).any(|word| word == b"pHYs");
    render("-o print.png --dpi 300");
    assert!(has_resolution("print.png") && !has_resolution("plain.png"));
    assert_eq!(run(f, &format!("rotate {scene} --frames 2 --dpi 300 -o turn")), Some(0));
    assert!(has_resolution("turn/frame_0001.png"));
    assert_eq!(run(f, &format!("views {scene} --dpi 300 -o views.png")), Some(0));
    assert!(has_resolution("views.png"));
    std::fs::write(f.join("views.ndjson"), r#"{"output": "many.png"}"#).unwrap();
    render("--cameras views.ndjson --dpi 300");
    assert!(std::fs::read(f.join("many.png")).unwrap() == std::fs::read(f.join("print.png")).unwrap());
    // The colour bar alone; larger letters make it wider.
    render("--legend-only --units HU -o bar.png");
    render("--legend-only --units HU --dpi 72 --font-size 30 -o large.png");
    let sides = |name: &str| image::image_dimensions(f.join(name)).unwrap();
    assert!(sides("bar.png").0 < sides("large.png").0 && decoded(&f.join("bar.png")).iter().any(|&value| value > 100));
    // As vector graphics, with the command in the metadata, and without it.
    for name in ["bar.svg", "bar.pdf"] {
        render(&format!("--legend-only --units HU -o {name}"));
        let file = std::fs::read(f.join(name)).unwrap();
        assert!(render(&format!("--legend-only --units HU -o {}:-", &name[4..])) == file, "{name} on standard output");
        let told = scene.replace(" --no-metadata", "");
        assert_eq!(run(f, &format!("render {told} --legend-only --units HU -o told-{name}")), Some(0));
        let told = std::fs::read(f.join(format!("told-{name}"))).unwrap();
        assert!(told.len() > file.len(), "{name}");
        let text = String::from_utf8_lossy(&told).into_owned();
        assert!(name == "bar.pdf" || (text.contains("--legend-only --units HU -o told-bar.svg</desc>") && text.contains("HU\"")));
    }
    // What a format cannot hold is refused before anything is rendered.
    for (command, says) in [
        ("render", "-o no.jpg --bits 16|write .png or .tif|--bits"),
        ("render", "-o no.webp --dpi 300|no resolution|--dpi"),
        ("render", "-o no.npy --dither|no dithering|--dither"),
        ("render", "-o no.png --bits 16 --dither|8 bits|--dither"),
        ("render", "-o no.png --bits 12|8 or 16|--bits"),
        ("render", "-o no.png --dpi 0|--dpi"),
        ("render", "-o no.png --dpi 300 --font-size 9999|1 to 1000|--font-size"),
        ("render", "-o no.png --font-size 9|--dpi"),
        ("render", "-o no.png --legend-only --axes|--axes"),
        ("render", "-o no.svg|.png, .jpg"),
        ("render", "-o no.doc --legend-only|.svg or .pdf"),
        ("render", "-o no.svg --legend-only --bits 16|shapes, not pixels|--bits"),
        ("render", "-o no.pdf --legend-only --dither|shapes, not pixels|--dither"),
        ("views", "-o no.exr --bits 8|32-bit floats|--bits"),
        ("rotate", "-o no.gif --dpi 100|folder of pictures|--dpi"),
        ("rotate", "-o no --bits 16 --dither|8 bits|--dither"),
    ] {
        let (options, said) = says.split_once('|').unwrap();
        let all = format!("{command} {scene} {options}");
        refused(f, &words(&all), 2, &said.split('|').collect::<Vec<_>>());
    }
}

/// Depths of one picture and of many equal those of the library. Other file formats, volumes that do not fit and values without depth are
/// rejected before a file is created.
#[test]
fn depths_stand_beside_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let volume = write_volume(f);
    let render = format!("render {NAME} --transfer fire --size 32x24 --azimuth 30 --depth --no-metadata");
    assert_eq!(run(f, &format!("{render} -o one.exr")), Some(0));
    std::fs::write(f.join("views.ndjson"), r#"{"output": "many.exr"}"#).unwrap();
    assert_eq!(run(f, &format!("{render} --cameras views.ndjson")), Some(0));
    assert_eq!(std::fs::read(f.join("one.exr")).unwrap(), std::fs::read(f.join("many.exr")).unwrap());
    let transfer = TransferFunction::builtin("fire", &volume).unwrap();
    let size = viewport(32, 24);
    let orbit = Orbit { azimuth: 30.0, elevation: 0.0, roll: 0.0 };
    let camera = Framing::visible(&volume, &transfer, None).parallel(orbit, size, Fixed::default());
    let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
    let depths = renderer.depths(&camera, size, &Settings::default()).unwrap();
    assert!(depths.first().iter().any(|depth| depth.is_finite()));
    renderer.render(&camera, size, &Settings::default()).unwrap().0.save_with_depths(f.join("own.exr"), None, &depths).unwrap();
    assert_eq!(std::fs::read(f.join("one.exr")).unwrap(), std::fs::read(f.join("own.exr")).unwrap());
    // A streamed volume whose voxels fit has the same depths.
    assert_eq!(run(f, &format!("{render} -o own.exr --memory 64M")), Some(0));
    assert_eq!(std::fs::read(f.join("one.exr")).unwrap(), std::fs::read(f.join("own.exr")).unwrap());
    for (more, says) in [("-o a.png", "use an .exr file"), ("-o a.exr --blend maximum", "composite and iso")] {
        let refused = layersplat(f, &words(&format!("{render} {more}")));
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && said.contains(says), "{more}: {said}");
    }
    // The layers of the picture fit in parts, but rays need all voxels.
    let large = "render builtin:hydrogen@112 --transfer fire --size 32x24 --depth -o a.exr --memory 1500k";
    refused(f, &words(large), 2, &[" parts of up to ", "a depth picture (rays", "set at least", "--memory BYTES"]);
    assert_eq!(names(f), ["many.exr", "one.exr", "own.exr", NAME, "views.ndjson"]);
}
