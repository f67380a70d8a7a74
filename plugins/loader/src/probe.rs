//! A file tried in another process, so that one which ends its process does not end this one.

use std::io::Read as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::conformance;
use crate::library;
use crate::refusal::{Refusal, Status};

/// What the other process is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeMode {
    /// Load the file, look at what is inside, make and drop an instance of each plugin.
    Load,
    /// Run the conformance suite on the file.
    Check,
}

impl ProbeMode {
    /// The word for it on a command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Check => "check",
        }
    }

    /// The mode of a word.
    pub fn of(word: &str) -> Option<Self> {
        [Self::Load, Self::Check].into_iter().find(|mode| mode.word() == word)
    }
}

/// Marks the line with the answer among whatever a plugin prints.
const MARK: &str = "marey-probe: ";
/// More text than this is not read.
const MAX_TEXT: u64 = 16 << 20;

#[derive(serde::Serialize, serde::Deserialize)]
struct Answer {
    refusal: Option<Said>,
    #[serde(default)]
    report: serde_json::Value,
}

#[derive(serde::Serialize, serde::Deserialize)]
struct Said {
    status: Status,
    problem: String,
    remedy: String,
}

/// What a probe program does: tries `file` and gives the line to print on its standard output.
pub fn probe_main(mode: ProbeMode, file: &Path) -> String {
    let tried = match mode {
        ProbeMode::Load => load(file).map(|()| serde_json::Value::Null),
        // Beside the private copy, which goes away with its folder.
        ProbeMode::Check => conformance::run(file, &file.with_extension("check")),
    };
    let answer = match tried {
        Ok(report) => Answer { refusal: None, report },
        Err(Refusal { status, problem, remedy, .. }) => {
            Answer { refusal: Some(Said { status, problem, remedy }), report: serde_json::Value::Null }
        }
    };
    format!("\n{MARK}{}", serde_json::to_string(&answer).unwrap_or_default())
}

fn load(file: &Path) -> Result<(), Refusal> {
    let opened = library::open(file, file, None, Box::new(|_, _| {}))?;
    library::smoke(&opened, file)
}

/// Runs the probe program on a copy. `file` is what a person knows it by.
pub(crate) fn run(
    program: &Path,
    mode: ProbeMode,
    copy: &Path,
    file: &Path,
    deadline: Duration,
) -> Result<serde_json::Value, Refusal> {
    let cannot = |e: std::io::Error| {
        let remedy = "name marey or marey-plugin-probe as the probe";
        Refusal::file(Status::Copy, program, format!("cannot be started to try a plugin: {e}"), remedy)
    };
    let mut command = Command::new(program);
    command.args(["plugin", "probe", mode.word()]).arg(copy);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(cannot)?;
    let pipe = child.stdout.take();
    let reader = std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(pipe) = pipe {
            let _ = pipe.take(MAX_TEXT).read_to_end(&mut text);
        }
        text
    });
    let began = Instant::now();
    let status = loop {
        match child.try_wait().map_err(cannot)? {
            Some(status) => break status,
            None if began.elapsed() >= deadline => {
                let _ = child.kill();
                let _ = child.wait();
                let problem = format!("was not loaded after {:.0} s", deadline.as_secs_f64());
                return Err(Refusal::file(Status::Timeout, file, problem, "tell its author"));
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    let text = reader.join().unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let answer = text.lines().rev().find_map(|l| serde_json::from_str::<Answer>(l.strip_prefix(MARK)?).ok());
    match answer {
        Some(Answer { refusal: None, report }) if status.success() => Ok(report),
        Some(Answer { refusal: Some(said), .. }) => {
            let problem = said.problem.replace(&*copy.to_string_lossy(), "it");
            Err(Refusal::file(said.status, file, problem, said.remedy))
        }
        _ => {
            use std::os::unix::process::ExitStatusExt as _;
            let how = match (status.signal(), status.code()) {
                (Some(signal), _) => format!("by signal {signal}"),
                (None, Some(code)) => format!("with exit code {code}"),
                (None, None) => String::new(),
            };
            let problem = format!("ended the process that tried it, {how}");
            Err(Refusal::file(Status::Crashed, file, problem, "tell its author; it was not loaded into this program"))
        }
    }
}
