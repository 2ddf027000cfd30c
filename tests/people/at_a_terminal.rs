//! What happens at a terminal of its own, which the command `script` makes: completions of shells, and the bar at Ctrl-C.
//!
//! Where `script` or a shell is missing, its test is left out, with a word about it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::io::{Read as _, Write as _};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use crate::common::{Place, wait_until, with_default_signals};

/// A command at a terminal, and what stands there.
struct Terminal {
    child: Child,
    said: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    /// None, and a note, if a program is missing.
    fn start(place: &Place, shell: &str) -> Option<Self> {
        for program in ["script", shell.split(' ').next().unwrap()] {
            if !is_there(program) {
                return None;
            }
        }
        // What runs the tests in the background may have had SIGINT ignored.
        let mut script = with_default_signals("script");
        script
            .args(["-qec", shell, "/dev/null"])
            .current_dir(place.path(""))
            .env("TERM", "xterm")
            .env("LC_ALL", "C.UTF-8");
        let mut child = script.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut stdout = child.stdout.take().unwrap();
        let said = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&said);
        thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(read @ 1..) = stdout.read(&mut buffer) {
                heard.lock().unwrap().extend_from_slice(&buffer[..read]);
            }
        });
        Some(Self { child, said })
    }

    fn said(&self) -> String {
        String::from_utf8_lossy(&self.said.lock().unwrap()).into_owned()
    }

    /// Types a text and waits until something stands there.
    #[track_caller]
    fn type_and_wait_for(&mut self, text: &str, answer: &str) {
        self.child.stdin.as_mut().unwrap().write_all(text.as_bytes()).unwrap();
        wait_until(answer, || self.said().contains(answer));
    }

    /// Types the end and returns all that was said.
    fn end(mut self) -> String {
        self.child.stdin.as_mut().unwrap().write_all(b"exit\n").unwrap();
        self.child.wait().unwrap();
        self.said()
    }
}

/// Whether a program is there; if not, a note says so.
fn is_there(program: &str) -> bool {
    let is_there = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !is_there {
        let _ = writeln!(std::io::stderr(), "note: no {program}, a test is left out");
    }
    is_there
}

/// The lines of a screen of 80 columns on which this was written.
fn screen(said: &str) -> Vec<String> {
    let mut lines: Vec<Vec<char>> = vec![Vec::new()];
    let (mut line, mut column) = (0, 0);
    let mut characters = said.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '\r' => column = 0,
            '\n' => line += 1,
            '\x1b' => {
                let sequence: String =
                    characters.by_ref().take_while(|c| !c.is_ascii_alphabetic() || *c == '[').collect();
                // The letter that ends a sequence is gone; of those that are written here, only clearing has a 2.
                if sequence == "[2" {
                    lines[line].clear();
                }
            }
            character => {
                // Only what follows the last column goes to the next line.
                if column == 80 {
                    (line, column) = (line + 1, 0);
                }
                lines.resize_with(lines.len().max(line + 1), Vec::new);
                let length = lines[line].len().max(column + 1);
                lines[line].resize(length, ' ');
                lines[line][column] = character;
                column += 1;
            }
        }
        lines.resize_with(lines.len().max(line + 1), Vec::new);
    }
    lines.into_iter().map(|line| line.into_iter().collect::<String>().trim_end().to_owned()).collect()
}

#[test]
fn a_bar_goes_away_when_its_run_is_interrupted() {
    let place = Place::new();
    place.write(
        "slow.toml",
        &crate::common::job(
            "slow",
            "kind = \"time-domain\"\ndisc = \"flexible\"",
            "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.1",
            "samples = 2000000\nseed = 1",
        ),
    );
    let Some(mut terminal) = Terminal::start(&place, "sh") else { return };
    terminal.type_and_wait_for("stty cols 80 rows 24; echo rea''dy\n", "ready");
    let program = env!("CARGO_BIN_EXE_stickslip");
    terminal.type_and_wait_for(&format!("{program} submit slow.toml --out slow --threads 1\n"), "░");
    thread::sleep(Duration::from_millis(1500));
    terminal.type_and_wait_for("\x03", "samples are kept");
    terminal.type_and_wait_for("echo at ''an end\n", "at an end");
    let said = terminal.end();
    assert!(said.contains("^C"), "the terminal shows what is typed: {said}");
    let screen = screen(&said);
    assert!(!screen.iter().any(|line| line.contains(['░', '█'])), "a bar is left:\n{}", screen.join("\n"));
}

#[test]
fn fish_completes_the_keys_of_set() {
    if !is_there("fish") {
        return;
    }
    let place = Place::new();
    place.write("stickslip.fish", &place.run("completions fish").done().stdout);
    let offered = |line: &str| {
        let asked = format!("source stickslip.fish; complete -C '{line}'");
        let output = Command::new("fish").args(["--no-config", "-c", &asked]).current_dir(place.path("")).output();
        let offered = String::from_utf8(output.unwrap().stdout).unwrap();
        offered.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        offered("stickslip analyse --set friction.st"),
        ["friction.static_coefficient=", "friction.stribeck_exponent=", "friction.stribeck_velocity="]
    );
    assert_eq!(offered("stickslip trajectory --set=pad.ma"), ["--set=pad.mass="]);
    assert!(offered("stickslip parameters --set ").len() > 20);
}

#[test]
fn zsh_completes_the_keys_of_set_and_adds_no_space() {
    let place = Place::new();
    place.write("_stickslip", &place.run("completions zsh").done().stdout);
    let Some(mut terminal) = Terminal::start(&place, "zsh -f -i") else { return };
    terminal.type_and_wait_for(
        "fpath=($PWD $fpath); autoload -U compinit; compinit -u -D; zstyle ':completion:*' insert-tab false; \
         stickslip() { print -r -- \"took: $*\" }; print rea''dy\n",
        "ready",
    );
    // What a Tab makes of a line before the rest is typed.
    for (typed, taken) in [
        ("analyse --set friction.vis\t0.1", "took: analyse --set friction.viscous=0.1"),
        ("trajectory --set=pad.ma\t0.2", "took: trajectory --set=pad.mass=0.2"),
    ] {
        terminal.type_and_wait_for(&format!("stickslip {typed}\n"), taken);
    }
    terminal.end();
}
