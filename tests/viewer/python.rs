//! Pictures as programs in Python. Where the package is installed, they are run: `LAYERSPLAT_PYTHON` names an interpreter that has it, by
//! default `python3`.

use crate::client::{Page, Viewer};
use serde_json::{Value, json};
use std::process::Command;

/// The interpreter, if it has the package and what the programs import.
fn interpreter() -> Option<String> {
    let python = std::env::var("LAYERSPLAT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imported = Command::new(&python).args(["-c", "import layersplat, numpy, PIL"]).output();
    let is_there = imported.is_ok_and(|output| output.status.success());
    if !is_there {
        eprintln!("not run: {python} has no layersplat, numpy and PIL");
    }
    is_there.then_some(python)
}

/// The picture that the page saves, and its program.
fn saved(page: &mut Page, look: &Value, camera: &Value, samples: u32, format: &str) -> (Value, Vec<u8>) {
    page.send(&json!({ "type": "look", "look": look }));
    page.send(&json!({ "type": "save", "camera": camera, "width": 60, "height": 40, "samples": samples, "format": format }));
    let command = page.text("command");
    (command, page.picture().bytes)
}

/// The bytes of the pixels of a saved PNG, or the numbers of an EXR.
fn pixels(name: &str, bytes: &[u8]) -> Vec<u8> {
    if name == "exr" {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        std::fs::write(&path, bytes).unwrap();
        let frame = layersplat::image::read_image(&path).unwrap();
        return frame.pixels().iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    }
    image::load_from_memory(bytes).unwrap().into_rgba8().into_raw()
}

#[test]
fn programs_draw_the_bits_of_saved_pictures() {
    let viewer =
        Viewer::start(&["builtin:hydrogen@32", "--sublayers", "2", "--shadows", "on", "--shadow-forgiveness", "3", "--up", "z"]);
    let mut page = viewer.page();
    let (first, camera) = (page.hello["look"].clone(), page.hello["camera"].clone());
    let mut eye = camera.clone();
    (eye["projection"], eye["roll"]) = (json!({ "perspective": [35.5, 90.25] }), json!(12.3));
    let changed = |changes: Value| {
        let mut look = first.clone();
        changes.as_object().unwrap().iter().for_each(|(name, value)| look[name] = value.clone());
        look
    };
    let light = json!([{ "direction": [0.5, 0.25, 0.3333333333333333], "strength": 0.8, "angle": 2.0 }]);
    let studio = json!({ "sky_up": [0.25, 1.0, -0.5], "scattering": 0.5, "exposure": 0.75 });
    let cases = [
        (first.clone(), &camera, 1, "png"),
        (changed(json!({ "shadows": true, "lights": light, "lights_follow": true, "background": "#a0b0c0" })), &eye, 2, "png"),
        (changed(json!({ "blend": "iso", "iso": 61.3, "kernel": "catmull-rom", "gradient": "gaussian:0.7" })), &camera, 1, "png"),
        (
            changed(json!({ "clips": [[15, 15, 15, 1, 0.5, 0]], "background": "transparent", "quality": "draft" })),
            &camera,
            3,
            "png",
        ),
        (changed(json!({ "crop": [[3, 4, 5], [20.5, 30, 31]], "background": "#102030" })), &eye, 1, "exr"),
        (changed(json!({ "blend": "maximum", "background": "transparent" })), &camera, 2, "exr"),
        (changed(json!({ "studio": studio, "lights": light, "lights_follow": false })), &eye, 1, "png"),
    ];
    let python = interpreter();
    for (look, camera, samples, format) in cases {
        let (command, bytes) = saved(&mut page, &look, camera, samples, format);
        let program = command["python"].as_str().unwrap();
        assert!(program.contains("samples_per_layer=2") && !program.contains("Not included"), "{program}");
        let Some(python) = &python else { continue };
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("layersplat.json"), command["transfer_text"].as_str().unwrap()).unwrap();
        let numbers = "import numpy\nnumpy.asarray(picture).tofile('pixels')\n";
        let output =
            Command::new(python).args(["-c", &format!("{program}{numbers}")]).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{program}{}", String::from_utf8_lossy(&output.stderr));
        let drawn = std::fs::read(folder.path().join("pixels")).unwrap();
        let expected = pixels(format, &bytes);
        let differ = drawn.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert!(drawn.len() == expected.len() && differ == 0, "{differ} of {} bytes differ: {program}", expected.len());
    }
    // An injected error is noticed: another camera gives other pixels.
    let (_, a) = saved(&mut page, &first, &camera, 1, "png");
    let (_, b) = saved(&mut page, &first, &eye, 1, "png");
    assert_ne!(pixels("png", &a), pixels("png", &b));
}
