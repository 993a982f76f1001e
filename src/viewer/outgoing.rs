//! What a session sends to its page.

use super::replies::{Picture, Reply};
use super::scene::SharedScene;
use crate::error::Error;
use std::sync::Arc;

/// A message to a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// JSON.
    Text(String),
    /// A picture after its header.
    Binary(Vec<u8>),
}

/// The way from the drawing thread to the page.
#[derive(Clone)]
pub(super) struct Outgoing(pub Arc<dyn Fn(Message) + Send + Sync>);

impl Outgoing {
    pub fn picture(&self, picture: &Picture) {
        (self.0)(Message::Binary(picture.message()));
    }

    /// Sends the sentence of an error.
    pub fn problem(&self, scene: &SharedScene, error: &Error) {
        self.tell(scene, error, false);
    }

    /// Sends the sentence of an error for which a change was refused.
    pub fn refuse(&self, scene: &SharedScene, error: &Error) {
        self.tell(scene, error, true);
    }

    fn tell(&self, scene: &SharedScene, error: &Error, undo: bool) {
        tracing::info!("reported to a page: {error}");
        self.reply(&Reply::Problem { sentence: &scene.host.sentence(error), undo });
    }

    pub fn reply(&self, reply: &Reply) {
        (self.0)(text(reply));
    }
}

pub(super) fn text(reply: &Reply) -> Message {
    Message::Text(serde_json::to_string(reply).expect("replies are plain data"))
}
