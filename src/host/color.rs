//! Linear light: colours as reflectances, the albedo of matter that reflects them, and the curve of pictures.

use crate::choice::choices;

/// Reflectance of white.
const WHITEST: f64 = 0.9;

/// The linear value of a component of an sRGB colour (IEC 61966-2-1).
pub fn linear(coded: f64) -> f64 {
    if coded <= 0.040_45 { coded / 12.92 } else { ((coded + 0.055) / 1.055).powf(2.4) }
}

/// The component of an sRGB colour of a linear value (IEC 61966-2-1).
pub fn coded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The reflectance of a component of a colour.
pub fn reflectance(coded: f64) -> f64 {
    WHITEST * linear(coded)
}

/// The albedo of a single scattering in opaque matter that reflects this share of a sky's light: its spherical albedo.
///
/// With s = √(1 − ω), van de Hulst's approximation (Multiple Light Scattering, 1980) is R = (1 − s)(1 − 0.139 s)/(1 + 1.17 s).
pub fn albedo(reflectance: f64) -> f64 {
    let b = 1.139 + 1.17 * reflectance;
    let s = (b - (b * b - 0.556 * (1.0 - reflectance)).sqrt()) / 0.278;
    1.0 - s * s
}

/// How bright colours are compressed in pictures of integers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tone {
    /// They are cut off.
    None,
    /// Above 0.6 they approach 1; hues are kept.
    #[default]
    Shoulder,
}

choices! { Tone, "tone"; None = "none", Shoulder = "shoulder" }

/// How the straight colours of a picture of floats become those of 8 and 16 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Colours are in linear light: they are exposed, compressed and coded as sRGB.
    pub linear: Option<Exposure>,
    /// Then colours are raised to 1/gamma.
    pub gamma: f64,
}

/// Exposure of linear colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Colours are multiplied by 2 to this power.
    pub stops: f64,
    /// How bright ones are compressed.
    pub tone: Tone,
}

impl Curve {
    /// Colours stay as they are.
    pub const NONE: Self = Self { linear: None, gamma: 1.0 };
    /// What is left of the curve once linear colours are coded.
    pub fn of_coded(self) -> Self {
        Self { linear: None, ..self }
    }

    /// Where the shoulder begins.
    const KNEE: f32 = 0.6;

    /// Numbers for [`curved`](Self::curved): factor, beginning of the shoulder, exponent, and whether colours are linear.
    pub fn numbers(&self) -> [f32; 4] {
        let knee = |tone| if tone == Tone::Shoulder { Self::KNEE } else { f32::INFINITY };
        let (factor, knee) = self.linear.map_or((1.0, f32::INFINITY), |linear| (linear.stops.exp2() as f32, knee(linear.tone)));
        [factor, knee, self.gamma.recip() as f32, f32::from(u8::from(self.linear.is_some()))]
    }

    /// A straight colour after the curve. Bit-identical to kernels/picture/display.cl except for powers.
    pub fn curved(&self, color: [f32; 3]) -> [f32; 3] {
        let [factor, knee, exponent, is_linear] = self.numbers();
        let [r, g, b] = color.map(|c| c.max(0.0) * factor);
        let largest = r.max(g).max(b);
        let above = (largest - knee) / (1.0 - knee);
        let scale = if largest > knee { (knee + (1.0 - knee) * (above / (1.0 + above))) / largest } else { 1.0 };
        [r, g, b].map(|c| {
            let toned = c * scale;
            let shown = if is_linear > 0.0 { coded(f64::from(toned)) as f32 } else { toned };
            if exponent == 1.0 { shown } else { shown.powf(exponent) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shoulder_keeps_hues_and_stays_below_white() {
        let curve = Curve { linear: Some(Exposure { stops: 1.0, tone: Tone::Shoulder }), gamma: 1.0 };
        let inverse = |coded: f32| linear(f64::from(coded));
        // Below the knee only the exposure counts.
        assert!((inverse(curve.curved([0.1, 0.2, 0.25])[1]) - 0.4).abs() < 1e-5);
        let bright = curve.curved([5.0, 2.5, 0.0]).map(inverse);
        assert!(bright[0] < 1.0 && (bright[0] / bright[1] - 2.0).abs() < 1e-4 && bright[2] == 0.0, "{bright:?}");
        // At the knee the slope is 1.
        let slope = (inverse(curve.curved([0.3005; 3])[0]) - inverse(curve.curved([0.2995; 3])[0])) / 0.002;
        assert!((slope - 1.0).abs() < 0.01, "{slope}");
        let none = Curve { linear: Some(Exposure { stops: 0.0, tone: Tone::None }), gamma: 1.0 };
        assert!((inverse(none.curved([0.8; 3])[0]) - 0.8).abs() < 1e-5);
        assert_eq!(Curve { linear: None, gamma: 2.0 }.curved([0.25, 1.0, -1.0]), [0.5, 1.0, 0.0]);
    }

    #[test]
    fn codes_are_those_of_srgb() {
        for (code, expected) in [(0.0, 0.0), (0.04, 0.04 / 12.92), (0.5, 0.214_041), (1.0, 1.0)] {
            assert!((linear(code) - expected).abs() < 1e-6, "{code}: {}", linear(code));
            assert!((coded(linear(code)) - code).abs() < 1e-9, "{code}");
        }
    }

    #[test]
    fn albedos_reflect_what_they_should() {
        for r in [0.0, 0.1, 0.45, 0.9] {
            let s = (1.0 - albedo(r)).sqrt();
            assert!(((1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s) - r).abs() < 1e-12, "{r}");
        }
        // The spherical albedos of a half-space (Chandrasekhar): of ω = 0.5, 0.9, 0.99. The approximation is good to 0.005.
        for (omega, expected) in [(0.5, 0.1465), (0.9, 0.4780), (0.99, 0.7946)] {
            assert!((albedo(expected) - omega).abs() < 5e-3, "{omega}: {}", albedo(expected));
        }
    }
}
