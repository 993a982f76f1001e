//! The command, as its users run it.

mod channels;
mod circles;
#[path = "../common/mod.rs"]
mod common;
mod device_checks;
mod environment;
mod guide;
mod options;
mod orientation;
mod output;
mod package;
mod paper;
mod pictures;
mod sequences;
mod settings;
mod slices;
mod streams;
mod surfaces;
mod transfer;
mod urls;
mod volumes;
