//! The page's files, in the program. None of them refers to anything outside.

/// A file of the page.
pub(super) struct Asset {
    pub path: &'static str,
    pub kind: &'static str,
    pub text: &'static str,
}

const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! asset {
    ($path:literal, $kind:expr) => {
        Asset { path: concat!("/", $path), kind: $kind, text: include_str!(concat!("page/", $path)) }
    };
}

/// The page itself.
pub(super) const PAGE: Asset = asset!("index.html", "text/html; charset=utf-8");

/// All that the page loads.
pub(super) const ASSETS: [Asset; 35] = [
    asset!("style.css", "text/css; charset=utf-8"),
    asset!("icon.svg", "image/svg+xml"),
    asset!("adjusting.js", SCRIPT),
    asset!("ball.js", SCRIPT),
    asset!("camera.js", SCRIPT),
    asset!("channels.js", SCRIPT),
    asset!("connection.js", SCRIPT),
    asset!("controls.js", SCRIPT),
    asset!("cutting.js", SCRIPT),
    asset!("editing.js", SCRIPT),
    asset!("editor-keys.js", SCRIPT),
    asset!("editor.js", SCRIPT),
    asset!("files.js", SCRIPT),
    asset!("film.js", SCRIPT),
    asset!("gestures.js", SCRIPT),
    asset!("handles.js", SCRIPT),
    asset!("keeping.js", SCRIPT),
    asset!("keys.js", SCRIPT),
    asset!("lighting.js", SCRIPT),
    asset!("main.js", SCRIPT),
    asset!("names.js", SCRIPT),
    asset!("overlay.js", SCRIPT),
    asset!("picture.js", SCRIPT),
    asset!("plot.js", SCRIPT),
    asset!("raw.js", SCRIPT),
    asset!("reading.js", SCRIPT),
    asset!("saving.js", SCRIPT),
    asset!("session.js", SCRIPT),
    asset!("sides.js", SCRIPT),
    asset!("slices.js", SCRIPT),
    asset!("state.js", SCRIPT),
    asset!("status.js", SCRIPT),
    asset!("tents.js", SCRIPT),
    asset!("time.js", SCRIPT),
    asset!("unavailable.js", SCRIPT),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Every file of the folder is embedded, and none asks for anything from elsewhere.
    #[test]
    fn the_page_is_whole_and_alone() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/viewer/page");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| format!("/{}", entry.unwrap().file_name().into_string().unwrap()))
            .collect();
        files.sort();
        let mut embedded: Vec<&str> = ASSETS.iter().chain([&PAGE]).map(|asset| asset.path).collect();
        embedded.sort_unstable();
        assert_eq!(embedded, files);
        for asset in ASSETS.iter().chain([&PAGE]) {
            let without_names = asset.text.replace("http://www.w3.org/2000/svg", "");
            for outside in ["http://", "https://", "//cdn", "innerHTML", "eval("] {
                assert!(!without_names.contains(outside), "{} has {outside}", asset.path);
            }
        }
    }
}
