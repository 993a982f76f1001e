//! Frames: their steps, their resources, and the engine that runs them.

mod arena;
mod declaring;
mod engine;
mod resources;
mod running;
mod steps;

pub(super) use arena::Arena;
pub(super) use declaring::{DeclaredLight, Declaring, PartOfLight};
pub(super) use engine::{Engine, Frame, Mode};
pub(super) use resources::{Bytes, Resources, Slot};
pub(super) use steps::{Output, Stage, Step};
