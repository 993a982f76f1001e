//! Curves and measured points, as an SVG drawing.

use plotters::prelude::*;

/// A curve, or measured points.
pub(super) struct Series {
    pub name: &'static str,
    pub color: (u8, u8, u8),
    pub points: Vec<(f64, f64)>,
    /// Draws dots instead of a line.
    pub measured: bool,
}

/// Draws series over the ranges `x` and `y`, with axis labels and a legend.
pub(super) fn svg(x: (f64, f64), y: (f64, f64), labels: [&str; 2], series: &[Series]) -> String {
    let mut text = String::new();
    draw(&mut text, x, y, labels, series).expect("drawing into a string does not fail");
    text
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

fn draw(text: &mut String, x: (f64, f64), y: (f64, f64), labels: [&str; 2], series: &[Series]) -> Drawn {
    let root = SVGBackend::with_string(text, (720, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart =
        ChartBuilder::on(&root).margin(16).x_label_area_size(40).y_label_area_size(48).build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart.configure_mesh().x_desc(labels[0]).y_desc(labels[1]).light_line_style(WHITE).draw()?;
    for s in series {
        let color = RGBColor(s.color.0, s.color.1, s.color.2);
        let swatch = move |(x, y): (i32, i32)| Rectangle::new([(x, y - 4), (x + 16, y + 4)], color.filled());
        let drawn = if s.measured {
            chart.draw_series(s.points.iter().map(|&p| Circle::new(p, 4, color.filled())))?
        } else {
            chart.draw_series(LineSeries::new(s.points.iter().copied(), color.stroke_width(2)))?
        };
        drawn.label(s.name).legend(swatch);
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    root.present()?;
    drop(chart);
    Ok(())
}
