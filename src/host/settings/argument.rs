//! Values of settings as clients state them.

use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The value of an argument. It is displayed as code in Python. Values of plain settings are those of JSON.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Argument {
    /// No value.
    Nothing,
    /// True or false.
    Switch(bool),
    /// A whole number.
    Whole(u32),
    /// A number.
    Number(f64),
    /// A name.
    Name(String),
    /// Values of fixed meaning and number.
    Tuple(Vec<Argument>),
    /// Any number of values.
    List(Vec<Argument>),
    /// Values by name.
    Fields(Vec<(String, Argument)>),
    /// What no setting takes, as it is displayed.
    Other(String),
}

/// What an argument states.
pub(super) trait Stated: Sized {
    /// What messages expect.
    const EXPECTED: &'static str;

    /// The value that an argument states.
    fn read(argument: &Argument) -> Result<Self, Error>;

    /// The argument that states the value.
    fn argument(&self) -> Argument;
}

/// States a type: what messages expect, how a value is read, and how it is written.
macro_rules! stated {
    ($type:ty: $expected:expr; |$argument:pat_param| $read:expr; |$own:pat_param| $write:expr) => {
        impl Stated for $type {
            const EXPECTED: &'static str = $expected;

            fn read($argument: &Argument) -> Result<Self, Error> {
                $read
            }

            fn argument(&self) -> Argument {
                let $own = self;
                $write
            }
        }
    };
}
pub(super) use stated;

/// The error of a value of another kind; [`Argument::value`] completes it.
pub(super) const OTHER_KIND: Error =
    Error::Argument { name: "", part: None, value: String::new(), expected: "", is_of_other_kind: true };
/// The error of another number of values, or a number that is out of range.
pub(super) const OTHER_VALUE: Error =
    Error::Argument { name: "", part: None, value: String::new(), expected: "", is_of_other_kind: false };

impl Argument {
    /// The value of the argument with this name.
    pub(super) fn value<T: Stated>(&self, name: &'static str) -> Result<T, Error> {
        T::read(self).map_err(|error| match error {
            Error::Argument { part: None, is_of_other_kind, .. } => {
                Error::Argument { name, part: None, value: self.to_string(), expected: T::EXPECTED, is_of_other_kind }
            }
            Error::Argument { part, value, expected, is_of_other_kind, .. } => {
                Error::Argument { name, part, value, expected, is_of_other_kind }
            }
            other => other,
        })
    }

    /// The value that has this name in another one.
    pub(super) fn part<T: Stated>(&self, name: &'static str) -> Result<T, Error> {
        self.value(name).map_err(|error| match error {
            Error::Argument { value, expected, is_of_other_kind, .. } => {
                Error::Argument { name, part: Some(name), value, expected, is_of_other_kind }
            }
            other => other,
        })
    }

    /// The values of a tuple or a list.
    pub(super) fn values(&self) -> Result<&[Argument], Error> {
        match self {
            Argument::Tuple(values) | Argument::List(values) => Ok(values),
            _ => Err(OTHER_KIND),
        }
    }
}

stated!(bool: "True or False";
    |argument| if let Argument::Switch(on) = argument { Ok(*on) } else { Err(OTHER_KIND) };
    |on| Argument::Switch(*on));
stated!(f64: "a number";
    |argument| match *argument {
        Argument::Number(number) => Ok(number),
        Argument::Whole(number) => Ok(number.into()),
        // Python counts with them, too.
        Argument::Switch(on) => Ok(f64::from(u8::from(on))),
        _ => Err(OTHER_KIND),
    };
    |number| Argument::Number(*number));
stated!(u32: "a whole number from 0 on";
    |argument| match *argument {
        Argument::Whole(number) => Ok(number),
        // Negative and large whole numbers are numbers.
        Argument::Number(number) if number.fract() == 0.0 => Err(OTHER_VALUE),
        _ => Err(OTHER_KIND),
    };
    |number| Argument::Whole(*number));
stated!(String: "a string";
    |argument| if let Argument::Name(name) = argument { Ok(name.clone()) } else { Err(OTHER_KIND) };
    |name| Argument::Name(name.clone()));
stated!([f64; 3]: "three numbers, (x, y, z)";
    |argument| <Vec<f64>>::read(argument)?.try_into().map_err(|_| OTHER_VALUE);
    |numbers| Argument::Tuple(numbers.map(Argument::Number).into()));

impl<A: Stated, B: Stated> Stated for (A, B) {
    const EXPECTED: &'static str = "two values";

    fn read(argument: &Argument) -> Result<Self, Error> {
        let [first, second] = argument.values()? else { return Err(OTHER_VALUE) };
        Ok((A::read(first)?, B::read(second)?))
    }

    fn argument(&self) -> Argument {
        Argument::Tuple(vec![self.0.argument(), self.1.argument()])
    }
}

impl<T: Stated> Stated for Vec<T> {
    const EXPECTED: &'static str = "a list";

    fn read(argument: &Argument) -> Result<Self, Error> {
        argument.values()?.iter().map(T::read).collect()
    }

    fn argument(&self) -> Argument {
        Argument::List(self.iter().map(T::argument).collect())
    }
}

impl<T: Stated> Stated for Option<T> {
    const EXPECTED: &'static str = T::EXPECTED;

    fn read(argument: &Argument) -> Result<Self, Error> {
        if *argument == Argument::Nothing { Ok(None) } else { T::read(argument).map(Some) }
    }

    fn argument(&self) -> Argument {
        self.as_ref().map_or(Argument::Nothing, T::argument)
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let list = |values: &[Argument]| values.iter().map(Argument::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Argument::Nothing => f.write_str("None"),
            Argument::Switch(on) => f.write_str(if *on { "True" } else { "False" }),
            Argument::Whole(number) => write!(f, "{number}"),
            Argument::Number(number) if number.is_finite() => write!(f, "{number}"),
            Argument::Number(number) => write!(f, "float(\"{number}\")"),
            Argument::Name(name) => write!(f, "{name:?}"),
            Argument::Tuple(values) => write!(f, "({})", list(values)),
            Argument::List(values) => write!(f, "[{}]", list(values)),
            Argument::Fields(fields) => {
                let fields: Vec<_> = fields.iter().map(|(name, value)| format!("{name:?}: {value}")).collect();
                write!(f, "{{{}}}", fields.join(", "))
            }
            Argument::Other(shown) => f.write_str(shown),
        }
    }
}
