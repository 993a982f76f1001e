//! Command line options for the library's field names.

use super::Cli;
use crate::error::Error;
use clap::{Arg, Command, CommandFactory};

/// Fields as in [`Error::fields`] whose options have other names; sorted by field.
const OTHERS: [(&str, &[&str]); 11] = [
    ("channels", &["channels", "with", "scene"]),
    ("clipping", &["clip"]),
    ("density", &["lattice"]),
    ("evaluation", &["lattice"]),
    ("field_of_view", &["perspective"]),
    ("longest", &["time_limit"]),
    ("samples_per_layer", &["sublayers"]),
    ("scale", &["parallel_scale"]),
    ("transfer function", &["transfer"]),
    ("transfer range", &["transfer_range"]),
    ("viewport", &["size"]),
];

/// Commands that have all options of fields.
const COMMANDS: [&str; 4] = ["render", "slice", "rotate", "info"];

/// The error's message, followed by the options that set the fields at fault.
pub(super) fn with_options(error: &Error) -> String {
    let command = Cli::command();
    let options = error.fields().iter().flat_map(|field| options(&command, field)).collect::<Vec<_>>();
    if options.is_empty() { error.to_string() } else { format!("{error} ({})", options.join(", ")) }
}

/// The options of a field, with their values.
fn options(command: &Command, field: &str) -> Vec<String> {
    let other = OTHERS.iter().find(|(name, _)| *name == field).map(|(_, options)| *options);
    other.unwrap_or(&[field]).iter().filter_map(|id| in_words(argument(command, id)?)).collect()
}

fn argument<'a>(command: &'a Command, id: &str) -> Option<&'a Arg> {
    let commands = COMMANDS.iter().filter_map(|name| command.find_subcommand(name));
    commands.flat_map(Command::get_arguments).find(|argument| argument.get_id() == id)
}

/// An option as the help writes it: `--light-grid full|half|quarter`.
fn in_words(argument: &Arg) -> Option<String> {
    let mut words = format!("--{}", argument.get_long()?);
    if argument.get_action().takes_values() {
        let names: Vec<String> = argument.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
        let value_names = argument.get_value_names().unwrap_or_default().iter().map(ToString::to_string);
        let values = if names.is_empty() { value_names.collect() } else { names };
        words = format!("{words}{}{}", if argument.is_require_equals_set() { "=" } else { " " }, values.join("|"));
    }
    Some(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_exist() {
        let command = Cli::command();
        for (field, ids) in OTHERS {
            assert_eq!(options(&command, field).len(), ids.len(), "{field}");
        }
        assert!(OTHERS.is_sorted());
        for (field, expected) in [
            ("blend", "--blend composite|maximum|minimum|average|iso"),
            ("dims", "--dims XxYxZ"),
            ("dither", "--dither"),
            ("evaluation", "--lattice direct|auto|N"),
            ("labels", "--labels=TABLE"),
            ("viewport", "--size WxH"),
        ] {
            assert_eq!(options(&command, field), [expected]);
        }
    }

    #[test]
    fn messages_name_field_and_option() {
        let step = Error::OutOfRange { name: "step", value: "0".into(), expected: "more" };
        assert_eq!(with_options(&step), "step is 0: expected more (--step D)");
        let memory = Error::DeviceMemory { what: "it".into(), device: "d".into(), needed: 2, available: 1 };
        assert!(with_options(&memory).ends_with("(--device NAME)"));
        let other = Error::Camera { problem: "no view" };
        assert_eq!(with_options(&other), other.to_string());
    }
}
