//! kill -9 at random moments while a session is edited and saved: every gesture that was finished is there afterwards.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use marey::job::Progress;
use marey::session::{Access, Session};
use marey_tests::editing;

/// The longest that an editor lives: some dozens of gestures.
const LIFE_MS: u64 = 300;

fn open(path: &Path) -> Session {
    Session::open(path, Access::Edit, Progress::new().whole()).expect("it opens after every kill")
}

/// Lets the editor run for so long, kills it, and gives the number of the last gesture that it said was finished.
fn edit_and_kill(path: &Path, life: Duration) -> Option<u64> {
    let mut editor = Command::new(env!("CARGO_BIN_EXE_session_editor"));
    let mut editor = editor.arg(path).stdout(Stdio::piped()).spawn().expect("started");
    let lines = BufReader::new(editor.stdout.take().expect("a pipe")).lines();
    let reader = std::thread::spawn(move || lines.map_while(Result::ok).last().and_then(|n| n.parse().ok()));
    std::thread::sleep(life);
    editor.kill().expect("killed");
    assert_eq!(editor.wait().expect("ended").code(), None, "it failed by itself");
    reader.join().expect("read")
}

fn kill_again_and_again(seed: u64, times: u64) {
    let folder = tempfile::tempdir().expect("a folder");
    let (ours, twins) = (folder.path().join("ours"), folder.path().join("twins"));
    std::fs::create_dir(&ours).expect("a folder");
    let path = ours.join("walk.marey");
    drop(Session::create(&path).expect("created"));
    let mut from_journal = 0;
    for time in 0..times {
        std::fs::create_dir(&twins).expect("a folder");
        for file in std::fs::read_dir(&ours).expect("listed").map(|e| e.expect("an entry")) {
            std::fs::copy(file.path(), twins.join(file.file_name())).expect("copied");
        }
        let told = edit_and_kill(&path, Duration::from_millis(editing::scatter(seed + time) % LIFE_MS));

        let session = open(&path);
        let mut twin = open(&twins.join("walk.marey"));
        let finished = told.unwrap_or_else(|| twin.gestures());
        // The last one may have been on the disk before the editor could say so.
        assert!((finished..=finished + 1).contains(&session.gestures()), "{finished} finished: {session:?}");
        while twin.gestures() < session.gestures() {
            editing::gesture(&mut twin).expect("done");
        }
        assert_eq!(session.document(), twin.document(), "kill {time}, after {} gestures", session.gestures());
        assert!(session.warnings().iter().all(|w| w.contains("cut off")), "{:?}", session.warnings());
        from_journal += session.replayed();
        if time + 1 == times {
            let names: Vec<_> =
                std::fs::read_dir(&ours).expect("listed").map(|e| e.expect("an entry").file_name()).collect();
            assert!(names.len() <= 3, "the session, its journal, perhaps a save that was cut off: {names:?}");
            assert!(session.gestures() > times && from_journal > 0, "the editor did too little to tell");
        }
        drop((session, twin));
        std::fs::remove_dir_all(&twins).expect("removed");
    }
}

#[test]
fn no_finished_gesture_is_lost_to_a_kill() {
    kill_again_and_again(1, 20);
}

#[test]
#[ignore = "long: ten times the kills, for a change of the session's files"]
fn no_finished_gesture_is_lost_to_many_kills() {
    kill_again_and_again(1000, 200);
}
