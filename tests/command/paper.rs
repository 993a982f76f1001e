//! `--algorithm` and `layersplat paper` on the command line, and the paper's own numbers.

use crate::common::command::*;
use crate::common::{Random, data_set};

/// Four digits are printed; measured values are roots of floats.
const CURVE_TOLERANCE: f64 = 3e-4;

/// A small data set with one of the paper's names.
fn small_fuel(folder: &std::path::Path) {
    let mut random = Random(1);
    let voxels: Vec<u8> = (0..12 * 10 * 9).map(|_| random.next() as u8).collect();
    std::fs::write(folder.join("fuel_12x10x9_uint8.raw"), voxels).unwrap();
}

#[test]
fn every_algorithm_renders_rotates_and_benches() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let size = ["builtin:hydrogen@20", "--size", "40x30"];
    let algorithms: [&[&str]; 7] = [
        &["layered"],
        &["axis-sheets", "--layer-axis", "z", "--azimuth", "40"],
        &["view-sheets", "--sheet-distance", "0.5"],
        &["slicing", "--step", "0.7"],
        &["raycast"],
        &["raycast", "--interpolation", "tricubic", "--step", "0.1"],
        &["raycast", "--interpolation", "gaussian", "--shading", "off", "--extinction", "linear"],
    ];
    for algorithm in algorithms {
        let with =
            |command: &'static str, more: &[&'static str]| [&[command], &size[..], &["--algorithm"], algorithm, more].concat();
        let rendered = json(f, &with("render", &["-o", "a.png"]));
        assert!(rendered["active_samples"].as_u64().unwrap() > 100, "{rendered}");
        json(f, &with("rotate", &["--frames", "2", "-o", "turn", "--elevation", "0"]));
        let bench = json(f, &with("bench", &["--frames", "2"]));
        assert_eq!(bench["algorithm"], algorithm[0]);
        assert_eq!(bench["quality"].is_null(), algorithm[0] != "layered");
        assert!(layersplat(f, &with("bench", &["--frames", "1"])).status.success());
    }
}

#[test]
fn options_of_other_algorithms_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let render = |more: &[&'static str]| [&["render", "builtin:cube@4"], more].concat();
    let no_meaning: [&[&str]; 10] = [
        &["--algorithm", "slicing", "--quality", "high"],
        &["--algorithm", "raycast", "--lattice", "2"],
        &["--algorithm", "view-sheets", "--classification", "post"],
        &["--algorithm", "axis-sheets", "--correction", "none"],
        &["--algorithm", "axis-sheets", "--sublayers", "2"],
        &["--algorithm", "view-sheets", "--layer-axis", "x"],
        &["--algorithm", "raycast", "--sheet-distance", "1"],
        &["--algorithm", "slicing", "--kernel", "cubic"],
        &["--step", "0.5"],
        &["--algorithm", "axis-sheets", "--step", "0.5"],
    ];
    for options in no_meaning {
        refused(f, &render(options), 2, &["no meaning", options[options.len() - 2]]);
    }
    refused(f, &render(&["--algorithm", "splatting"]), 2, &["layered", "view-sheets"]);
    refused(f, &render(&["--algorithm", "axis-sheets", "--layer-axis", "x", "--azimuth", "0"]), 2, &["--layer-axis", "lean"]);
    for algorithm in ["raycast", "slicing"] {
        let steps = ["render", "builtin:cube@60000x1x1", "--algorithm", algorithm, "--step", "0.001", "--size", "4x4"];
        refused(f, &steps, 2, &["steps", "longer", "--step"]);
    }
    for (options, words) in [
        (["--algorithm", "view-sheets", "--sheet-distance", "0.1"], ["--sheet-distance", "0.125"]),
        (["--algorithm", "slicing", "--step", "100"], ["step", "64"]),
        (["--algorithm", "raycast", "--step", "0"], ["--step", "above 0"]),
        (["--algorithm", "raycast", "--step", "NaN"], ["--step", "NaN"]),
    ] {
        refused(f, &render(&options), 2, &words);
    }
}

#[test]
fn the_papers_experiments_become_pages() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    small_fuel(f);
    let small = ["--size", "40x36", "--frames", "3", "--volumes", "."];
    let written = json(f, &[&["paper", "all", "--out", "pages"], &small[..]].concat());
    assert_eq!(keys(&written), ["data_sets", "device", "missing", "pages"]);
    assert_eq!(written["data_sets"][0], "fuel");
    assert_eq!(written["missing"].as_array().unwrap().len(), 7);
    let pages = ["README.md", "fig2.md", "fig3.md", "fig4.md", "fig5.md", "popping.md", "table1.md"];
    for page in pages {
        let text = std::fs::read_to_string(f.join("pages").join(page)).unwrap();
        assert!(text.contains("Missing data sets: lobster, aneurism"), "{page}: {text}");
        // Every picture of a page is stored beside it.
        for picture in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            assert!(f.join("pages").join(picture).is_file(), "{page}: {picture}");
        }
    }
    let table = std::fs::read_to_string(f.join("pages/table1.md")).unwrap();
    assert!(table.contains("| fuel | 12×10×9 |") && table.contains("(14K)") && table.contains("(2.5)"), "{table}");
    assert!(table.contains("Data sets: fuel with "), "{table}");
    assert!(!table.contains("NaN") && !table.contains("inf"), "{table}");
    for picture in ["table1_fuel.png", "fig2.png", "fig3.png", "fig5.png", "popping.png"] {
        assert!(image::open(f.join("pages").join(picture)).unwrap().width() > 70);
    }
    // Rows of Fig. 4: extinction, its closed form, measured, the linear form, measured.
    let curves = std::fs::read_to_string(f.join("pages/fig4.md")).unwrap();
    let numbers = |line: &str| line.split('|').filter_map(|cell| cell.trim().parse().ok()).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = curves.lines().map(numbers).filter(|row| row.len() == 5).collect();
    assert_eq!(rows.len(), 10, "{curves}");
    for row in rows {
        assert!((row[1] - (-row[0]).exp()).abs() < CURVE_TOLERANCE && (row[2] - row[1]).abs() < CURVE_TOLERANCE, "{row:?}");
        assert!((row[3] - (1.0 - row[0]).max(0.0)).abs() < CURVE_TOLERANCE, "{row:?}");
        assert!((row[4] - row[3]).abs() < CURVE_TOLERANCE, "{row:?}");
    }
    assert!(std::fs::read_to_string(f.join("pages/fig4.svg")).unwrap().ends_with("</svg>\n"));
}

#[test]
fn without_data_sets_built_in_volumes_stand_in() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let written = json(f, &["paper", "popping", "--out", "pages", "--size", "24x24", "--volumes", "."]);
    assert!(written["data_sets"][0].as_str().unwrap().starts_with("hydrogen"), "{written}");
    assert!(std::fs::read_to_string(f.join("pages/popping.md")).unwrap().contains("built-in volumes are used"));
}

#[test]
fn bad_folders_and_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    refused(f, &["paper", "fig2", "--volumes", "nowhere"], 1, &["nowhere"]);
    refused(f, &["paper", "fig2", "--volumes", ".", "--transfers", "nowhere"], 1, &["nowhere"]);
    refused(f, &["paper", "fig2", "--size", "9000x16"], 2, &["size"]);
    refused(f, &["paper", "fig6"], 2, &["fig5", "popping"]);
    refused(f, &["paper", "fig2", "--frames", "0"], 2, &["--frames"]);
    std::fs::write(f.join("fuel_12x10x9_uint8.raw"), [0; 100]).unwrap();
    std::fs::create_dir(f.join("pages")).unwrap();
    refused(f, &["paper", "fig2", "--volumes", ".", "--out", "pages"], 1, &["fuel_12x10x9", "1080"]);
    assert!(names(&f.join("pages")).is_empty());
    std::fs::write(f.join("file"), "").unwrap();
    refused(f, &["paper", "fig4", "--out", "file/pages"], 1, &["file/pages"]);
}

/// The column of the paper's Table 1, exact to the voxel.
#[test]
#[cfg_attr(not(real_volumes), ignore = "needs ../shared/volumes or LAYERSPLAT_VOLUMES")]
fn effective_splats_are_the_papers() {
    let paper = [("fuel", 13_731), ("neghip", 121_586), ("lobster", 233_509), ("aneurism", 78_989), ("engine", 1_301_479)];
    for (name, splats) in paper {
        let (volume, transfer) = data_set(name);
        assert_eq!(transfer.effective_splats(&volume), splats, "{name}");
    }
}

/// Splats that cover the whole screen: lists of tiles with more entries than a uint can count.
#[test]
fn lists_that_no_device_holds_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let zoom = ["--parallel-scale", "0.5", "--size", "1168x1024", "--algorithm", "axis-sheets"];
    refused(
        folder.path(),
        &[&["render", "builtin:cube@4x4x60000", "--azimuth", "0"], &zoom[..]].concat(),
        1,
        &["lists of splats per tile"],
    );
}
