//! Curves and measured points, as an SVG drawing.

/// Size of the drawing in pixels.
const SIZE: [u32; 2] = [720, 480];
/// The area in which series are drawn: left, top, width and height.
const AREA: [f64; 4] = [64.0, 16.0, 640.0, 408.0];
/// Intervals between the numbers of an axis.
const TICKS: u32 = 10;

/// A curve, or measured points.
pub(super) struct Series {
    pub name: &'static str,
    /// Colour in SVG.
    pub color: &'static str,
    pub points: Vec<(f64, f64)>,
    /// Draws dots instead of a line.
    pub measured: bool,
}

/// Draws series from 0 to `largest`, with axis labels and a legend.
pub(super) fn svg(largest: [f64; 2], labels: [&str; 2], series: &[Series]) -> String {
    let ([width, height], [left, top, across, down]) = (SIZE, AREA);
    let bottom = top + down;
    let place = |&(x, y): &(f64, f64)| (left + x / largest[0] * across, bottom - y / largest[1] * down);
    let text = |x: f64, y: f64, anchor: &str, text: &str| format!("<text x='{x}' y='{y}' text-anchor='{anchor}'>{text}</text>\n");
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{width}' height='{height}' font-family='sans-serif' font-size='12'>\n\
         <rect width='{width}' height='{height}' fill='white'/>\n"
    );
    for tick in 0..=TICKS {
        let share = f64::from(tick) / f64::from(TICKS);
        let (x, y) = place(&(share * largest[0], share * largest[1]));
        let line = format!("<path d='M{x:.1} {bottom}v4M{left} {y:.1}h-4' stroke='black'/>\n");
        let [below, beside] = largest.map(|largest| format!("{:.1}", share * largest));
        svg += &[line, text(x, bottom + 18.0, "middle", &below), text(left - 8.0, y + 4.0, "end", &beside)].concat();
    }
    svg += &text(left + across / 2.0, bottom + 40.0, "middle", labels[0]);
    svg +=
        &format!("<g transform='translate(16 {}) rotate(-90)'>{}</g>\n", top + down / 2.0, text(0.0, 0.0, "middle", labels[1]));
    for Series { color, points, measured, .. } in series {
        let points = points.iter().map(place);
        svg += &if *measured {
            points.map(|(x, y)| format!("<circle cx='{x:.1}' cy='{y:.1}' r='4' fill='{color}'/>\n")).collect::<String>()
        } else {
            let points = points.map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ");
            format!("<polyline points='{points}' fill='none' stroke='{color}' stroke-width='2'/>\n")
        };
    }
    for (n, Series { name, color, .. }) in series.iter().enumerate() {
        let y = top + 20.0 * (n as f64 + 1.0);
        let swatch = format!("<rect x='{}' y='{}' width='16' height='8' fill='{color}'/>\n", left + across - 24.0, y - 8.0);
        svg += &[swatch, text(left + across - 32.0, y, "end", name)].concat();
    }
    svg + &format!("<rect x='{left}' y='{top}' width='{across}' height='{down}' fill='none' stroke='black'/>\n</svg>\n")
}
