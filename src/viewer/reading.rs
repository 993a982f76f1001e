//! What is seen at a place of a picture: a point, by the depths that the renderer defines, and the value of the field there.

use super::drawn::{CurrentLook, Drawn, PageField};
use super::painter::Painter;
use super::replies::{Picked, PickedLabel};
use super::requests::{Pick, shown_size};
use super::scene::SharedScene;
use crate::camera::{Camera, Projection};
use crate::error::Error;
use crate::layers::Kernel;
use crate::renderer::depth_settings;
use crate::settings::{Algorithm, Blend, Classification, FieldKind, Layered, Method, Settings};
use crate::shown::{IndexedLabels, Shown, name_of};
use crate::viewport::Viewport;
use crate::volume::{LabelLayer, LabelSurfaces, LabelTable, Volume};
use glam::DVec3;
use std::collections::BTreeMap;

/// Farthest place in half heights from the middle of a picture. Pictures are at most this many times as wide as high.
const FARTHEST: f64 = 65_536.0;
/// Largest opacity with a finite extinction.
const MOST_OPAQUE: f64 = 0.99999;
/// The one pixel of a pick.
const PIXEL: Viewport = Viewport { width: 1, height: 1 };

impl Pick {
    /// Checks the numbers of a page.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for places that no picture has.
    pub fn check(&self) -> Result<(), Error> {
        shown_size(1, self.height)?;
        match [self.x, self.y].into_iter().find(|place| place.is_nan() || place.abs() > FARTHEST) {
            None => Ok(()),
            Some(place) => Err(Error::OutOfRange { name: "pick", value: place.to_string(), expected: "a place of the picture" }),
        }
    }

    /// The camera whose only pixel is the place: it looks from the same eye, or in the same direction.
    fn camera(&self, whole: &Camera) -> Result<Camera, Error> {
        let basis = whole.basis()?;
        let pixel = 1.0 / f64::from(self.height);
        Ok(match whole.projection {
            Projection::Parallel { scale } => {
                let by = (basis.right * self.x + basis.up * self.y) * scale;
                let projection = Projection::Parallel { scale: scale * pixel };
                Camera { position: whole.position + by, focal_point: whole.focal_point + by, projection, ..*whole }
            }
            Projection::Perspective { field_of_view } => {
                let half = (field_of_view.to_radians() / 2.0).tan();
                let ray = (basis.forward + (basis.right * self.x + basis.up * self.y) * half).normalize();
                let distance = whole.position.distance(whole.focal_point);
                let projection = Projection::Perspective { field_of_view: 2.0 * (half * pixel).atan().to_degrees() };
                Camera { focal_point: whole.position + ray * distance, view_up: basis.up, projection, ..*whole }
            }
        })
    }
}

impl Painter {
    /// The point that is seen at a place, by a depth picture of one pixel: that of the mean depth, which lies in what contributes most to an
    /// opaque place. Between two visible layers nothing may be visible: then that of the first depth. `None` where nothing is seen, or where the
    /// blend mode has no depths.
    pub(super) fn pick(&mut self, pick: &Pick) -> Result<Option<Picked>, Error> {
        let settings = self.scene.host.settings(&self.look, None)?;
        if self.scene.kind().check_method(Method::Depths, settings.blend).is_err() {
            return Ok(None);
        }
        let casting = depth_settings(&settings);
        let camera = pick.camera(&self.scene.camera(&pick.camera)?)?;
        self.scene.host.require_checked(&camera, PIXEL, &casting)?;
        let depths = self.renderer.depths(&camera, PIXEL, &settings)?;
        let (first, mean) = (f64::from(depths.first()[0]), f64::from(depths.mean()[0]));
        if !first.is_finite() {
            return Ok(None);
        }
        let forward = camera.basis()?.forward;
        let seen = Seen { scene: &self.scene, volume: self.moment.volume(), now: self.now(), settings: &settings };
        let (within, is_visible) = seen.at(camera.position + forward * mean)?;
        Ok(Some(if is_visible { within } else { seen.at(camera.position + forward * first)?.0 }))
    }
}

/// What is read at points.
struct Seen<'a> {
    scene: &'a SharedScene,
    /// The volume, or the step of a sequence.
    volume: &'a Volume<'static>,
    now: CurrentLook<'a>,
    settings: &'a Settings,
}

impl Seen<'_> {
    /// What is at a point, and whether any of it is visible there.
    fn at(&self, position: DVec3) -> Result<(Picked, bool), Error> {
        let &Self { volume, now, settings, .. } = self;
        let kernel = kernel(settings);
        let voxel = volume.grid().world_to_voxel(position);
        let value = value_at(volume, voxel, kernel);
        let is_iso = matches!(settings.blend, Blend::Iso(_));
        let opacity = |n: usize, value: f64| now.transfers[n].opacity(value);
        let (mut values, mut labels) = (Vec::new(), Vec::new());
        let is_visible = match &self.scene.opening.drawn {
            Drawn::One => is_iso || opacity(0, value) > 0.0,
            Drawn::Several(fields) => {
                let read = |field: &PageField| value_at(&field.volume, field.volume.grid().world_to_voxel(position), kernel);
                values = fields.iter().map(read).collect();
                let shown = now.look.channels_of(fields.len())?.iter().enumerate();
                is_iso || shown.filter(|(_, shown)| shown.visible).any(|(n, _)| opacity(n, values[n]) > 0.0)
            }
            Drawn::Shown(Shown::Components(components, _) | Shown::Vectors { components, .. }) => {
                values = components.iter().map(|component| value_at(component, voxel, kernel)).collect();
                true
            }
            Drawn::Shown(Shown::Labels(all)) => {
                // Labels are interpolated by the cubic kernel, or by a narrower one; smooth surfaces reach one voxel further.
                let kernel = match all.labels().surfaces() {
                    LabelSurfaces::Smooth => Kernel::BSpline,
                    LabelSurfaces::Voxels => Kernel::Cubic,
                };
                let extinction = |opacity: f64| -(-opacity.min(MOST_OPAQUE)).ln_1p();
                labels = self.labels_at(all, position, kernel, extinction)?;
                !labels.is_empty()
            }
            Drawn::LabelColors(all) => {
                // Colours are weighted by opacities.
                labels = self.labels_at(all, position, Kernel::Linear, |opacity| opacity)?;
                is_iso || opacity(0, value) > 0.0
            }
        };
        let value = (self.scene.kind() != FieldKind::Labels).then_some(value);
        Ok((Picked { position: position.to_array(), voxel: voxel.to_array(), value, values, labels }, is_visible))
    }

    /// The labels at a point, of each layer that has a visible one. `weight` of an opacity: how much a voxel counts.
    fn labels_at(
        &self,
        all: &IndexedLabels,
        position: DVec3,
        kernel: Kernel,
        weight: impl Fn(f64) -> f64,
    ) -> Result<Vec<PickedLabel>, Error> {
        let layers = all.layers().zip(self.scene.tables(self.now.look)?);
        let label_of = |((layer, indices), table): ((&LabelLayer, &Volume<'static>), LabelTable)| {
            let palette = layer.palette_of(&table);
            let voxel = layer.grid().world_to_voxel(position);
            let index = most_weighted(indices, voxel, kernel, |index| weight(palette[index][3]))?;
            let label = table.get(layer.ids()[index])?;
            Some(PickedLabel { id: label.id, name: name_of(label) })
        };
        Ok(layers.filter_map(label_of).collect())
    }
}

/// The index that contributes most at a point in voxels; `None` if all weights there are 0.
fn most_weighted(indices: &Volume, voxel: DVec3, kernel: Kernel, weight_of: impl Fn(usize) -> f64) -> Option<usize> {
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for_each_tap(indices, voxel, kernel, |weight, index| {
        let index = index as usize;
        *sums.entry(index).or_default() += weight * weight_of(index);
    });
    let (index, sum) = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (sum > 0.0).then_some(index)
}

/// The kernel that values are read with: that of the picture if it interpolates voxels, and otherwise the nearest one that does.
fn kernel(settings: &Settings) -> Kernel {
    let kernel = match settings.algorithm {
        Algorithm::Raycast { kernel, .. } => kernel,
        Algorithm::Layered(Layered { classification: Classification::Preintegrated { kernel, .. }, .. }) => kernel,
        Algorithm::Slicing { .. } => Kernel::Linear,
        _ => Kernel::Cubic,
    };
    match kernel {
        Kernel::BSpline | Kernel::Gaussian => Kernel::CatmullRom,
        kernel => kernel,
    }
}

/// Value of the field at a point in voxels. Voxels beyond the grid are the background.
fn value_at(volume: &Volume, voxel: DVec3, kernel: Kernel) -> f64 {
    let mut sum = 0.0;
    for_each_tap(volume, voxel, kernel, |weight, value| sum += weight * value);
    sum
}

/// Passes on the weight and the value of each voxel that a kernel reaches from a point in voxels.
fn for_each_tap(volume: &Volume, voxel: DVec3, kernel: Kernel, mut take: impl FnMut(f64, f64)) {
    let dims = volume.grid().dims();
    let radius = i64::from(kernel.radius());
    let first = voxel.to_array().map(|x| x.floor() as i64 + 1 - radius);
    let weight = |axis: usize, tap: i64| kernel.weight(voxel[axis] - (first[axis] + tap) as f64);
    let known = |axis: usize, tap: i64| usize::try_from(first[axis] + tap).ok().filter(|&i| i < dims[axis]);
    let taps = 2 * radius;
    for n in 0..taps * taps * taps {
        let [x, y, z] = [n % taps, n / taps % taps, n / (taps * taps)];
        let value = match (known(0, x), known(1, y), known(2, z)) {
            (Some(x), Some(y), Some(z)) => volume.value(x + dims[0] * (y + dims[1] * z)),
            _ => volume.background(),
        };
        take(weight(0, x) * weight(1, y) * weight(2, z), value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;
    use crate::device::{Device, DeviceChoice};
    use crate::renderer::Renderer;
    use crate::transfer::TransferFunction;
    use crate::viewer::PageCamera;
    use crate::volume::OpenOptions;

    fn pick(camera: &Camera, height: u32, x: f64, y: f64) -> Pick {
        Pick { id: 0, camera: PageCamera::new(camera, Orbit::default()), height, x, y }
    }

    /// A depth picture of one pixel has the point of the whole picture's pixel, in both projections.
    #[test]
    fn a_pick_is_a_pixel_of_the_depth_picture() {
        /// Half the step between samples, whose phase differs, and a bit for the depth of a slanted ray.
        const TOLERANCE: f64 = 0.6;
        let volume = Volume::open("builtin:hydrogen@32", &OpenOptions::default()).unwrap();
        let transfer = TransferFunction::new("t", vec![(0.0, [1.0; 3])], vec![(50.0, 0.0), (60.0, 1.0)]).unwrap();
        let mut renderer = Renderer::new(&Device::open(&DeviceChoice::Default).unwrap(), &volume, &transfer).unwrap();
        let size = Viewport { width: 24, height: 16 };
        let (centre, orbit) = (volume.grid().centre(), Orbit { azimuth: 33.0, elevation: 21.0, roll: 5.0 });
        let mut seen = 0;
        for projection in [Projection::Parallel { scale: 14.0 }, Projection::Perspective { field_of_view: 40.0 }] {
            let camera = Camera::orbit(centre, 45.0, orbit, projection);
            let basis = camera.basis().unwrap();
            let depths = renderer.depths(&camera, size, &Settings::default()).unwrap();
            for (column, row) in [(7, 6), (9, 9), (12, 8), (15, 7), (0, 0)] {
                let depth = f64::from(depths.first()[(row * size.width + column) as usize]);
                let half = f64::from(size.height) / 2.0;
                let x = (f64::from(column) + 0.5 - f64::from(size.width) / 2.0) / half;
                let y = (half - f64::from(row) - 0.5) / half;
                let own = pick(&camera, size.height, x, y).camera(&camera).unwrap();
                let found = f64::from(renderer.depths(&own, PIXEL, &Settings::default()).unwrap().first()[0]);
                assert_eq!(found.is_finite(), depth.is_finite(), "{projection:?} {column} {row}");
                if !depth.is_finite() {
                    continue;
                }
                seen += 1;
                let beside = basis.right * x + basis.up * y;
                let expected = match projection {
                    Projection::Parallel { scale } => camera.position + beside * scale + basis.forward * depth,
                    Projection::Perspective { field_of_view } => {
                        let half = (field_of_view.to_radians() / 2.0).tan();
                        camera.position + (basis.forward + beside * half) * depth
                    }
                };
                let position = own.position + own.basis().unwrap().forward * found;
                assert!(position.distance(expected) < TOLERANCE, "{position} instead of {expected}");
                // The first visible point lies where the transfer function begins to be opaque.
                let value = value_at(&volume, volume.grid().world_to_voxel(position), Kernel::Cubic);
                assert!((45.0..75.0).contains(&value), "{value}");
            }
        }
        assert!(seen >= 6, "{seen} places show something");
    }

    #[test]
    fn values_are_those_of_voxels_and_linear_between_them() {
        let volume = Volume::open("builtin:hydrogen@8", &OpenOptions::default()).unwrap();
        let value = |x: usize, y: usize, z: usize| volume.value(x + 8 * (y + 8 * z));
        for kernel in [Kernel::Linear, Kernel::Cubic, Kernel::CatmullRom] {
            assert!((value_at(&volume, DVec3::new(3.0, 4.0, 2.0), kernel) - value(3, 4, 2)).abs() < 1e-9, "{kernel:?}");
            assert!((value_at(&volume, DVec3::splat(-9.0), kernel) - volume.background()).abs() < 1e-9, "{kernel:?}");
        }
        let between = value_at(&volume, DVec3::new(3.25, 4.0, 2.0), Kernel::Linear);
        assert!((between - (0.75 * value(3, 4, 2) + 0.25 * value(4, 4, 2))).abs() < 1e-9);
    }

    #[test]
    fn places_of_no_picture_are_refused() {
        let camera = Camera::orbit(DVec3::ZERO, 5.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
        assert!(pick(&camera, 100, 1.5, -1.0).check().is_ok());
        for (height, x) in [(0, 0.0), (100, f64::NAN), (100, f64::INFINITY), (100, 1e9), (1 << 25, 0.0)] {
            assert!(pick(&camera, height, x, 0.0).check().is_err(), "{height} {x}");
        }
    }
}
