//! No memory left: one line and an exit code, as for other limits of the system, rather than an abort.

#![allow(unsafe_code, reason = "an allocator is unsafe by its interface; this one passes every call on")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::{Cursor, Write as _};

use crate::messages::{Code, are_json};

/// The exit code: that of input and output.
const EXIT_CODE: i32 = 74;

#[global_allocator]
static ALLOCATOR: OrEnd = OrEnd;

/// The allocator of the system, which ends the process where it would return nothing.
struct OrEnd;

// SAFETY: every call is passed on to the allocator of the system as it is, and so is what that returns.
unsafe impl GlobalAlloc for OrEnd {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        granted(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the same promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        granted(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the same promises.
        granted(unsafe { System.realloc(pointer, layout, size) }, size)
    }
}

#[inline]
fn granted(pointer: *mut u8, size: usize) -> *mut u8 {
    if pointer.is_null() {
        end(size)
    }
    pointer
}

/// Ends the process. Nothing here takes memory.
#[cold]
fn end(size: usize) -> ! {
    let mut line = Cursor::new([0; 512]);
    // Nothing in the text needs an escape in JSON.
    let _ = if are_json() {
        write!(line, "{{\"code\":\"{}\",\"text\":\"", Code::InternalError.name())
    } else {
        write!(line, "stickslip: ")
    };
    let _ = write!(
        line,
        "out of memory: {size} bytes more were refused. Finished work that is on disk is kept; allow more memory, \
         or give fewer threads with --threads"
    );
    let _ = writeln!(line, "{}", if are_json() { "\"}" } else { "" });
    let length = line.position() as usize;
    let _ = rustix::io::write(rustix::stdio::stderr(), &line.get_ref()[..length]);
    signal_hook::low_level::exit(EXIT_CODE)
}
