//! Why a call failed.

use marey_ffi::mry_status_code as Code;

/// What kind of failure it is: the blocks of the status table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The work was cancelled.
    Cancelled,
    /// The call asked for something that is not there: an unknown tracker, a text that is not UTF-8.
    BadUse,
    /// A file, a rig or a value in them is wrong or too large.
    BadInput,
    /// The operating system refused.
    Failed,
    /// A defect of the library.
    Defect,
}

/// A failed call: its status, and one line of detail.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    code: i32,
    message: String,
    param: String,
}

/// The binding's result.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    pub(crate) fn new(code: i32, message: String, param: String) -> Self {
        Self { code, message, param }
    }

    /// The status as the C ABI has it.
    pub fn code(&self) -> i32 {
        self.code
    }

    /// What kind of failure it is.
    pub fn status(&self) -> Status {
        match self.code {
            code if code == Code::MRY_CANCELLED as i32 => Status::Cancelled,
            -199..=-100 => Status::BadUse,
            -399..=-200 => Status::BadInput,
            // A plugin that is not there is asked for in vain; one that is bad is a bad file; the rest failed.
            code if code == Code::MRY_E_PLUGIN_NOT_FOUND as i32 => Status::BadUse,
            -511..=-502 => Status::BadInput,
            -599..=-400 => Status::Failed,
            _ => Status::Defect,
        }
    }

    /// The C parameter at fault; empty where no single one is.
    pub fn param(&self) -> &str {
        &self.param
    }
}
