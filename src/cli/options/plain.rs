//! Options that the description of settings makes.

use crate::cli::{names, parse};
use crate::error::Error;
use crate::settings::{Argument, Kind, Setting, Settings};
use clap::builder::TypedValueParser;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

/// The plain settings that were given.
#[derive(Clone, Debug, Default)]
pub(in crate::cli) struct PlainOptions(Vec<(&'static str, Argument)>);

impl PlainOptions {
    /// Settings with these options applied.
    ///
    /// # Errors
    /// [`Error::Argument`].
    pub fn apply(&self, settings: Settings) -> Result<Settings, Error> {
        settings.with_plain(self.0.iter().map(|(name, argument)| (*name, argument)))
    }
}

impl Args for PlainOptions {
    fn augment_args(command: Command) -> Command {
        command.args(Setting::plain().map(option))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PlainOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |setting: &Setting| Some((setting.name, matches.get_one::<Argument>(setting.name)?.clone()));
        Ok(Self(Setting::plain().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn option(setting: &'static Setting) -> Arg {
    let option = Arg::new(setting.name).long(setting.option).help(setting.help);
    match setting.kind {
        Kind::Choice(known) => option.value_name("NAME").value_parser(names::from_list(known()).map(Argument::Name)),
        Kind::Number(number) => {
            let parser = parse::number(number);
            option.value_name("N").allow_hyphen_values(true).value_parser(move |text: &str| parser(text).map(Argument::Number))
        }
        _ => option.value_name("on|off").value_parser(|text: &str| parse::switch(text).map(Argument::Switch)),
    }
}
