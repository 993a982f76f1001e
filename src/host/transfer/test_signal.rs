//! Transfer function of the built-in Marschner–Lobb signal. It fills its box and oscillates, so materials and shells mean nothing in it; it is
//! known by its surface at half its range.

use super::TransferFunction;
use super::palettes::Palette;
use crate::volume::Volume;

/// Opacities of values 0 … 255.
const OPACITIES: [(f64, f64); 3] = [(0.0, 0.0), (112.0, 0.0), (144.0, 0.9)];

/// The signal's transfer function; `None` for other volumes.
pub(super) fn transfer(volume: &Volume, palette: Palette) -> Option<TransferFunction> {
    if volume.name().split('@').next() != Some("builtin:marschner-lobb") {
        return None;
    }
    TransferFunction::new("marschner-lobb", vec![(0.0, palette.materials(1)[0])], OPACITIES.to_vec()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OpenOptions;

    #[test]
    fn the_signal_has_one_surface() {
        let open = |name: &str| Volume::open(name, &OpenOptions::default()).unwrap();
        let transfer = TransferFunction::automatic(&open("builtin:marschner-lobb@16"));
        assert_eq!((transfer.name(), transfer.opacity(100.0), transfer.opacity(150.0)), ("marschner-lobb", 0.0, 0.9));
        assert_ne!(TransferFunction::automatic(&open("builtin:gyroid@16")).name(), "marschner-lobb");
    }
}
