//! The README and the guide: every command in a block of `sh` runs, its pictures are those of the page, and the reference of commands is that
//! of the help.

mod reference;

use crate::common::command::names;
use layersplat::image::read_image;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Least dB between a picture of a page and that of its command. Equal files have none; other processors and OpenCL implementations change
/// last bits, and JPEG a few values after that.
const LEAST_PSNR: f64 = 35.0;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// README and all pages of the guide.
fn pages() -> Vec<PathBuf> {
    let guide = root().join("docs/guide");
    let of_guide = names(&guide).into_iter().filter(|name| name.ends_with(".md")).map(|name| guide.join(name));
    [root().join("README.md")].into_iter().chain(of_guide).collect()
}

/// Lines of the blocks of `sh` in a page, without comments; lines that end with a backslash are joined with the next.
fn commands(page: &str) -> Vec<String> {
    let mut in_block = false;
    let mut lines = Vec::new();
    let mut begun = String::new();
    for line in page.lines() {
        if line.starts_with("```") {
            in_block = line == "```sh";
        } else if in_block && !line.trim().is_empty() && !line.starts_with('#') {
            begun.push_str(line.trim_start());
            match begun.strip_suffix('\\') {
                Some(first) => begun = first.to_owned(),
                None => lines.push(std::mem::take(&mut begun)),
            }
        }
    }
    lines
}

/// A folder with the files that commands of the pages name: the examples, and the reader's own file and folder of slices.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("examples/data");
    std::fs::create_dir_all(&data).unwrap();
    for name in names(&root().join("examples/data")) {
        std::fs::copy(root().join("examples/data").join(&name), data.join(&name)).unwrap();
    }
    std::fs::copy(data.join("brain.nii.gz"), folder.path().join("scan.nii.gz")).unwrap();
    let slices = root().join("tests/formats/files/png/bytes");
    std::fs::create_dir(folder.path().join("slices")).unwrap();
    for name in names(&slices) {
        std::fs::copy(slices.join(&name), folder.path().join("slices").join(&name)).unwrap();
    }
    folder
}

/// The shell, which finds the command by its name.
fn shell(folder: &Path, line: &str) -> Command {
    let binary = Path::new(env!("CARGO_BIN_EXE_layersplat"));
    let mut path = vec![binary.parent().unwrap().to_owned()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let mut shell = Command::new("sh");
    shell.current_dir(folder).env("PATH", std::env::join_paths(path).unwrap()).args(["-c", line]);
    shell
}

/// Why a line fails, if it does. The viewer serves until it is ended, once it has printed its address.
fn failure(folder: &Path, line: &str) -> Option<String> {
    if let Some(arguments) = line.strip_prefix("layersplat view ") {
        let mut viewer = Command::new(env!("CARGO_BIN_EXE_layersplat"));
        let arguments = arguments.split('#').next().unwrap().split_whitespace();
        let mut viewer =
            viewer.current_dir(folder).args(["view", "--no-browser"]).args(arguments).stdout(Stdio::piped()).spawn().unwrap();
        let mut address = String::new();
        std::io::BufReader::new(viewer.stdout.take().unwrap()).read_line(&mut address).unwrap();
        viewer.kill().unwrap();
        viewer.wait().unwrap();
        return (!address.contains("http://")).then_some(address);
    }
    if let Some(script) = line.strip_prefix("scripts/") {
        // CI runs these; they would build everything again here.
        let name = script.split_whitespace().next().unwrap();
        return (!root().join("scripts").join(name).is_file()).then(|| format!("no scripts/{name}"));
    }
    let output = shell(folder, line).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    (!output.status.success()).then(|| format!("{}: {message}", output.status))
}

/// Pictures of the guide that this folder has, too, and that differ.
fn changed_pictures(folder: &Path) -> Vec<String> {
    let images = root().join("docs/guide/images");
    let shared = names(&images).into_iter().filter(|name| folder.join(name).is_file() && !name.ends_with(".gif"));
    let psnr = |name: &String| {
        let [theirs, ours] = [&images, folder].map(|of: &Path| read_image(&of.join(name)).unwrap());
        theirs.compare(&ours).map_or(0.0, |c| c.psnr.unwrap_or(f64::INFINITY))
    };
    shared.filter(|name| psnr(name) < LEAST_PSNR).collect()
}

#[test]
fn commands_of_all_pages_run() {
    let mut failures = Vec::new();
    let mut pictures = 0;
    for page in pages() {
        let folder = workplace();
        let lines = commands(&std::fs::read_to_string(&page).unwrap());
        for line in &lines {
            let starts_well = ["layersplat ", "scripts/", "echo ", "for ", "printf "].iter().any(|start| line.starts_with(start));
            let failed = if starts_well { failure(folder.path(), line) } else { Some("cannot be tested".into()) };
            failures.extend(failed.map(|why| format!("{}: {line}: {why}", page.display())));
        }
        let changed = changed_pictures(folder.path());
        failures.extend(changed.iter().map(|name| format!("{}: {name} differs: scripts/gallery", page.display())));
        pictures += names(folder.path()).len() - 3;
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(pictures > 6, "only {pictures} files were written");
}

#[test]
fn faults_are_noticed() {
    let page = "```sh\n# x\nlayersplat render \\\n    FILE\n\nlayersplat info # x\n```\n```text\nlayersplat no\n```\n";
    assert_eq!(commands(page), ["layersplat render FILE", "layersplat info # x"]);
    let folder = workplace();
    assert!(failure(folder.path(), "layersplat info missing.nrrd").unwrap().contains("missing.nrrd"));
    assert!(failure(folder.path(), "scripts/missing").is_some() && failure(folder.path(), "scripts/demo").is_none());
    assert!(failure(folder.path(), "layersplat view missing.nrrd").is_some());
    // Another picture of the same size, under the name of one of the guide.
    assert_eq!(failure(folder.path(), "layersplat render builtin:cube@8 -o vessels.jpg"), None);
    assert_eq!(changed_pictures(folder.path()), ["vessels.jpg"]);
}

#[test]
fn every_picture_of_the_guide_is_shown() {
    let text: String = pages().iter().map(|page| std::fs::read_to_string(page).unwrap()).collect();
    for name in names(&root().join("docs/guide/images")) {
        assert!(text.contains(&format!("images/{name}")), "docs/guide/images/{name} is on no page");
    }
}

#[test]
fn the_readme_is_short() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.lines().count() <= 120, "{} lines", readme.lines().count());
}
