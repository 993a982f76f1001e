//! 3D Slicer volume properties as text (`.vp`). Nine lines: interpolation, shading, diffuse, ambient, specular, specular power,
//! scalar opacity, gradient opacity and colour. Each of the last three is a count followed by that many numbers.

use super::{MAX_POINTS, bad, slicer_json};
use crate::error::Error;
use crate::transfer::TransferFunction;

/// Lines before the scalar opacity.
const LIGHTING_LINES: usize = 6;
/// Bytes of a line that Slicer reads.
const SLICERS_LINE: usize = 1023;

pub(super) fn parse(text: &str, file: &str) -> Result<TransferFunction, Error> {
    let mut lines = text.lines().map(str::trim).skip_while(|line| line.is_empty()).skip(LIGHTING_LINES);
    let mut list = |what: &str| match lines.next() {
        Some(line) => numbers(line).map_err(|problem| bad(file, format!("its {what} {problem}"))),
        None => Err(bad(file, format!("ends before its {what}: a 3D Slicer volume property has nine lines"))),
    };
    let opacities = points::<2>(&list("opacity by value")?, "opacity by value", file)?;
    let by_gradient = points::<2>(&list("opacity by gradient")?, "opacity by gradient", file)?;
    let colors = points::<4>(&list("colour by value")?, "colour by value", file)?;
    slicer_json::warn_of_gradients(file, by_gradient.iter().map(|point| point[1]));
    let colors = colors.iter().map(|&[value, r, g, b]| (value, [r, g, b])).collect();
    TransferFunction::new(file, colors, opacities.iter().map(|&[value, a]| (value, a)).collect())
}

/// The numbers of a line, which starts with their count.
fn numbers(line: &str) -> Result<Vec<f64>, String> {
    let mut words = line.split_ascii_whitespace();
    let count: Option<usize> = words.next().and_then(|count| count.parse().ok());
    let numbers: Option<Vec<f64>> = words.take(4 * MAX_POINTS + 1).map(|number| number.parse().ok()).collect();
    match (count, numbers) {
        (Some(count), Some(numbers)) if numbers.len() == count => Ok(numbers),
        (Some(count), Some(numbers)) => {
            Err(format!("should hold {count} numbers, but holds {}{}", numbers.len(), truncation_note(line)))
        }
        _ => Err("is not a count followed by numbers".into()),
    }
}

fn truncation_note(line: &str) -> String {
    if line.len() == SLICERS_LINE { format!(": it was cut off after {SLICERS_LINE} bytes") } else { String::new() }
}

fn points<const N: usize>(numbers: &[f64], what: &str, file: &str) -> Result<Vec<[f64; N]>, Error> {
    match numbers.as_chunks::<N>() {
        (points, []) if points.len() <= MAX_POINTS => Ok(points.to_vec()),
        (_, []) => Err(bad(file, format!("its {what} has more than {MAX_POINTS} points: use fewer"))),
        _ => Err(bad(file, format!("its {what} holds {} numbers, which is not a multiple of {N}", numbers.len()))),
    }
}

pub(super) fn written(transfer: &TransferFunction) -> String {
    let list = |numbers: Vec<f64>| {
        let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
        format!("{} {}", words.len(), words.join(" "))
    };
    let opacities = list(transfer.opacities().iter().flat_map(|&(value, a)| [value, a]).collect());
    let colors = list(transfer.colors().iter().flat_map(|&(value, [r, g, b])| [value, r, g, b]).collect());
    if opacities.len().max(colors.len()) > SLICERS_LINE {
        tracing::warn!(
            "3D Slicer reads at most {SLICERS_LINE} bytes of a line, and this function has longer lines: write .vp.json"
        );
    }
    let by_gradient = list(vec![0.0, 1.0, 255.0, 1.0]);
    // Linear interpolation, shaded, VTK's default lighting.
    format!("1\n1\n0.7\n0.1\n0.2\n10\n{opacities}\n{by_gradient}\n{colors}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "1\n1\n0.9\n0.1\n0.2\n10\n6 -100 0 50 0.5 300 1\n4 0 1 255 1\n8 -100 0 0 0 300 1 0.5 0\n";

    #[test]
    fn a_small_one() {
        let t = parse(SMALL, "f").unwrap();
        assert_eq!((t.opacities(), t.range()), (&[(-100.0, 0.0), (50.0, 0.5), (300.0, 1.0)][..], (-100.0, 300.0)));
        assert_eq!(t.color(100.0), [0.5, 0.25, 0.0]);
        assert_eq!(parse(&SMALL.replace('\n', " \r\n"), "f").unwrap(), t);
    }

    #[test]
    fn bad_ones_say_what_is_wrong() {
        for (from, to, word) in [
            ("6 -100", "7 -100", "opacity by value should hold 7 numbers, but holds 6"),
            ("6 -100 0 50 0.5 300 1", "5 -100 0 50 0.5 300", "multiple of 2"),
            ("300 1\n", "300 x\n", "not a count followed by numbers"),
            ("300 1\n", "300 NaN\n", "from 0 to 1"),
            ("50 0.5", "-500 0.5", "sorted"),
            ("8 -100 0 0 0", "8 -100 0 0 2", "from 0 to 1"),
            ("4 0 1 255 1\n8 -100 0 0 0 300 1 0.5 0\n", "", "ends before its opacity by gradient"),
            ("8 -100 0 0 0 300 1 0.5 0", "0", "no points"),
            ("6 -100", "-6 -100", "not a count followed by numbers"),
        ] {
            let text = SMALL.replace(from, to);
            assert_ne!(text, SMALL);
            let message = parse(&text, "f.vp").unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("f.vp"), "{text}: {message}");
        }
        let long = "0 0 ".repeat(MAX_POINTS + 1);
        let many = SMALL.replace("6 -100 0 50 0.5 300 1", &format!("{} {long}", 2 * MAX_POINTS + 2));
        assert!(parse(&many, "f").unwrap_err().to_string().contains("use fewer"));
    }
}
