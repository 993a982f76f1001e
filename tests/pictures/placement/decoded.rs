//! Independent readers of pictures.

use layersplat::Frame;
use std::path::Path;

/// Rows of premultiplied RGBA, top row first.
pub struct Picture {
    /// Columns and rows.
    pub size: [u32; 2],
    pixels: Vec<[f64; 4]>,
}

impl Picture {
    pub fn of(frame: &Frame) -> Self {
        Self { size: [frame.width(), frame.height()], pixels: frame.pixels().iter().map(|p| p.map(f64::from)).collect() }
    }

    /// From 8-bit pixels with straight alpha.
    pub fn bytes(size: [u32; 2], bytes: &[u8]) -> Self {
        let straight = bytes.as_chunks::<4>().0.iter().map(|p| p.map(|byte| f64::from(byte) / 255.0));
        Self { size, pixels: straight.map(|[r, g, b, a]| [r * a, g * a, b * a, a]).collect() }
    }

    /// From a PNG file, by an independent decoder.
    pub fn png(path: &Path) -> Self {
        let picture = image::open(path).unwrap().into_rgba8();
        Self::bytes([picture.width(), picture.height()], picture.as_raw())
    }

    /// From an NPY file: 10 bytes, the last two of which are the length of a text header, then numbers.
    pub fn npy(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = str::from_utf8(&bytes[10..end]).unwrap().replace(' ', "");
        assert!(header.contains("'descr':'<f4'") && header.contains("'fortran_order':False"), "{header}");
        let (_, shape) = header.split_once("'shape':(").unwrap();
        let shape: Vec<u32> = shape.split(')').next().unwrap().split_terminator(',').map(|n| n.parse().unwrap()).collect();
        let [height, width, 4] = shape[..] else { panic!("{shape:?}") };
        let numbers: Vec<f64> = bytes[end..].as_chunks().0.iter().map(|&n| f64::from(f32::from_le_bytes(n))).collect();
        assert_eq!(numbers.len(), 4 * width as usize * height as usize);
        Self { size: [width, height], pixels: numbers.as_chunks().0.to_vec() }
    }

    /// Column, row and opacity of each pixel; pixel centres are half-integers.
    fn opacities(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        let width = self.size[0] as usize;
        self.pixels.iter().enumerate().map(move |(n, p)| ([(n % width) as f64 + 0.5, (n / width) as f64 + 0.5], p[3]))
    }

    /// Opacity-weighted mean position.
    pub fn middle(&self) -> [f64; 2] {
        let sums = self.opacities().fold([0.0; 3], |s, ([x, y], a)| [s[0] + x * a, s[1] + y * a, s[2] + a]);
        [sums[0] / sums[2], sums[1] / sums[2]]
    }

    /// Largest opacity.
    pub fn most(&self) -> f64 {
        self.brightest()[3]
    }

    /// Pixel of the largest opacity.
    pub fn brightest(&self) -> [f64; 4] {
        self.pixels.iter().copied().fold([0.0; 4], |most, p| if p[3] > most[3] { p } else { most })
    }

    /// First and last column and row above an opacity, counted from 0.
    pub fn extent(&self, opacity: f64) -> [[f64; 2]; 2] {
        let nothing = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let visible = self.opacities().filter(|&(_, a)| a > opacity);
        visible.fold(nothing, |seen, (at, _)| std::array::from_fn(|i| [seen[i][0].min(at[i] - 0.5), seen[i][1].max(at[i] - 0.5)]))
    }
}
