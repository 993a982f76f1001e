//! Names as values of options: case does not matter, and `_` stands for `-`.

use crate::choice::Choice;
use clap::builder::{EnumValueParser, PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::Error;
use clap::{Arg, Command, ValueEnum};
use std::ffi::{OsStr, OsString};

/// Parses the names that `P` does, written in any of these forms.
#[derive(Clone)]
pub(super) struct Names<P>(P);

/// Names of choices.
pub(super) fn of<T: Choice>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL.iter().map(|choice| PossibleValue::new(choice.name()).aliases(choice.aliases().iter().copied()));
    Names(PossibleValuesParser::new(values)).map(|name| T::from_name(&name).expect("the name is a possible value"))
}

/// Names of the variants of an enumeration that only the command has.
pub(super) fn of_enum<T: ValueEnum + Clone + Send + Sync + 'static>() -> Names<EnumValueParser<T>> {
    Names(EnumValueParser::new())
}

/// Names from a list.
pub(super) fn from_list(names: impl IntoIterator<Item = &'static str>) -> Names<PossibleValuesParser> {
    Names(PossibleValuesParser::new(names.into_iter().map(PossibleValue::new)))
}

impl<P: TypedValueParser> TypedValueParser for Names<P> {
    type Value = P::Value;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<P::Value, Error> {
        let plain = value.to_str().map(|name| OsString::from(name.to_lowercase().replace('_', "-")));
        self.0.parse_ref(command, argument, plain.as_deref().unwrap_or(value))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        self.0.possible_values()
    }
}
