//! Values that are chosen by name.

use crate::error::Error;

/// A value that is chosen by name. The command, JSON, Python and ANARI have the same names; C numbers the values in the order of
/// [`ALL`](Choice::ALL).
///
/// ```
/// use layersplat::{Choice, Quality};
///
/// assert_eq!(Quality::from_name("high")?, Quality::High);
/// assert_eq!(Quality::names(), "draft, standard, high or paper");
/// # Ok::<(), layersplat::Error>(())
/// ```
pub trait Choice: Copy + Send + Sync + 'static {
    /// The field that holds such a value, as errors name it.
    const FIELD: &'static str;
    /// All values. Those with numbers have the default numbers.
    const ALL: &'static [Self];

    /// Name of the value.
    fn name(self) -> &'static str;

    /// Further names that are accepted.
    fn aliases(self) -> &'static [&'static str] {
        &[]
    }

    /// The value with this name.
    ///
    /// # Errors
    /// [`Error::UnknownName`] if there is none.
    fn from_name(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.iter().copied().find(|choice| choice.name() == name || choice.aliases().contains(&name));
        found.ok_or_else(|| Error::UnknownName { what: Self::FIELD, name: name.into(), known: Self::names() })
    }

    /// All names, as a message lists them.
    fn names() -> String {
        in_words(Self::ALL.iter().map(|choice| choice.name()))
    }
}

/// A list for a message: `a, b or c`.
pub fn in_words(names: impl Iterator<Item = &'static str>) -> String {
    let names: Vec<_> = names.collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Lists the values of an enumeration with their names: `choices! { Type, "field"; Value = "name", Other(5) = "other" | "alias" }`.
/// Implements [`Choice`], and `ALL` and `name` without the trait.
macro_rules! choices {
    ($type:ty, $field:literal; $($variant:ident $(($($number:expr),+))? $({$($part:ident: $given:expr),+})? = $name:literal $(| $alias:literal)*),+ $(,)?) => {
        impl $type {
            /// All values. Those with numbers have the default numbers.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant $(($($number),+))? $({$($part: $given),+})?),+];

            /// Name, the same in all clients.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant { .. } => $name),+
                }
            }
        }

        impl $crate::choice::Choice for $type {
            const FIELD: &'static str = $field;
            const ALL: &'static [Self] = &Self::ALL;

            fn name(self) -> &'static str {
                self.name()
            }

            fn aliases(self) -> &'static [&'static str] {
                match self {
                    $(Self::$variant { .. } => &[$($alias),*]),+
                }
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::error::Error;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                $crate::choice::Choice::from_name(name)
            }
        }

        // For `#[serde(into = "&'static str", try_from = "String")]`.
        impl From<$type> for &'static str {
            fn from(choice: $type) -> Self {
                choice.name()
            }
        }

        impl TryFrom<String> for $type {
            type Error = $crate::error::Error;

            fn try_from(name: String) -> Result<Self, Self::Error> {
                $crate::choice::Choice::from_name(&name)
            }
        }
    };
}
pub(crate) use choices;

/// Writes and reads choices by their names: `#[serde(with = "crate::choice::by_name")]`.
pub mod by_name {
    use super::Choice;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<T: Choice, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(choice.name())
    }

    pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        T::from_name(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}
