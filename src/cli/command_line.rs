//! The command line as it is parsed: what short help shows, and tips for options that other programs have.

use super::Cli;
use super::channels::KEYS;
use crate::url;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::{Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Options that `-h` shows of commands with many options, by name. `--help` shows all.
const ESSENTIAL: [&str; 34] = [
    "volume",
    "dims",
    "voxel_type",
    "spacing",
    "transfer",
    "preset",
    "palette",
    "from",
    "azimuth",
    "elevation",
    "perspective",
    "size",
    "background",
    "legend",
    "output",
    "frames",
    "keys",
    "axis",
    "at",
    "plane",
    "values",
    "cameras",
    "quality",
    "light",
    "shadows",
    "mip",
    "iso",
    "crop",
    "device",
    "memory",
    "json",
    "help",
    "verbose",
    "version",
];

/// Commands with more options than this have a short help.
const MANY: usize = 30;

/// Options by the names that other programs have, with those to use here.
const ELSEWHERE: [(&str, &str); 19] = [
    ("--width", "--size WIDTHxHEIGHT"),
    ("--height", "--size WIDTHxHEIGHT"),
    ("--resolution", "--size WIDTHxHEIGHT"),
    ("--projection", "--perspective FOV, or nothing for a parallel projection"),
    ("--fov", "--perspective FOV"),
    ("--view-angle", "--perspective FOV"),
    ("--mode", "--blend MODE"),
    ("--isovalue", "--iso V"),
    ("--isosurface", "--iso V"),
    ("--threshold", "--iso V"),
    ("--max", "--mip"),
    ("--cmap", "--transfer NAME"),
    ("--colormap", "--transfer NAME"),
    ("--tf", "--transfer NAME"),
    ("--bg", "--background COLOR"),
    ("--zoom", "--parallel-scale SCALE (half the height of the picture in world units)"),
    ("--out", "--output FILE"),
    ("--ao", "--ambient-occlusion on"),
    ("--antialias", "--samples N"),
];

impl Cli {
    /// Parses the arguments of this process. On errors, prints a message and exits with 2.
    pub fn from_arguments() -> Self {
        let parse = || Self::from_arg_matches(&command().try_get_matches_from(words())?);
        parse().unwrap_or_else(|error| with_tip(error).exit())
    }
}

/// The arguments of this process. Addresses in them have lost their secrets, which nothing but their servers gets.
pub(super) fn words() -> Vec<OsString> {
    let keys: Vec<&str> = KEYS.split([',', ' ']).filter(|key| !key.is_empty()).collect();
    std::env::args_os().map(|argument| url::public_argument(argument, &keys)).collect()
}

/// The command, with a short help for subcommands with many options.
pub(super) fn command() -> Command {
    Cli::command().mut_subcommands(|subcommand| {
        if subcommand.get_arguments().count() < MANY {
            return subcommand;
        }
        let name = subcommand.get_name().to_owned();
        let long = subcommand.get_after_help().cloned().unwrap_or_default();
        let short = format!("These are the most common options. All options, with examples: layersplat {name} --help");
        let subcommand = subcommand.after_help(short).after_long_help(long);
        subcommand.mut_args(|argument| {
            let is_essential = ESSENTIAL.contains(&argument.get_id().as_str());
            argument.hide_short_help(!is_essential)
        })
    })
}

/// The error, with a tip if an unknown option is known from other programs.
fn with_tip(mut error: Error) -> Error {
    let Some(ContextValue::String(given)) =
        error.get(ContextKind::InvalidArg).filter(|_| error.kind() == ErrorKind::UnknownArgument)
    else {
        return error;
    };
    if let Some((_, here)) = ELSEWHERE.iter().find(|(name, _)| name == given) {
        let tip = format!("use {here}");
        error.remove(ContextKind::SuggestedArg);
        // The usage of the error names the option with the most similar letters.
        error.remove(ContextKind::Usage);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the options of `render`.
    fn longs(command: &Command) -> Vec<String> {
        let arguments = command.find_subcommand("render").unwrap().get_arguments();
        arguments.filter_map(|argument| Some(format!("--{}", argument.get_long()?))).collect()
    }

    #[test]
    fn tips_name_existing_options() {
        let mut command = command();
        command.build();
        let known = longs(&command);
        for (elsewhere, here) in ELSEWHERE {
            assert!(!known.contains(&elsewhere.to_owned()), "{elsewhere} exists");
            let named = here.split_whitespace().find(|word| word.starts_with("--"));
            assert!(named.is_some_and(|named| known.contains(&named.to_owned())), "{elsewhere}: {here}");
            let error = command.clone().try_get_matches_from(["layersplat", "render", elsewhere]).unwrap_err();
            let error = with_tip(error);
            assert!(error.to_string().contains(&format!("use {here}")), "{elsewhere}: {error}");
            let others = |word: &&str| word.starts_with("--") && *word != elsewhere && !here.contains(word) && *word != "--help";
            let text = error.to_string().replace('\'', " ");
            assert_eq!(text.split([' ', ',', '\n']).find(others), None, "{error}");
        }
    }

    #[test]
    fn short_help_is_short() {
        let mut command = command();
        command.build();
        let render = command.find_subcommand_mut("render").unwrap();
        let shown = |help: String| help.lines().filter(|line| line.trim_start().starts_with('-')).count();
        let (short, long) = (shown(render.render_help().to_string()), shown(render.render_long_help().to_string()));
        assert!((18..=28).contains(&short) && long > 70, "{short} options of {long}");
        for id in ESSENTIAL {
            assert!(command.get_subcommands().any(|c| c.get_arguments().any(|a| a.get_id() == id)), "{id} does not exist");
        }
    }
}
