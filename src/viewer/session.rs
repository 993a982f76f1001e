//! The session of a page: takes its requests as text, and answers by texts and pictures. How both travel is the caller's matter.

use super::inbox::{Inbox, Job, Saving};
use super::look::Look;
use super::painter::Painter;
use super::protocol::{MAX_MESSAGE, PageCamera, Picture, Reply, Request, saved_size, shown_size, transfer_function};
use super::scene::{First, Scene};
use super::warming;
use crate::device::Cancel;
use crate::error::Error;
use crate::transfer::{FileFormat, TransferFunction};
use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;

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
pub(super) struct Outgoing(Arc<dyn Fn(Message) + Send + Sync>);

impl Outgoing {
    pub fn picture(&self, picture: &Picture) {
        (self.0)(Message::Binary(picture.message()));
    }

    pub fn reply(&self, reply: &Reply) {
        (self.0)(text(reply));
    }
}

pub(super) fn text(reply: &Reply) -> Message {
    Message::Text(serde_json::to_string(reply).expect("replies are plain data"))
}

/// The session of a page. Dropping it ends the drawing thread after the kernel that is running.
pub struct Session {
    scene: Arc<Scene>,
    inbox: Arc<Inbox>,
    thread: Option<JoinHandle<()>>,
}

/// What a request was, and its answer if that is known at once.
#[derive(Debug)]
pub struct Received {
    /// What the user changed.
    pub change: Option<Change>,
    /// The answer; others come from the drawing thread.
    pub answer: Option<Message>,
}

/// What the user of a page changed.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "what changed")]
pub enum Change {
    Camera(PageCamera),
    Look(Look),
    Transfer(TransferFunction),
}

impl Session {
    /// Starts to draw for a page that was sent [`Scene::hello`] with the same `first`. `send` is called on the drawing thread, which waits
    /// until it returns.
    ///
    /// # Errors
    /// Insufficient memory of the device, and failures of the system.
    pub fn new(scene: Arc<Scene>, first: &First, send: impl Fn(Message) + Send + Sync + 'static) -> Result<Self, Error> {
        let cancel = Cancel::new();
        let inbox = Arc::new(Inbox::new(cancel.clone()));
        let mut painter = Painter::new(scene.clone(), inbox.clone(), Outgoing(Arc::new(send)), first, cancel)?;
        scene.ready.watch(&inbox);
        warming::begin(&scene, &mut painter);
        let thread = std::thread::Builder::new().name("painter".into()).spawn(move || painter.run());
        let thread = thread.map_err(|e| Error::read(Path::new("the viewer's drawing thread"), e))?;
        Ok(Self { scene, inbox, thread: Some(thread) })
    }

    /// Whether the drawing thread lives. It ends by a panic only.
    pub fn is_drawing(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Ends the drawing thread, and waits until it has ended.
    pub fn end(mut self) {
        self.inbox.close();
        if let Some(thread) = self.thread.take() {
            // A panic was reported by its hook.
            let _ = thread.join();
        }
    }

    /// Takes a message of the page. It does not wait: the newest request is stored for the drawing thread. `None` if the message is too
    /// long, or none of this version's.
    pub fn receive(&self, message: &str) -> Option<Received> {
        if message.len() > MAX_MESSAGE {
            return None;
        }
        let request: Request = serde_json::from_str(message).ok()?;
        let change = match &request {
            Request::View(view) => self.scene.camera(&view.camera).ok().map(|_| Change::Camera(view.camera)),
            Request::Look { look } => Some(Change::Look(look.clone())),
            Request::Transfer { colors, opacities } => {
                transfer_function(colors.clone(), opacities.clone()).ok().map(Change::Transfer)
            }
            _ => None,
        };
        Some(match self.handle(request) {
            Ok(answer) => Received { change, answer },
            Err(error) => {
                let sentence = self.scene.host.sentence(&error);
                Received { change: None, answer: Some(text(&Reply::Problem { sentence: &sentence })) }
            }
        })
    }

    /// Takes a request; returns the answer of requests that are answered at once.
    fn handle(&self, request: Request) -> Result<Option<Message>, Error> {
        let job = match request {
            Request::View(view) => {
                shown_size(view.width, view.height)?;
                self.inbox.post_view(view);
                return Ok(None);
            }
            Request::Slices(slices) => {
                slices.check()?;
                self.inbox.post_slices(slices);
                return Ok(None);
            }
            Request::Look { look } => {
                look.check()?;
                self.inbox.post_look(look);
                return Ok(None);
            }
            Request::Transfer { colors, opacities } => {
                self.inbox.post_transfer(transfer_function(colors, opacities)?);
                return Ok(None);
            }
            Request::Shown {} => {
                self.inbox.acknowledge();
                return Ok(None);
            }
            Request::Named { kind, name } => return Ok(Some(described(&self.scene.named(kind, &name)?))),
            Request::Read { name, text } => return Ok(Some(described(&TransferFunction::from_text(&text, &name)?))),
            Request::Write { name } => {
                let format = FileFormat::from_path(Path::new(&name))?;
                // The drawing thread has the transfer function.
                Job::Write { name, format }
            }
            Request::Fit { camera, width, height } => Job::Fit { camera, size: shown_size(width, height)? },
            Request::Save { camera, width, height, samples, format } => {
                Job::Save(Saving { camera, size: saved_size(width, height, samples)?, samples, format })
            }
            Request::Command { camera, width, height, samples, format } => {
                Job::Command(Saving { camera, size: saved_size(width, height, samples)?, samples, format })
            }
            Request::Pick(pick) => {
                pick.check()?;
                Job::Pick(pick)
            }
        };
        if self.inbox.post_job(job) {
            return Ok(None);
        }
        Err(Error::Settings { field: "page", problem: "too many requests wait: try again when they are done".into() })
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.inbox.close();
    }
}

fn described(transfer: &TransferFunction) -> Message {
    text(&Reply::Transfer { name: transfer.name(), colors: transfer.colors(), opacities: transfer.opacities() })
}
