"""Models given by matrices that are arrays: the same results as from files, and what no matrix can be."""

from __future__ import annotations

import copy
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse

import stickslip

#: Two masses of Hoffmann, Fischer, Allgaier and Gaul (2002), critical at friction = 3/4.
HOFFMANN: dict[str, Any] = {
    "name": "hoffmann",
    "model": {
        "kind": "matrices",
        "mass": np.eye(2),
        "stiffness": [
            np.array([[2, 1], [1, 2]]),
            {"matrix": np.array([[0.0, -4.0 / 3.0], [0.0, 0.0]]), "factor": "friction"},
        ],
        "parameters": {"friction": 0.7},
    },
    "random": {"inputs": ["friction"], "relative_std": 0.1},
    "criterion": {"kind": "complex-eigenvalue"},
    "sampling": {"method": "exact"},
}
EXPECTED = 1.0 - NormalDist(0.7, 0.07).cdf(0.75)


@pytest.fixture
def hoffmann() -> dict[str, Any]:
    return copy.deepcopy(HOFFMANN)


def probability(job: dict[str, Any], out: str) -> float:
    return float(stickslip.run(job, out, progress=False).surface()["p_unstable"].item())


def as_sparse(job: dict[str, Any]) -> dict[str, Any]:
    model = job["model"]
    model["mass"] = {"matrix": sparse.csr_matrix(model["mass"])}
    model["stiffness"] = [
        sparse.coo_array(model["stiffness"][0]),
        {**model["stiffness"][1], "matrix": sparse.lil_matrix(model["stiffness"][1]["matrix"])},
    ]
    return job


def test_two_masses_have_the_probability_of_their_formula(hoffmann: dict[str, Any], place: Path) -> None:
    assert probability(hoffmann, "runs/dense") == pytest.approx(EXPECTED, abs=1e-8)
    assert not (place / "runs" / ".matrices").exists()
    assert stickslip.check(hoffmann)["cells"] == 1
    assert stickslip.analyse(job=hoffmann)["stable"]
    hoffmann["axes"] = {"friction": [0.5, 0.9]}
    limit = stickslip.limit(hoffmann, of="friction", probability=0.5)["limit"].item()
    assert limit == pytest.approx(0.75, abs=1e-6)


def test_sparse_matrices_stay_so_and_give_what_files_give(hoffmann: dict[str, Any], place: Path) -> None:
    by_array = probability(as_sparse(hoffmann), "runs/arrays")
    files = sorted((place / "runs" / ".matrices").iterdir())
    assert len(files) == 3 and all(sparse.load_npz(file).format == "csc" for file in files)
    model = hoffmann["model"]
    for name, matrix in (("M", model["mass"]["matrix"]), ("K", model["stiffness"][0])):
        sparse.save_npz(place / f"{name}.npz", matrix.tocsc())
    sparse.save_npz(place / "F.npz", model["stiffness"][1]["matrix"].tocsc())
    model["mass"] = {"file": "M.npz"}
    model["stiffness"] = [{"file": "K.npz"}, {"file": "F.npz", "factor": "friction"}]
    assert by_array == probability(hoffmann, "runs/files") == pytest.approx(EXPECTED, abs=1e-8)


def test_the_same_arrays_are_the_same_run_and_others_are_not(
    hoffmann: dict[str, Any], place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = stickslip.run(as_sparse(hoffmann))
    files = sorted((place / "runs" / ".matrices").iterdir())
    assert stickslip.run(hoffmann) == first
    assert "is finished already" in capsys.readouterr().err
    assert sorted((place / "runs" / ".matrices").iterdir()) == files
    hoffmann["model"]["mass"]["matrix"] = 2.0 * hoffmann["model"]["mass"]["matrix"]
    with pytest.raises(stickslip.JobError, match="holds a run of another job"):
        stickslip.run(hoffmann, first)
    assert stickslip.run(hoffmann) != first


def test_large_full_matrices_stand_in_a_file(place: Path) -> None:
    size = 30
    stiffness = np.diag(np.arange(1.0, size + 1.0))
    stiffness[:2, :2] = [[2, 1], [1, 2]]
    friction = np.zeros((size, size), order="F")
    friction[0, 1] = -4.0 / 3.0
    model = {**HOFFMANN["model"], "mass": np.eye(size)}
    model["stiffness"] = [stiffness, {"matrix": friction, "factor": "friction"}]
    assert probability({**HOFFMANN, "model": model}, "runs/large") == pytest.approx(EXPECTED, abs=1e-8)
    assert len(list((place / "runs" / ".matrices").glob("*.npz"))) == 3


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        (np.ones((2, 3)), "has the shape (2, 3); it must be square"),
        (np.ones(4), "has the shape (4,); it must be square"),
        (np.eye(3), "has 3 rows, that of model.mass has 2"),
        (np.eye(2) * 1j, "are of type complex128; they must be real numbers"),
        (sparse.eye(2, format="csr", dtype=complex), "are of type complex128; they must be real numbers"),
        (np.array([[1, None], [0, 1]]), "are of type object; they must be real numbers"),
        (np.array([[1.0, np.nan], [0.0, 1.0]]), "an entry of the matrix is not finite"),
        (np.ma.masked_equal(np.eye(2), 0), "is a masked array"),
    ],
)
def test_what_is_no_matrix_is_named_by_its_key(hoffmann: dict[str, Any], matrix: Any, said: str) -> None:
    hoffmann["model"]["stiffness"][1]["matrix"] = matrix
    with pytest.raises(stickslip.JobError) as caught:
        stickslip.check(hoffmann)
    assert str(caught.value).startswith("model.stiffness[1]: ") and said in str(caught.value)
    assert caught.value.code == "job-spec" and caught.value.exit_code == 65
