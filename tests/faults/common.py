"""What all rows of the fault suite share: jobs, commands with a time limit, and what must hold after a fault."""

import contextlib
import os
import random
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Callable, Iterable, NamedTuple, Optional

# Exit codes, as docs/reference/command-line.md lists them.
DONE, USAGE, JOB, CANNOT_CREATE, INPUT_OUTPUT, BUSY = 0, 64, 65, 73, 74, 75

# How a try ended: the run survived the fault, or said what was wrong and gave the same bytes when it was resumed.
SAME, STATED = "same bytes", "stated error"

KINDS = ("eigenvalue", "time-domain", "boundary", "until", "sobol")

_GRID = """preload = { from = 0.05, to = 0.30, points = 4 }
static_friction = { from = 0.28, to = 0.50, points = 3 }"""
_MAPPED_GRID = """preload = 0.1
static_friction = [0.38, 0.40]"""
_RIGID = 'kind = "time-domain"\ndisc = "rigid"\nstart = '

# Axes, standard deviation, criterion, and `[sampling]` of the larger and of the smaller job of each kind. A larger one
# takes some tenths of a second and writes several pieces.
_JOBS = {
    "eigenvalue": (_GRID, 0.2, 'kind = "eigenvalue"', ("samples = 300_000", "samples = 20_000")),
    "time-domain": (_GRID, 0.2, _RIGID + '"rest"', ("samples = 1500", "samples = 200")),
    "boundary": (
        _MAPPED_GRID,
        0.02,
        _RIGID + '"near-equilibrium"',
        ('samples = 20_000\nevaluate = "boundary"\naudit = 50', 'samples = 20_000\nevaluate = "boundary"\naudit = 10'),
    ),
    "until": (
        _GRID,
        0.2,
        _RIGID + '"rest"',
        (
            "until = { half_width = 0.05, confidence = 0.9, at_most = 4000 }",
            "until = { half_width = 0.2, confidence = 0.8, at_most = 1000 }",
        ),
    ),
    "sobol": (_GRID, 0.2, _RIGID + '"rest"', ('method = "sobol"\nsamples = 1024', 'method = "sobol"\nsamples = 128')),
}


def job(kind: str, small: bool = False, seed: int = 3) -> str:
    """The job of a kind of run."""
    grid, deviation, criterion, sampling = _JOBS[kind]
    return (
        f'name = "{kind}"\n\n[axes]\nrotating_speed = 15.0\n{grid}\n\n[random]\n'
        f'inputs = ["preload", "static_friction"]\nrelative_std = {deviation}\n\n[criterion]\n{criterion}\n\n'
        f"[sampling]\n{sampling[small]}\nseed = {seed}\n"
    )


class Failed(Exception):
    """What is promised does not hold."""


class Skipped(Exception):
    """A row cannot be tried on this machine."""


class Missed(Exception):
    """The fault came before the program began or after its end; the try does not count."""


def check(condition: object, message: str) -> None:
    if not condition:
        raise Failed(message)


def need(*tools: str) -> None:
    """Skips a row where a tool is missing. In continuous integration it fails then."""
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        raise (Failed if "CI" in os.environ else Skipped)(f"{', '.join(missing)} not installed")


def need_root() -> None:
    """Skips a row that only root can try."""
    if os.geteuid() != 0:
        raise Skipped("needs root")


class Ended(NamedTuple):
    """A command that has ended. A negative code is that of a signal."""

    code: int
    stdout: str
    stderr: str
    seconds: float

    def says(self, *texts: str) -> None:
        for text in texts:
            check(text in self.stderr, f"{text!r} is not said: {self.stderr.strip()!r}")


class Running:
    """A command under way."""

    def __init__(self, place: "Place", words: list, environment: Optional[dict], shown: str) -> None:
        self.place, self.shown, self.begun = place, shown, time.monotonic()
        self.process = subprocess.Popen(
            words,
            cwd=place.path,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        place.running.append(self.process)

    def is_alive(self) -> bool:
        return self.process.poll() is None

    def send(self, number: int) -> None:
        if self.is_alive():
            self.process.send_signal(number)

    def ended(self, expect: Optional[Iterable] = None) -> Ended:
        """Waits for the end, and checks the exit code if `expect` has some."""
        limit = self.place.suite.limit
        try:
            output = self.process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            end_group(self.process)
            raise Failed(f"`{self.shown}` does not end within {limit:.0f} s") from None
        stdout, stderr = (text.decode("utf-8", "replace") for text in output)
        ended = Ended(self.process.returncode, stdout, stderr, time.monotonic() - self.begun)
        self.place.history.append(f"{self.shown}  -> {ended.code}\n{stderr.rstrip()}".rstrip())
        for word in ("panicked", "internal error"):
            check(word not in stderr, f"a panic in `{self.shown}`: {stderr.strip()!r}")
        if expect is not None:
            codes = sorted(expect)
            check(ended.code in codes, f"`{self.shown}` ends with {ended.code}, not {codes}: {stderr.strip()!r}")
        return ended


def end_group(process: subprocess.Popen) -> None:
    """Ends a process that was started here, and those that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


class Reference(NamedTuple):
    """A run that was not disturbed."""

    surface: bytes
    seconds: float
    # Its run directory, and that of a run of which one of two shards has finished.
    whole: Path
    half: Path


class Place:
    """A directory of its own for one try, with the job of a kind of run."""

    def __init__(
        self, suite: "Suite", path: Path, kind: str, small: bool, chance: random.Random, attempt: int = 0
    ) -> None:
        self.suite, self.path, self.kind, self.small, self.random, self.attempt = (
            suite, path, kind, small, chance, attempt
        )
        self.run = path / "run"
        self.history: list = []
        self.running: list = []
        path.mkdir(parents=True)
        path.chmod(0o777)
        (path / "job.toml").write_text(job(kind, small))

    @property
    def reference(self) -> Reference:
        return self.suite.reference(self.kind, self.small)

    def copy_of(self, run: Path) -> None:
        """Puts a copy of a run in place of the run of this try."""
        shutil.rmtree(self.run, ignore_errors=True)
        shutil.copytree(run, self.run, symlinks=True)

    def start(self, *words: object, before: Iterable = (), environment: Optional[dict] = None) -> Running:
        """Starts stickslip; `before` are the words of a command that starts it, such as `strace`."""
        line = [*map(str, before), str(self.suite.program), *map(str, words)]
        shown = " ".join([*map(str, before), "stickslip", *map(str, words)])
        return Running(self, line, environment, shown)

    def stickslip(
        self, *words: object, before: Iterable = (), environment: Optional[dict] = None, expect: Iterable = (DONE,)
    ) -> Ended:
        """Runs stickslip to its end."""
        return self.start(*words, before=before, environment=environment).ended(expect)

    def submit(self, **options: object) -> Ended:
        return self.stickslip("submit", "job.toml", "--out", "run", "--threads", self.threads(), **options)

    def shell(self, line: str, expect: Optional[Iterable] = (DONE,)) -> Ended:
        """Runs a line of the shell in which $S is stickslip."""
        environment = dict(os.environ, S=str(self.suite.program))
        return Running(self, ["sh", "-c", line], environment, f"sh -c {line!r}").ended(expect)

    def wait(self, part: float = 1.0) -> None:
        """Waits for a random moment in (this part of) the time that the job takes, earlier if that was too late."""
        time.sleep(self.random.uniform(0, part * self.reference.seconds * 0.6**self.attempt))

    def threads(self) -> int:
        return self.random.randint(1, 3)

    def pieces(self) -> set:
        """Everything that is finished: pieces of samples and tiles."""
        return {path.relative_to(self.run) for path in self.run.glob("*/*.jsonl")}

    def samples_done(self) -> Optional[int]:
        """The samples that `status` counts; none if there is no run yet."""
        if not (self.run / "job.toml").exists():
            return None
        found = re.search(r'"samples_done": (\d+)', self.stickslip("status", "run", "--json").stdout)
        check(found, "status --json does not hold samples_done")
        return int(found.group(1))

    def same_bytes(self) -> str:
        surface = (self.run / "surface.parquet").read_bytes()
        check(surface == self.reference.surface, "the surface has other bytes than that of an undisturbed run")
        return SAME

    def finish(self, outcome: str = STATED, remove: Iterable = ()) -> str:
        """Goes on as the messages say; everything that was finished must count, and the surface be the same."""
        kept, done = self.pieces() - set(remove), self.samples_done()
        if done is None:
            ended = self.submit()
        else:
            ended = self.stickslip("resume", "run", "--threads", self.threads())
        check(kept <= self.pieces(), f"finished pieces are gone: {sorted(map(str, kept - self.pieces()))}")
        self.same_bytes()
        computed = re.search(r"([\d,]+) samples? in ", ended.stderr)
        if done is not None and self.kind != "until":
            total, new = self.samples_done(), int(computed.group(1).replace(",", "")) if computed else 0
            check(done + new == total, f"{done} samples were finished, {new} were computed, there are {total}")
        self.sound()
        return outcome

    def tidy(self) -> None:
        """No unfinished files are left."""
        left = sorted(path.name for path in self.path.rglob(".unfinished-*"))
        check(not left, f"unfinished files are left: {left}")

    def sound(self) -> None:
        """`verify` finds nothing to repair."""
        said = self.stickslip("verify", "run", "--json").stdout
        check('"state": "sound"' in said and "mended" not in said, f"verify finds more: {said}")

    def wait_for(self, condition: Callable, running: Running, what: str) -> None:
        """Waits until something is there, or raises [`Missed`] if the command ends before."""
        begun = time.monotonic()
        while not condition():
            if not running.is_alive():
                raise Missed(f"the run ended before {what}")
            check(time.monotonic() - begun < self.suite.limit, f"{what} does not come")
            time.sleep(0.001)

    def end(self) -> None:
        """Ends what still runs, and removes the directory."""
        for process in self.running:
            if process.poll() is None:
                end_group(process)
        shutil.rmtree(self.path, ignore_errors=True)


class Try(NamedTuple):
    """One fault in one run."""

    kind: str
    label: str
    act: Callable
    small: bool = False


class Row(NamedTuple):
    """A row of the table."""

    name: str
    fault: str
    tries: Callable
    # Whether a fault comes at a random moment, and so may come too late: then it is tried again.
    is_timed: bool = False


class Suite:
    """What all tries share."""

    def __init__(self, program: Path, scratch: Path, seed: int, is_full: bool, limit: float) -> None:
        self.seed, self.scratch, self.is_full = seed, scratch, is_full
        # Seconds after which a command counts as hanging.
        self.limit = limit
        scratch.chmod(0o755)
        # A copy, as the program may be built again meanwhile, and for users who cannot read the folder of the build.
        self.program = scratch / "stickslip"
        shutil.copy2(program, self.program)
        self.program.chmod(0o755)
        self.references: dict = {}
        self.count = 0

    def many(self, quick: int, full: int) -> int:
        return full if self.is_full else quick

    def steps(self, count: int, quick: int, chance: random.Random) -> list:
        """All of the numbers below `count`, or a seeded sample of them that has the first and the last."""
        if self.is_full or count <= quick:
            return list(range(count))
        return sorted({0, count - 1, *chance.sample(range(count), quick - 2)})

    def chance(self, *names: object) -> random.Random:
        """Random numbers of their own for everything that has a name."""
        return random.Random("/".join(map(str, (self.seed, *names))))

    def place(self, row: str, chosen: Try, attempt: int) -> Place:
        self.count += 1
        chance = self.chance(row, chosen.kind, chosen.label, attempt)
        return Place(self, self.scratch / f"try-{self.count}", chosen.kind, chosen.small, chance, attempt)

    def reference(self, kind: str, small: bool = False) -> Reference:
        """The undisturbed run of a kind."""
        if (kind, small) not in self.references:
            path = self.scratch / f"reference-{kind}-{'small' if small else 'large'}"
            place = Place(self, path, kind, small, random.Random(0))
            place.stickslip("submit", "job.toml", "--out", "half", "--threads", 1, "--shard", "1/2")
            ended = place.stickslip("submit", "job.toml", "--out", "run", "--threads", 1)
            surface = (place.run / "surface.parquet").read_bytes()
            self.references[kind, small] = Reference(surface, ended.seconds, place.run, path / "half")
        return self.references[kind, small]
