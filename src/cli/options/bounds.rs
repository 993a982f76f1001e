//! Options that limit a frame.

use crate::cli::parse;
use clap::Args;
use std::time::Duration;

/// Limits of device memory and frame time.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub(in crate::cli) struct BoundOptions {
    /// Limit of device memory, e.g. 512M, 1.5G or 800MB; larger volumes are streamed (same picture) [default: all of it]
    #[arg(long, value_parser = parse::bytes, value_name = "BYTES", allow_hyphen_values = true)]
    pub memory: Option<u64>,
    /// Limit of device time per frame, checked between kernels; longer frames fail [default: none]
    #[arg(long, value_parser = parse::seconds, value_name = "SECONDS", allow_hyphen_values = true)]
    pub time_limit: Option<Duration>,
}
