//! A frame: what it does step by step, what it needs, and the one place where it runs.

mod arena;
mod declaring;
mod engine;
mod resources;
mod steps;

pub(super) use arena::Arena;
pub(super) use declaring::Declaring;
pub(super) use engine::{Engine, Frame, Mode};
pub(super) use resources::{Bytes, Resources, Slot};
pub(super) use steps::{Output, Stage, Step};
