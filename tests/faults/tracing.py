"""Faults in single system calls, by strace."""

import signal
import subprocess

from common import Skipped, need

# Calls by which files appear and are read, in groups: architectures differ in which of them they have.
CALLS = {
    "write": "write,?writev,?pwrite64,?copy_file_range",
    "fsync": "fsync,?fdatasync",
    "rename": "?rename,renameat,?renameat2,?linkat",
    "openat": "openat,?open",
    "mkdir": "?mkdir,mkdirat",
    "read": "read,?pread64,?readv",
}

# No run makes that many calls of one kind.
MOST_CALLS = 2000


def with_fault(call: str, fault: str) -> list:
    """The words of a command that runs another one, in which calls are hit by a fault."""
    calls = CALLS[call]
    words = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={calls}"]
    return [*words, "-e", f"inject={calls}:{fault}"]


def need_tracing() -> None:
    """Skips a row where strace cannot inject faults."""
    need("strace")
    tried = subprocess.run([*with_fault("write", "signal=SIGKILL:when=1"), "echo"], capture_output=True)
    if tried.returncode != -signal.SIGKILL:
        raise Skipped(f"strace cannot inject faults here: {tried.stderr.decode(errors='replace').strip()}")
