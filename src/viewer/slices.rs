//! Three slices beside the picture, through one point.

use super::encoding::encoded;
use super::inbox::Inbox;
use super::painter::Painter;
use super::replies::{Picture, PlacedSlice, Reply, Step};
use super::requests::{PagePlane, SlicesView};
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::settings::{Algorithm, Blend, Method, Settings};
use crate::slice::{Slice, SliceAxis, SliceColors};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume};
use glam::DVec3;
use serde_json::{Value, json};
use std::time::Instant;

/// Most pixels of a slice.
const MOST_PIXELS: usize = 1 << 22;
/// The pixel whose centre is the point, relative to the smallest spacing.
const POINT_SCALE: f64 = 1e-3;

impl SlicesView {
    /// Checks sizes and numbers, before anything is drawn.
    ///
    /// # Errors
    /// The first number outside its range.
    pub fn check(&self) -> Result<(), Error> {
        let viewport = self.viewport()?;
        if viewport.pixels() > MOST_PIXELS {
            let value = format!("{}x{}", self.width, self.height);
            return Err(Error::OutOfRange { name: "viewport", value, expected: "a slice of at most 4 million pixels" });
        }
        self.planes().iter().try_for_each(|slice| slice.basis().map(|_| ()))?;
        self.colors().check()
    }

    fn viewport(&self) -> Result<Viewport, Error> {
        Viewport::new(self.width, self.height)
    }

    /// The planes through the point, of any scale.
    fn planes(&self) -> [Slice; 3] {
        let centre = DVec3::from_array(self.point);
        self.planes.map(|PagePlane { right, up }| Slice { centre, right: right.into(), up: up.into(), scale: 1.0 })
    }

    fn colors(&self) -> SliceColors {
        match (self.window, self.thickness) {
            (Some([level, width]), _) => SliceColors::Window { level, width },
            (None, Some(thickness)) => SliceColors::Transfer { thickness },
            (None, None) => SliceColors::TRANSFER,
        }
    }
}

impl Painter {
    /// Draws three slices, and sends them below each other as one picture, after their places and the value at their point.
    pub(super) fn show_slices(&mut self, view: &SlicesView) -> Result<(), Error> {
        let since = Instant::now();
        self.scene.kind().check_method(Method::Slices, Blend::Composite)?;
        let viewport = view.viewport()?;
        let opening = &self.scene.opening;
        // Slices sample and colour the field by the code of these kernels.
        let blend = Settings { blend: Blend::Average, ..Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }.into() };
        self.require_checked(&self.scene.camera(&opening.camera)?, viewport, &blend)?;
        let grid = opening.volume.grid().clone();
        let slices = view.planes().map(|slice| slice.fitted(&grid, viewport));
        let background = self.look.background()?;
        self.build_programs(Inbox::has_look, |renderer| {
            value_at(renderer, &grid, DVec3::from_array(view.point), view.kernel)?;
            renderer.slice(&slices[0], viewport, view.kernel, view.colors()).map(drop)
        })?;
        let renderer = self.renderer.require_whole("the page's slices")?;
        let value = value_at(renderer, &grid, DVec3::from_array(view.point), view.kernel)?;
        let mut rgba = Vec::new();
        let mut placed = Vec::new();
        for slice in &slices {
            let frame: Frame = renderer.slice(slice, viewport, view.kernel, view.colors())?;
            rgba.extend(frame.to_rgba8(background));
            let pixels = slice.pixels(viewport)?;
            let [corner, right, down] = [pixels.corner, pixels.right, pixels.down].map(|v| v.to_array());
            placed.push(PlacedSlice { corner, right, down });
        }
        let size = Viewport { width: viewport.width, height: 3 * viewport.height };
        let (format, bytes) = encoded(&rgba, size, background, view.moving)?;
        self.outgoing.reply(&Reply::Slices { id: view.id, value, placed: &placed });
        self.inbox.sent();
        let milliseconds = since.elapsed().as_secs_f32() * 1e3;
        self.outgoing.picture(&Picture { step: Step::Slices, format, id: view.id, size, milliseconds, bytes });
        Ok(())
    }
}

/// The value of the field at a point; `None` outside the volume.
fn value_at(renderer: &mut Renderer, grid: &Grid, point: DVec3, kernel: Kernel) -> Result<Option<f32>, Error> {
    let pixel = Viewport { width: 1, height: 1 };
    let scale = POINT_SCALE * grid.spacing().min_element();
    let slice = Slice { centre: point, right: DVec3::X, up: DVec3::Y, scale };
    let value = renderer.slice_values(&slice, pixel, kernel)?.values()[0];
    Ok((!value.is_nan()).then_some(value))
}

/// What the page needs to know about the slices of a volume: its axes, with coordinates that are affine in world points, and a window.
/// `values`: a volume with its values.
pub(super) fn described(grid: &Grid, values: &Volume) -> Value {
    let axes = SliceAxis::three(grid).map(|axis| {
        let offset = axis.coordinate(grid, DVec3::ZERO);
        let per_unit = DVec3::AXES.map(|unit| axis.coordinate(grid, unit) - offset);
        let (lo, hi) = axis.range(grid).expect("axes that the volume has");
        let [right, up] = axis.directions(grid).expect("axes that the volume has");
        let along = DVec3::from_array(per_unit).normalize() * axis.spacing(grid);
        json!({
            "name": axis.name(), "right": right.to_array(), "up": up.to_array(), "step": along.to_array(),
            "offset": offset, "per_unit": per_unit, "range": [lo, hi],
        })
    });
    let (lo, hi) = TransferFunction::grey_ramp(values).range();
    json!({ "axes": axes, "has_anatomy": grid.has_anatomy(), "window": [(lo + hi) / 2.0, hi - lo] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: &str = r#"{"id":1,"point":[1,2,3],"planes":[{"right":[1,0,0],"up":[0,1,0]},{"right":[1,0,0],"up":[0,0,1]},
        {"right":[0,1,0],"up":[0,0,1]}],"width":8,"height":9,"kernel":"linear","window":[1,2],"thickness":null,"moving":false}"#;

    #[test]
    fn numbers_are_checked_before_anything_is_drawn() {
        let view: SlicesView = serde_json::from_str(VIEW).unwrap();
        assert!(view.check().is_ok());
        let flat = PagePlane { right: [1.0, 0.0, 0.0], up: [2.0, 0.0, 0.0] };
        for (bad, field) in [
            (SlicesView { width: 0, ..view }, "viewport"),
            (SlicesView { width: 4096, height: 4096, ..view }, "viewport"),
            (SlicesView { planes: [flat, view.planes[1], view.planes[2]], ..view }, "plane"),
            (SlicesView { point: [f64::INFINITY, 0.0, 0.0], ..view }, "plane"),
            (SlicesView { window: Some([0.0, 0.0]), ..view }, "window"),
            (SlicesView { window: None, thickness: Some(-1.0), ..view }, "thickness"),
        ] {
            assert_eq!(bad.check().unwrap_err().fields(), [field], "{bad:?}");
        }
        assert!(serde_json::from_str::<SlicesView>(&VIEW.replace("linear", "nearest")).is_err());
        assert!(serde_json::from_str::<SlicesView>(&VIEW.replace("\"id\":1", "\"id\":1,\"path\":\"/etc\"")).is_err());
    }

    /// Coordinates of the page are those of the library.
    #[test]
    fn axes_are_affine_in_the_world() {
        let turn = glam::DMat3::from_rotation_z(0.3) * glam::DMat3::from_rotation_x(-0.4);
        let plain = Grid::oriented([4, 5, 6], DVec3::new(0.5, 1.0, 2.0), DVec3::new(7.0, 8.0, 9.0), turn).unwrap();
        for grid in [plain.clone(), plain.with_anatomy()] {
            let voxels = crate::volume::Voxels::Uint8(vec![7; 120]);
            let volume = Volume::new("test", grid.clone(), voxels).unwrap();
            let described = described(&grid, &volume);
            for (axis, found) in SliceAxis::three(&grid).iter().zip(described["axes"].as_array().unwrap()) {
                let vector = |name: &str| DVec3::from_array(std::array::from_fn(|i| found[name][i].as_f64().unwrap()));
                let coordinate = |point: DVec3| vector("per_unit").dot(point) + found["offset"].as_f64().unwrap();
                let point = DVec3::new(3.0, -1.0, 2.0);
                assert!((coordinate(point) - axis.coordinate(&grid, point)).abs() < 1e-9, "{axis:?}");
                let step = coordinate(point + vector("step")) - coordinate(point);
                let expected = if grid.has_anatomy() { axis.spacing(&grid) } else { 1.0 };
                assert!((step - expected).abs() < 1e-9, "{axis:?}: {step}");
            }
        }
    }
}
