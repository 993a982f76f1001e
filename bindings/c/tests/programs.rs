//! Compiles and runs the programs of examples/c.

use layersplat::{Background, DeviceChoice, Framing, OpenOptions, Orbit, Quality, TransferFunction, Viewport};
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The folder of the libraries that cargo built for this test: the test's own.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// Runs a command that must succeed. Returns its standard output.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let [stdout, stderr] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(output.status.success(), "{command:?}: {}\n{stdout}\n{stderr}", output.status);
    stdout
}

const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];

/// Compiles an example against one of the libraries.
fn compile(name: &str, to: &Path, library: &[&str]) -> PathBuf {
    let program = to.join(name);
    let mut compiler = Command::new("cc");
    compiler.args(STRICT).args(["-std=c11", "-g"]).current_dir(root());
    compiler.arg(format!("examples/c/{name}.c")).arg("-Ibindings/c/include").arg("-o").arg(&program);
    compiler.args(library).args(["-l:libOpenCL.so.1", "-lgcc_s", "-lpthread", "-ldl", "-lm"]);
    run(&mut compiler);
    program
}

fn shared(name: &str, to: &Path) -> PathBuf {
    let folder = libraries().display().to_string();
    compile(name, to, &[&format!("-L{folder}"), "-llayersplat_c", &format!("-Wl,-rpath,{folder}")])
}

/// Saves the library's picture of the scene of plain.c.
fn save_expected(path: &Path) {
    let volume = layersplat::Volume::open("builtin:hydrogen@48", &OpenOptions::default()).unwrap();
    let transfer = TransferFunction::automatic(&volume);
    let device = layersplat::Device::open(&DeviceChoice::Default).unwrap();
    let viewport = Viewport::new(256, 192).unwrap();
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = Framing::visible(&volume, &transfer, None).perspective(orbit, viewport, 30.0, Default::default());
    let mut settings = Quality::Standard.settings();
    settings.shading.as_mut().unwrap().specular = 0.4;
    let mut renderer = layersplat::Renderer::new(&device, &volume, &transfer).unwrap();
    let (frame, _) = renderer.render(&camera, viewport, &settings).unwrap();
    assert!(frame.pixels().iter().any(|p| p[3] > 0.1));
    frame.save(path, Some(Background::BLACK)).unwrap();
}

#[test]
fn the_plain_program_draws_the_picture_of_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let archive = libraries().join("liblayersplat_c.a").display().to_string();
    let [dynamic, fixed] = ["dynamic", "fixed"].map(|name| folder.path().join(name));
    for to in [&dynamic, &fixed] {
        std::fs::create_dir(to).unwrap();
    }
    let programs = [shared("plain", &dynamic), compile("plain", &fixed, &[&archive])];
    for file in ["picture.png", "picture.npy"] {
        let expected = folder.path().join(file);
        save_expected(&expected);
        for program in &programs {
            let found = program.with_file_name(file);
            run(Command::new(program).arg(&found));
            assert!(std::fs::read(found).unwrap() == std::fs::read(&expected).unwrap(), "{}", program.display());
        }
    }
    let failed = Command::new(&programs[0]).args(["a.png", "builtin:pink"]).output().unwrap();
    assert!(!failed.status.success() && String::from_utf8_lossy(&failed.stderr).contains("error 3: unknown"), "{failed:?}");
}

/// The program itself checks its reference counts.
#[test]
fn the_program_with_its_own_opencl_context_draws_its_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let program = shared("own_opencl", folder.path());
    let pictures = ["one.npy", "two.npy"].map(|name| folder.path().join(name));
    let output = run(Command::new(program).args(&pictures));
    let difference = output.lines().next().and_then(|line| line.rsplit(' ').next()).and_then(|n| n.parse::<f64>().ok());
    assert!(difference.is_some_and(|d| d > 0.05), "{output}");
    assert_eq!(output.matches("references:").count(), 3, "{output}");
    for picture in &pictures {
        assert!(std::fs::metadata(picture).unwrap().len() > 160 * 120 * 16);
    }
}

/// Alone, before and after OpenCL's header; in C, and in C++ if a compiler is installed.
#[test]
fn the_header_compiles_in_c_and_cpp() {
    let folder = tempfile::tempdir().unwrap();
    let orders = [
        "#include <layersplat.h>",
        "#include \"opencl.h\"\n#include <layersplat.h>",
        "#include <layersplat.h>\n#include \"opencl.h\"",
    ];
    for (compiler, standard, file) in [("cc", "-std=c99", "header.c"), ("c++", "-std=c++11", "header.cpp")] {
        if Command::new(compiler).arg("--version").output().is_err() {
            eprintln!("not run: there is no {compiler}");
            continue;
        }
        for order in orders {
            let source = folder.path().join(file);
            std::fs::write(&source, format!("{order}\nint main(void) {{ return 0; }}\n")).unwrap();
            let mut command = Command::new(compiler);
            command.args(STRICT).args([standard, "-fsyntax-only", "-Ibindings/c/include", "-Iexamples/c"]);
            run(command.arg(&source).current_dir(root()));
        }
    }
}
