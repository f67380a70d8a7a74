//! One answer from a thread of its own.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::Context;

/// Something that is being found out. Dropped before, its answer is dropped too.
#[derive(Debug)]
pub(crate) struct Background<T>(Receiver<T>);

impl<T: Send + 'static> Background<T> {
    /// Starts to find out; the window is drawn again when it is there.
    pub(crate) fn start(ui: &Context, find: impl FnOnce() -> T + Send + 'static) -> Self {
        let (send, receive) = channel();
        let ui = ui.clone();
        std::thread::spawn(move || {
            let _ = send.send(find());
            ui.request_repaint();
        });
        Self(receive)
    }

    /// The answer, once; `Err` where it will never come, because its thread has failed.
    pub(crate) fn answer(&self) -> Result<Option<T>, ()> {
        match self.0.try_recv() {
            Ok(answer) => Ok(Some(answer)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(()),
        }
    }
}
