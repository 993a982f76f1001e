//! A page's WebSocket: what goes both ways, and the limits of both.

use super::protocol::Reply;
use super::rate::Rate;
use super::server::Served;
use super::session::{Message as PageMessage, Received, Session, text};
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
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

/// Serves a page until it closes.
pub(super) async fn serve(mut socket: WebSocket, served: Arc<Served>) {
    let Some(_place) = Place::take(&served) else {
        let reason = "Too many pages are open. Close one of them and reload this page.";
        close(&mut socket, close_code::AGAIN, reason).await;
        return;
    };
    let scene = &served.scene;
    if !send(&mut socket, Message::Text(scene.hello(&scene.opening.first()).into())).await {
        return;
    }
    let (sender, mut outgoing) = mpsc::channel(MOST_WAITING);
    // Waits while too much is on its way. A page that is gone needs nothing.
    let to_page = move |message: PageMessage| drop(sender.blocking_send(message.into()));
    match Session::new(scene.clone(), &scene.opening.first(), to_page) {
        Ok(session) => Connection { session, rate: Rate::new(Instant::now()) }.run(&mut socket, &mut outgoing).await,
        Err(error) => {
            send(&mut socket, text(&Reply::Problem { sentence: &scene.host.sentence(&error) }).into()).await;
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
    rate: Rate,
}

impl Connection {
    async fn run(&mut self, socket: &mut WebSocket, outgoing: &mut mpsc::Receiver<Message>) {
        let mut pings = interval(PING);
        pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut heard = Instant::now();
        loop {
            let answer = tokio::select! {
                received = socket.recv() => {
                    let Some(Ok(message)) = received else { return };
                    heard = Instant::now();
                    match self.receive(&message, heard) {
                        Heard::Nothing => continue,
                        Heard::Answer(answer) => answer,
                        Heard::Close(code, reason) => return close(socket, code, reason).await,
                    }
                }
                message = outgoing.recv() => match message {
                    Some(message) => message,
                    None => return,
                },
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
