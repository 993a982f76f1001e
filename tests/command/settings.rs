//! Every client has the settings that the library describes.

use layersplat::settings::Setting;

/// Settings without an option: pixels of the command are square.
const NO_OPTIONS: [&str; 1] = ["pixel_aspect"];
/// Settings whose options have other names.
const OTHER_OPTIONS: [(&str, &str); 3] = [("samples_per_layer", "sublayers"), ("density", "lattice"), ("planes", "clip")];

/// Names before `=` or `:` in a list of arguments.
fn names(arguments: &str, separator: char) -> Vec<&str> {
    let parts = arguments.split('\n').flat_map(|line| line.split(", "));
    let names =
        parts.filter_map(|part| Some(part.trim().split_once(separator)?.0)).filter(|name| !name.contains(['[', ']', '(']));
    names.collect()
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    text.split_once(start).and_then(|(_, rest)| rest.split_once(end)).expect("the list of arguments").0
}

/// `mypy.stubtest` compares the signature with the types.
#[test]
fn python_has_all_settings() {
    let source = include_str!("../../bindings/python/src/settings.rs");
    let signature = between(source, "text_signature = \"(", ")\"");
    let stubs =
        between(include_str!("../../bindings/python/package/layersplat/_layersplat.pyi"), "class Settings:", "-> Settings");
    let stubs = stubs.split_once("cls,").expect("a constructor").1;
    let mut expected: Vec<_> = Setting::ALL.iter().map(|setting| setting.name).collect();
    expected.sort_unstable();
    for (mut found, client) in [(names(signature, '='), "signature"), (names(stubs, ':'), "stubs")] {
        found.sort_unstable();
        assert_eq!(found, expected, "{client}");
    }
}

/// The reference is that of the help, as tests/command/guide makes sure.
#[test]
fn the_reference_has_all_settings() {
    let reference = include_str!("../../docs/guide/reference.md");
    for setting in Setting::ALL.iter().filter(|setting| !NO_OPTIONS.contains(&setting.name)) {
        let other = OTHER_OPTIONS.iter().find(|(name, _)| *name == setting.name).map(|(_, option)| (*option).to_owned());
        let option = other.unwrap_or_else(|| setting.name.replace('_', "-"));
        let row = reference.lines().find(|line| line.starts_with('|') && line.contains(&format!("--{option} ")));
        let row = row.unwrap_or_else(|| panic!("--{option} is missing"));
        assert!(setting.option.is_none() || row.contains(&setting.help.replace('[', "\\[")), "{row}");
    }
}
