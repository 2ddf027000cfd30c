"""The kinds of run that are disturbed: the job of each, and what it writes."""

from pathlib import Path
from typing import NamedTuple


class Kind(NamedTuple):
    """A kind of run, by the tables of its job."""

    axes: str
    criterion: str
    # `[sampling]` of the larger and of the smaller job. A larger one takes some tenths of a second and writes several
    # pieces.
    sampling: tuple
    random: str = 'inputs = ["preload", "static_friction"]\nrelative_std = 0.2'
    model: str = ""
    # Further tables.
    rest: str = ""
    # `[sampling]` of a run that has finished before, and is extended.
    first: tuple = ()
    # Pairs of masses in files of matrices beside the job; 0 where there are no files.
    pairs: int = 0
    # What computes it. A command other than `submit` keeps nothing but its results, and is begun anew.
    command: str = "submit job.toml --out {out} --threads {threads}"
    # What it writes in the directory `out`.
    results: tuple = ("surface.parquet",)

    @property
    def is_run(self) -> bool:
        return self.command.startswith("submit")

    @property
    def files(self) -> list:
        """The names of files beside the job."""
        return [f"{name}.mtx" for name in _PAIR] if self.pairs else []

    def write(self, path: Path, name: str, sampling: str, seed: int) -> None:
        """Writes its job, with another `[sampling]`, and the files that this names."""
        tables = [f'name = "{name}"', self.model, f"[axes]\n{self.axes}", f"[random]\n{self.random}"]
        tables += [f"[criterion]\n{self.criterion}", f"[sampling]\n{sampling}\nseed = {seed}", self.rest]
        path.write_text("\n\n".join(tables) + "\n")
        for file, block in zip(self.files, _PAIR.values()):
            (path.parent / file).write_text(_matrix_market(block, self.pairs, file in ("K.mtx", "F.mtx")))


_GRID = """rotating_speed = 15.0
preload = { from = 0.05, to = 0.30, points = 4 }
static_friction = { from = 0.28, to = 0.50, points = 3 }"""
_SOME_CELLS = "rotating_speed = 15.0\nstatic_friction = 0.39\npreload = "
_EIGENVALUE = 'kind = "eigenvalue"'
_RIGID = 'kind = "time-domain"\ndisc = "rigid"\nstart = "rest"'
_THREE_INPUTS = 'inputs = ["preload", "static_friction", "friction.kinetic_coefficient"]\nrelative_std = 0.1'
_RARE_CELLS = "rotating_speed = 15.0\nstatic_friction = 0.35\npreload = [0.03, 0.05]"
_RARE = 'inputs = ["preload", "static_friction"]\nrelative_std = 0.1'

# Two masses that flutter above a friction of 3/4 (Hoffmann, Fischer, Allgaier, Gaul 2002), with little damping: mass, damping,
# stiffness and friction of each pair.
_PAIR = {
    "M": [[1.0, 0.0], [0.0, 1.0]],
    "C": [[0.001, 0.0], [0.0, 0.001]],
    "K": [[2.0, 1.0], [1.0, 2.0]],
    "F": [[0.0, -4 / 3], [0.0, 0.0]],
}
_MODEL = '[model]\nkind = "matrices"\n{}\n\n[model.parameters]\nfriction = 0.6'
_INLINE = _MODEL.format(
    "mass = {{ matrix = {M} }}\ndamping = {{ matrix = {C} }}\n"
    'stiffness = [{{ matrix = {K} }}, {{ matrix = {F}, factor = "friction" }}]'.format(**_PAIR)
)
_OF_FILES = _MODEL.format(
    'mass = { file = "M.mtx" }\ndamping = { file = "C.mtx" }\n'
    'stiffness = [{ file = "K.mtx" }, { file = "F.mtx", factor = "friction" }]'
)
_OF_MATRICES = {
    "axes": "friction = { from = 0.6, to = 0.9, points = 4 }",
    "criterion": 'kind = "complex-eigenvalue"\nfrequency = [0.1, 0.4]',
    "random": 'inputs = ["friction"]\nrelative_std = 0.1',
}


def _matrix_market(block: list, pairs: int, grows: bool) -> str:
    """A matrix with a block for each pair. Stiffness and friction grow from pair to pair, so that frequencies differ."""
    entries = [
        f"{2 * pair + row + 1} {2 * pair + column + 1} {block[row][column] * (1 + 0.1 * pair if grows else 1)!r}"
        for pair in range(pairs)
        for row in range(2)
        for column in range(2)
        if block[row][column]
    ]
    size = 2 * pairs
    head = f"%%MatrixMarket matrix coordinate real general\n{size} {size} {len(entries)}"
    return "\n".join([head, *entries]) + "\n"


TABLE = {
    "eigenvalue": Kind(_GRID, _EIGENVALUE, ("samples = 300_000", "samples = 20_000")),
    "time-domain": Kind(_GRID, _RIGID, ("samples = 1500", "samples = 200")),
    "boundary": Kind(
        "preload = 0.1\nrotating_speed = 15.0\nstatic_friction = [0.38, 0.40]",
        _RIGID.replace("rest", "near-equilibrium"),
        tuple(f'samples = 20_000\nevaluate = "boundary"\naudit = {audit}' for audit in (50, 10)),
        random='inputs = ["preload", "static_friction"]\nrelative_std = 0.02',
    ),
    "until": Kind(
        _GRID,
        _RIGID,
        (
            "until = { half_width = 0.05, confidence = 0.9, at_most = 4000 }",
            "until = { half_width = 0.2, confidence = 0.8, at_most = 1000 }",
        ),
    ),
    "sobol": Kind(_GRID, _RIGID, tuple(f'method = "sobol"\nsamples = {count}' for count in (1024, 128))),
    "importance": Kind(
        _RARE_CELLS,
        _RIGID,
        tuple(f'method = "importance"\nsamples = {samples}\nparticles = 100' for samples in (4096, 256)),
        random=_RARE,
    ),
    "subset": Kind(
        _RARE_CELLS,
        _RIGID,
        tuple(f'method = "subset"\nparticles = 100\nrandomisations = {count}' for count in (8, 4)),
        random=_RARE,
    ),
    "conditional": Kind(
        _GRID,
        _EIGENVALUE,
        tuple(f'method = "conditional"\nsamples = {samples}' for samples in (1024, 256)),
        random=_THREE_INPUTS,
    ),
    "limit": Kind(
        _SOME_CELLS + "[0.05, 0.1, 0.3]",
        _EIGENVALUE,
        tuple(f'method = "conditional"\nsamples = {samples}' for samples in (256, 64)),
        random=_THREE_INPUTS,
        rest='[limit]\nof = "preload"\nprobability = 0.1',
        results=("surface.parquet", "limits.parquet"),
    ),
    "extension": Kind(
        _SOME_CELLS + "[0.05, 0.1, 0.2]",
        _RIGID,
        ("samples = 5500", "samples = 1600"),
        first=("samples = 2500", "samples = 500"),
    ),
    "matrices": Kind(**_OF_MATRICES, model=_INLINE, sampling=("samples = 40_000", "samples = 1500")),
    "matrix-files": Kind(**_OF_MATRICES, model=_OF_FILES, pairs=5, sampling=("samples = 2000", "samples = 200")),
    "reduction": Kind(
        **_OF_MATRICES,
        model=_OF_FILES,
        pairs=20,
        sampling=("samples = 2000",) * 2,
        command="reduce job.toml --vectors 12 --audit 20 --out {out}/reduced.toml",
        results=("reduced.toml", "reduced.mat"),
    ),
}

# The names of all kinds.
KINDS = tuple(TABLE)
# Those with a run directory, and those of which nothing is there before.
RUNS = tuple(name for name, kind in TABLE.items() if kind.is_run)
NEW_RUNS = tuple(name for name in RUNS if not TABLE[name].first)
