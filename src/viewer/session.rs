//! A page's connection: what it asks for, what it gets, and the limits of both.

use super::inbox::{Inbox, Job};
use super::painter::Painter;
use super::protocol::{MAX_MESSAGE, Picture, Reply, Request, saved_size, shown_size, transfer_function};
use super::rate::Rate;
use super::scene::Scene;
use super::warming;
use crate::device::Cancel;
use crate::error::Error;
use crate::transfer::{FileFormat, TransferFunction};
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval, timeout};

/// Most pages at once.
const MOST_SESSIONS: usize = 8;
/// Messages that wait for the connection. More would only take memory.
const MOST_WAITING: usize = 4;
/// A page that takes no byte for this long is given up.
const LONGEST_SEND: Duration = Duration::from_secs(30);
/// Distance of the pings of a page at rest.
const PING: Duration = Duration::from_secs(15);
/// A page that says nothing for this long, not even to pings, is given up.
const LONGEST_SILENCE: Duration = Duration::from_secs(60);

/// The way from the drawing thread to the page.
#[derive(Clone)]
pub(super) struct Outgoing(mpsc::Sender<Message>);

impl Outgoing {
    /// Sends a picture; waits while too much is on its way. Does nothing if the page is gone.
    pub fn picture(&self, picture: &Picture) {
        let _ = self.0.blocking_send(Message::Binary(picture.message().into()));
    }

    /// Sends a reply; waits while too much is on its way. Does nothing if the page is gone.
    pub fn reply(&self, reply: &Reply) {
        let _ = self.0.blocking_send(text(reply));
    }
}

fn text(reply: &Reply) -> Message {
    Message::Text(serde_json::to_string(reply).expect("replies are plain data").into())
}

/// Serves a page until it closes.
pub(super) async fn serve(mut socket: WebSocket, scene: Arc<Scene>) {
    let Some(_place) = Place::take(&scene) else {
        let reason = "Too many pages are open. Close one of them and reload this page.";
        close(&mut socket, close_code::AGAIN, reason).await;
        return;
    };
    let hello = Message::Text(scene.hello().to_string().into());
    if !send(&mut socket, hello).await {
        return;
    }
    let cancel = Cancel::new();
    let inbox = Arc::new(Inbox::new(cancel.clone()));
    let (sender, mut outgoing) = mpsc::channel(MOST_WAITING);
    let painter = Painter::new(scene.clone(), inbox.clone(), Outgoing(sender.clone()), cancel);
    drop(sender);
    let mut painter = match painter {
        Ok(painter) => painter,
        Err(error) => {
            send(&mut socket, text(&Reply::Problem { sentence: &scene.host.sentence(&error) })).await;
            return;
        }
    };
    warming::begin(&scene, &mut painter);
    let thread = std::thread::Builder::new().name("painter".into()).spawn(move || painter.run());
    let mut session = Session { scene, inbox, rate: Rate::new(Instant::now()) };
    if thread.is_ok() {
        session.run(&mut socket, &mut outgoing).await;
    }
}

impl Drop for Session {
    /// Ends the drawing thread, also where the server ends in the middle of a session.
    fn drop(&mut self) {
        self.inbox.close();
    }
}

/// A place among the sessions.
struct Place(Arc<Scene>);

impl Place {
    fn take(scene: &Arc<Scene>) -> Option<Self> {
        let place = Self(scene.clone());
        // Dropping the place frees it again.
        (scene.sessions.fetch_add(1, Ordering::SeqCst) < MOST_SESSIONS).then_some(place)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.sessions.fetch_sub(1, Ordering::SeqCst);
    }
}

struct Session {
    scene: Arc<Scene>,
    inbox: Arc<Inbox>,
    rate: Rate,
}

impl Session {
    async fn run(&mut self, socket: &mut WebSocket, outgoing: &mut mpsc::Receiver<Message>) {
        let mut ready = self.scene.ready.subscribe();
        let is_ready = *ready.borrow_and_update();
        if !send(socket, text(&Reply::Ready { ready: is_ready })).await {
            return;
        }
        let mut pings = interval(PING);
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut heard = Instant::now();
        loop {
            let answer = tokio::select! {
                received = socket.recv() => {
                    let Some(Ok(message)) = received else { return };
                    heard = Instant::now();
                    match self.receive(&message, heard) {
                        Received::Nothing => continue,
                        Received::Answer(answer) => answer,
                        Received::Close(code, reason) => return close(socket, code, reason).await,
                    }
                }
                picture = outgoing.recv() => match picture {
                    Some(message) => message,
                    None => return,
                },
                Ok(()) = ready.changed() => text(&Reply::Ready { ready: *ready.borrow_and_update() }),
                _ = pings.tick() => {
                    if heard.elapsed() > LONGEST_SILENCE {
                        return;
                    }
                    Message::Ping(Vec::new().into())
                }
            };
            if !send(socket, answer).await {
                return;
            }
        }
    }

    fn receive(&mut self, message: &Message, now: Instant) -> Received {
        let request = match message {
            Message::Text(text) => text.as_str(),
            Message::Binary(_) => return Received::Close(close_code::UNSUPPORTED, "Pages send text."),
            Message::Close(_) => return Received::Close(close_code::NORMAL, ""),
            Message::Ping(_) | Message::Pong(_) => "",
        };
        if !self.rate.allows(now, request.len()) {
            return Received::Close(close_code::POLICY, "The page sends too much.");
        }
        if request.is_empty() {
            return Received::Nothing;
        }
        debug_assert!(request.len() <= MAX_MESSAGE);
        match serde_json::from_str(request) {
            Ok(request) => self.handle(request).map_or_else(
                |error| Received::Answer(text(&Reply::Problem { sentence: &self.scene.host.sentence(&error) })),
                |answer| answer.map_or(Received::Nothing, Received::Answer),
            ),
            Err(_) => Received::Close(close_code::INVALID, "This page belongs to another version of layersplat. Reload it."),
        }
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
            Request::Save { camera, width, height, samples } => {
                Job::Save { camera, size: saved_size(width, height, samples)?, samples }
            }
            Request::Command { camera, width, height, samples } => {
                Job::Command { camera, size: saved_size(width, height, samples)?, samples }
            }
        };
        if self.inbox.post_job(job) {
            return Ok(None);
        }
        Err(Error::Settings { field: "page", problem: "too many requests wait: try again when they are done".into() })
    }
}

/// What a message of the page leads to.
enum Received {
    Nothing,
    Answer(Message),
    Close(u16, &'static str),
}

fn described(transfer: &TransferFunction) -> Message {
    text(&Reply::Transfer { name: transfer.name(), colors: transfer.colors(), opacities: transfer.opacities() })
}

/// Sends a message; false if the page is gone or takes nothing.
async fn send(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(LONGEST_SEND, socket.send(message)).await, Ok(Ok(())))
}

async fn close(socket: &mut WebSocket, code: u16, reason: &'static str) {
    let _ = timeout(LONGEST_SEND, socket.send(Message::Close(Some(CloseFrame { code, reason: reason.into() })))).await;
}
