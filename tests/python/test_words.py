"""Messages of the program in the terms of the package."""

import pytest

from stickslip._words import in_python, remedy_in_python


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("continue it with `stickslip resume runs/a`", "continue it with `stickslip.Run('runs/a').resume()`"),
        ("`stickslip verify 'a b'` writes it", "`stickslip.Run('a b').verify()` writes it"),
        ("`stickslip limit` finds it", "`stickslip.limit(...)` finds it"),
        ("`stickslip status` says more", "`run.status()` says more"),
        (
            "Use --samples 1000, or choose another directory with --out",
            "Use samples=1000, or choose another directory with out=",
        ),
        ("choose --out or --disc-modes for it", "choose out= or disc_modes= for it"),
        ("replace it with --overwrite.", "replace it with overwrite=True."),
        ("submit it with `--out runs/a`", "submit it with `out='runs/a'`"),
        ("submit it with --out runs/a", "submit it with out= runs/a"),
        ("give `stickslip submit x --overwrite --out`", "give `stickslip submit x overwrite=True out=`"),
        ("--cell 9: the run has cells 0 to 3", "cell=9: the run has cells 0 to 3"),
        ("a value '0' for '--threads <N>': no", "a value '0' for 'threads': no"),
        ("--set pad.mass: no", "pad.mass: no"),
        ("give --engine=slurm", "give --engine=slurm"),
        ("`stickslip merge a` writes it", "`stickslip merge a` writes it"),
        ("a file --- of none", "a file --- of none"),
        ("a `b` c `", "a `b` c `"),
    ],
)
def test_commands_are_calls_and_options_are_arguments(text: str, wanted: str) -> None:
    assert in_python(text) == wanted


def test_remedies_are_commands_or_options() -> None:
    assert remedy_in_python("stickslip resume runs/a") == "stickslip.Run('runs/a').resume()"
    assert remedy_in_python("stickslip submit job.toml") == "stickslip.run(...)"
    assert remedy_in_python("--samples 1000") == "samples=1000"
    assert remedy_in_python("--out") == "out="
