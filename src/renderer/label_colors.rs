//! Colours of labels over a scan: the scan's opacity, the labels' colours.

use super::colors::check_labels;
use crate::device::launch::Tint;
use crate::device::launch::structs::TintParams;
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::AxisFrame;
use crate::memory;
use crate::volume::{Description, Grid, Labels, Volume, grid_over};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Largest number of voxels: kernels count bytes in 32 bits, and a voxel has up to two.
const MOST_VOXELS: usize = 1 << 30;
/// Largest number of different colours.
const MOST_COLORS: usize = 1 << 16;
/// Bytes behind the last voxel that are read with it, as a word.
const READ_BEHIND: usize = 3;
/// Voxels per unit of parallel work.
const BLOCK: usize = 1 << 16;
/// Distance in voxels below which corners of two grids are one: files round placements.
const SAME: f64 = 0.1;

/// Colours of labels on a device, which a scan is drawn in: [`Renderer::set_label_colors`](super::Renderer::set_label_colors). One or
/// two bytes per voxel of the labels, on a grid of their own.
///
/// The colour of a scan C becomes (1 − w) C + w L where labels have the colour L and the opacity w, before lighting; its opacity stays. Voxels
/// without a label and hidden labels have w = 0. Both are interpolated linearly between the voxels of the labels, weighted by w. Labels end one
/// voxel beyond their grid, unless that is the scan's: then they colour all that shows of it.
#[derive(Clone)]
pub struct LabelColors {
    pub(super) device: Device,
    name: String,
    grid: Grid,
    /// Whether their file states a placement.
    is_placed: bool,
    voxels: Arc<Buffer<u8>>,
    colors: Arc<Buffer<u8>>,
    /// Bytes of a voxel.
    bytes: usize,
}

impl LabelColors {
    /// Uploads the colours of labels, in layers that may overlap, on one grid: of each layer, voxel n has entry n, a colour and an opacity.
    /// Where layers overlap, their weights add, at most to 1.
    ///
    /// # Errors
    /// Without layers, for other grids, for voxels that are not unsigned integers or have no entry, for colours and opacities that are not 0
    /// to 1, for more than 2^30 voxels or 2^16 different colours, and for too little memory.
    pub fn new(device: &Device, layers: &[(&Volume, &[[f64; 4]])]) -> Result<Self, Error> {
        let Some((first, _)) = layers.first() else {
            return Err(Error::Settings { field: "labels", problem: "there are no layers: give at least one".into() });
        };
        let (name, grid) = (first.name(), first.grid());
        layers.iter().try_for_each(|(labels, entries)| check_labels(labels.description(), entries, grid))?;
        let count = grid.voxel_count();
        if count > MOST_VOXELS {
            let problem =
                format!("it has {count} voxels, and at most {MOST_VOXELS} can colour a scan: crop it or make it coarser");
            return Err(Error::volume(Path::new(name), problem));
        }
        let layers: Vec<Layer> = layers.iter().map(|(labels, entries)| Layer::new(labels, entries)).collect();
        let colors = colors_of(&layers, count);
        if colors.len() > MOST_COLORS {
            let problem =
                format!("its labels have {} different colours, and at most {MOST_COLORS} are drawn: hide some", colors.len());
            return Err(Error::volume(Path::new(name), problem));
        }
        let bytes = if colors.len() <= 1 << 8 { 1 } else { 2 };
        let mut voxels: Vec<u8> = memory::zeroed(name, bytes * count + READ_BEHIND)?;
        voxels[..bytes * count].par_chunks_mut(bytes * BLOCK).enumerate().for_each(|(block, voxels)| {
            let (first, count) = (block * BLOCK, voxels.len() / bytes);
            let mut last = (0, 0);
            for_each_color(&layers, first..first + count, |n, color| {
                if color != last.0 {
                    last = (color, colors.binary_search(&color).expect("one of all colours"));
                }
                voxels[bytes * n..bytes * (n + 1)].copy_from_slice(&last.1.to_le_bytes()[..bytes]);
            });
        });
        let buffer = |bytes: &[u8]| Ok::<_, Error>(Arc::new(Buffer::from_slice(device, bytes, "the colours of labels")?));
        Ok(Self {
            device: device.clone(),
            name: name.into(),
            grid: grid.clone(),
            is_placed: first.contents().states_spacing,
            voxels: buffer(&voxels)?,
            colors: buffer(bytemuck::cast_slice(&colors))?,
            bytes,
        })
    }

    /// Uploads the colours of the labels of a file.
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`LabelLayer::indices`](crate::volume::LabelLayer::indices).
    pub fn from_labels(device: &Device, labels: &Labels) -> Result<Self, Error> {
        let indices = labels.layers().iter().map(|layer| layer.indices(None)).collect::<Result<Vec<_>, _>>()?;
        let palettes: Vec<_> = labels.layers().iter().map(|layer| layer.palette()).collect();
        let layers: Vec<_> = indices.iter().zip(palettes.iter().map(Vec::as_slice)).collect();
        Self::new(device, &layers)
    }

    /// The grid of the labels over a scan. Labels whose file states no placement, as NumPy arrays, have that of a scan of their size.
    ///
    /// # Errors
    /// If no voxel of the labels lies in the scan's box, and for labels of another size without a placement.
    pub(super) fn grid_over(&self, scan: &Description) -> Result<Grid, Error> {
        grid_over(&self.name, (&self.grid, self.is_placed), scan)
    }

    /// Kernel arguments for points of a scan, along the axes of `frame`.
    ///
    /// # Errors
    /// As [`grid_over`](Self::grid_over).
    pub(super) fn tint(&self, scan: &Description, frame: AxisFrame) -> Result<Tint<'_>, Error> {
        let grid = self.grid_over(scan)?;
        let moved: DAffine3 = grid.index_to_world().inverse() * scan.grid().index_to_world();
        let stays = |corner: DVec3| moved.transform_point3(corner).distance(corner) < SAME;
        let is_same = grid.dims() == scan.grid().dims() && grid.corner_voxels().into_iter().all(stays);
        let beyond = if is_same { f32::MAX } else { 1.0 };
        let columns = [frame.u, frame.v, frame.a].map(|axis| moved.matrix3.col(axis));
        let row = |n: usize| [columns[0][n], columns[1][n], columns[2][n], moved.translation[n]].map(|c| c as f32);
        let tint_params = TintParams {
            to_voxels: [row(0), row(1), row(2)],
            dims: grid.dims().map(|n| n as i32),
            beyond,
            bytes: self.bytes as i32,
        };
        Ok(Tint { label_voxels: &self.voxels, label_colors: &self.colors, tint_params })
    }
}

/// A layer of labels.
struct Layer<'a> {
    labels: &'a Volume<'a>,
    /// Red, green and blue times their weight, and the weight, 0 to 1, per label.
    entries: Vec<[f64; 4]>,
}

impl<'a> Layer<'a> {
    fn new(labels: &'a Volume<'a>, entries: &[[f64; 4]]) -> Self {
        let weighted = |&[r, g, b, weight]: &[f64; 4]| [weight * r, weight * g, weight * b, weight];
        Self { labels, entries: entries.iter().map(weighted).collect() }
    }

    /// Positions of the entries of some voxels.
    fn entries_at(&self, voxels: Range<usize>) -> Vec<u16> {
        let rescale = self.labels.description().rescale();
        self.labels.look(|value| voxels.map(|voxel| rescale.stored(value(voxel)) as u16).collect())
    }
}

/// Passes on the weighted colour and the weight of each voxel, as bytes of a word, red the lowest.
fn for_each_color(layers: &[Layer], voxels: Range<usize>, mut take: impl FnMut(usize, u32)) {
    let count = voxels.len();
    let entries: Vec<Vec<u16>> = layers.iter().map(|layer| layer.entries_at(voxels.clone())).collect();
    let mut color = 0;
    for n in 0..count {
        // Neighbours mostly have the same labels.
        if n == 0 || entries.iter().any(|own| own[n] != own[n - 1]) {
            let mut sum = [0.0f64; 4];
            for (layer, own) in layers.iter().zip(&entries) {
                (0..4).zip(layer.entries[usize::from(own[n])]).for_each(|(c, own)| sum[c] += own);
            }
            color = u32::from_le_bytes(sum.map(|c| (255.0 * c / sum[3].max(1.0)).round() as u8));
        }
        take(n, color);
    }
}

/// All colours of `count` voxels, ascending from that of no label, which is 0.
fn colors_of(layers: &[Layer], count: usize) -> Vec<u32> {
    let of_block = |block: usize| {
        let (mut found, mut last) = (BTreeSet::new(), 0);
        for_each_color(layers, block * BLOCK..((block + 1) * BLOCK).min(count), |_, color| {
            if color != last {
                found.insert(color);
                last = color;
            }
        });
        found
    };
    let merged = |mut one: BTreeSet<u32>, other: BTreeSet<u32>| {
        one.extend(other);
        one
    };
    let none = || BTreeSet::from([0]);
    (0..count.div_ceil(BLOCK)).into_par_iter().map(of_block).reduce(none, merged).into_iter().collect()
}
