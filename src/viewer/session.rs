//! A page's connection: what it asks for, what it gets, and the limits of both.

use super::inbox::{Inbox, Job};
use super::keeper::{Keeper, Maker};
use super::opening::{self, Wanted};
use super::painter::Painter;
use super::protocol::{MAX_MESSAGE, Picture, Reply, Request, saved_size, shown_size, transfer_function};
use super::rate::Rate;
use super::scene::Scene;
use super::server::Served;
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

    /// Sends the sentence of an error.
    pub fn problem(&self, scene: &Scene, error: &Error) {
        tracing::info!("reported to a page: {error}");
        self.reply(&Reply::Problem { sentence: &scene.host.sentence(error) });
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
pub(super) async fn serve(mut socket: WebSocket, served: Arc<Served>) {
    let Some(_place) = Place::take(&served) else {
        let reason = "Too many pages are open. Close one of them and reload this page.";
        close(&mut socket, close_code::AGAIN, reason).await;
        return;
    };
    let mut scene = Some(served.scene());
    while let Some(shown) = scene {
        scene = show(&mut socket, &served, shown).await;
    }
}

/// Serves a page as long as it shows a scene. Returns the next one, which the page has opened.
async fn show(socket: &mut WebSocket, served: &Arc<Served>, scene: Arc<Scene>) -> Option<Arc<Scene>> {
    let hello = Message::Text(scene.hello().to_string().into());
    if !send(socket, hello).await {
        return None;
    }
    let cancel = Cancel::new();
    let inbox = Arc::new(Inbox::new(cancel.clone()));
    let keeper = Arc::new(Keeper::default());
    let (sender, mut outgoing) = mpsc::channel(MOST_WAITING);
    let maker = Maker { scene: scene.clone(), keeper: keeper.clone(), outgoing: Outgoing(sender.clone()) };
    let painter = Painter::new(scene.clone(), inbox.clone(), keeper.clone(), Outgoing(sender), cancel);
    let mut painter = match painter {
        Ok(painter) => painter,
        Err(error) => {
            send(socket, text(&Reply::Problem { sentence: &scene.host.sentence(&error) })).await;
            return None;
        }
    };
    warming::begin(&scene, &mut painter);
    let thread = |name: &str| std::thread::Builder::new().name(name.into());
    let (opened, mut opening) = mpsc::channel(1);
    let (served, rate) = (served.clone(), Rate::new(Instant::now()));
    let mut session = Session { served, scene, inbox, keeper, rate, opened, is_opening: false };
    if thread("painter").spawn(move || painter.run()).is_ok() && thread("maker").spawn(move || maker.run()).is_ok() {
        return session.run(socket, &mut outgoing, &mut opening).await;
    }
    None
}

impl Drop for Session {
    /// Ends the drawing threads, also where the server ends in the middle of a session.
    fn drop(&mut self) {
        self.inbox.close();
        self.keeper.close();
    }
}

/// A place among the sessions.
struct Place(Arc<Served>);

impl Place {
    fn take(served: &Arc<Served>) -> Option<Self> {
        let place = Self(served.clone());
        // Dropping the place frees it again.
        (served.sessions.fetch_add(1, Ordering::SeqCst) < MOST_SESSIONS).then_some(place)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.sessions.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A scene that a page has opened, or the sentence of an error.
type Opened = Result<Arc<Scene>, String>;

struct Session {
    served: Arc<Served>,
    scene: Arc<Scene>,
    inbox: Arc<Inbox>,
    keeper: Arc<Keeper>,
    rate: Rate,
    /// Where a volume that was opened comes out.
    opened: mpsc::Sender<Opened>,
    is_opening: bool,
}

impl Session {
    async fn run(
        &mut self,
        socket: &mut WebSocket,
        outgoing: &mut mpsc::Receiver<Message>,
        opening: &mut mpsc::Receiver<Opened>,
    ) -> Option<Arc<Scene>> {
        let mut ready = self.scene.ready.subscribe();
        let is_ready = *ready.borrow_and_update();
        if !send(socket, text(&Reply::Ready { ready: is_ready })).await {
            return None;
        }
        let mut pings = interval(PING);
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut heard = Instant::now();
        loop {
            let answer = tokio::select! {
                received = socket.recv() => {
                    let Some(Ok(message)) = received else { return None };
                    heard = Instant::now();
                    match self.receive(&message, heard) {
                        Received::Nothing => continue,
                        Received::Answer(answer) => answer,
                        Received::Close(code, reason) => {
                            close(socket, code, reason).await;
                            return None;
                        }
                    }
                }
                picture = outgoing.recv() => match picture {
                    Some(message) => message,
                    None => return None,
                },
                // The session has a sender, too: this never ends.
                Some(opened) = opening.recv() => match opened {
                    Ok(scene) => {
                        self.served.set_scene(scene.clone());
                        return Some(scene);
                    }
                    Err(sentence) => {
                        self.is_opening = false;
                        text(&Reply::Problem { sentence: &sentence })
                    }
                },
                Ok(()) = ready.changed() => text(&Reply::Ready { ready: *ready.borrow_and_update() }),
                _ = pings.tick() => {
                    if heard.elapsed() > LONGEST_SILENCE {
                        return None;
                    }
                    Message::Ping(Vec::new().into())
                }
            };
            if !send(socket, answer).await {
                return None;
            }
        }
    }

    /// Opens a volume on a thread of its own, since reading takes long. Pictures of the old one are drawn meanwhile.
    fn open(&mut self, volume: Wanted) -> Result<(), Error> {
        let problem = |problem: &str| Error::Settings { field: "page", problem: problem.into() };
        if self.is_opening {
            return Err(problem("a volume is being opened: wait until it is there"));
        }
        let (served, scene, opened) = (self.served.clone(), self.scene.clone(), self.opened.clone());
        let work = move || {
            // The page may be gone.
            let _ = opened.blocking_send(opening::open(&served, &scene, &volume));
        };
        let thread = std::thread::Builder::new().name("opening".into()).spawn(work);
        self.is_opening = thread.is_ok();
        thread.map(|_| ()).map_err(|_| problem("the server has no thread left: try again"))
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
    fn handle(&mut self, request: Request) -> Result<Option<Message>, Error> {
        let job = match request {
            Request::View(view) => {
                shown_size(view.width, view.height)?;
                self.keeper.hand(view.moving);
                self.inbox.post_view(view);
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
            Request::Open { volume } => return self.open(volume).map(|()| None),
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
            Request::Film(film) => Job::Film(film),
            // After the order, which waits there too.
            Request::CancelFilm { id } => Job::CancelFilm(id),
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
