//! Questions of a page that take passes over voxels or files. A thread of its own answers them in order: neither connections nor pictures wait
//! for it.

use super::drawn::CurrentLook;
use super::look::Look;
use super::outgoing::Outgoing;
use super::page_camera::PageCamera;
use super::replies::Reply;
use super::requests::Kind;
use super::scene::SharedScene;
use crate::error::Error;
use crate::settings::Settings;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

/// Questions that wait. A page that asks for more has to wait for answers.
pub(super) const MOST_QUESTIONS: usize = 8;

/// A question that is answered once.
pub(super) enum Question {
    /// A transfer function of a field by name.
    Named { field: usize, kind: Kind, name: String },
    /// The transfer function in the text of a file.
    Read { field: usize, name: String, text: String },
    /// The camera that fits what is visible.
    Fit(Box<Fit>),
}

/// What a camera is fitted to.
pub(super) struct Fit {
    pub camera: PageCamera,
    pub size: Viewport,
    pub settings: Settings,
    pub look: Look,
    pub transfers: Vec<TransferFunction>,
}

/// Asks a question; fails if too many wait.
pub(super) fn ask(questions: &SyncSender<Question>, question: Question) -> Result<(), Error> {
    let refused = || Error::Settings { field: "page", problem: "too many requests wait: try again when they are done".into() };
    questions.try_send(question).map_err(|_| refused())
}

/// Answers questions until nobody can ask any more.
pub(super) fn answer(scene: &Arc<SharedScene>, outgoing: &Outgoing, questions: &Receiver<Question>) {
    for question in questions {
        let answered = match question {
            Question::Named { field, kind, name } => {
                scene.named(field, kind, &name).map(|found| described(outgoing, field, &found))
            }
            Question::Read { field, name, text } => {
                TransferFunction::from_text(&text, &name).map(|found| described(outgoing, field, &found))
            }
            Question::Fit(fit) => {
                let Fit { camera, size, settings, look, transfers } = &*fit;
                let now = CurrentLook { look, transfers };
                scene.fitted(camera, *size, settings, now).map(|camera| outgoing.reply(&Reply::Fitted { camera }))
            }
        };
        if let Err(error) = answered {
            outgoing.problem(scene, &error);
        }
    }
}

fn described(outgoing: &Outgoing, field: usize, transfer: &TransferFunction) {
    outgoing.reply(&Reply::Transfer { field, name: transfer.name(), colors: transfer.colors(), opacities: transfer.opacities() });
}
