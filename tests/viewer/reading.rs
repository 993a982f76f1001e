//! What pages ask about places of a picture, annotations, and the formats of saved pictures.

use crate::client::{Message, Page, Viewer};
use serde_json::{Value, json};

/// Opaque from a value of 60 on.
const OPAQUE: &str = r#"{"type":"transfer","colors":[[0,[1,1,1]]],"opacities":[[50,0],[60,1]]}"#;

fn pick(page: &Page, id: u32, x: f64, y: f64) -> Value {
    json!({ "type": "pick", "id": id, "camera": page.hello["camera"], "height": 64, "x": x, "y": y })
}

#[test]
fn a_pick_finds_the_point_that_is_seen() {
    let viewer = Viewer::start(&["builtin:hydrogen@32"]);
    let mut page = viewer.page();
    page.send(&serde_json::from_str(OPAQUE).unwrap());
    page.send(&pick(&page, 3, 0.3, 0.0));
    let picked = page.text("picked");
    assert_eq!(picked["id"], 3);
    let value = picked["point"]["value"].as_f64().unwrap();
    // The mean depth lies where the transfer function becomes opaque, within a voxel.
    assert!((50.0..90.0).contains(&value), "{picked}");
    let numbers = |name: &str| picked["point"][name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<_>>();
    assert!(numbers("voxel").iter().all(|&x| (-1.0..=32.0).contains(&x)) && numbers("position").len() == 3);
    // Between two layers nothing is visible: the point is in the first of them.
    page.send(&json!({ "type": "transfer", "colors": [[0, [1, 1, 1]]], "opacities": [[10, 0], [15, 0.05], [20, 0]] }));
    page.send(&pick(&page, 6, 0.0, 0.0));
    let value = page.text("picked")["point"]["value"].as_f64().unwrap();
    assert!((9.0..21.0).contains(&value), "{value}");
    // Nothing is seen beside the volume, and pictures of maxima have no depth.
    page.send(&pick(&page, 4, 50.0, 0.0));
    assert!(page.text("picked")["point"].is_null());
    let mut look = page.hello["look"].clone();
    look["blend"] = json!("maximum");
    page.send(&json!({ "type": "look", "look": look }));
    page.send(&pick(&page, 5, 0.3, 0.0));
    assert!(page.text("picked")["point"].is_null());
}

#[test]
fn places_of_no_picture_are_refused() {
    let viewer = Viewer::start(&["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    for (height, x) in [(0u32, 0.0), (4_000_000_000, 0.0), (64, 1e30)] {
        let mut request = pick(&page, 1, x, 0.0);
        request["height"] = json!(height);
        page.send(&request);
        page.text("problem");
    }
    page.send(&json!({ "type": "pick", "id": 1, "camera": page.hello["camera"], "height": 64, "x": "left", "y": 0 }));
    while !matches!(page.receive(), Message::Closed(_)) {}
}

/// Each annotation changes the picture; all of them lie over it, so that without them it has the same bits.
#[test]
fn annotations_lie_over_the_picture() {
    let viewer = Viewer::start(&["builtin:hydrogen@16"]);
    let mut page = viewer.page();
    let mut look = page.hello["look"].clone();
    look["quality"] = json!("draft");
    let draw = |page: &mut Page, look: &Value, moving: bool| {
        page.send(&json!({ "type": "look", "look": look }));
        page.send(&page.view(1, 0.0, moving));
        if moving {
            let picture = page.picture();
            page.shown();
            return picture.pixels();
        }
        page.refined().pixels()
    };
    let plain = draw(&mut page, &look, false);
    for name in ["legend", "bounding_box", "axes"] {
        look[name] = json!(true);
        let annotated = draw(&mut page, &look, false);
        let changed = annotated.pixels().zip(plain.pixels()).filter(|(a, b)| a != b).count();
        assert!((20..96 * 64 / 2).contains(&changed), "{name}: {changed}");
        assert_ne!(draw(&mut page, &look, true), plain, "{name}, moving");
        look[name] = json!(false);
    }
    assert_eq!(draw(&mut page, &look, false), plain);
}
