//! Axes of patients.

use crate::choice::choices;

/// The axes of a patient that the coordinates of a surface run along. Those of volumes are RAS, where these state a patient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Left, posterior, superior: DICOM, ITK, and 3D Slicer's models.
    Lps,
    /// Right, anterior, superior: NIfTI.
    Ras,
}

choices! { Space, "space"; Lps = "LPS" | "lps", Ras = "RAS" | "ras" }

impl Space {
    /// What a header says, as 3D Slicer writes it: `SPACE=LPS`.
    pub(super) fn of_header(text: &str) -> Option<Self> {
        let is_word = |found: &str, at: usize| !found[..at].ends_with(|c: char| c.is_alphanumeric());
        let stated = text.match_indices("SPACE=").find(|(at, _)| is_word(text, *at)).map(|(at, word)| &text[at + word.len()..]);
        Self::ALL.into_iter().find(|space| stated.is_some_and(|stated| stated.starts_with(space.name())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_slicer_name_the_space() {
        for (header, expected) in [
            ("3D Slicer output. SPACE=LPS", Some(Space::Lps)),
            ("SPACE=RAS;more", Some(Space::Ras)),
            ("WORKSPACE=RAS", None),
            ("SPACE=abc", None),
            ("", None),
        ] {
            assert_eq!(Space::of_header(header), expected, "{header}");
        }
    }
}
