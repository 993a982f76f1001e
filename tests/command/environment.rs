//! The command in unusual environments: without OpenCL, without a home folder, interrupted.

use crate::common::command::*;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

#[test]
fn no_opencl_names_the_package() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("vendors");
    std::fs::create_dir(&empty).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_layersplat")).arg("devices").env("OCL_ICD_VENDORS", &empty).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("pocl-opencl-icd"), "{message}");
}

/// Without MPI support, each process would do all of the work and write the same file.
#[cfg(not(feature = "mpi"))]
#[test]
fn under_mpirun_it_says_what_to_build() {
    let folder = tempfile::tempdir().unwrap();
    let render = |processes: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        command.args(["render", "builtin:cube@4", "--size", "8x8"]).env("OMPI_COMM_WORLD_SIZE", processes);
        command.current_dir(folder.path()).output().unwrap()
    };
    let output = render("2");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("--features mpi") && !folder.path().join("layersplat.png").exists(), "{message}");
    assert!(render("1").status.success());
}

/// The command starts without OpenCL and says what to install. So do programs that use the library, except with the feature `gl-interop`.
#[cfg(target_os = "linux")]
#[cfg_attr(feature = "gl-interop", ignore = "ocl-interop links OpenCL and OpenGL: docs/dev/gl.md")]
#[test]
fn opencl_is_loaded_at_run_time() {
    let output = Command::new("readelf").args(["-d", env!("CARGO_BIN_EXE_layersplat")]).output().expect("binutils");
    let needed = String::from_utf8_lossy(&output.stdout);
    assert!(needed.contains("libc.so"), "{needed}");
    assert!(!needed.contains("OpenCL") && !needed.contains("libGL"), "{needed}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_implementation_that_cannot_be_loaded_says_why() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("broken.icd"), "libno_such_implementation.so.7\n").unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_layersplat")).arg("devices").env("OCL_ICD_VENDORS", folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    for part in ["broken.icd: ", "libno_such_implementation.so.7: cannot open shared object file", "pocl-opencl-icd"] {
        assert!(message.contains(part), "{message}");
    }
}

/// Runs the command with PoCL only, and with only these variables for the location of PoCL's kernel cache.
fn with_pocl_alone(folder: &Path, variables: &[(&str, &Path)], arguments: &[&str]) -> (Option<i32>, String) {
    let vendors = folder.join("vendors");
    if !vendors.is_dir() {
        std::fs::create_dir(&vendors).unwrap();
        let system = std::env::var_os("OCL_ICD_VENDORS").map_or("/etc/OpenCL/vendors".into(), PathBuf::from);
        let files = std::fs::read_dir(system).unwrap().map(|entry| entry.unwrap().path());
        let pocl = files.filter(|file| std::fs::read_to_string(file).is_ok_and(|text| text.contains("pocl")));
        for file in pocl {
            std::fs::copy(&file, vendors.join(file.file_name().unwrap())).unwrap();
        }
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    command.current_dir(folder).args(arguments).env("OCL_ICD_VENDORS", &vendors).env_remove("LAYERSPLAT_DEVICE");
    for name in ["POCL_CACHE_DIR", "XDG_CACHE_HOME", "HOME"] {
        command.env_remove(name);
    }
    let output = command.envs(variables.iter().copied()).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A folder that cannot be created, not even by root.
#[cfg(target_os = "linux")]
const IMPOSSIBLE: &str = "/proc/nonexistent";

#[cfg(target_os = "linux")]
#[test]
fn kernels_are_kept_elsewhere_where_the_default_cannot_be_written() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let temporary = f.join("temporary");
    let run = |name, arguments: &[&str]| {
        let variables = [("HOME", f), (name, Path::new(IMPOSSIBLE)), ("TMPDIR", &temporary)];
        let (code, message) = with_pocl_alone(f, &variables, arguments);
        assert_eq!(code, Some(0), "{name}: {message}");
        names(&temporary)
    };
    std::fs::create_dir(&temporary).unwrap();
    let kept = run("HOME", &["devices"]);
    assert!(matches!(&kept[..], [one] if one.starts_with("layersplat-kernels-of-")), "{kept:?}");
    let kernels = temporary.join(&kept[0]);
    assert_eq!(kernels.metadata().unwrap().permissions().mode() & 0o777, 0o700, "other users must not write kernels there");
    let render = ["render", "builtin:cube@4", "--size", "8x8", "--device-unchecked"];
    assert_eq!(run("XDG_CACHE_HOME", &render), kept, "the folder must be reused");
    assert!(!names(&kernels).is_empty(), "no kernels were kept");
    // A folder that others can write to is never used.
    std::fs::set_permissions(&kernels, PermissionsExt::from_mode(0o777)).unwrap();
    assert_eq!(run("HOME", &["devices"]).len(), 2);
}

#[cfg(target_os = "linux")]
#[test]
fn an_empty_name_of_the_kernel_cache_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let variables = [("POCL_CACHE_DIR", Path::new("")), ("HOME", f), ("TMPDIR", f)];
    let (code, message) = with_pocl_alone(f, &variables, &["devices"]);
    assert_eq!((code, names(f)), (Some(0), vec![".cache".into(), "vendors".into()]), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_kernel_cache_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let impossible = Path::new(IMPOSSIBLE);
    for variables in [
        &[("POCL_CACHE_DIR", impossible)][..],
        &[("POCL_CACHE_DIR", Path::new("/dev/null/kernels"))],
        &[("XDG_CACHE_HOME", impossible), ("TMPDIR", impossible)],
        &[("HOME", impossible), ("TMPDIR", impossible)],
    ] {
        for command in [&["devices"][..], &["render", "builtin:cube@4"]] {
            let (code, message) = with_pocl_alone(f, variables, command);
            assert_eq!(code, Some(1), "{variables:?}: {message}");
            let place = variables[0].1.to_str().unwrap();
            assert!(message.contains(place) && message.contains("POCL_CACHE_DIR"), "{variables:?}: {message}");
            assert!(!message.contains("install") && !message.contains("panicked"), "{variables:?}: {message}");
        }
    }
    assert_eq!(names(f), ["vendors"]);
}

/// A full disk under the kernel cache is no fault of the driver: PoCL's compiler ends the process that checks, or builds nothing.
#[cfg(unix)]
#[test]
fn a_full_disk_under_the_kernel_cache_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    // Nothing can be built with 4 KiB; with 128 KiB the compiler starts, and fails in the middle.
    for blocks in [8, 256] {
        let kernels = f.join(format!("kernels-{blocks}"));
        // No file may be larger, and writing more is an error instead of a signal: as on a full disk. Blocks have 512 bytes.
        let script = format!("trap '' XFSZ; ulimit -c 0; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_layersplat"), "render", "builtin:cube@4", "--size", "8x8"]);
        command.args(["--device", "pocl"]).current_dir(f).env("POCL_CACHE_DIR", &kernels).env("XDG_CACHE_HOME", f);
        let output = command.output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{blocks}: {message}");
        assert!(message.contains(kernels.to_str().unwrap()) && message.contains("POCL_CACHE_DIR"), "{blocks}: {message}");
        assert!(!message.contains("update its driver"), "{blocks}: {message}");
        let kept = f.join("layersplat/checks");
        assert!(!kept.exists() || std::fs::read_dir(kept).unwrap().count() == 0, "{blocks}: a verdict is kept");
    }
}

/// Compiling takes seconds, with an empty cache, and is announced, also to a pipe; with a warm cache nothing is said.
#[test]
fn compiling_kernels_is_announced() {
    let folder = tempfile::tempdir().unwrap();
    let messages = [(); 2].map(|()| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        command.args(["render", "builtin:hydrogen@16", "--device-unchecked", "--size", "16x16", "--device", "pocl"]);
        command.current_dir(&folder).env("POCL_CACHE_DIR", folder.path().join("kernels")).env("XDG_CACHE_HOME", folder.path());
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    });
    let [cold, warm] = messages.each_ref().map(|message| message.matches("compiling kernels, once per set of options\n").count());
    assert_eq!((cold, warm), (1, 0), "{messages:?}");
    assert!(messages[0].contains("compiled kernels in ") && !messages[1].contains("compiled"), "{messages:?}");
}

/// Names that files have while they are written.
#[cfg(target_os = "linux")]
fn unfinished(folder: &Path) -> bool {
    std::fs::read_dir(folder)
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with(".layersplat-")))
}

/// Whether the caller of the tests ignores this signal.
#[cfg(target_os = "linux")]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let bits = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(bits.trim(), 16).unwrap() >> (signal - 1) & 1 == 1
}

/// When interrupted while writing a file, `rotate` completes it and leaves nothing else.
#[cfg(target_os = "linux")]
#[test]
fn signals_leave_no_file_half_written() {
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let folder = tempfile::tempdir().unwrap();
        let turn = folder.path().join("turn");
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        command.args(["rotate", "builtin:cube@4", "--frames", "2000", "--size", "1500x1500", "-o"]).arg(&turn);
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        // A few frames in, at the start of a file.
        while child.try_wait().unwrap().is_none() && !(unfinished(&turn) && names(&turn).len() > 2) {
            std::thread::sleep(std::time::Duration::from_micros(100));
        }
        assert!(Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap().success());
        if is_ignored(number) {
            // As required, the command continues.
            assert!(child.try_wait().unwrap().is_none());
            child.kill().unwrap();
            child.wait().unwrap();
            continue;
        }
        assert_eq!(child.wait().unwrap().code(), Some(128 + number), "{name}");
        let left = names(&turn);
        let expected: Vec<String> = (0..left.len()).map(|n| format!("frame_{n:04}.png")).collect();
        assert_eq!(left, expected, "{name}");
        for frame in left {
            layersplat::image::read_image(&turn.join(frame)).unwrap();
        }
    }
}

/// Runs the command with any arguments.
fn run(folder: &Path, arguments: &[&OsStr]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_layersplat")).current_dir(folder).args(arguments).output().unwrap()
}

/// Presets as ParaView and editors write them: with a byte-order mark, a logarithmic scale, categorical colours.
const PRESET: &str = "\u{feff}[{\"Name\": \"odd one\", \"ColorSpace\": \"RGB\", \"UseLogScale\": 1, \"IndexedColors\": [1, 0, 0], \
                      \"RGBPoints\": [0, 1, 0, 0, 7, 1, 1, 0], \"Points\": [0, 0, 0.5, 0, 7, 1, 0.5, 0]}]";

/// Upper-case names, as old cameras and systems wrote them.
#[test]
fn names_in_capitals_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("CUBE_2X2X2_UINT8.RAW"), [0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut encoder, &[0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    std::fs::write(f.join("cube_2x2x2_uint8.Raw.GZ"), encoder.finish().unwrap()).unwrap();
    for name in ["CUBE_2X2X2_UINT8.RAW", "cube_2x2x2_uint8.Raw.GZ"] {
        let info = json(f, &["info", name]);
        assert_eq!((&info["max"], &info["dims"][0], &info["type"]), (&7.0.into(), &2.into(), &"uint8".into()), "{name}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_unicode_are_read_and_written() {
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let name = |end: &str| OsString::from_vec([b"caf\xe9".as_slice(), end.as_bytes()].concat());
    let (volume, preset, picture) = (name("_2x2x2_uint8.raw"), name(".json"), name(".npy"));
    std::fs::write(f.join(&volume), [0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    std::fs::write(f.join(&preset), PRESET).unwrap();
    for preset in [preset, name(".json#odd one")] {
        let arguments = [
            OsStr::new("render"),
            &volume,
            "--transfer".as_ref(),
            &preset,
            "--size".as_ref(),
            "8x8".as_ref(),
            "-o".as_ref(),
            &picture,
        ];
        let output = run(f, &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{message}");
        assert!(layersplat::image::read_image(&f.join(&picture)).unwrap().pixels().iter().any(|p| p[3] > 0.0));
        std::fs::remove_file(f.join(&picture)).unwrap();
    }
    let output = run(f, &[OsStr::new("info"), OsStr::from_bytes(b"\xe9_2x2x2_uint8.raw")]);
    assert_eq!(output.status.code(), Some(1), "a missing file must give exit code 1");
}

/// Ignored properties and errors are reported, without colour codes if standard error is not a terminal.
#[test]
fn warnings_name_what_a_preset_has_and_are_not_coloured() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("odd.json"), PRESET).unwrap();
    let render = ["render", "builtin:cube@2", "--size", "8x8", "--transfer", "odd.json"];
    for (more, code, words) in [
        (["-o", "a.png"], 0, &["WARN", "odd.json", "'odd one'", "UseLogScale", "IndexedColors"][..]),
        (["--type", "int7"], 2, &["error", "int7"]),
    ] {
        let output = layersplat(f, &[&render[..], &more].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{message}");
        for word in words {
            assert!(message.contains(word), "{word}: {message}");
        }
        assert!(!message.contains('\u{1b}'), "{message:?}");
    }
}

/// What is built in the background is compiled in the process that the caller names: its own folder of compiled kernels fills.
#[test]
fn another_process_compiles_what_is_built_in_the_background() {
    use layersplat::renderer::ExpectedFrames;
    use layersplat::{Camera, Device, DeviceChoice, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume};
    let device = Device::open(&DeviceChoice::Default).unwrap();
    if !device.info().platform.contains("Portable Computing Language") {
        return eprintln!("SKIPPED: only PoCL keeps compiled kernels in a folder of its own");
    }
    let kernels = tempfile::tempdir().unwrap();
    let folder = kernels.path().to_owned();
    device.set_compiler_command(move || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        command.env("POCL_CACHE_DIR", &folder);
        command
    });
    let volume = Volume::open("builtin:hydrogen@16", &OpenOptions::default()).unwrap();
    let renderer = Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
    let viewport = Viewport::new(32, 24).unwrap();
    let camera = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), viewport, Orbit::default());
    let expected = ExpectedFrames::new(&[Settings::default()], viewport).with_cameras(&[camera]);
    let (tell, told) = std::sync::mpsc::channel();
    let builds = renderer.warm_up(&expected, move |built| tell.send(built).unwrap());
    told.recv().unwrap().unwrap();
    let compiled = compiled_kernels(kernels.path());
    assert_eq!(Some(compiled), builds.progress().1, "kernels that the other process compiled, of those that were built");
}

/// Libraries of kernels that PoCL compiled into a folder.
fn compiled_kernels(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let count = |path: PathBuf| {
        if path.is_dir() { compiled_kernels(&path) } else { usize::from(path.extension() == Some(OsStr::new("so"))) }
    };
    entries.map(count).sum()
}
