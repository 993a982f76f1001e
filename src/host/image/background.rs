//! Background of pictures.

use std::str::FromStr;

/// Background of a picture.
///
/// ```
/// use layersplat::Background;
///
/// assert_eq!("#ff0000".parse(), Ok(Background::Color([1.0, 0.0, 0.0])));
/// assert_eq!("transparent".parse(), Ok(Background::Transparent));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// An opaque colour: red, green, blue in 0 … 1.
    Color([f32; 3]),
    /// No background: the picture keeps its alpha channel.
    Transparent,
}

impl Background {
    /// Opaque black.
    pub const BLACK: Background = Background::Color([0.0; 3]);
}

impl FromStr for Background {
    type Err = String;

    /// Parses `transparent`, `black`, `white`, `grey`, `#rrggbb`, or `R,G,B` with numbers in 0 … 1.
    fn from_str(text: &str) -> Result<Self, String> {
        let color = match text {
            "transparent" => return Ok(Background::Transparent),
            "black" => Some([0.0; 3]),
            "grey" | "gray" => Some([0.5; 3]),
            "white" => Some([1.0; 3]),
            _ => hexadecimal(text).or_else(|| numbers(text)),
        };
        color.map(Background::Color).ok_or_else(|| {
            format!("invalid colour '{text}': use transparent, black, white, grey, #rrggbb or R,G,B with numbers from 0 to 1")
        })
    }
}

fn hexadecimal(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let value = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| (value >> shift & 255) as f32 / 255.0))
}

fn numbers(text: &str) -> Option<[f32; 3]> {
    let parts: Vec<f32> = text.split(',').map(|c| c.trim().parse().ok()).collect::<Option<_>>()?;
    let color: [f32; 3] = parts.try_into().ok()?;
    color.iter().all(|c| (0.0..=1.0).contains(c)).then_some(color)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours() {
        assert_eq!("transparent".parse(), Ok(Background::Transparent));
        assert_eq!("#ff0033".parse(), Ok(Background::Color([1.0, 0.0, 0.2])));
        assert_eq!("0,0.5,1".parse(), Ok(Background::Color([0.0, 0.5, 1.0])));
        for bad in ["", "pink", "#ff00", "#ff00zz", "1,2,3", "0,0", "NaN,0,0", "#\u{e9}\u{e9}\u{e9}"] {
            assert!(bad.parse::<Background>().is_err(), "{bad}");
        }
    }
}
