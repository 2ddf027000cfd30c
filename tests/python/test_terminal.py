"""What a user sees at a terminal: a bar, each message once, and errors as exceptions."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import sys
import termios
from pathlib import Path

import pytest
import tomli_w
from conftest import LONG

import stickslip


def at_terminal(
    script: str | list[str], folder: Path, *, interrupt_after: str | None = None, columns: int = 80
) -> tuple[str, int]:
    """Runs a script, or a command, at a terminal, presses Ctrl-C when a regular expression has been seen, and returns what
    is seen and the exit code.
    """
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        command = [sys.executable, "-c", script] if isinstance(script, str) else script
        os.execv(command[0], command)
    seen = b""
    while True:
        try:
            data = os.read(terminal, 1 << 16)
        except OSError:
            data = b""
        if not data:
            break
        seen += data
        if interrupt_after is not None and re.search(interrupt_after, seen.decode(errors="replace"), re.DOTALL):
            interrupt_after = None
            os.write(terminal, b"\x03")
    # Ctrl-C drops what the terminal has not passed on, which may end within a character.
    _, status = os.waitpid(child, 0)
    os.close(terminal)
    return seen.decode(errors="replace"), os.waitstatus_to_exitcode(status)


def test_ctrl_c_at_a_terminal(place: Path) -> None:
    script = f"""
import stickslip
try:
    stickslip.run({LONG!r}, 'long', threads=1)
except stickslip.Interrupted as interrupted:
    print('CAUGHT', interrupted)
    interrupted.run.resume()
"""
    seen, code = at_terminal(script, place, interrupt_after="░.*samples/s")
    assert code == 0, seen
    before, after = seen.split("CAUGHT")
    for bar in (before, after):
        assert "░" in bar and "samples/s" in bar
    assert seen.count("interrupted: saving what is finished") == 1
    # The message of the end is that of the exception, and is not shown besides.
    assert "samples are kept" not in before and "samples are kept; continue with" in after
    assert (place / "long" / "surface.parquet").is_file()


def test_an_error_at_a_terminal_is_said_once(place: Path) -> None:
    script = """
import stickslip
job = {"name": "x", "axes": {"preload": 7, "rotating_speed": 2000}, "criterion": {"kind": "eigenvalue"}}
try:
    stickslip.run(job)
except stickslip.JobError as error:
    print('CAUGHT', repr(str(error)))
job["axes"]["preload"] = 0.1
stickslip.run(job)
try:
    stickslip.run(job, threads=0)
except stickslip.UsageError as error:
    print('CAUGHT', repr(str(error)))
"""
    seen, code = at_terminal(script, place)
    assert code == 0, seen
    assert seen.count("7 is out of range") == 1
    assert "CAUGHT 'job:4:11: axes.preload: 7 is out of range" in seen
    assert seen.count("JobWarning: axes.rotating_speed = 2000 rad/s is not plausible") == 1
    assert "stickslip: warning" not in seen
    assert "CAUGHT \"invalid value '0' for 'threads': a number of threads is a whole number from 1 to 1024, for example 4\"" in seen
    assert "10,000 samples in" in seen


@pytest.mark.parametrize("columns", [60, 80, 100])
def test_the_bar_of_the_program_keeps_to_its_line(place: Path, columns: int) -> None:
    (place / "long.toml").write_text(tomli_w.dumps(LONG), encoding="utf-8")
    command = [str(stickslip.program()), "submit", "long.toml", "--threads=1"]
    seen, code = at_terminal(command, place, interrupt_after="( %  .*){4}left", columns=columns)
    assert code == 130
    drawn = [re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", line) for line in re.split(r"[\r\n]", seen)]
    bars = [line for line in drawn if " %  " in line]
    assert len(bars) > 3 and any("left" in bar for bar in bars), seen
    # What is not cut off and does not wrap; spaces fill the line.
    assert all(len(bar.replace("^C", "").rstrip()) <= columns - 3 for bar in bars), bars
    # The message takes the place of the bar.
    assert re.search(r"\r\x1b\[2Kstickslip: interrupted: saving", seen), seen
    assert not [line for line in seen.split("\r\n")[-4:] if " %  " in line.rsplit("\r", 1)[-1]], seen
