//! The options that this process was given and that the page does not change. They stand in every command that the page shows.

use crate::cli::Cli;
use crate::cli::blending::BlendOptions;
use crate::cli::channels::ChannelOptions;
use crate::cli::colors::ColorOptions;
use crate::cli::options::{BoundOptions, DeviceOptions, LabelOptions, QualityOptions, VolumeOptions};
use crate::settings::Setting;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, CommandFactory};
use std::ffi::OsString;
use std::path::Path;

/// Options whose values are part of the page's look, besides those of plain settings.
const OF_THE_PAGE: [&str; 20] = [
    "ambient_occlusion",
    "blend",
    "clip",
    "crop",
    "exposure",
    "gradient",
    "iso",
    "iso_color",
    "kernel",
    "light",
    "light_space",
    "look",
    "minip",
    "mip",
    "quality",
    "scattering",
    "shading",
    "shadow_strength",
    "shadows",
    "sky_up",
];

/// An option and its value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GivenOption {
    pub id: String,
    pub words: Vec<String>,
}

/// GivenOptions options.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct GivenOptions {
    /// The volume, without folders.
    pub volume: String,
    /// Further volumes of a sequence.
    pub more: Vec<String>,
    /// How the volume is read, which way is up, and the device.
    pub reading: Vec<GivenOption>,
    /// The device and its limits, which go with any volume.
    pub running: Vec<GivenOption>,
    /// Options that settings are made of.
    pub drawing: Vec<GivenOption>,
}

impl GivenOptions {
    pub fn of(command_line: impl IntoIterator<Item = OsString>) -> Self {
        let mut cli = Cli::command();
        // The command line was parsed before; a test parses one without the program's name.
        let Ok(matches) = cli.try_get_matches_from_mut(command_line) else { return Self::default() };
        let (Some(matches), Some(command)) = (matches.subcommand_matches("view"), cli.find_subcommand("view")) else {
            return Self::default();
        };
        let names =
            |id: &str| matches.get_raw(id).into_iter().flatten().map(|path| file_name(Path::new(path))).collect::<Vec<_>>();
        let name = names("volume").pop().unwrap_or_default();
        let options = |ids: Vec<String>| -> Vec<GivenOption> {
            let own = command.get_arguments().filter(|arg| ids.iter().any(|id| arg.get_id() == id.as_str()));
            own.filter_map(|arg| given(arg, matches)).collect()
        };
        let mut reading = ids::<VolumeOptions>();
        reading.extend(ids::<ChannelOptions>());
        reading.extend(ids::<ColorOptions>());
        reading.extend(ids::<LabelOptions>());
        reading.extend(ids::<DeviceOptions>());
        reading.push("up".into());
        let running = ids::<DeviceOptions>().into_iter().chain(ids::<BoundOptions>()).collect();
        let drawing = ids::<QualityOptions>().into_iter().chain(ids::<BlendOptions>());
        let is_plain = |id: &String| Setting::plain().any(|setting| setting.name == id);
        let drawing = drawing.filter(|id| !OF_THE_PAGE.contains(&id.as_str()) && !is_plain(id)).collect();
        let more = names("more");
        Self { volume: name, more, reading: options(reading), running: options(running), drawing: options(drawing) }
    }
}

/// A volume without folders. Built-in volumes and standard input have none.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The value of an option that names files, without their folders.
fn without_folders(id: &str, value: &str) -> String {
    let name = |text: &str| file_name(Path::new(text));
    match id {
        "scene" | "labels" | "label_colors" | "mask" => name(value),
        "with" | "field" => {
            let part = |(n, part): (usize, &str)| match part.split_once('=') {
                Some((key @ ("transfer" | "at"), file)) => format!("{key}={}", name(file)),
                None if n == 0 => name(part),
                _ => part.to_owned(),
            };
            value.split(',').enumerate().map(part).collect::<Vec<_>>().join(",")
        }
        _ => value.to_owned(),
    }
}

/// Names of the options of a group.
fn ids<Group: Args>() -> Vec<String> {
    Group::augment_args(Command::new("group")).get_arguments().map(|arg| arg.get_id().to_string()).collect()
}

/// An option as it was given.
fn given(arg: &Arg, matches: &ArgMatches) -> Option<GivenOption> {
    let id = arg.get_id().as_str();
    let long = format!("--{}", arg.get_long()?);
    if matches.value_source(id) != Some(ValueSource::CommandLine) {
        return None;
    }
    let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
    let values = matches.get_raw(id).into_iter().flatten().map(|value| without_folders(id, &value.to_string_lossy()));
    let words = match id {
        _ if is_flag => vec![long],
        // Its value is optional, so that it needs the equals sign.
        "labels" => vec![values.fold(long, |option, value| format!("{option}={value}"))],
        _ => values.flat_map(|value| [long.clone(), value]).collect(),
    };
    Some(GivenOption { id: id.to_owned(), words })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(line: &str) -> GivenOptions {
        GivenOptions::of(line.split(' ').map(OsString::from))
    }

    #[test]
    fn options_that_the_page_does_not_change_are_kept_as_given() {
        let line = "layersplat view /secret/folder/head.raw --dims 4x5x6 --type uint16 --up z --sublayers 2 --quality high --shadows on \
                    --gradient-opacity 5:0,20:1 --gamma 2 --iso 3 --blend iso --device-unchecked --port 7 --azimuth 12";
        let given = given(line);
        let words =
            |options: &[GivenOption]| options.iter().flat_map(|option| option.words.clone()).collect::<Vec<_>>().join(" ");
        assert_eq!(given.volume, "head.raw");
        let reading = words(&given.reading);
        for option in ["--dims 4x5x6", "--type uint16", "--up z", "--device-unchecked"] {
            assert!(reading.contains(option), "{reading}");
        }
        assert_eq!(words(&given.drawing), "--sublayers 2 --gradient-opacity 5:0,20:1");
        assert!(!format!("{given:?}").contains("secret"));
    }

    #[test]
    fn options_of_fields_name_no_folder() {
        let line = "layersplat view a.nii --with /secret/b.nii,at=/secret/at.txt,factor=2,transfer=/secret/t.json --field 1,transfer=/secret/u.json \
                    --mask /secret/m.nrrd:3,liver --label-colors /secret/l.nrrd --label 3,7-9:hide --labels=/secret/table.txt";
        let given = given(line);
        let words: Vec<String> = given.reading.iter().flat_map(|option| option.words.clone()).collect();
        let words = words.join(" ");
        for option in [
            "--with b.nii,at=at.txt,factor=2,transfer=t.json",
            "--field 1,transfer=u.json",
            "--mask m.nrrd:3,liver",
            "--label-colors l.nrrd",
            "--label 3,7-9:hide",
            "--labels=table.txt",
        ] {
            assert!(words.contains(option), "{words}");
        }
        assert!(!format!("{given:?}").contains("secret"));
    }

    #[test]
    fn ids_of_the_page_are_options() {
        let all: Vec<String> = ids::<QualityOptions>().into_iter().chain(ids::<BlendOptions>()).collect();
        for id in OF_THE_PAGE {
            assert!(all.iter().any(|known| known == id), "{id}");
        }
        assert_eq!(given("layersplat view").volume, "builtin:hydrogen");
    }
}
