use super::*;
use crate::camera::{Orbit, Projection};
use glam::DVec3;

fn scene() -> (Grid, TransferFunction, Viewport) {
    let colors = vec![(0.0, [1.0, 0.0, 0.0]), (100.0, [0.0, 0.0, 1.0])];
    let transfer = TransferFunction::new("test", colors, vec![(0.0, 0.0), (100.0, 1.0)]).unwrap();
    (Grid::new([11, 21, 31], DVec3::ONE).unwrap(), transfer, Viewport::new(200, 160).unwrap())
}

fn camera(grid: &Grid, azimuth: f64, projection: Projection) -> Camera {
    Camera::orbit(grid.centre(), 200.0, Orbit { azimuth, elevation: 0.0, roll: 0.0 }, projection)
}

fn drawn(annotations: &Annotations, fill: [f32; 4], projection: Projection) -> Frame {
    let (grid, transfer, viewport) = scene();
    let camera = camera(&grid, 0.0, projection);
    let frame = Frame::new(viewport, vec![fill; viewport.pixels()]);
    let shown = AnnotatedView {
        camera: &camera,
        grid: &grid,
        transfer: &transfer,
        blend: Blend::Composite,
        background: Background::BLACK,
    };
    annotations.drawn(frame, shown).unwrap()
}

const PARALLEL: Projection = Projection::Parallel { scale: 20.0 };

/// Seen along z with a half height of 20 units on 80 pixels. The sides of the box lie 5 units (20 pixels) and 10 units (40) from the centre.
#[test]
fn the_box_is_where_the_voxels_are() {
    let bounding_box = Annotations { bounding_box: true, ..Annotations::default() };
    let frame = drawn(&bounding_box, [0.0; 4], PARALLEL);
    let opaque = |column, row| frame.pixel(column, row)[3] > 0.5;
    for column in [79, 80, 119, 120] {
        assert!(opaque(column, 80), "{column}");
    }
    for row in [39, 40, 119, 120] {
        assert!(opaque(100, row), "{row}");
    }
    assert!(!opaque(90, 80) && !opaque(70, 80) && !opaque(100, 60) && !opaque(100, 30));
    // In a perspective, the front face is larger than in the parallel view and the back face smaller.
    let wide = drawn(&bounding_box, [0.0; 4], Projection::Perspective { field_of_view: 2.0 * 0.1f64.atan().to_degrees() });
    let columns: Vec<u32> = (0..200).filter(|&column| wide.pixel(column, 80)[3] > 0.4).collect();
    assert!(columns.iter().any(|c| (75..80).contains(c)) && columns.iter().any(|c| (80..84).contains(c)), "{columns:?}");
}

/// An opaque volume hides the back edges; the front edges remain visible.
#[test]
fn the_volume_hides_what_is_behind_it() {
    let (grid, transfer, viewport) = scene();
    let bounding_box = Annotations { bounding_box: true, ..Annotations::default() };
    let camera = Camera::orbit(grid.centre(), 200.0, Orbit { azimuth: 30.0, elevation: 25.0, roll: 0.0 }, PARALLEL);
    let shown = AnnotatedView {
        camera: &camera,
        grid: &grid,
        transfer: &transfer,
        blend: Blend::Composite,
        background: Background::BLACK,
    };
    let on = |fill| bounding_box.drawn(Frame::new(viewport, vec![fill; viewport.pixels()]), shown).unwrap();
    let count = |frame: &Frame, bare: [f32; 4]| frame.pixels().iter().filter(|&&pixel| pixel != bare).count();
    let (empty, opaque) = (count(&on([0.0; 4]), [0.0; 4]), count(&on([0.5, 0.5, 0.5, 1.0]), [0.5, 0.5, 0.5, 1.0]));
    // Three of the twelve edges are at the back.
    assert!(opaque > empty / 2 && opaque < empty * 9 / 10, "{opaque} of {empty}");
}

/// The bar has the colours of the transfer function, with the largest value at the top.
#[test]
fn the_legend_shows_the_colours() {
    let legend = Annotations { legend: true, ..Annotations::default() };
    let frame = drawn(&legend, [0.0; 4], PARALLEL);
    // 160 · 0.44 rows, centred vertically.
    let (top, bottom) = (80 - 35 + 2, 80 + 35 - 3);
    let is = |pixel: [f32; 4], red: bool| pixel[3] > 0.9 && (pixel[0] > 0.8) == red && (pixel[2] > 0.8) != red && pixel[1] < 0.1;
    let found = |row: u32, red: bool| (100..200).filter(|&column| is(frame.pixel(column, row), red)).count();
    assert!(found(top, false) >= 10 && found(bottom, true) >= 10, "{} and {}", found(top, false), found(bottom, true));
    assert_eq!((found(top, true), found(bottom, false)), (0, 0));
}

/// Compositing shows opacities beside the bar; an iso-value is a line across it.
#[test]
fn the_legend_shows_what_the_blend_mode_shows() {
    let (grid, transfer, viewport) = scene();
    let camera = camera(&grid, 0.0, PARALLEL);
    let legend = Annotations { legend: true, ..Annotations::default() };
    let left = |blend| {
        let shown = AnnotatedView { camera: &camera, grid: &grid, transfer: &transfer, blend, background: Background::BLACK };
        let frame = legend.drawn(Frame::new(viewport, vec![[0.0; 4]; viewport.pixels()]), shown).unwrap();
        // The leftmost drawn column of each row.
        let first = |row: u32| (100..200).find(|&column| frame.pixel(column, row)[3] > 0.5).unwrap_or(200);
        [47, 62, 80, 97].map(first)
    };
    let composited = left(Blend::Composite);
    assert!(composited.is_sorted() && composited[0] < composited[3], "{composited:?}");
    let bar = left(Blend::Maximum)[0];
    assert_eq!(left(Blend::Maximum), [bar; 4]);
    assert!(composited[0] < bar);
    // At a quarter of the range: 160 · 0.44 / 4 rows below the centre.
    let iso = left(Blend::Iso(25.0));
    assert!(iso[..3] == [bar; 3] && iso[3] < bar, "{iso:?}");
    assert_eq!(left(Blend::Iso(250.0)), [bar; 4]);
}

/// 20 units span 80 pixels. At 44 of 200 columns the bar could be 11 units long; 10 is round.
#[test]
fn the_scale_bar_is_as_long_as_it_says() {
    let legend = Annotations { legend: true, ..Annotations::default() };
    let bright = |frame: &Frame| (0..200).filter(|&column| frame.pixel(column, 160 - 16)[0] > 0.7).count();
    let found = bright(&drawn(&legend, [0.0; 4], PARALLEL));
    assert!((40..=43).contains(&found), "{found}");
    assert_eq!(bright(&drawn(&legend, [0.0; 4], Projection::Perspective { field_of_view: 30.0 })), 0);
}

#[test]
fn axes_point_where_they_should() {
    let frame = drawn(&Annotations { axes: true, ..Annotations::default() }, [0.0; 4], PARALLEL);
    let red = |column: u32, row: u32| frame.pixel(column, row)[0] > frame.pixel(column, row)[1] + 0.3;
    let green = |column: u32, row: u32| frame.pixel(column, row)[1] > frame.pixel(column, row)[0] + 0.2;
    assert!(red(70, 110) && green(50, 90) && !red(30, 110) && !green(50, 130));
}

/// Pixels without annotations stay bit-identical, on an empty and on a filled frame.
#[test]
fn what_is_not_drawn_on_is_not_touched() {
    let all = Annotations {
        legend: true,
        list: None,
        bounding_box: true,
        axes: true,
        units: Some("HU".into()),
        length_units: Some("mm".into()),
        font_size: None,
    };
    let fill = [0.123, 0.2, 0.3, 0.7];
    let frame = drawn(&all, fill, PARALLEL);
    let same = frame.pixels().iter().filter(|&&pixel| pixel == fill).count();
    assert!(same > frame.pixels().len() / 2 && same < frame.pixels().len());
    assert!(frame.pixels().iter().flatten().all(|c| (0.0..=1.001).contains(c)));
    assert_eq!(drawn(&Annotations::default(), fill, PARALLEL).pixels(), vec![fill; 200 * 160]);
}

/// An eye inside the box sees the lines in front of it only. Degenerate sizes must not fail.
#[test]
fn odd_views_do_no_harm() {
    let (grid, transfer, _) = scene();
    let all = Annotations { legend: true, bounding_box: true, axes: true, units: Some("HU".into()), ..Annotations::default() };
    for (width, height) in [(1, 1), (3, 200), (200, 3), (40, 40)] {
        let viewport = Viewport::new(width, height).unwrap();
        let inside = Camera {
            position: grid.centre(),
            focal_point: grid.centre() + DVec3::X,
            view_up: DVec3::Y,
            projection: Projection::Perspective { field_of_view: 150.0 },
        };
        let shown = AnnotatedView {
            camera: &inside,
            grid: &grid,
            transfer: &transfer,
            blend: Blend::Composite,
            background: Background::Transparent,
        };
        let frame = all.drawn(Frame::new(viewport, vec![[0.0; 4]; viewport.pixels()]), shown).unwrap();
        assert!(frame.pixels().iter().flatten().all(|c| c.is_finite()));
    }
}

/// Beside the frame: every pixel of the frame stays, the box is clipped to it, and legend and axes lie in the room that is left.
#[test]
fn annotations_have_room_of_their_own() {
    let (grid, transfer, _) = scene();
    let all = Annotations { legend: true, axes: true, units: Some("kg/m3".into()), ..Annotations::default() };
    for (width, height) in [(300, 300), (800, 600), (1200, 1000)] {
        let size = Viewport::new(width, height).unwrap();
        let inner = all.inner(size, &transfer, Blend::Composite);
        assert!(inner.width > width / 2 && inner.height > height / 2, "{inner:?}");
        // The camera is so near that the box reaches beyond the frame.
        let camera = camera(&grid, 30.0, Projection::Parallel { scale: 8.0 });
        let shown = AnnotatedView {
            camera: &camera,
            grid: &grid,
            transfer: &transfer,
            blend: Blend::Composite,
            background: Background::BLACK,
        };
        let fill = [0.1, 0.2, 0.3, 0.7];
        let frame = || Frame::new(inner, vec![fill; inner.pixels()]);
        let is_inside = |n: usize| n % (width as usize) < inner.width as usize && n / (width as usize) < inner.height as usize;
        let drawn = all.drawn_beside(frame(), size, shown).unwrap();
        let (inside, outside): (Vec<usize>, Vec<usize>) = (0..size.pixels()).partition(|&n| is_inside(n));
        assert!(inside.iter().all(|&n| drawn.pixels()[n] == fill), "{size:?}: an annotation lies over the frame");
        assert!(outside.iter().any(|&n| drawn.pixels()[n][3] > 0.9), "{size:?}: no annotation");
        let boxed = Annotations { bounding_box: true, ..Annotations::default() }.drawn_beside(frame(), size, shown).unwrap();
        assert!(outside.iter().all(|&n| boxed.pixels()[n] == [0.0; 4]), "{size:?}: the box leaves the frame");
        assert!(inside.iter().any(|&n| boxed.pixels()[n] != fill));
        // Over a frame of the full size, they cover some of it.
        let over = all.drawn(Frame::new(size, vec![fill; size.pixels()]), shown).unwrap();
        assert!(inside.iter().any(|&n| over.pixels()[n] != fill));
    }
    let small = Viewport::new(3, 1).unwrap();
    assert_eq!(all.inner(small, &transfer, Blend::Composite), Viewport::new(2, 1).unwrap());
}

/// Capital letters are 0.73 em high, whatever the picture's size, and take their room from the frame. Other sizes are refused.
#[test]
fn letters_have_the_size_that_is_asked_for() {
    let (grid, transfer, _) = scene();
    let camera = camera(&grid, 0.0, PARALLEL);
    let background = Background::BLACK;
    let shown = AnnotatedView { camera: &camera, grid: &grid, transfer: &transfer, blend: Blend::Composite, background };
    let mut widths = Vec::new();
    for (font_size, capitals) in [(None, 9), (Some(12.0), 9), (Some(18.0), 13), (Some(25.0), 18), (Some(50.0), 36)] {
        let size = Viewport::new(620, 560).unwrap();
        let legend = Annotations { legend: true, units: Some("HHH".into()), font_size, ..Annotations::default() };
        let frame = legend.drawn(Frame::new(size, vec![[0.0; 4]; size.pixels()]), shown).unwrap();
        // The unit is above the bar, which has 0.44 of the height.
        let bright = |row: u32| (310..620).any(|column| frame.pixel(column, row)[0] > 0.5);
        let found = (0..150).skip_while(|&row| !bright(row)).take_while(|&row| bright(row)).count();
        assert!(found.abs_diff(capitals) <= 1, "{font_size:?}: {found} rows");
        widths.push(legend.inner(size, &transfer, Blend::Composite).width);
    }
    assert!(widths[0] == widths[1] && widths[1..].is_sorted_by(|a, b| a > b), "{widths:?}");
    for font_size in [0.5, 1001.0, -3.0, f64::NAN, f64::INFINITY] {
        let legend = Annotations { legend: true, font_size: Some(font_size), ..Annotations::default() };
        let frame = Frame::new(Viewport::new(20, 20).unwrap(), vec![[0.0; 4]; 400]);
        let refused = legend.drawn(frame, shown).unwrap_err();
        assert!(legend.check().is_err() && refused.to_string().contains("1 to 1000"), "{refused}");
    }
}

/// The colour bar alone has the pixels of that beside a picture, and all of them.
#[test]
fn the_legend_alone_is_that_beside_a_picture() {
    let (grid, transfer, size) = scene();
    // A perspective has no scale bar.
    let camera = camera(&grid, 0.0, Projection::Perspective { field_of_view: 30.0 });
    let background = Background::BLACK;
    for (blend, font_size) in [(Blend::Composite, None), (Blend::Maximum, None), (Blend::Composite, Some(7.5))] {
        let shown = AnnotatedView { camera: &camera, grid: &grid, transfer: &transfer, blend, background };
        let legend = Annotations { legend: true, units: Some("HU".into()), font_size, ..Annotations::default() };
        let whole = legend.drawn(Frame::new(size, vec![[0.0; 4]; size.pixels()]), shown).unwrap();
        let bar = legend.legend_alone(size, &transfer, blend, background).unwrap();
        let (left, top) = (200 - bar.width(), legend::rows(legend.extent(size)).start);
        // Edges at other columns are rounded differently by a step of 8 bits.
        let steps = |x: u32, y: u32| {
            let (a, b) = (bar.pixel(x, y), whole.pixel(left + x, top + y));
            (0..4).map(|i| (255.0 * (a[i] - b[i])).abs()).fold(0.0, f32::max)
        };
        let most =
            (0..bar.height()).flat_map(|y| (0..bar.width()).map(move |x| (x, y))).map(|(x, y)| steps(x, y)).fold(0.0, f32::max);
        assert!(most < 1.5, "{blend:?}, {font_size:?}: {most}");
        let drawn = |frame: &Frame| frame.pixels().iter().filter(|pixel| pixel[3] > 0.0).count();
        assert_eq!(drawn(&bar), drawn(&whole), "{blend:?}, {font_size:?}");
    }
}

/// A list takes the place of the colour bar, with the colours of its entries, and no more room than it needs.
#[test]
fn a_list_shows_the_colours_of_its_entries() {
    let entries = vec![LegendEntry::new("liver", [1.0, 0.0, 0.0]), LegendEntry::new("spleen", [0.0, 0.4, 1.0])];
    let list = Annotations { legend: true, list: Some(Legend { entries }), ..Annotations::default() };
    let colors = |annotations: &Annotations, color: [f32; 3]| {
        let frame = drawn(annotations, [0.0; 4], PARALLEL);
        frame.pixels().iter().filter(|pixel| (0..3).all(|i| (pixel[i] - color[i]).abs() < 0.01) && pixel[3] == 1.0).count()
    };
    // Swatches of one size; the bar's colours lie between red and blue.
    let red = colors(&list, [1.0, 0.0, 0.0]);
    assert!(red > 30 && red == colors(&list, [0.0, 0.4, 1.0]), "{red}");
    let bar = Annotations { list: None, ..list.clone() };
    assert_eq!(colors(&bar, [0.0, 0.4, 1.0]), 0);
    let (_, transfer, viewport) = scene();
    let alone = list.legend_alone(viewport, &transfer, Blend::Composite, Background::BLACK).unwrap();
    let beside = viewport.width - list.inner(viewport, &transfer, Blend::Composite).width;
    assert!(alone.width() <= beside && alone.height() < viewport.height, "{} of {beside}", alone.width());
}
