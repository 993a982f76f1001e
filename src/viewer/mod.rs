//! The viewer: a page in the user's browser or in a notebook, whose pictures are drawn on this machine's device (docs/dev/viewer.md).
//!
//! Each page has a [`Session`], with a thread that draws (`painter`) and an `inbox` between both, which keeps the newest requests only. All
//! pages share the voxels on the device ([`SharedScene`]). The program that shows the page is a [`Host`]: it knows its options. It also carries the
//! messages: the feature `viewer` has a `Server` for browsers, and the Python package has the channel of a notebook.

#[cfg(feature = "viewer")]
mod access;
mod annotated;
#[cfg(feature = "viewer")]
mod assets;
mod checks;
mod drawn;
#[cfg(feature = "viewer")]
mod drops;
mod encoding;
mod films;
mod first;
mod hello;
mod host;
mod inbox;
mod jobs;
mod keeper;
mod look;
mod look_fields;
#[cfg(feature = "viewer")]
mod opening;
mod outgoing;
mod overlay;
mod pace;
mod page_camera;
mod page_light;
mod page_renderer;
mod painter;
#[cfg(feature = "viewer")]
mod places;
#[cfg(feature = "viewer")]
mod rate;
mod readiness;
mod reading;
mod replies;
mod requests;
mod saving;
mod scene;
#[cfg(feature = "viewer")]
mod served;
#[cfg(feature = "viewer")]
mod server;
mod session;
mod sharpening;
mod slices;
#[cfg(feature = "viewer")]
mod socket;
mod survey;
mod time;
mod turns;
mod warming;

pub use crate::shown::{IndexedLabels, Shown};
#[cfg(feature = "viewer")]
pub use access::Access;
#[doc(hidden)]
pub use checks::check_message;
pub use drawn::{Drawn, PageField};
pub use first::{First, Opening, Time};
pub use host::{FilmWanted, Host, Offered, RawLayout, Source, Wanted};
pub use look::Look;
pub use look_fields::{PageChannel, PageLabels};
#[cfg(feature = "viewer")]
#[doc(hidden)]
pub use opening::reorders;
pub use outgoing::Message;
pub use overlay::Overlay;
pub use page_camera::{PageCamera, PageProjection};
pub use page_light::{PageLight, PageStudio};
pub use requests::{OpenWanted, SavedFormat};
pub use scene::SharedScene;
#[cfg(feature = "viewer")]
pub use server::{Server, Stop};
pub use session::{Change, Received, Session};
