//! The session of a page: takes its requests as text, and answers by texts and pictures. How both travel is the caller's matter.

use super::first::First;
use super::inbox::{Inbox, Job, Saving};
use super::keeper::{Keeper, Maker};
use super::look::Look;
use super::outgoing::{Message, Outgoing, text};
use super::page_camera::PageCamera;
use super::painter::{Painter, Ways};
use super::replies::Reply;
use super::requests::{MAX_MESSAGE, OpenWanted, Request, saved_size, shown_size, transfer_function};
use super::scene::SharedScene;
use super::survey::{self, MOST_QUESTIONS, Question};
use crate::device::Cancel;
use crate::error::Error;
use crate::memory;
use crate::transfer::{FileFormat, TransferFunction};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

/// The session of a page. Dropping it ends the drawing thread after the kernel that is running.
pub struct Session {
    scene: Arc<SharedScene>,
    inbox: Arc<Inbox>,
    keeper: Arc<Keeper>,
    /// `None` once it ends.
    questions: Option<SyncSender<Question>>,
    threads: Vec<JoinHandle<()>>,
}

/// What a request was, and its answer if that is known at once.
#[derive(Debug)]
pub struct Received {
    /// What the user changed.
    pub change: Option<Change>,
    /// The answer; others come from the drawing thread.
    pub answer: Option<Message>,
    /// A volume that the user wants to open instead, for programs that offer some.
    pub open: Option<OpenWanted>,
    /// Whether the user gives up the volume that is being opened.
    pub cancels_open: bool,
}

/// What the user of a page changed.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "what changed")]
pub enum Change {
    Camera(PageCamera),
    Look(Box<Look>),
    Transfer(TransferFunction),
}

impl Session {
    /// Starts to draw for a page that was sent [`SharedScene::hello`] with the same `first`. `send` is called on the drawing thread, which waits
    /// until it returns.
    ///
    /// # Errors
    /// Insufficient memory of the device, and failures of the system.
    pub fn new(scene: Arc<SharedScene>, first: &First, send: impl Fn(Message) + Send + Sync + 'static) -> Result<Self, Error> {
        let inbox = Arc::new(Inbox::new(Cancel::new()));
        let (keeper, outgoing) = (Arc::new(Keeper::default()), Outgoing(Arc::new(send)));
        let maker = Maker { scene: scene.clone(), keeper: keeper.clone(), outgoing: outgoing.clone() };
        let (questions, asked) = sync_channel(MOST_QUESTIONS);
        let surveyor = (scene.clone(), outgoing.clone());
        let ways = Ways { inbox: inbox.clone(), keeper: keeper.clone(), questions: questions.clone() };
        let painter = Painter::new(scene.clone(), ways, outgoing, first)?;
        scene.ready.watch(&inbox);
        let thread = std::thread::Builder::new().name("painter".into()).spawn(move || {
            painter.run();
            memory::return_freed();
        });
        let failed = |e| Error::read(Path::new("the viewer's drawing thread"), e);
        // From here on, dropping the session ends the threads.
        let mut session = Self { scene, inbox, keeper, questions: Some(questions), threads: vec![thread.map_err(failed)?] };
        let thread = std::thread::Builder::new().name("maker".into()).spawn(move || maker.run());
        session.threads.push(thread.map_err(failed)?);
        let answer = move || survey::answer(&surveyor.0, &surveyor.1, &asked);
        let thread = std::thread::Builder::new().name("surveyor".into()).spawn(answer);
        session.threads.push(thread.map_err(failed)?);
        Ok(session)
    }

    /// Whether the drawing threads live. They end by a panic only.
    pub fn is_drawing(&self) -> bool {
        self.threads.iter().all(|thread| !thread.is_finished())
    }

    /// Ends the drawing threads, and waits until they have ended.
    pub fn end(mut self) {
        self.close();
        self.questions = None;
        for thread in std::mem::take(&mut self.threads) {
            // A panic was reported by its hook.
            let _ = thread.join();
        }
    }

    fn close(&self) {
        self.inbox.close();
        self.keeper.close();
    }

    /// Takes a message of the page. It does not wait: the newest request is stored for the drawing thread. `None` if the message is too
    /// long, or none of this version's.
    pub fn receive(&self, message: &str) -> Option<Received> {
        if message.len() > MAX_MESSAGE {
            return None;
        }
        let request: Request = serde_json::from_str(message).ok()?;
        let open = if let Request::Open { volume } = &request { Some(volume.clone()) } else { None };
        let change = match &request {
            Request::View(view) => self.scene.camera(&view.camera).ok().map(|_| Change::Camera(view.camera)),
            Request::Look { look } => Some(Change::Look(Box::new(look.clone()))),
            // Programs that follow a page show one field.
            Request::Transfer { field: 0, colors, opacities } => {
                transfer_function(colors.clone(), opacities.clone()).ok().map(Change::Transfer)
            }
            _ => None,
        };
        let cancels_open = matches!(request, Request::CancelOpen {});
        let undo = matches!(request, Request::View(_) | Request::Look { .. } | Request::Transfer { .. });
        Some(match self.handle(request) {
            Ok(answer) => Received { change, answer, open, cancels_open },
            Err(error) => {
                let sentence = self.scene.host.sentence(&error);
                Received {
                    change: None,
                    open: None,
                    cancels_open: false,
                    answer: Some(text(&Reply::Problem { sentence: &sentence, undo })),
                }
            }
        })
    }

    /// Takes a request; returns the answer of requests that are answered at once.
    fn handle(&self, request: Request) -> Result<Option<Message>, Error> {
        // A film that is refused is answered on the drawing thread, with its number.
        if !matches!(request, Request::Film(_)) {
            request.check()?;
        }
        let job = match request {
            Request::View(view) => {
                self.keeper.hand(view.moving);
                self.inbox.post_view(view);
                return Ok(None);
            }
            Request::Slices(slices) => {
                self.inbox.post_slices(slices);
                return Ok(None);
            }
            Request::Look { look } => {
                self.inbox.post_look(look);
                return Ok(None);
            }
            Request::Transfer { field, colors, opacities } => {
                self.scene.check_field(field)?;
                self.inbox.post_transfer(field, transfer_function(colors, opacities)?);
                return Ok(None);
            }
            Request::Shown {} => {
                self.inbox.acknowledge();
                return Ok(None);
            }
            // The caller's matter.
            Request::Open { .. } | Request::CancelOpen {} => return Ok(None),
            Request::Named { field, kind, name } => return self.ask(field, Question::Named { field, kind, name }),
            Request::Read { field, name, text } => return self.ask(field, Question::Read { field, name, text }),
            Request::Write { field, name } => {
                self.scene.check_field(field)?;
                let format = FileFormat::from_path(Path::new(&name))?;
                // The drawing thread has the transfer function.
                Job::Write { field, name, format }
            }
            Request::Fit { camera, width, height } => Job::Fit { camera, size: shown_size(width, height)? },
            Request::Save { camera, width, height, samples, format } => {
                Job::Save(Saving { camera, size: saved_size(width, height, samples)?, samples, format })
            }
            Request::Film(film) => Job::Film(film),
            // After the order, which waits there too.
            Request::CancelFilm { id } => Job::CancelFilm(id),
            Request::Command { camera, width, height, samples, format } => {
                Job::Command(Saving { camera, size: saved_size(width, height, samples)?, samples, format })
            }
            Request::Pick(pick) => Job::Pick(pick),
        };
        if self.inbox.post_job(job) {
            return Ok(None);
        }
        Err(Error::Settings { field: "page", problem: "too many requests wait: try again when they are done".into() })
    }
}

impl Session {
    /// Asks what is answered by a thread of its own.
    fn ask(&self, field: usize, question: Question) -> Result<Option<Message>, Error> {
        self.scene.check_field(field)?;
        self.questions.as_ref().map_or(Ok(()), |questions| survey::ask(questions, question))?;
        Ok(None)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.close();
    }
}
