//! Surfaces, met by rays: triangles, spheres and tubes as they are defined, without tessellation.
//!
//! Each crossing of a ray with a set is a [`Fragment`]: its depth is the ray parameter, in front of the start of the ray, and its colour and
//! opacity are straight. Fragments follow each other front to back; those of one depth by the index of their set, then by the bits of their
//! colour and opacity. Fragments without opacity are left out.
//!
//! - **Triangles** that a ray sees edge-on, and those without area, show nothing. Of the triangles at an edge, a ray meets exactly one, or at
//!   a silhouette both or none: where it meets the edge, it counts as moved along x by less than any number, else along y, else along z.
//! - **Spheres** are met at the entry and at the exit; from inside only at the exit.
//! - **Tubes** show the surface of solids together: a piece is a truncated cone between the planes through its two points, and a joint, at
//!   an inner point, is the part of a ball that is beyond the planes of both pieces. Of the side and of the discs of a piece, what is inside
//!   the piece before or behind it, or next to a joint, is not drawn; joints are outside of both. A line ends with a disc, nothing, or the
//!   half of a sphere beyond the plane. Points at the place of the one before are left out; a line of a single point shows nothing.
//! - **Colours** of points are interpolated over the triangle or along the piece, straight and with alpha, then values, whose colour is looked up
//!   afterwards; a value that is not finite has the colour of the set. The opacity is that of the set times the alpha of the colour.
//! - **Light** is that of samples with a certain normal (no fade where gradients are weak, no gradient opacity), on both sides. Shadows and
//!   occlusion reach fragments between the outermost voxels; all light reaches others. Depth cueing is that of samples.
//! - **Clipping** by the crop box and the planes cuts sets that are clipped. Regions of blend modes and kernels do not.
//!
//! A fragment cuts the volume: what is in front of its depth is composited before it, and the rest after it. At a cut within a segment, the value
//! is that of the segment's own interpolant, so no further voxel is read. The iso-surface is an opaque fragment; where values are reduced,
//! the fragments, up to the first opaque one, are composited over the result.

mod elements;
mod tree;

use super::compositing::Gathered;
use super::depth_cue::{Fade, faded};
use super::interval::{Part, Region};
use super::shading::Lighting;
use super::shadow_rays::{Reached, ShadowRays};
use crate::layers::Ray;
use crate::settings::{Clipping, Shading};
use crate::surface::{Per, Surface, SurfaceShading};
use crate::volume::Volume;
use elements::{Elements, Hit};
use glam::DVec3;
use tree::Tree;

/// A crossing of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fragment {
    /// Ray parameter.
    pub t: f64,
    /// Lit, not multiplied by the opacity.
    pub color: [f64; 3],
    pub opacity: f64,
}

/// Surfaces around a volume. Lengths are those of the world, in the axes of the volume's grid, from its first voxel.
pub(super) struct Surfaces<'a> {
    sets: &'a [Surface],
    volume: &'a Volume<'a>,
    elements: Elements,
    tree: Tree,
}

/// How a ray sees fragments.
pub(super) struct Look<'a> {
    pub clipping: &'a Clipping,
    pub shading: Option<Shading>,
    pub shadow_rays: Option<&'a ShadowRays<'a>>,
    pub fade: Option<Fade>,
    /// The reversed direction of the central ray, in grid axes.
    pub to_eye: DVec3,
}

impl<'a> Surfaces<'a> {
    pub fn new(sets: &'a [Surface], volume: &'a Volume<'a>) -> Self {
        let elements = Elements::new(sets, volume.grid());
        let tree = Tree::new(elements.bounds());
        Self { sets, volume, elements, tree }
    }

    /// What a ray, in voxels, meets, front to back.
    pub fn fragments(&self, ray: &Ray, look: &Look) -> Vec<Fragment> {
        let spacing = self.volume.grid().spacing();
        let scaled = Ray { origin: ray.origin * spacing, direction: ray.direction * spacing, ..*ray };
        let mut hits = Vec::new();
        self.tree.visit(&scaled, |n| self.elements.meet(n, &scaled, &mut hits));
        hits.retain(|hit| hit.t > ray.start && hit.t.is_finite());
        if hits.is_empty() {
            return Vec::new();
        }
        let region = Region::from_clipping(self.volume, look.clipping);
        let fragment = |hit: &Hit| {
            let set = &self.sets[hit.set as usize];
            let place = ray.origin + ray.direction * hit.t;
            if set.is_clipped && !region.contains(place) {
                return None;
            }
            let ([red, green, blue], opacity) = appearance(set, hit);
            let lit = match look.shading {
                Some(shading) if set.shading != SurfaceShading::Off => {
                    let reached = look.shadow_rays.filter(|_| self.is_between_voxels(place));
                    let reached = reached.map_or(Reached::ALL, |rays| rays.reached(place));
                    Lighting::of_surface(self.volume, shading, reached, hit.normal, look.to_eye).on([red, green, blue])
                }
                _ => [red, green, blue],
            };
            let fragment = Fragment { t: hit.t, color: faded(look.fade, place, lit), opacity };
            (opacity > 0.0).then_some((hit.set, fragment))
        };
        let mut fragments: Vec<_> = hits.iter().filter_map(fragment).collect();
        let bits = |f: &Fragment| [f.color[0], f.color[1], f.color[2], f.opacity].map(f64::to_bits);
        fragments
            .sort_by(|(set, a), (other, b)| a.t.total_cmp(&b.t).then_with(|| set.cmp(other)).then_with(|| bits(a).cmp(&bits(b))));
        fragments.into_iter().map(|(_, fragment)| fragment).collect()
    }

    fn is_between_voxels(&self, place: DVec3) -> bool {
        let last = DVec3::from_array(self.volume.grid().dims().map(|n| n as f64 - 1.0));
        place.cmpge(DVec3::ZERO).all() && place.cmple(last).all()
    }
}

/// Colour before lighting, and opacity.
fn appearance(set: &Surface, hit: &Hit) -> ([f64; 3], f64) {
    let (own, opacity) = (set.color.map(f64::from), f64::from(set.opacity).clamp(0.0, 1.0));
    if let Some(colors) = set.colors() {
        let [red, green, blue, alpha] = interpolated(colors, hit, |color| color.map(f64::from));
        return ([red, green, blue], opacity * alpha);
    }
    let color = set.values().map_or(own, |(values, transfer)| {
        let [value] = interpolated(values, hit, |value| [f64::from(value)]);
        if value.is_finite() { transfer.color(value) } else { own }
    });
    (color, opacity)
}

/// Numbers of the points or of the cell at a hit.
fn interpolated<T: Copy, const N: usize>(entries: &Per<T>, hit: &Hit, numbers: impl Fn(T) -> [f64; N]) -> [f64; N] {
    match entries {
        Per::Cell(entries) => numbers(entries[hit.cell as usize]),
        Per::Point(entries) => hit.weights.iter().filter(|(_, weight)| *weight != 0.0).fold([0.0; N], |sum, &(point, weight)| {
            let own = numbers(entries[point as usize]);
            std::array::from_fn(|i| sum[i] + weight * own[i])
        }),
    }
}

/// The fragments of a ray that are not composited yet.
pub(super) struct Cuts<'f>(pub &'f [Fragment]);

impl Cuts<'_> {
    /// Composites the fragments in front of the end of a part of a segment, and, by `volume`, the parts that they cut it into. The segment is
    /// given by its ray parameters.
    pub fn split(
        &mut self,
        [front, back]: [f64; 2],
        mut part: Part,
        gathered: &mut Gathered,
        mut volume: impl FnMut(Part, &mut Gathered),
    ) {
        while let Some((fragment, behind)) = self.0.split_first() {
            let cut = (fragment.t - front) / (back - front);
            if cut >= part.to {
                break;
            }
            if cut > part.from {
                volume(Part { to: cut, ..part }, gathered);
                part.from = cut;
            }
            gathered.add(fragment.color, fragment.opacity);
            self.0 = behind;
        }
        volume(part, gathered);
    }

    /// Composites all other fragments.
    pub fn finish(self, gathered: &mut Gathered) {
        self.0.iter().for_each(|fragment| gathered.add(fragment.color, fragment.opacity));
    }
}

/// Composites the fragments in front of a depth over a premultiplied colour.
pub(super) fn over(fragments: &[Fragment], depth: f64, [red, green, blue, alpha]: [f64; 4]) -> [f64; 4] {
    let mut gathered = Gathered::new();
    Cuts(&fragments[..fragments.partition_point(|fragment| fragment.t < depth)]).finish(&mut gathered);
    let [r, g, b, a] = gathered.rgba();
    let left = gathered.transmittance;
    [r + left * red, g + left * green, b + left * blue, a + left * alpha]
}

#[cfg(test)]
mod tests;
