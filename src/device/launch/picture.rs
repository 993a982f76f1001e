//! Kernels that produce the final picture.

use super::structs::{Float4, WarpParams};
use super::{Argument, Defines, Extras, Items, Parameter, kernel, large_grid};
use crate::device::{Buffer, Tuning};
use opencl3::kernel::Kernel as ClKernel;

/// Destination of the warp: a float frame or an 8-bit picture.
#[derive(Clone, Copy)]
pub(crate) enum Warped<'a> {
    Frame(&'a Buffer<Float4>),
    Displayed(&'a Buffer<[u8; 4]>),
}

impl Argument for Warped<'_> {
    fn set(&self, kernel: &ClKernel, index: u32) -> opencl3::Result<u32> {
        match self {
            Warped::Frame(frame) => frame.set(kernel, index),
            Warped::Displayed(picture) => picture.set(kernel, index),
        }
    }

    fn parameters(name: &str, _: Extras) -> Vec<Parameter> {
        Parameter::buffer(name, "uchar")
    }
}

kernel! {
    /// Warps a composited lattice to the screen.
    Warp = "picture/warp.cl", warp, "warp", Items::Tiles;
    // The flags: pictures of 8 bits have a curve; colours are in linear light.
    defines |tuning, (has_curve, is_linear): (bool, bool)| {
        let [columns, rows] = tuning.block;
        let defines = Defines::new(tuning.vector_width).with("BLOCK_COLUMNS", columns).with("BLOCK_ROWS", rows);
        defines.with_if(has_curve, "CURVE").with_if(is_linear, "LINEAR")
    };
    items |a, tuning| blocks(&a.p, tuning);
    arguments WarpArguments<'a> {
        lattice: &'a Buffer<Float4>,
        /// One per tile.
        active_samples: &'a Buffer<u32>,
        p: WarpParams,
        /// (r, g, b, 1), or zeros for a transparent picture. Unused for float frames.
        background: Float4,
        /// Numbers of a curve (`src/host/color.rs`).
        curve: Float4,
        /// The kind must match `p.displayed`.
        picture: Warped<'a>,
    }
}

fn blocks(p: &WarpParams, tuning: &Tuning) -> usize {
    let [columns, rows] = tuning.block;
    (p.frame[0] as u32).div_ceil(columns) as usize * (p.frame[1] as u32).div_ceil(rows) as usize
}

kernel! {
    /// Converts a float frame to an 8-bit picture.
    Present = "picture/present.cl", present, "present", Items::Pixels;
    defines |tuning, has_curve: bool| {
        let defines = Defines::new(tuning.vector_width);
        defines.with_if(has_curve, "CURVE")
    };
    items |a, _| large_grid(a.pixels as usize);
    arguments PresentArguments<'a> {
        frame: &'a Buffer<Float4>,
        /// See [`WarpArguments`].
        background: Float4,
        curve: Float4,
        pixels: i32,
        rgba: &'a Buffer<[u8; 4]>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Curve, Exposure, Tone};
    use crate::device::launch::Launcher;
    use crate::device::{Device, DeviceChoice};
    use crate::image::{Background, Frame};
    use crate::viewport::Viewport;

    /// Pixels per row; a single column would have too many rows.
    const COLUMNS: usize = 64;

    /// The device's 8-bit picture of `pixels`.
    fn presented(pixels: &[[f32; 4]], background: Background, curve: Curve) -> Vec<u8> {
        let choice = std::env::var("LAYERSPLAT_DEVICE").map_or(DeviceChoice::Default, DeviceChoice::Named);
        let device = Device::open(&choice).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        let values: Vec<Float4> = pixels.iter().copied().map(Float4).collect();
        let frame = Buffer::from_slice(&device, &values, "the frame").unwrap();
        let rgba = Buffer::new(&device, pixels.len(), "the picture").unwrap();
        let background = match background {
            Background::Color([r, g, b]) => Float4([r, g, b, 1.0]),
            Background::Transparent => Float4([0.0; 4]),
        };
        let (numbers, pixel_count) = (Float4(curve.numbers()), pixels.len() as i32);
        let arguments = PresentArguments { frame: &frame, background, curve: numbers, pixels: pixel_count, rgba: &rgba };
        Launcher::<Present>::default().launch(&device, curve != Curve::NONE, &arguments).unwrap();
        let mut picture = vec![[0u8; 4]; pixels.len()];
        rgba.read(&device, &mut picture).unwrap();
        picture.into_flattened()
    }

    /// Values that test rounding: the neighbourhood of each odd multiple of 1/510, and values that are not colours.
    fn critical_values() -> Vec<f32> {
        let halves = (-2..=512).flat_map(|n| {
            let half = n as f32 / 510.0;
            (-4..=4).map(move |ulps: i32| f32::from_bits(half.to_bits().wrapping_add_signed(ulps)))
        });
        let tenths = (-3..=14).map(|n| n as f32 / 10.0);
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::EPSILON];
        let small = [-0.0, f32::from_bits(1), 1e-38, 1e-39, 2f32.powi(-100), 2f32.powi(-101), 1e-20];
        halves.chain(tenths).chain(odd).chain(small).collect()
    }

    /// Each critical value as a colour, with several opacities, and as an opacity.
    fn critical_pixels() -> Vec<[f32; 4]> {
        let values = critical_values();
        let opacities = [1.0, 0.0, 0.3, 0.5, 0.75, 1.0 / 3.0, 1e-3, 1e-30, 2f32.powi(-100), 1e-38, 1e-40, -0.25, 1.5, f32::NAN];
        let next = |i: usize| values[(i * 7 + 3) % values.len()];
        let colors = opacities.iter().flat_map(|&a| values.iter().enumerate().map(move |(i, &c)| [c, next(i), c * a, a]));
        let alphas = values.iter().enumerate().map(|(i, &a)| [a, a * 0.3, next(i), a]);
        let mut pixels: Vec<_> = colors.chain(alphas).collect();
        pixels.resize(pixels.len().next_multiple_of(COLUMNS), [0.0; 4]);
        pixels
    }

    /// The values would detect rounding of halves to even.
    #[test]
    fn critical_values_distinguish_rounding_modes() {
        let even = |c: f32| (c * 255.0).round_ties_even() as u8;
        let up = |c: f32| c.mul_add(255.0, 0.5) as u8;
        assert!(critical_values().into_iter().filter(|&c| even(c) != up(c)).count() > 100);
    }

    #[test]
    fn bytes_equal_those_of_the_host() {
        let pixels = critical_pixels();
        let viewport = Viewport::new(COLUMNS as u32, (pixels.len() / COLUMNS) as u32).unwrap();
        let frame = Frame::new(viewport, pixels.clone());
        let backgrounds = [[0.0; 3], [1.0; 3], [0.5; 3], [0.1, 0.7, 0.31], [1.0 / 3.0, 0.3, 1e-3]].map(Background::Color);
        for background in backgrounds.into_iter().chain([Background::Transparent]) {
            let (device, host) = (presented(&pixels, background, Curve::NONE), frame.to_rgba8(background));
            for ((pixel, device), host) in pixels.iter().zip(device.as_chunks::<4>().0).zip(host.as_chunks::<4>().0) {
                assert_eq!(device, host, "{pixel:?} over {background:?}");
            }
        }
    }

    /// Powers of the device are not those of the host to the last bit.
    #[test]
    fn curves_are_those_of_the_host() {
        let levels = || (0..=16).map(|n| n as f32 / 16.0);
        let pixels: Vec<_> = levels().flat_map(|c| levels().map(move |a| [2.0 * c * a, 0.25 * a, (1.0 - c) * a, a])).collect();
        let viewport = Viewport::new(17, 17).unwrap();
        let linear = [Tone::None, Tone::Shoulder].map(|tone| Some(Exposure { stops: -0.5, tone }));
        for (linear, gamma) in [(None, 0.5), (None, 2.2), (linear[0], 1.0), (linear[1], 1.0), (linear[1], 1.4)] {
            let curve = Curve { linear, gamma };
            let frame = Frame::new(viewport, pixels.clone()).with_curve(curve);
            for background in [Background::Transparent, Background::Color([0.1, 0.7, 0.31])] {
                let (device, host) = (presented(&pixels, background, curve), frame.to_rgba8(background));
                let near = |(a, b): (&u8, &u8)| a.abs_diff(*b) <= 1;
                assert!(device.iter().zip(&host).all(near) && device != presented(&pixels, background, Curve::NONE), "{curve:?}");
            }
        }
        // The quarter of green of an opaque pixel.
        assert_eq!(presented(&[[0.0, 0.25, 0.0, 1.0]; COLUMNS], Background::BLACK, Curve { linear: None, gamma: 2.0 })[1], 128);
    }
}
