//! Work of a page that is answered once, with the look and the transfer functions that it has then.

use super::inbox::Job;
use super::keeper::{Kept, Order};
use super::painter::Painter;
use super::replies::{FilmState, Reply};
use super::survey::{self, Fit, Question};
use crate::error::Error;

impl Painter {
    /// Does work that is answered once, or passes it on to the thread that answers it.
    pub(super) fn do_job(&mut self, job: Job) -> Result<(), Error> {
        match job {
            Job::Fit { camera, size } => {
                self.scene.camera(&camera)?;
                let settings = self.scene.host.settings(&self.look, None)?;
                let (look, transfers) = (self.look.clone(), self.transfers.clone());
                survey::ask(&self.questions, Question::Fit(Box::new(Fit { camera, size, settings, look, transfers })))
            }
            Job::Write { field, name, format } => {
                self.outgoing.reply(&Reply::Written { name: &name, text: &self.transfers[field].to_text(format) });
                Ok(())
            }
            Job::Command(saving) => self.say_command(&saving),
            Job::Pick(pick) => {
                let point = self.pick(&pick)?;
                self.outgoing.reply(&Reply::Picked { id: pick.id, point });
                Ok(())
            }
            Job::Save(saving) => self.keep(Kept::Picture(saving)),
            Job::Film(film) => {
                let id = film.id;
                if let Err(error) = film.check().and_then(|_| self.keep(Kept::Film(film))) {
                    self.outgoing.problem(&self.scene, &error);
                    self.outgoing.reply(&Reply::Film { id, state: FilmState::Failed, done: 0, of: 0 });
                }
                Ok(())
            }
            Job::CancelFilm(id) => {
                if self.keeper.cancel_film(id) {
                    self.outgoing.reply(&Reply::Film { id, state: FilmState::Cancelled, done: 0, of: 0 });
                }
                Ok(())
            }
        }
    }

    /// Orders what is kept, with the current look and transfer functions.
    fn keep(&self, kept: Kept) -> Result<(), Error> {
        let (look, transfers) = (self.look.clone(), self.transfers.clone());
        if self.keeper.post(Order { kept, look, transfers }) {
            return Ok(());
        }
        Err(Error::Settings { field: "page", problem: "too many pictures and films wait: try again when they are done".into() })
    }
}
