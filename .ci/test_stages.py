"""What .ci/stages.py reads from the output of cargo, pytest and the fault suite."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import stages

CARGO = """\
     Running unittests src/lib.rs (target/release/deps/core-8348ca7a80742723)
running 3 tests
test one::sound ... ok
test one::panics - should panic ... FAILED
test one::red ... FAILED

failures:

---- one::panics stdout ----
note: test did not panic as expected
---- one::red stdout ----
assertion failed

failures:
    one::panics
    one::red

test result: FAILED. 1 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.07s

error: test failed, to rerun pass `--lib`
     Running ../../tests/crash/main.rs (target/release/deps/crash-73660483e1969ded)

running 1 test
error: test failed, to rerun pass `--test crash`

Caused by:
  process didn't exit successfully: `crash-73660483e1969ded` (signal: 6, SIGABRT: process abort signal)
     Running ../../tests/whole/main.rs (target/release/deps/whole-e9be729b3f2bc181)

running 2 tests
test one::red ... ok
test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s
"""

PYTEST = """\
==================================== ERRORS ====================================
__________________________ ERROR at setup of test_set __________________________
E   RuntimeError: no fixture
=================================== FAILURES ===================================
_______________________________ TestA.test_method ______________________________
E   assert 1 == 2
__________________________________ test_p[b c] _________________________________
E   assert 'b c' == 1
=========================== short test summary info ============================
FAILED tests/python/test_x.py::TestA::test_method - assert 1 == 2
FAILED tests/python/test_x.py::test_p[b c] - AssertionError: assert 'b c' == 1
ERROR tests/python/test_x.py::test_set - RuntimeError: no fixture
============= 2 failed, 125 passed, 1 skipped, 1 error in 61.02s (0:01:01) =============
"""

FAULTS = """\
FAILED call-fails, limit, read 50 EIO: 'cannot ' is not said
  again: python3 tests/faults target/release/stickslip --seed 1
| kill -9 | until | 8 | 7 | 1 | 0 | 1 |
| read fails | limit | 53 | 22 | 30 | 1 | 8 |
| fault | kind of run | tries | same bytes | stated error | failed | seconds |
|---|---|---|---|---|---|---|
| kill -9 | until | 8 | 7 | 1 | 0 | 1 |
| read fails | limit | 53 | 22 | 30 | 1 | 8 |
seed 1, 195 s, 192 s of processors, 1 failed
"""


def read(text, code=2):
    return stages.ended("test", code, text.splitlines(), 61.4)


class Reading(unittest.TestCase):
    def test_cargo(self):
        stage = read(CARGO)
        self.assertEqual((stage.passed, stage.failed), (3, 3))
        self.assertEqual(stage.failures["src/lib.rs one::panics"], ["note: test did not panic as expected"])
        self.assertEqual(stage.failures["src/lib.rs one::red"], ["assertion failed"])
        self.assertIn("SIGABRT", stage.failures["tests/crash/main.rs"][-1])
        self.assertEqual(len(stage.failures), 3)

    def test_pytest(self):
        stage = read(PYTEST)
        self.assertEqual((stage.passed, stage.failed), (125, 3))
        of = "tests/python/test_x.py::"
        self.assertEqual(stage.failures[of + "TestA::test_method"], ["E   assert 1 == 2"])
        self.assertEqual(stage.failures[of + "test_p[b c]"], ["E   assert 'b c' == 1"])
        self.assertEqual(stage.failures[of + "test_set"], ["E   RuntimeError: no fixture"])

    def test_faults(self):
        stage = read(FAULTS)
        self.assertEqual((stage.passed, stage.failed), (60, 1))
        [(name, output)] = stage.failures.items()
        self.assertEqual(name, "call-fails, limit, read 50 EIO")
        self.assertEqual(len(output), 2)

    def test_a_target_that_fails_without_a_test_shows_its_last_lines(self):
        stage = read("\n".join(f"line {i}" for i in range(100)) + "\n\n")
        [output] = stage.failures.values()
        self.assertEqual((output[0], output[-1]), ("line 60", "line 99"))
        self.assertEqual(read("fine", 0).failures, {})

    def test_the_end_has_a_line_for_each_target_then_the_failed_tests(self):
        stage = read(CARGO)
        lines = list(stages.summary([stage, stage._replace(name="docs", code=0, passed=0, failed=0, failures={})]))
        self.assertEqual(lines[:2], ["FAILED  test     61 s      3 passed    3 failed", "ok      docs     61 s"])
        self.assertEqual(lines[2:4], ["\nFAILED test: src/lib.rs one::panics", "    note: test did not panic as expected"])

    def run_targets(self, makefile, *words):
        """What it prints for these targets."""
        with tempfile.TemporaryDirectory() as place:
            Path(place, "Makefile").write_text(makefile)
            # As .ci/run calls it, not a make that calls another.
            environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
            command = [sys.executable, "-B", str(Path(stages.__file__).resolve()), *words]
            return subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True, timeout=3600)

    def test_what_follows_a_red_target_runs_as_well(self):
        ran = self.run_targets("red:\n\t@echo broken; exit 3\ngreen:\n\t@echo done\n", "red", "green")
        self.assertEqual(ran.returncode, 1)
        last = ran.stdout[ran.stdout.index("\nFAILED") :]
        self.assertRegex(last, r"(?s)^\nFAILED  red .*\nok      green .*\nFAILED red: no test, but the target\n    broken\n")

    def test_targets_beside_others_begin_after_the_first_and_wait_for_none(self):
        # Each of the three lanes waits for the others.
        makefile = (
            "first:\n\t@sleep 0.2; touch first\n"
            "here:\n\t@ls first; touch here; until [ -e there ]; do sleep 0.01; done\n"
            "before:\n\t@ls first; exit 3\n"
            "there:\n\t@until [ -e here ] && [ -e third ]; do sleep 0.01; done; touch there; printf end\n"
            "third:\n\t@ls first; touch third; until [ -e there ]; do sleep 0.01; done\n"
        )
        ran = self.run_targets(makefile, "first", "here", "--beside", "before", "there", "--beside", "third")
        self.assertEqual(ran.returncode, 1)
        self.assertEqual(ran.stdout.splitlines().count("first"), 3)
        ends = ran.stdout[ran.stdout.index("\n\n") :].split()
        self.assertEqual(ends[:17:4], ["ok", "ok", "FAILED", "ok", "ok"])
        self.assertEqual(ends[1:18:4], ["first", "here", "before", "there", "third"])


if __name__ == "__main__":
    unittest.main()
