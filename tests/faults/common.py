"""What all rows of the fault suite share: jobs, commands with a time limit, and what must hold after a fault."""

import contextlib
import filecmp
import itertools
import math
import os
import random
import re
import shutil
import signal
import subprocess
import threading
import time
from pathlib import Path
from typing import Callable, Iterable, NamedTuple, Optional, Sequence

from kinds import KINDS, TABLE, Kind

# Exit codes, as docs/reference/command-line.md lists them.
DONE, USAGE, JOB, CANNOT_CREATE, INPUT_OUTPUT, BUSY = 0, 64, 65, 73, 74, 75

# Without --all, a row is tried with so many kinds of run, which its name and the seed choose.
KINDS_OF_A_ROW = 5

# Folders of pieces of a run.
PIECES = ("shards", "map", "audit", "searches")

# How a try ended: the run survived the fault, or said what was wrong and gave the same bytes when it was resumed.
SAME, STATED = "same bytes", "stated error"

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


def copy_of_program(program: Path, to: Path) -> None:
    """Waits for a program that is away, since a Python package that is built meanwhile moves it for some seconds."""
    until = time.monotonic() + 60
    while True:
        try:
            shutil.copy2(program, to)
            break
        except FileNotFoundError:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)
    to.chmod(0o755)


class Ended(NamedTuple):
    """A command that has ended. A negative code is that of a signal."""

    code: int
    stdout: str
    stderr: str

    def says(self, *texts: str) -> None:
        for text in texts:
            check(text in self.stderr, f"{text!r} is not said: {self.stderr.strip()!r}")


class Running:
    """A command under way."""

    def __init__(self, place: "Place", words: list, environment: Optional[dict], shown: str) -> None:
        self.place, self.shown = place, shown
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

    def work(self) -> float:
        """Seconds that it has had on processors so far, until its end is waited for."""
        # As Linux numbers the clock of another process.
        return time.clock_gettime(~self.process.pid << 3 | 2)

    def work_until(self, moment: float = math.inf) -> float:
        """Waits until it has worked so many seconds, or has ended; what it had done then."""
        begun, work = time.monotonic(), 0.0
        while work < moment and self.is_alive():
            check(time.monotonic() - begun < self.place.suite.limit, f"`{self.shown}` neither works nor ends")
            work = self.work()
            time.sleep(0.001)
        return work

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
        ended = Ended(self.process.returncode, stdout, stderr)
        self.place.history.append(f"{self.shown}  -> {ended.code}\n{stderr.rstrip()}".rstrip())
        for word in ("panicked", "internal error"):
            check(word not in stderr, f"a panic in `{self.shown}`: {stderr.strip()!r}")
        if expect is not None:
            codes = sorted(expect)
            check(ended.code in codes, f"`{self.shown}` ends with {ended.code}, not {codes}: {stderr.strip()!r}")
        return ended


def watches_for_signals(process: int) -> bool:
    """Whether a process has a handler of SIGTERM."""
    with contextlib.suppress(OSError):
        caught = re.search(r"^SigCgt:\s*([0-9a-f]+)", Path(f"/proc/{process}/status").read_text(), re.MULTILINE)
        return caught is not None and bool(int(caught.group(1), 16) >> (signal.SIGTERM - 1) & 1)
    return False


def end_group(process: subprocess.Popen) -> None:
    """Ends a process that was started here, and those that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


class Reference(NamedTuple):
    """A run that was not disturbed."""

    # The bytes of its results, by their names.
    results: dict
    # Seconds on processors.
    work: float
    # Its run directory, that of a run of which one of two shards has finished, and the finished run that is extended. Only
    # the first is there of every kind.
    whole: Path
    half: Optional[Path]
    first: Optional[Path]


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
        self.write_job("job.toml")

    @property
    def table(self) -> Kind:
        return TABLE[self.kind]

    @property
    def reference(self) -> Reference:
        return self.suite.reference(self.kind, self.small)

    def write_job(self, name: str, kind: Optional[str] = None, seed: int = 3, is_first: bool = False) -> None:
        """Writes a job of this kind, or of another one, and the files that it names."""
        kind = kind or self.kind
        sampling = TABLE[kind].first if is_first else TABLE[kind].sampling
        TABLE[kind].write(self.path / name, kind, sampling[self.small], seed)

    def prepare(self) -> None:
        """Puts in place what is there before the fault: the run that is extended, or the directory of the results."""
        if self.table.first:
            self.copy_of(self.reference.first)
        elif not self.table.is_run:
            self.run.mkdir()

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

    def words(self, threads: object = None) -> list:
        """The words by which it is computed."""
        out = self.run.relative_to(self.path)
        return self.table.command.format(out=out, threads=threads or self.threads()).split()

    def begin(self, threads: object = None, **options: object) -> Running:
        """Starts to compute it."""
        return self.start(*self.words(threads), **options)

    def go_on(self, threads: object = None, **options: object) -> Running:
        """Begins it, or resumes it if it has begun."""
        if not self.table.is_run:
            self.begin_anew()
        elif self.has_begun():
            return self.start("resume", "run", "--threads", threads or self.threads(), **options)
        return self.begin(threads, **options)

    def begin_anew(self) -> None:
        """What a command has written is whole, or is not there; if everything is there, it may be written again."""
        written = {name for name in self.table.results if (self.run / name).exists()}
        for name in written:
            check((self.run / name).read_bytes() == self.reference.results[name], f"{name} is there with other bytes")
        if len(written) == len(self.table.results):
            for name in written:
                (self.run / name).unlink()

    def has_begun(self) -> bool:
        """Whether the job is in its run directory."""
        job = self.run / "job.toml"
        if not job.exists():
            return False
        return not self.table.first or not filecmp.cmp(job, self.reference.first / "job.toml", shallow=False)

    def wait_for_work(self, running: Running) -> None:
        """Waits until a run has its job in its directory, or another command watches for signals."""
        ready = self.has_begun if self.table.is_run else lambda: watches_for_signals(running.process.pid)
        self.wait_for(ready, running, "the job")

    def says_how_to_go_on(self, ended: Ended) -> None:
        if self.table.is_run:
            ended.says("continue with `stickslip resume run`")

    def shell(self, line: str, expect: Optional[Iterable] = (DONE,)) -> Ended:
        """Runs a line of the shell in which $S is stickslip."""
        environment = dict(os.environ, S=str(self.suite.program))
        return Running(self, ["sh", "-c", line], environment, f"sh -c {line!r}").ended(expect)

    def wait(self, running: Running, part: float = 1.0) -> None:
        """Waits for a random moment in (this part of) the work that the job takes, earlier if that was too late."""
        running.work_until(self.random.uniform(0, part * self.reference.work * 0.6**self.attempt))

    def threads(self) -> int:
        return self.random.randint(1, 3)

    def pieces(self) -> set:
        """Everything that is finished, but what is found of limits: that is removed when they are written."""
        return {path.relative_to(self.run) for folder in PIECES for path in self.run.glob(f"{folder}/*.jsonl")}

    def samples_done(self) -> Optional[int]:
        """The samples that `status` counts; none if there is no run yet."""
        if not self.table.is_run or not (self.run / "job.toml").exists():
            return None
        found = re.search(r'"samples_done": (\d+)', self.stickslip("status", "run", "--json").stdout)
        check(found, "status --json does not hold samples_done")
        return int(found.group(1))

    def same_bytes(self) -> str:
        for name, expected in self.reference.results.items():
            check((self.run / name).read_bytes() == expected, f"{name} has other bytes than that of an undisturbed run")
        return SAME

    def finish(self, outcome: str = STATED, remove: Iterable = ()) -> str:
        """Goes on as the messages say; everything that was finished must count, and the results be the same."""
        kept, done = self.pieces() - set(remove), self.samples_done()
        if not self.table.is_run and not self.run.exists():
            self.prepare()
        ended = self.go_on().ended({DONE})
        check(kept <= self.pieces(), f"finished pieces are gone: {sorted(map(str, kept - self.pieces()))}")
        self.same_bytes()
        if not self.table.is_run:
            return outcome
        computed = re.search(r"([\d,]+) samples? in [\d.]+ s on ", ended.stderr)
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

    def __init__(
        self, program: Path, scratch: Path, seed: int, is_full: bool, limit: float, kind: Optional[str] = None
    ) -> None:
        self.seed, self.scratch, self.is_full, self.kind = seed, scratch, is_full, kind
        # Seconds after which a command counts as hanging.
        self.limit = limit
        scratch.chmod(0o755)
        # A copy, as the program may be built again meanwhile, and for users who cannot read the folder of the build.
        self.program = scratch / "stickslip"
        copy_of_program(program, self.program)
        # The rows of a suite are made side by side.
        self.lock = threading.Lock()
        self.references: dict = {}
        self.numbers = itertools.count(1)
        # Whether no further try is begun.
        self.is_ending = False

    def kinds(self, row: str, among: Sequence = KINDS) -> list:
        """The kinds of run that a row is tried with: all, or a seeded sample of them, or the one that was asked for."""
        if self.kind is not None:
            return [kind for kind in among if kind == self.kind]
        if self.is_full:
            return list(among)
        sample = self.chance("kinds", row).sample(among, KINDS_OF_A_ROW)
        return [kind for kind in among if kind in sample]

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
        if self.is_ending:
            raise SystemExit
        chance = self.chance(row, chosen.kind, chosen.label, attempt)
        place = Place(self, self.scratch / f"try-{next(self.numbers)}", chosen.kind, chosen.small, chance, attempt)
        place.prepare()
        return place

    def reference(self, kind: str, small: bool = False) -> Reference:
        """The undisturbed run of a kind."""
        with self.lock:
            if (kind, small) not in self.references:
                self.references[kind, small] = self.undisturbed(kind, small)
            return self.references[kind, small]

    def undisturbed(self, kind: str, small: bool) -> Reference:
        """Computes it, and what some rows begin with."""
        path = self.scratch / f"reference-{kind}-{'small' if small else 'large'}"
        place = Place(self, path, kind, small, self.chance("reference", kind, small))
        first = half = None
        if place.table.first:
            first = path / "first"
            place.write_job("first.toml", is_first=True)
            place.stickslip("submit", "first.toml", "--out", "first", "--threads", 1)
        if not place.table.is_run:
            place.prepare()
        running = place.begin(threads=1)
        work = running.work_until()
        running.ended({DONE})
        results = {name: (place.run / name).read_bytes() for name in place.table.results}
        if place.table.is_run:
            half = path / "half"
            self.make_half(place, half, first, work)
        return Reference(results, work, place.run, half, first)

    @staticmethod
    def make_half(place: Place, half: Path, first: Optional[Path], work: float) -> None:
        """Computes one of two shards. A search for rare events is stopped besides, so that there are answers of it."""
        shard = ["submit", "job.toml", "--out", "half", "--threads", 1, "--shard"]
        while True:
            shutil.rmtree(half, ignore_errors=True)
            if first is not None:
                shutil.copytree(first, half)
            place.stickslip(*shard, "1/2")
            if not (half / "searches").exists():
                return
            running = place.start(*shard, "2/2")
            running.work_until(place.random.uniform(0, work))
            running.send(signal.SIGTERM)
            running.ended()
            if any((half / "searches").iterdir()):
                return
