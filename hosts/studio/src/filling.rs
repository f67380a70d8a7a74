//! Steps that the machine fills in as soon as it can, behind any door: what is to be done next is begun, what runs for what
//! is no more is stopped, and what failed is not tried again until something else is wanted.

use eframe::egui::Ui;
use marey_binding::Job;

use crate::around::Around;
use crate::running::{Purpose, Running, Step};
use crate::workshop::{Watched, Workshop};

/// What runs was begun for these; what failed for them is not tried again.
#[derive(Debug)]
pub(crate) struct Steps<Of> {
    begun: Option<(Step, Of)>,
    failed: Option<(Step, Of)>,
    /// How many times points were followed.
    pub(crate) followed: u64,
}

impl<Of> Default for Steps<Of> {
    fn default() -> Self {
        Self { begun: None, failed: None, followed: 0 }
    }
}

impl<Of> Steps<Of> {
    /// What failed can be tried again; whether there is something that did.
    pub(crate) fn try_again(&mut self) -> bool {
        self.failed.take().is_some()
    }
}

/// A door whose steps fill themselves in.
pub(crate) trait Filling {
    /// What a step is done for, and what was made of it is known by.
    type Of: Clone + Default + PartialEq;

    fn shop(&mut self) -> &mut Workshop;

    fn steps(&mut self) -> &mut Steps<Self::Of>;

    /// The step that is to be done, and what it is to be done for; after every change.
    fn wanted(&mut self, around: &mut Around) -> Option<(Step, Self::Of)>;

    /// Begins a step; none where there is nothing to begin.
    fn start(&mut self, step: Step, of: &Self::Of, around: &Around) -> Result<Option<Job>, String>;

    /// Takes in what a step made.
    fn take(&mut self, step: Step, job: &Job, of: Self::Of, now: f64, around: &mut Around)
    -> marey_binding::Result<()>;

    /// Starts what can be filled in next.
    fn go_on(&mut self, around: &mut Around) {
        let wanted = self.wanted(around);
        let outdated = wanted.is_some() && self.steps().begun != wanted;
        if let Some(running) = &mut self.shop().running {
            if outdated && matches!(running.purpose, Purpose::Step(step) if !step.is_asked_for()) {
                running.give_up();
            }
            return;
        }
        let Some(wanted) = wanted.filter(|w| self.steps().failed.as_ref() != Some(w)) else { return };
        match self.start(wanted.0, &wanted.1, around) {
            Ok(Some(job)) => {
                self.shop().running = Some(Running::new(job, Purpose::Step(wanted.0)));
                self.steps().followed += u64::from(wanted.0 == Step::Points);
                self.steps().begun = Some(wanted);
            }
            Ok(None) => {}
            Err(message) => {
                around.notices.failed(message);
                self.steps().failed = Some(wanted);
            }
        }
    }

    /// Takes in how what runs ended, and goes on.
    fn watch(&mut self, ui: &Ui, around: &mut Around) {
        let Some(watched) = self.shop().watch(ui, around) else { return };
        let begun = self.steps().begun.take();
        match watched {
            Watched::Failed => self.steps().failed = begun,
            Watched::Outdated => {}
            Watched::Done(step, running) => {
                let of = begun.map(|b| b.1).unwrap_or_default();
                let taken = self.take(step, &running.job, of, ui.input(|i| i.time), around);
                around.notices.check(taken);
            }
        }
        self.go_on(around);
    }
}
