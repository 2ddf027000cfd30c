"""The program on processors with other instructions than this one, by an emulator. GLIBC_TUNABLES hides instructions from
glibc alone: not from the program's own lanes, nor from the library that factorises full matrices."""

from __future__ import annotations

import platform
import subprocess
from pathlib import Path

import pytest
from conftest import output, tool

# With AVX2 and FMA, as this one has, and with SSE4.2 at most.
LIKE_THIS, OLDER = "Haswell", "Nehalem"

PAD = """
[axes]
rotating_speed = 15
preload = [0.05, 0.1, 0.2]
static_friction = [0.3, 0.4]
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
"""

CHAIN = """
[model]
kind = "matrices"
mass = { file = "mass.txt" }
damping = [{ file = "damping.txt" }]
stiffness = [{ file = "stiffness.txt" }, { file = "coupling.txt", factor = "friction" }]
[model.parameters]
friction = 0.42
[random]
inputs = ["friction"]
relative_std = 0.05
[sampling]
method = "exact"
audit = 2
[criterion]
kind = "complex-eigenvalue"
"""

JOBS = {
    "eigenvalues": PAD + '[criterion]\nkind = "eigenvalue"\n[sampling]\nsamples = 2000\n',
    "motions": PAD + '[criterion]\nkind = "time-domain"\ndisc = "rigid"\n[sampling]\nsamples = 20\n',
    "dense": CHAIN,
    # In a band from 0, as in others small matrices are proved to have their critical values by dense ones.
    "full": CHAIN + 'matrices = "full"\nfrequency = [0, 130]\n',
}


def chain(place: Path) -> None:
    """Writes the matrices of 16 masses in a row, of which friction couples some."""
    count = 16
    diagonal = {(i, i): 1.0 + 0.05 * i for i in range(count)}
    springs = {(i, i): 2.2e6 for i in range(count)}
    springs |= {(i, j): -1e6 for i in range(count) for j in (i - 1, i + 1) if 0 <= j < count}
    damping = {place: 1e-5 * value for place, value in springs.items()}
    # Far from the diagonal, so that factors have dense blocks.
    coupling = {(7 * k % count, (11 * k + 3) % count): 4e5 * (-1.0) ** k for k in range(20)}
    for name, matrix in [("mass", diagonal), ("damping", damping), ("stiffness", springs), ("coupling", coupling)]:
        lines = [f"{i + 1} {j + 1} {value}" for (i, j), value in sorted(matrix.items())]
        heading = f"%%MatrixMarket matrix coordinate real general\n{count} {count} {len(lines)}"
        (place / f"{name}.txt").write_text("\n".join([heading, *lines, ""]))


def said(folder: Path, place: Path, processor: str | None, *words: object) -> str:
    """What the program says on standard error, run by this processor or by an emulated one."""
    emulator = [] if processor is None else [tool("qemu-x86_64"), "-cpu", processor]
    command = [str(word) for word in (*emulator, folder / "bin" / "stickslip", *words)]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr


def surface(folder: Path, place: Path, name: str, processor: str | None) -> tuple[bytes, str]:
    """The surface of a job, and what was said."""
    run = place / f"{name}-{processor}"
    text = said(folder, place, processor, "submit", f"{name}.toml", "--out", run, "--threads", "1")
    return (run / "surface.parquet").read_bytes(), text


def reduction(folder: Path, place: Path, processor: str | None) -> tuple[bytes, str, str]:
    """The matrices of a reduction, its job, and what was said."""
    job = place / f"reduced-{processor}.toml"
    text = said(folder, place, processor, "reduce", "full.toml", "--vectors", "12", "--audit", "2", "--out", job.name)
    return job.with_suffix(".mat").read_bytes(), job.read_text(), text


def csv(folder: Path, run: Path) -> dict[str, float]:
    """The numbers of the only cell of a run."""
    out = run.with_suffix(".csv")
    output(folder / "bin" / "stickslip", "export", run, "--format", "csv", "--out", out)
    lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
    names, numbers = (line.split(",") for line in lines)
    return {name: float(number) for name, number in zip(names, numbers) if number != ""}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the jobs."""
    if platform.machine() != "x86_64":
        pytest.skip("the emulated processors are of x86-64")
    place = tmp_path_factory.mktemp("processors")
    chain(place)
    for name, text in JOBS.items():
        (place / f"{name}.toml").write_text(f'name = "{name}"\n{text}')
    return place


@pytest.mark.parametrize("name", ["eigenvalues", "motions", "dense"])
def test_an_older_processor_gives_the_same_bytes(folder: Path, place: Path, name: str) -> None:
    assert surface(folder, place, name, OLDER)[0] == surface(folder, place, name, None)[0]


def test_full_matrices_give_the_same_bytes_on_processors_with_avx2_and_nearly_the_same_on_others(
    folder: Path, place: Path
) -> None:
    here, text = surface(folder, place, "full", None)
    assert "AVX2" not in text
    assert surface(folder, place, "full", LIKE_THIS)[0] == here
    other, text = surface(folder, place, "full", OLDER)
    assert "lacks AVX2 or FMA" in text
    # The emulator hides instructions from the library that factorises, or this test compares nothing.
    assert other != here
    values = [csv(folder, place / f"full-{processor}") for processor in (None, OLDER)]
    assert 0.01 < values[0]["p_unstable"] < 0.99
    for column in ["p_unstable", "p_low", "p_high"]:
        assert abs(values[1][column] - values[0][column]) < 1e-11, column
    assert values[1]["n_audit_unstable"] == values[0]["n_audit_unstable"]


def test_a_reduction_with_other_last_digits_says_so(folder: Path, place: Path) -> None:
    here, job, text = reduction(folder, place, None)
    assert "AVX2" not in text + job
    matrices, job, text = reduction(folder, place, LIKE_THIS)
    assert matrices == here
    assert "AVX2" not in text + job
    matrices, job, text = reduction(folder, place, OLDER)
    # So its job is another one.
    assert matrices != here
    for words in (text, job):
        assert "lacks AVX2 or FMA" in words
        assert "the identity of the job" in words
