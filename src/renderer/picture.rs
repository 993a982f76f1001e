//! The warp and the finished picture.

use super::frame::{Resources, Slot};
use super::tiles::{Drawn, Target, Tiles};
use crate::color::Curve;
use crate::device::launch::Launcher;
use crate::device::launch::picture::{Present, PresentArguments, Warp, WarpArguments, Warped};
use crate::device::launch::structs::{Float4, WarpParams};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::image::Background;
use crate::layers::{Lattice, Lines, Rays};
use crate::memory;
use crate::viewport::Viewport;
use std::sync::Arc;

/// Largest number of filter taps per pixel and axis, for pixels that cover many voxels.
const MAX_FILTER_TAPS: f64 = 16.0;

/// Float picture that lattices are warped into.
pub(super) const FRAME: Slot<Float4> = Slot::new("the float picture");
/// Displayed 8-bit picture.
const RGBA: Slot<[u8; 4]> = Slot::new("the 8-bit picture");

/// Warps lattices to the screen and converts float pictures to 8 bits.
#[derive(Default)]
pub(super) struct Picture {
    warp: Launcher<Warp>,
    present: Launcher<Present>,
}

/// Result of a frame on the device.
#[derive(Clone)]
pub(super) enum Finished {
    /// No step has rendered yet.
    Nothing,
    Floats(Arc<Buffer<Float4>>),
    Rgba8(Arc<Buffer<[u8; 4]>>),
}

impl Finished {
    /// The float picture, or the samples of a lattice.
    pub fn floats(&self) -> &Arc<Buffer<Float4>> {
        let Self::Floats(floats) = self else { unreachable!("the steps end in floats") };
        floats
    }

    /// The 8-bit picture.
    pub fn rgba8(&self) -> &Arc<Buffer<[u8; 4]>> {
        let Self::Rgba8(rgba8) = self else { unreachable!("the steps end in 8 bits") };
        rgba8
    }
}

/// Declares the float picture.
pub(super) fn declare_floats(viewport: Viewport, resources: &mut Resources) {
    resources.frame(&FRAME, viewport.pixels());
}

/// Declares the displayed picture.
pub(super) fn declare_displayed(viewport: Viewport, resources: &mut Resources) {
    resources.frame(&RGBA, viewport.pixels());
}

/// Binds a buffer of the caller for the next picture.
pub(super) fn bind(target: &mut Target, into: Finished) {
    match into {
        Finished::Floats(buffer) => target.arena.bind(&FRAME, buffer),
        Finished::Rgba8(buffer) => target.arena.bind(&RGBA, buffer),
        Finished::Nothing => {}
    }
}

/// Contribution of a lattice to a frame.
#[derive(Clone, Copy)]
pub(super) struct Share {
    pub share: f64,
    /// Whether it is added to the contributions of other lattices.
    pub added: bool,
}

impl Share {
    /// A single lattice that makes up the whole frame.
    pub const WHOLE: Share = Share { share: 1.0, added: false };
}

/// Inputs of the warp to the screen.
#[derive(Clone, Copy)]
pub(super) struct WarpInputs<'a> {
    pub lattice: &'a Lattice,
    pub rays: &'a Rays,
    pub viewport: Viewport,
    /// Whether colours are in linear light.
    pub is_linear: bool,
}

impl WarpInputs<'_> {
    /// Kernel argument, for a lattice in these tiles.
    pub fn params(self, tiles: Tiles, share: Share) -> WarpParams {
        let Self { lattice, rays, viewport, .. } = self;
        let from_screen = lattice.from_screen(rays);
        let filter = rays.voxels_per_pixel(lattice.frame).ceil().clamp(1.0, MAX_FILTER_TAPS) as i32;
        let (lines, is_upright) = match Lines::new(lattice, rays, viewport) {
            Some(lines) if filter == 1 && lattice.crossed_along.is_none() => (Some(lines.axis), lines.upright),
            _ => (None, false),
        };
        WarpParams {
            from_screen: from_screen.transpose().to_cols_array().map(|m| m as f32),
            lattice: lattice.size.map(|n| n as i32),
            frame: [viewport.width as i32, viewport.height as i32],
            forward: lattice.forward() as f32,
            tile: tiles.size.map(|n| n as i32),
            tile_lead: tiles.most_lead() as i32,
            share: share.share as f32,
            added: i32::from(share.added),
            displayed: 0,
            lines: lines.map_or(0, |axis| axis as i32 + 1),
            upright: i32::from(is_upright),
            on_pixels: i32::from(is_upright && lines.is_some_and(|axis| lattice.aligned[axis])),
            for_each_pixel: i32::from(lattice.has_pixels_samples()),
            crossed_along: lattice.crossed_along.map_or(0, |axis| axis as i32 + 1),
            stagger: [lattice.stagger.first, lattice.stagger.per_column],
            filter,
        }
    }
}

impl Picture {
    /// Warps a lattice into the float picture.
    pub fn warp(&mut self, device: &Device, target: &Target, onto: WarpInputs, share: Share) -> Result<Finished, Error> {
        let Drawn { samples: lattice, active_samples, tiles, .. } = &target.drawn();
        let picture = target.arena.get(&FRAME);
        let [background, curve] = [Float4([0.0; 4]); 2];
        let (p, warped) = (onto.params(*tiles, share), Warped::Frame(&picture));
        let arguments = WarpArguments { lattice, active_samples, p, background, curve, picture: warped };
        self.warp.launch(device, (false, onto.is_linear), &arguments)?;
        Ok(Finished::Floats(picture))
    }

    /// Warps a lattice directly into an 8-bit picture.
    pub fn warp_displayed(
        &mut self,
        device: &Device,
        target: &Target,
        onto: WarpInputs,
        (background, curve): (Background, Curve),
    ) -> Result<Finished, Error> {
        let Drawn { samples: lattice, active_samples, tiles, .. } = &target.drawn();
        let picture = target.arena.get(&RGBA);
        let p = WarpParams { displayed: 1, ..onto.params(*tiles, Share::WHOLE) };
        let (numbers, warped) = (Float4(curve.numbers()), Warped::Displayed(&picture));
        let arguments =
            WarpArguments { lattice, active_samples, p, background: for_kernels(background), curve: numbers, picture: warped };
        self.warp.launch(device, (curve != Curve::NONE, onto.is_linear), &arguments)?;
        Ok(Finished::Rgba8(picture))
    }

    /// Converts a float picture to 8 bits.
    pub fn present(
        &mut self,
        device: &Device,
        target: &Target,
        frame: &Buffer<Float4>,
        viewport: Viewport,
        (background, curve): (Background, Curve),
    ) -> Result<Finished, Error> {
        let rgba = target.arena.get(&RGBA);
        let (pixels, background) = (viewport.pixels() as i32, for_kernels(background));
        let arguments = PresentArguments { frame, background, curve: Float4(curve.numbers()), pixels, rgba: &rgba };
        self.present.launch(device, curve != Curve::NONE, &arguments)?;
        Ok(Finished::Rgba8(rgba))
    }
}

/// Bytes per pixel of float and 8-bit pictures on the host.
pub(super) const FLOATS: u64 = size_of::<[f32; 4]>() as u64;
pub(super) const RGBA8: u64 = size_of::<[u8; 4]>() as u64;

/// Reads an 8-bit picture to the host.
pub(super) fn read_displayed(device: &Device, rgba: &Buffer<[u8; 4]>, viewport: Viewport) -> Result<Vec<u8>, Error> {
    let mut picture = memory::zeroed::<[u8; 4]>("the picture", viewport.pixels())?;
    rgba.read(device, &mut picture)?;
    Ok(picture.into_flattened())
}

fn for_kernels(background: Background) -> Float4 {
    match background {
        Background::Color([r, g, b]) => Float4([r, g, b, 1.0]),
        Background::Transparent => Float4([0.0; 4]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DeviceChoice;
    use crate::camera::{Camera, Orbit, Projection};
    use crate::layers::{Axis, Density, Kernel, Sampling};
    use crate::volume::Grid;
    use glam::DVec3;

    /// Rounding of float positions up to a hundred samples, and of weights.
    const ROUNDING: f64 = 2e-5;
    const SIZE: [u32; 2] = [83, 61];

    /// A quadratic colour function over the lattice, which cubic interpolation reproduces exactly. It increases everywhere, so
    /// that the filter stays within the range of the surrounding samples.
    fn color([i, j]: [f64; 2]) -> [f64; 4] {
        let (u, v) = (i / 400.0, j / 400.0);
        [u * u + 0.3 * v, 0.5 * v * v + 0.1 * u, 0.2 * (u + v) + 0.1 * (u + v) * (u + v), 0.9]
    }

    /// Largest difference between the warped picture of this colour function and the function, at pixels surrounded by at least
    /// four samples.
    fn difference(device: &Device, lattice: &Lattice, rays: &Rays, moved: f64) -> f64 {
        let [width, height] = lattice.size.map(f64::from);
        let stagger = lattice.stagger;
        let places =
            (0..lattice.size[1]).flat_map(|j| (0..lattice.size[0]).map(move |i| [f64::from(i), f64::from(j) + stagger.shift(i)]));
        let samples: Vec<_> = places.map(|place| color(place).map(|c| c as f32)).collect();
        let mut target = Target::with_samples(device, &samples, Tiles::for_points(lattice, device.tuning())).unwrap();
        let viewport = Viewport::new(SIZE[0], SIZE[1]).unwrap();
        let mut resources = Resources::default();
        declare_floats(viewport, &mut resources);
        target.arena.reserve(device, &resources).unwrap();
        let onto = WarpInputs { lattice, rays, viewport, is_linear: false };
        let Finished::Floats(warped) = Picture::default().warp(device, &target, onto, Share::WHOLE).unwrap() else {
            panic!("the warp yields a float picture");
        };
        let mut pixels = vec![Float4([0.0; 4]); viewport.pixels()];
        warped.read(device, &mut pixels).unwrap();
        let (mut largest, mut compared) = (0.0_f64, 0);
        for (n, pixel) in pixels.iter().enumerate() {
            let (x, y) = (n % SIZE[0] as usize, n / SIZE[0] as usize);
            let place = lattice.from_screen(rays) * DVec3::new(x as f64 + 0.5, y as f64 + 0.5, 1.0);
            let place = [place.x / place.z, place.y / place.z];
            if place.iter().zip([width, height]).all(|(&at, samples)| at >= 1.0 && at < samples - 2.0) {
                let expected = color(place.map(|at| at + moved));
                largest = (0..4).map(|c| (f64::from(pixel.0[c]) - expected[c]).abs()).fold(largest, f64::max);
                compared += 1;
            }
        }
        assert!(compared > 500, "{compared} pixels in the lattice");
        largest
    }

    #[test]
    fn quadratic_functions_are_warped_as_they_are() {
        let choice = std::env::var("LAYERSPLAT_DEVICE").map_or(DeviceChoice::Default, DeviceChoice::Named);
        let device = Device::open(&choice).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let grid = Grid::new([40, 50, 60], DVec3::ONE).unwrap();
        let viewport = Viewport::new(SIZE[0], SIZE[1]).unwrap();
        let mut seen = [0; 3];
        for (azimuth, elevation, roll) in
            [(30.0, 20.0, 0.0), (90.0, 60.0, 0.0), (200.0, 0.0, 0.0), (30.0, 20.0, 8.0), (30.0, 20.0, 90.0)]
        {
            for (density, pixels) in
                [(Density::Relaxed, 1.2), (Density::Relaxed, 4.1), (Density::Fixed(1), 2.7), (Density::Fixed(3), 1.1)]
            {
                let camera = Camera::orbit(
                    grid.centre(),
                    100.0,
                    Orbit { azimuth, elevation, roll },
                    Projection::Parallel { scale: f64::from(SIZE[1]) / 2.0 / pixels },
                );
                let rays = Rays::new(&camera, viewport, &grid).unwrap();
                let axis = Axis::most_parallel(rays.central_direction());
                let lattice = Lattice::new(&rays, viewport, &grid, axis, density, Sampling::Points(Kernel::Cubic)).unwrap();
                let what = format!("{azimuth} {elevation} {roll}, {density:?}, {pixels} pixels per voxel");
                let upright = Lines::new(&lattice, &rays, viewport).filter(|lines| lines.upright).map(|lines| lines.axis);
                seen[upright.map_or(0, |axis| axis + 1)] += 1;
                let right = difference(&device, &lattice, &rays, 0.0);
                assert!(right < ROUNDING, "{what}, upright {upright:?}: {right}");
                let shifted = difference(&device, &lattice, &rays, 0.05);
                assert!(shifted > ROUNDING, "{what}: a twentieth of a sample must be noticed, {shifted}");
            }
        }
        assert!(seen.iter().all(|&n| n >= 4), "no axis upright, u, v: {seen:?}");
    }
}
