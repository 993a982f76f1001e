//! A page's WebSocket: what goes both ways, and the limits of both.

use super::opening::{Opened, Progress};
use super::outgoing::{Message as PageMessage, text};
use super::rate::Rate;
use super::replies::{Reply, Stage};
use super::requests::OpenWanted;
use super::scene::SharedScene;
use super::served::{Served, aside};
use super::session::{Received, Session};
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval, timeout};

/// Most pages at once. Each has three threads, and they share memory (`MOST_AT_REST` in painter.rs).
const MOST_SESSIONS: usize = 24;
/// Messages that wait for the connection. More would only take memory.
const MOST_WAITING: usize = 4;
/// A page that takes no byte for this long is given up.
const LONGEST_SEND: Duration = Duration::from_secs(30);
/// Distance of the pings of a page at rest.
const PING: Duration = Duration::from_secs(15);
/// A page that says nothing for this long, not even to pings, is given up.
const LONGEST_SILENCE: Duration = Duration::from_secs(60);

/// Serves a page until it closes.
pub(super) async fn serve(mut socket: WebSocket, served: Arc<Served>) {
    let Some(_place) = Place::take(&served) else {
        let reason = "Too many pages are open. Close one of them and reload this page.";
        close(&mut socket, close_code::AGAIN, reason).await;
        return;
    };
    let mut scene = Some(served.scenes.last());
    while let Some(shown) = scene {
        scene = show(&mut socket, &served, shown).await;
    }
}

/// Serves a page as long as it shows a scene. Returns the next one, which the page has opened.
async fn show(socket: &mut WebSocket, served: &Arc<Served>, scene: Arc<SharedScene>) -> Option<Arc<SharedScene>> {
    let described = scene.clone();
    // Looks at the voxels.
    let hello = aside(move || described.hello(&described.opening.first())).await?;
    if !send(socket, Message::Text(hello.into())).await {
        return None;
    }
    let (sender, mut outgoing) = mpsc::channel(MOST_WAITING);
    // Waits while too much is on its way. A page that is gone needs nothing.
    let to_page = move |message: PageMessage| drop(sender.blocking_send(message.into()));
    let drawn = scene.clone();
    // May upload voxels.
    match aside(move || Session::new(drawn.clone(), &drawn.opening.first(), to_page)).await? {
        Ok(session) => {
            let (opened, mut opening) = mpsc::channel(MOST_WAITING);
            let (served, rate) = (served.clone(), Rate::new(Instant::now()));
            let mut connection = Connection { session, served, scene, rate, opened, opening: None };
            let next = connection.run(socket, &mut outgoing, &mut opening).await;
            connection.cancel_opening();
            // Nobody else may have the voxels: freeing them takes a while.
            aside(move || drop((connection, opening))).await;
            next
        }
        Err(error) => {
            send(socket, text(&Reply::Problem { sentence: &scene.host.sentence(&error), undo: false }).into()).await;
            None
        }
    }
}

impl From<PageMessage> for Message {
    fn from(message: PageMessage) -> Self {
        match message {
            PageMessage::Text(text) => Message::Text(text.into()),
            PageMessage::Binary(bytes) => Message::Binary(bytes.into()),
        }
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

struct Connection {
    session: Session,
    served: Arc<Served>,
    scene: Arc<SharedScene>,
    rate: Rate,
    /// Where a volume that was opened comes out.
    opened: mpsc::Sender<Opened>,
    /// The volume that is being opened.
    opening: Option<Arc<Progress>>,
}

impl Connection {
    async fn run(
        &mut self,
        socket: &mut WebSocket,
        outgoing: &mut mpsc::Receiver<Message>,
        opening: &mut mpsc::Receiver<Opened>,
    ) -> Option<Arc<SharedScene>> {
        let mut pings = interval(PING);
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut heard = Instant::now();
        loop {
            let answer = tokio::select! {
                received = socket.recv() => {
                    let Some(Ok(message)) = received else { return None };
                    heard = Instant::now();
                    match self.receive(&message, heard) {
                        Heard::Nothing => continue,
                        Heard::Answer(answer) => answer,
                        Heard::Close(code, reason) => {
                            close(socket, code, reason).await;
                            return None;
                        }
                    }
                }
                message = outgoing.recv() => match message {
                    Some(message) => message,
                    None => return None,
                },
                // The connection has a sender, too: this never ends.
                Some(opened) = opening.recv() => match opened {
                    Opened::Progress(message) => message.into(),
                    Opened::Scene(scene) => {
                        let (served, opened) = (self.served.clone(), scene.clone());
                        // May free the last one.
                        aside(move || served.scenes.open(opened)).await;
                        return Some(scene);
                    }
                    Opened::Problem(sentence) => {
                        self.opening = None;
                        text(&Reply::Problem { sentence: &sentence, undo: false }).into()
                    }
                    Opened::Cancelled => {
                        self.opening = None;
                        text(&Reply::Opening { stage: Stage::Cancelled, done: None }).into()
                    }
                },
                _ = pings.tick() => {
                    // The page connects again, to threads that draw.
                    if heard.elapsed() > LONGEST_SILENCE || !self.session.is_drawing() {
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

    /// Opens a volume on a thread of its own, since reading takes long. Pictures of the old one are drawn meanwhile. Returns the problem.
    fn open(&mut self, volume: OpenWanted) -> Heard {
        let problem = |sentence: &str| Heard::Answer(text(&Reply::Problem { sentence, undo: false }).into());
        if self.opening.is_some() {
            return problem("A volume is being opened: wait until it is there, or cancel it.");
        }
        let (served, scene, progress) = (self.served.clone(), self.scene.clone(), Progress::new(self.opened.clone()));
        let opening = progress.clone();
        let work = move || opening.open(&served, &scene, &volume);
        if std::thread::Builder::new().name("opening".into()).spawn(work).is_err() {
            return problem("The server has no thread left: try again.");
        }
        self.opening = Some(progress);
        Heard::Nothing
    }

    fn cancel_opening(&self) {
        if let Some(opening) = &self.opening {
            opening.cancel();
        }
    }

    fn receive(&mut self, message: &Message, now: Instant) -> Heard {
        let request = match message {
            Message::Text(text) => text.as_str(),
            Message::Binary(_) => return Heard::Close(close_code::UNSUPPORTED, "Pages send text."),
            Message::Close(_) => return Heard::Close(close_code::NORMAL, ""),
            Message::Ping(_) | Message::Pong(_) => "",
        };
        if !self.rate.allows(now, request.len()) {
            return Heard::Close(close_code::POLICY, "The page sends too much.");
        }
        if request.is_empty() {
            return Heard::Nothing;
        }
        match self.session.receive(request) {
            Some(Received { open: Some(volume), .. }) => self.open(volume),
            Some(Received { cancels_open: true, .. }) => {
                self.cancel_opening();
                match self.opening {
                    Some(_) => Heard::Nothing,
                    None => Heard::Answer(text(&Reply::Opening { stage: Stage::Cancelled, done: None }).into()),
                }
            }
            Some(Received { answer, .. }) => answer.map_or(Heard::Nothing, |answer| Heard::Answer(answer.into())),
            None => Heard::Close(close_code::INVALID, "This page belongs to another version of layersplat. Reload it."),
        }
    }
}

/// What a message of the page leads to.
enum Heard {
    Nothing,
    Answer(Message),
    Close(u16, &'static str),
}

/// Sends a message; false if the page is gone or takes nothing.
async fn send(socket: &mut WebSocket, message: Message) -> bool {
    matches!(timeout(LONGEST_SEND, socket.send(message)).await, Ok(Ok(())))
}

async fn close(socket: &mut WebSocket, code: u16, reason: &'static str) {
    let _ = timeout(LONGEST_SEND, socket.send(Message::Close(Some(CloseFrame { code, reason: reason.into() })))).await;
}
