//! A tree of boxes, which finds the elements near a ray.

use super::super::interval::Interval;
use crate::layers::Ray;
use crate::surface::Bounds;
use glam::DVec3;

/// Elements of a leaf.
const LEAF: usize = 4;
/// By how much boxes are larger than what they contain, relative to coordinates: more than the rounding of a crossing.
const MARGIN: f64 = 1e-9;

/// Boxes of boxes, split in the middle of the elements along their longest side.
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Elements, in the order of leaves.
    order: Vec<u32>,
}

struct Node {
    bounds: Bounds,
    /// Elements of a leaf.
    elements: std::ops::Range<usize>,
    /// The second half; the first one is the next node. 0 in leaves.
    second: usize,
}

impl Tree {
    /// A tree of elements with these bounds.
    pub fn new(bounds: Vec<Bounds>) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..bounds.len() as u32).collect() };
        if !bounds.is_empty() {
            tree.add(&bounds, 0..bounds.len());
        }
        tree
    }

    fn add(&mut self, bounds: &[Bounds], elements: std::ops::Range<usize>) {
        let of = |n: &u32| bounds[*n as usize];
        let own = &mut self.order[elements.clone()];
        let around = own.iter().map(of).reduce(Bounds::and).expect("no node is empty");
        let margin = DVec3::splat(MARGIN * (around.lowest.abs().max_element() + around.highest.abs().max_element()));
        let around = Bounds { lowest: around.lowest - margin, highest: around.highest + margin };
        let node = self.nodes.len();
        self.nodes.push(Node { bounds: around, elements: elements.clone(), second: 0 });
        if elements.len() <= LEAF {
            return;
        }
        let axis = (around.highest - around.lowest).max_position();
        let place = |n: &u32| of(n).lowest[axis] + of(n).highest[axis];
        let middle = elements.len() / 2;
        own.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)));
        self.add(bounds, elements.start..elements.start + middle);
        self.nodes[node].second = self.nodes.len();
        self.add(bounds, elements.start + middle..elements.end);
    }

    /// Calls `element` with every element whose box a ray meets, and some others.
    pub fn visit(&self, ray: &Ray, mut element: impl FnMut(usize)) {
        let mut open = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(n) = open.pop() {
            let node = &self.nodes[n];
            if Interval::in_box(ray, node.bounds.lowest, node.bounds.highest).is_none() {
                continue;
            }
            if node.second == 0 {
                self.order[node.elements.clone()].iter().for_each(|&n| element(n as usize));
            } else {
                open.extend([n + 1, node.second]);
            }
        }
    }
}
