//! Kernels that finish a picture.

use super::structs::{Float4, WarpParams};
use super::{Defines, Items, Launch, kernel};
use crate::device::{Buffer, Tuning};

kernel! {
    /// Brings a composited lattice onto the screen, as a frame of floats.
    Warp = "picture/warp.cl", warp, "warp";
    WarpArguments<'a> {
        lattice: &'a Buffer<Float4>,
        /// `params.counts` per tile.
        active_samples: &'a Buffer<u32>,
        p: WarpParams,
        /// Of no use to floats.
        background: Float4,
        picture: &'a Buffer<Float4>,
    }
}

kernel! {
    /// The same as the 8-bit picture.
    WarpDisplayed = "picture/warp.cl", warp, "warp";
    WarpDisplayedArguments<'a> {
        lattice: &'a Buffer<Float4>,
        active_samples: &'a Buffer<u32>,
        p: WarpParams,
        /// Red, green, blue and 1, or four zeros for a transparent picture.
        background: Float4,
        picture: &'a Buffer<[u8; 4]>,
    }
}

fn warp_defines(tuning: &Tuning) -> Defines {
    let [columns, rows] = tuning.block;
    Defines::new(tuning.vector_width).with("BLOCK_COLUMNS", columns).with("BLOCK_ROWS", rows)
}

fn blocks(p: &WarpParams, tuning: &Tuning) -> usize {
    let [columns, rows] = tuning.block;
    (p.frame[0] as u32).div_ceil(columns) as usize * (p.frame[1] as u32).div_ceil(rows) as usize
}

impl Launch for Warp {
    type Variant = ();
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (): ()) -> String {
        warp_defines(tuning).0
    }

    fn items(a: &WarpArguments, tuning: &Tuning) -> usize {
        blocks(&a.p, tuning)
    }
}

impl Launch for WarpDisplayed {
    type Variant = ();
    const ITEMS: Items = Items::Tiles;

    fn defines(tuning: &Tuning, (): ()) -> String {
        warp_defines(tuning).with_if(true, "PRESENT").0
    }

    fn items(a: &WarpDisplayedArguments, tuning: &Tuning) -> usize {
        blocks(&a.p, tuning)
    }
}

kernel! {
    /// Makes the 8-bit picture of a frame.
    Present = "picture/present.cl", present, "present";
    PresentArguments<'a> {
        frame: &'a Buffer<Float4>,
        /// See [`WarpDisplayedArguments`].
        background: Float4,
        pixels: i32,
        rgba: &'a Buffer<[u8; 4]>,
    }
}

impl Launch for Present {
    type Variant = ();
    const ITEMS: Items = Items::Pixels;

    fn defines(tuning: &Tuning, (): ()) -> String {
        Defines::new(tuning.vector_width).0
    }

    fn items(a: &PresentArguments, _: &Tuning) -> usize {
        a.pixels as usize
    }
}
