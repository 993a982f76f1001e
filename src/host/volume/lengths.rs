//! Units of length.

/// Names in lower case, the symbol, and the length in metres.
const UNITS: [(&[&str], &str, f64); 9] = [
    (&["angstrom", "angstroms", "å", "\u{212b}"], "Å", 1e-10),
    (&["pm", "picometer", "picometre"], "pm", 1e-12),
    (&["nm", "nanometer", "nanometre", "nanometers"], "nm", 1e-9),
    (&["um", "µm", "\u{3bc}m", "micrometer", "micrometre", "micrometers", "micron", "microns"], "µm", 1e-6),
    (&["mm", "millimeter", "millimetre", "millimeters"], "mm", 1e-3),
    (&["cm", "centimeter", "centimetre", "centimeters"], "cm", 1e-2),
    (&["m", "meter", "metre", "meters", "metres"], "m", 1.0),
    (&["km", "kilometer", "kilometre", "kilometers"], "km", 1e3),
    (&["inch", "inches", "in"], "in", 0.0254),
];

fn found(unit: &str) -> Option<&'static (&'static [&'static str], &'static str, f64)> {
    let unit = unit.trim().to_lowercase();
    UNITS.iter().find(|(names, ..)| names.contains(&unit.as_str()))
}

/// The symbol of a unit by any of its names, if it is known.
pub(super) fn symbol(unit: &str) -> Option<&'static str> {
    found(unit).map(|(_, symbol, _)| *symbol)
}

/// Length of a unit in metres, if it is known.
#[cfg(any(feature = "hdf5", feature = "zarr"))]
pub(super) fn metres(unit: &str) -> Option<f64> {
    found(unit).map(|(.., metres)| *metres)
}
