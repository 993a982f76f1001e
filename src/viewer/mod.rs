//! The viewer: a server for a page in the user's browser, whose pictures are drawn on this machine's device (docs/viewer.md).
//!
//! [`Server`] answers requests on the calling thread. Each page has a session, with a thread that draws (`painter`) and an `inbox` between
//! both, which keeps the newest requests only. All pages share the voxels on the device (`scene`). The program that calls it is a [`Host`]:
//! it knows its options.

mod access;
mod assets;
mod encoding;
mod films;
mod inbox;
mod keeper;
mod look;
mod opening;
mod pace;
mod painter;
mod protocol;
mod rate;
mod saving;
mod scene;
mod server;
mod session;
mod sharpening;
mod warming;

pub use access::Access;
pub use look::{Look, PageBlend, PageKernel, PageLight, PageQuality};
pub use protocol::{PageCamera, PageProjection};
pub use scene::{Host, Offered, Opening, Source};

use crate::error::Error;
use server::Served;
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;

/// Time for drawing threads to end after the server has.
const LONGEST_END: Duration = Duration::from_secs(3);

/// Ends a server from another thread. Clones end the same one.
#[derive(Clone, Debug)]
pub struct Stop(watch::Sender<bool>);

impl Default for Stop {
    fn default() -> Self {
        Self(watch::Sender::new(false))
    }
}

impl Stop {
    /// Ends the server, now or as soon as it begins.
    pub fn stop(&self) {
        self.0.send_replace(true);
    }

    async fn stopped(&self) {
        // The sender is this one: it is not dropped before.
        let _ = self.0.subscribe().wait_for(|stopped| *stopped).await;
    }
}

/// A server that has a volume on the device and is ready to answer.
pub struct Server {
    runtime: Runtime,
    listener: TcpListener,
    served: Arc<Served>,
}

impl Server {
    /// Uploads the volume. `listener` is bound already, so that its address can be printed.
    ///
    /// # Errors
    /// Insufficient memory of the device, and failures of the system.
    pub fn new(opening: Opening, host: Box<dyn Host>, access: Access, listener: TcpListener) -> Result<Self, Error> {
        let failed = |e| Error::read(Path::new("the viewer's address"), e);
        let runtime = Builder::new_current_thread().enable_all().build().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        Ok(Self { runtime, listener, served: Arc::new(Served::new(access, opening, host)?) })
    }

    /// Answers requests until `stop`.
    ///
    /// # Errors
    /// Failures of the system.
    pub fn run(self, stop: &Stop) -> Result<(), Error> {
        let Self { runtime, listener, served } = self;
        let alive = served.alive.clone();
        let ended: std::io::Result<()> = runtime.block_on(async {
            server::run(tokio::net::TcpListener::from_std(listener)?, served.clone(), stop.stopped()).await;
            Ok(())
        });
        // Ends all sessions, which cancel the frames of their threads.
        drop((runtime, served));
        let since = Instant::now();
        while Arc::strong_count(&alive) > 1 && since.elapsed() < LONGEST_END {
            std::thread::sleep(Duration::from_millis(5));
        }
        ended.map_err(|e| Error::read(Path::new("the viewer's address"), e))
    }
}
