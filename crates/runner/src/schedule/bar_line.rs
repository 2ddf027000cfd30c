//! The line of a terminal that has a progress bar.

use std::io::{self, Write as _};
use std::sync::{Mutex, PoisonError};

use indicatif::TermLike;

/// What is taken for the width of a terminal that does not say it.
const WIDTH: u16 = 80;

/// Columns at the end of the line that stay free: a terminal writes `^C` there, which would go to the next line, and the bar
/// would stay behind when that line is cleared.
const FREE: u16 = 4;

/// Standard error, with some columns less.
#[derive(Debug, Default)]
pub struct BarLine {
    /// What is to be written at once.
    text: Mutex<String>,
}

impl BarLine {
    fn add(&self, text: &str) -> io::Result<()> {
        self.text.lock().unwrap_or_else(PoisonError::into_inner).push_str(text);
        Ok(())
    }

    /// Moves the cursor by so many places in a direction of ANSI terminals.
    fn moved(&self, places: usize, direction: char) -> io::Result<()> {
        if places > 0 { self.add(&format!("\x1b[{places}{direction}")) } else { Ok(()) }
    }
}

/// The columns that a bar and what stands beside it may fill.
pub fn width() -> u16 {
    let size = rustix::termios::tcgetwinsize(io::stderr()).ok().filter(|size| size.ws_col > 0);
    size.map_or(WIDTH, |size| size.ws_col).saturating_sub(FREE)
}

impl TermLike for BarLine {
    fn width(&self) -> u16 {
        width()
    }

    fn move_cursor_up(&self, places: usize) -> io::Result<()> {
        self.moved(places, 'A')
    }

    fn move_cursor_down(&self, places: usize) -> io::Result<()> {
        self.moved(places, 'B')
    }

    fn move_cursor_right(&self, places: usize) -> io::Result<()> {
        self.moved(places, 'C')
    }

    fn move_cursor_left(&self, places: usize) -> io::Result<()> {
        self.moved(places, 'D')
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.add(text)?;
        self.add("\n")
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        self.add(text)
    }

    fn clear_line(&self) -> io::Result<()> {
        self.add("\r\x1b[2K")
    }

    fn flush(&self) -> io::Result<()> {
        let text = std::mem::take(&mut *self.text.lock().unwrap_or_else(PoisonError::into_inner));
        let mut stderr = io::stderr().lock();
        stderr.write_all(text.as_bytes())?;
        stderr.flush()
    }
}
