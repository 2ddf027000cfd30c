"""Runs targets of the Makefile one after the other, whatever fails, and says at the end what failed.

Usage: stages.py TARGET [TARGET ...] [--beside TARGET [TARGET ...]] ...

Those after each --beside begin when the first target has ended, and run beside the others, one after the other as well.

What the targets print is passed on as it comes, in whole lines. Then follow one line for each target (name, seconds,
passed, failed) and, for each failed test, its name and its last lines. The exit code is 1 if anything failed.
"""

import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Dict, Iterator, List, NamedTuple, Tuple

# Lines that are shown of a failed test, or of a target that failed without one.
LAST = 40

# What cargo, pytest and the fault suite print: the results of a program, where the output of a failed test begins or
# ends, and the names of failed tests. The fault suite prints its rows twice.
CARGO_PROGRAM = re.compile(r"^ +(?:Running|Doc-tests) (?:unittests )?(?:\.\./)*(\S+)")
CARGO_RESULT = re.compile(r"^test result: \S+ (\d+) passed; (\d+) failed;")
CARGO_OUTPUT = re.compile(r"^---- (.+) std(?:out|err) ----$")
CARGO_FAILED = re.compile(r"^test (.+?)(?: - should panic)? \.\.\. FAILED$")
CARGO_CRASHED = re.compile(r"^  process didn't exit successfully: ")
PYTEST_RESULT = re.compile(r"^=*.*\b\d+ (?:passed|failed|errors?)\b.* in [\d.]+s")
PYTEST_OUTPUT = re.compile(r"^_+ (?:ERROR (?:at \w+ of|collecting) )?(.+?) _+$")
PYTEST_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+\.py)(?:::(.+?))?(?: - .*)?$")
FAULTS_RESULT = re.compile(r"^\| .+ \| .+ \| \d+ \| (\d+) \| (\d+) \| (\d+) \| \d+ \|$")
FAULTS_FAILED = re.compile(r"^FAILED ([\w-]+(?:, [^:]+)?): ")
END_OF_OUTPUT = re.compile(r"^(?:failures:|test result: |\| |=====)")


class Stage(NamedTuple):
    """How a target ended."""

    name: str
    seconds: float
    code: int
    passed: int
    failed: int
    # The last lines of each failed test, by its name.
    failures: Dict[str, List[str]]


def main(words: List[str]) -> int:
    first, *others = words
    lanes: List[List[str]] = [[]]
    for word in others:
        if word == "--beside":
            lanes.append([])
        else:
            lanes[-1].append(word)
    stages = [run(first)]
    with ThreadPoolExecutor(len(lanes)) as pool:
        for lane in list(pool.map(lambda lane: [run(target) for target in lane], lanes)):
            stages += lane
    print("\n" + "\n".join(summary(stages)), flush=True)
    return 1 if any(stage.code for stage in stages) else 0


def run(target: str) -> Stage:
    """Runs a target, and passes on what it prints."""
    pass_on(f"== make {target}\n".encode())
    begun, lines = time.monotonic(), []
    words = ["make", target]
    process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    for line in process.stdout or ():
        pass_on(line.rstrip(b"\n") + b"\n")
        lines.append(line.decode("utf-8", "replace").rstrip("\n"))
    return ended(target, process.wait(), lines, time.monotonic() - begun)


def pass_on(line: bytes) -> None:
    """Writes a line at once, whole beside those of other targets."""
    sys.stdout.buffer.write(line)
    sys.stdout.buffer.flush()


def ended(target: str, code: int, lines: List[str], seconds: float) -> Stage:
    """How a target ended, by its lines."""
    passed, failed = counts(lines)
    failures = {name: cut(output) for name, output in failed_tests(lines)}
    # A program that crashes does not count its tests.
    failed = max(failed, len(failures))
    if code and not failures:
        failures = {"no test, but the target": cut(lines)}
    return Stage(target, seconds, code, passed, failed, failures)


def counts(lines: List[str]) -> Tuple[int, int]:
    """How many tests passed and how many failed."""
    passed = failed = 0
    rows = {}
    for line in lines:
        if match := CARGO_RESULT.match(line):
            passed, failed = passed + int(match[1]), failed + int(match[2])
        elif match := FAULTS_RESULT.match(line):
            rows[line] = match
        elif PYTEST_RESULT.match(line):
            passed += sum(map(int, re.findall(r"(\d+) passed", line)))
            failed += sum(map(int, re.findall(r"(\d+) (?:failed|error)", line)))
    for match in rows.values():
        passed, failed = passed + int(match[1]) + int(match[2]), failed + int(match[3])
    return passed, failed


def failed_tests(lines: List[str]) -> Iterator[Tuple[str, List[str]]]:
    """The names of failed tests, each with what it printed."""
    program = ""
    outputs: Dict[str, List[str]] = {}
    names: Dict[str, str] = {}
    output: List[str] = []
    for line in lines:
        if match := CARGO_PROGRAM.match(line):
            program, output = match[1], []
        elif match := CARGO_FAILED.match(line):
            names[f"{program} {match[1]}"] = f"{program} {match[1]}"
        elif match := CARGO_OUTPUT.match(line):
            output = outputs.setdefault(f"{program} {match[1]}", [])
        elif CARGO_CRASHED.match(line):
            names[program] = program
            outputs[program] = [*output, line]
        elif match := PYTEST_OUTPUT.match(line):
            output = outputs.setdefault(match[1], [])
        elif match := PYTEST_FAILED.match(line):
            # The output of a test of a class begins with their names and a dot between them.
            test = match[2].replace("::", ".", 1) if match[2] else match[1]
            names[f"{match[1]}::{match[2]}" if match[2] else match[1]] = test
        elif match := FAULTS_FAILED.match(line):
            names[match[1]] = match[1]
            output = outputs.setdefault(match[1], [])
            output.append(line)
        elif END_OF_OUTPUT.match(line):
            output = []
        else:
            output.append(line)
    for name, where in names.items():
        yield name, outputs.get(where, ["it printed nothing"])


def cut(lines: List[str]) -> List[str]:
    """The last lines, without empty ones at both ends."""
    return "\n".join(lines).strip("\n").split("\n")[-LAST:]


def summary(stages: List[Stage]) -> Iterator[str]:
    """A line for each target, then the failed tests."""
    width = max(len(stage.name) for stage in stages)
    for stage in stages:
        tests = f"{stage.passed:5} passed {stage.failed:4} failed" if stage.passed or stage.failed else ""
        yield f"{'FAILED' if stage.code else 'ok':6}  {stage.name:{width}}  {stage.seconds:5.0f} s  {tests}".rstrip()
    for stage in stages:
        for name, output in stage.failures.items():
            yield f"\nFAILED {stage.name}: {name}"
            yield from (f"    {line}" for line in output)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
