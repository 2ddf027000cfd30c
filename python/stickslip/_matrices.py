"""Matrices of a job that are arrays: checked, and written to files where they are sparse or large."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ._errors import job_error

#: Full matrices with more entries stand in a file.
_MOST_ENTRIES_IN_JOB = 400


def with_files(job: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """The job with its arrays as rows, or as files in a folder, each named by the digest of its content.

    Raises
    ------
    JobError
        If an array is no real, finite, square matrix, or their sizes differ.
    """
    model = job.get("model")
    if not isinstance(model, Mapping) or model.get("kind") != "matrices":
        return job
    done = dict(model)
    for key in ("mass", "damping", "stiffness"):
        value = done.get(key)
        if isinstance(value, (list, tuple)):
            done[key] = [_with_matrix(term) for term in value]
        elif value is not None:
            done[key] = _with_matrix(value)
    sizes: dict[str, int] = {}
    for place, term in _terms(done):
        if _is_array(term.get("matrix")):
            if "file" in term:
                raise job_error(place, "a file is given beside an array; remove one of the two")
            term.update(_stored(term.pop("matrix"), place, folder, sizes))
    return {**job, "model": done}


def _is_array(value: Any) -> bool:
    return not isinstance(value, str) and (hasattr(value, "tocsc") or hasattr(value, "__array__"))


def _with_matrix(term: Any) -> Any:
    """A term as a dict of its own, also where it is an array alone."""
    return {"matrix": term} if _is_array(term) else dict(term) if isinstance(term, Mapping) else term


def _terms(model: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    for key in ("mass", "damping", "stiffness"):
        value = model.get(key)
        if isinstance(value, dict):
            yield f"model.{key}", value
        elif isinstance(value, list):
            yield from ((f"model.{key}[{i}]", term) for i, term in enumerate(value) if isinstance(term, dict))


def _stored(matrix: Any, place: str, folder: Path, sizes: dict[str, int]) -> dict[str, Any]:
    """What a term has in place of an array."""
    import numpy as np

    is_sparse = hasattr(matrix, "tocsc")
    if isinstance(matrix, np.ma.MaskedArray):
        raise job_error(place, "the matrix is a masked array; fill what is masked")
    if is_sparse and len(matrix.shape) == 2:
        matrix = matrix.tocsc(copy=True)
        matrix.sum_duplicates()
    values = matrix.data if is_sparse else np.asarray(matrix)
    shape = matrix.shape if is_sparse else values.shape
    if len(shape) != 2 or shape[0] != shape[1]:
        raise job_error(place, f"the matrix has the shape {tuple(map(int, shape))}; it must be square")
    if values.dtype.kind not in "fiu":
        raise job_error(place, f"the entries of the matrix are of type {values.dtype}; they must be real numbers")
    values = values.astype(np.float64, order="C")
    if not np.isfinite(values).all():
        raise job_error(place, "an entry of the matrix is not finite")
    for other, size in sizes.items():
        if size != shape[0]:
            raise job_error(place, f"the matrix has {shape[0]} rows, that of {other} has {size}")
    sizes[place] = shape[0]
    if not is_sparse and values.size <= _MOST_ENTRIES_IN_JOB:
        return {"matrix": values.tolist()}
    arrays: dict[str, Any] = {"matrix": values}
    if is_sparse:
        # As scipy.sparse.save_npz writes it.
        arrays = {
            "format": np.array(b"csc"),
            "shape": np.array(shape, np.int64),
            "data": values,
            "indices": matrix.indices.astype(np.int64),
            "indptr": matrix.indptr.astype(np.int64),
        }
    digest = hashlib.sha256()
    for name, array in arrays.items():
        digest.update(f"{name} {array.shape} ".encode())
        digest.update(array.tobytes())
    file = folder / f"{digest.hexdigest()[:32]}.npz"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        # Written beside it first, and then with the permissions that a new file has.
        with tempfile.TemporaryDirectory(dir=folder, prefix=".unfinished-") as unfinished:
            written = Path(unfinished) / file.name
            np.savez(written, **arrays)
            os.replace(written, file)
    return {"file": str(file)}
