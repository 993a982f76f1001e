//! CSV lines of value, red, green, blue and opacity; colours and opacities in 0 … 1. A header line and lines after `#` are skipped.

use super::{MAX_POINTS, bad};
use crate::error::Error;
use crate::transfer::{ControlPoint, TransferFunction, approached};

/// Accepted separators between numbers.
pub(super) const SEPARATORS: [char; 3] = [',', ';', '\t'];

pub(super) fn parse(text: &str, file: &str) -> Result<TransferFunction, Error> {
    let (mut colors, mut opacities) = (Vec::new(), Vec::new());
    let lines = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).peekable();
    lines.next_if(|(_, line)| line.split(SEPARATORS).all(|name| name.trim().parse::<f64>().is_err()));
    for (number, line) in lines {
        let numbers: Option<Vec<f64>> = line.split(SEPARATORS).map(|n| n.trim().parse().ok()).collect();
        let Some(&[value, r, g, b, a]) = numbers.as_deref() else {
            return Err(bad(file, format!("line {number} is '{}': expected five numbers, value,r,g,b,a", shortened(line))));
        };
        colors.push((value, [r, g, b]));
        opacities.push((value, a));
        if colors.len() > MAX_POINTS {
            return Err(bad(file, format!("has more than {MAX_POINTS} lines: use fewer points")));
        }
    }
    TransferFunction::new(file, colors, opacities)
}

fn shortened(line: &str) -> String {
    let begin: String = line.chars().take(60).collect();
    if begin.len() < line.len() { begin + "…" } else { begin }
}

/// One line per control point of colour or opacity, and two where either has a step.
pub(super) fn written(transfer: &TransferFunction) -> String {
    let (colors, opacities) = (&transfer.colors, &transfer.opacities);
    let mut values: Vec<f64> = colors.iter().map(|p| p.0).chain(opacities.iter().map(|p| p.0)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t);
    let line = |value: f64, [r, g, b]: [f64; 3], a: f64| format!("{value},{r},{g},{b},{a}\n");
    let lines = values.into_iter().map(|value| {
        let here = line(value, transfer.color(value), transfer.opacity(value));
        if steps(colors, value) || steps(opacities, value) {
            let below = approached(opacities, value, |a, b, t| a + (b - a) * t);
            return line(value, approached(colors, value, mix), below) + &here;
        }
        here
    });
    std::iter::once("value,r,g,b,a\n".to_owned()).chain(lines).collect()
}

fn steps<T>(points: &[ControlPoint<T>], value: f64) -> bool {
    points.windows(2).any(|pair| pair[0].0 == value && pair[1].0 == value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_notes_and_other_separators() {
        let plain = parse("0,0,0,0,0\n10,1,0.5,0,1\n", "f").unwrap();
        for text in [
            "value,r,g,b,a\r\n0,0,0,0,0\r\n10,1,0.5,0,1\r\n",
            "# made by hand\n\"Value\";\"R\";\"G\";\"B\";\"A\"\n0;0;0;0;0\n\n# the top\n10; 1; 0.5; 0; 1",
            "0\t0\t0\t0\t0\n1e1\t1.0\t.5\t0\t1\n",
        ] {
            assert_eq!(parse(text, "f").unwrap(), plain, "{text}");
        }
        assert_eq!((plain.opacity(5.0), plain.color(10.0)), (0.5, [1.0, 0.5, 0.0]));
    }

    #[test]
    fn bad_lines_are_named() {
        for (text, word) in [
            ("0,0,0,0,0\n1,1,1,1\n", "line 2 is '1,1,1,1': expected five"),
            ("0,0,0,0,0\n1,1,1,1,x\n", "line 2"),
            ("0,0,0,0,0\nvalue,r,g,b,a\n", "line 2"),
            ("0,0,0,0,0,0\n", "line 1"),
            ("value,r,g,b,a\n", "no points"),
            ("0,0,0,0,NaN\n", "from 0 to 1"),
            ("NaN,0,0,0,0\n", "finite"),
            ("inf,0,0,0,0\n", "finite"),
            ("0,255,0,0,0\n", "from 0 to 1"),
            ("5,0,0,0,0\n1,0,0,0,0\n", "sorted"),
        ] {
            let message = parse(text, "f.csv").unwrap_err().to_string();
            assert!(message.contains(word) && message.contains("f.csv"), "{text}: {message}");
        }
        let many: String = (0..=MAX_POINTS).map(|i| format!("{i},0,0,0,0\n")).collect();
        assert!(parse(&many, "f").unwrap_err().to_string().contains("use fewer"));
    }
}
