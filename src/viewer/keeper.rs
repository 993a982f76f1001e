//! What a page keeps, saved pictures and films, made one after another by a thread of its own. Its frames are drawn in bands, which wait while
//! a hand moves.

use super::drawn::CurrentLook;
use super::inbox::Saving;
use super::look::Look;
use super::outgoing::Outgoing;
use super::replies::{FilmState, Reply};
use super::requests::Film;
use super::scene::SharedScene;
use crate::device::{Bands, Cancel};
use crate::error::Error;
use crate::transfer::TransferFunction;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Orders that wait. A page that asks for more has to wait for answers.
const MOST_ORDERS: usize = 4;
/// Time after the last movement of a hand at which work goes on, if the page does not say that the hand rests.
const HAND: Duration = Duration::from_millis(300);

/// A picture or a film, with the look and the transfer functions of the moment it was asked for.
pub(super) struct Order {
    pub kept: Kept,
    pub look: Look,
    /// Those of all fields.
    pub transfers: Vec<TransferFunction>,
}

impl Order {
    /// How the fields were shown.
    pub fn now(&self) -> CurrentLook<'_> {
        CurrentLook { look: &self.look, transfers: &self.transfers }
    }

    /// The step of a sequence that comes first.
    fn step(&self) -> usize {
        match &self.kept {
            Kept::Picture(_) => self.look.frame,
            Kept::Film(film) => film.first_step(),
        }
    }
}

/// What is made.
pub(super) enum Kept {
    Picture(Saving),
    Film(Film),
}

impl Kept {
    /// Number of the film.
    fn film(&self) -> Option<u32> {
        if let Kept::Film(film) = self { Some(film.id) } else { None }
    }
}

#[derive(Default)]
struct State {
    orders: VecDeque<Order>,
    /// The film that is being drawn.
    film: Option<u32>,
    is_closed: bool,
}

/// The orders of a page.
#[derive(Default)]
pub(super) struct Keeper {
    state: Mutex<State>,
    changed: Condvar,
    cancel: Cancel,
    bands: Bands,
}

impl Keeper {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an order; returns false if too many wait.
    pub fn post(&self, order: Order) -> bool {
        let mut state = self.state();
        if state.orders.len() == MOST_ORDERS {
            return false;
        }
        state.orders.push_back(order);
        self.changed.notify_all();
        true
    }

    /// Gives up a film. Returns false if it is being drawn: it then ends soon, and its thread tells the page.
    pub fn cancel_film(&self, id: u32) -> bool {
        let mut state = self.state();
        if state.film == Some(id) {
            self.cancel.cancel();
        }
        state.orders.retain(|order| order.kept.film() != Some(id));
        state.film != Some(id)
    }

    /// Work waits for a hand.
    pub fn hand(&self, is_moving: bool) {
        if is_moving { self.bands.pause(HAND) } else { self.bands.resume() }
    }

    /// The page is gone.
    pub fn close(&self) {
        let mut state = self.state();
        state.is_closed = true;
        state.orders.clear();
        self.cancel.cancel();
        self.changed.notify_all();
    }

    /// Whether what is being made was given up.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Waits for an order. `None` if the page is gone.
    fn next(&self) -> Option<Order> {
        let mut state = self.state();
        loop {
            if state.is_closed {
                return None;
            }
            if let Some(order) = state.orders.pop_front() {
                state.film = order.kept.film();
                return Some(order);
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn done(&self) {
        let mut state = self.state();
        state.film = None;
        if !state.is_closed {
            self.cancel.reset();
        }
    }
}

/// Makes what is kept for one page.
pub(super) struct Maker {
    pub scene: Arc<SharedScene>,
    pub keeper: Arc<Keeper>,
    pub outgoing: Outgoing,
}

impl Maker {
    /// Works until the page is gone.
    pub fn run(self) {
        while let Some(order) = self.keeper.next() {
            let made = self.make(&order);
            self.keeper.done();
            let Err(error) = made else { continue };
            let is_cancelled = matches!(error, Error::Cancelled { .. });
            if !is_cancelled {
                self.outgoing.problem(&self.scene, &error);
            }
            if let Some(id) = order.kept.film() {
                let state = if is_cancelled { FilmState::Cancelled } else { FilmState::Failed };
                self.outgoing.reply(&Reply::Film { id, state, done: 0, of: 0 });
            }
        }
    }

    fn make(&self, order: &Order) -> Result<(), Error> {
        // Dropped when done, with its buffers on the device.
        let volume = self.scene.step(order.step())?;
        let mut renderer = self.scene.page_renderer(&volume, order.now())?;
        let renderer = &mut renderer;
        renderer.set_cancel(Some(self.keeper.cancel.clone()));
        renderer.set_bands(Some(self.keeper.bands.clone()));
        match &order.kept {
            Kept::Picture(saving) => self.save(order, renderer.as_mut(), saving),
            Kept::Film(film) => self.film(order, renderer.as_mut(), film),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Background;
    use crate::settings::Settings;
    use crate::viewer::requests::FilmFormat;

    fn order(id: u32) -> Order {
        let film = Film { id, keys: Vec::new(), width: 1, height: 1, samples: 1, rate: 1, format: FilmFormat::Gif };
        let transfer = TransferFunction::new("test", vec![(0.0, [0.0; 3])], vec![(0.0, 0.0)]).unwrap();
        Order {
            kept: Kept::Film(film),
            look: Look::of(&Settings::default(), Background::BLACK, 0.0, [1; 3]),
            transfers: vec![transfer],
        }
    }

    #[test]
    fn films_are_given_up_by_number() {
        let keeper = Keeper::default();
        assert!((1..=MOST_ORDERS as u32).all(|id| keeper.post(order(id))) && !keeper.post(order(9)));
        assert_eq!(keeper.next().unwrap().kept.film(), Some(1));
        assert!(keeper.cancel_film(2) && !keeper.cancel.is_cancelled());
        assert!(!keeper.cancel_film(1) && keeper.cancel.is_cancelled());
        keeper.done();
        assert!(!keeper.cancel.is_cancelled());
        assert_eq!(keeper.next().unwrap().kept.film(), Some(3));
        keeper.close();
        keeper.done();
        assert!(keeper.cancel.is_cancelled() && keeper.next().is_none());
    }
}
