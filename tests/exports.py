"""Reads the NPZ and MAT files of a run and compares them with its CSV file.

    python exports.py RUN_DIR NAMES_OF_AXES LENGTHS_OF_AXES
"""

import csv
import sys
import zipfile
from pathlib import Path

import numpy
import scipy.io

run, names, shape = Path(sys.argv[1]), sys.argv[2].split(","), tuple(map(int, sys.argv[3].split(",")))

with open(run / "surface.csv", newline="") as file:
    rows = list(csv.DictReader(file))
assert zipfile.ZipFile(run / "surface.npz").testzip() is None
arrays = dict(numpy.load(run / "surface.npz"))
matrices = {name: value for name, value in scipy.io.loadmat(run / "surface.mat").items() if name[0] != "_"}

assert arrays["axes"].dtype.kind == "U" and arrays["axes"].tolist() == names, arrays["axes"]
assert matrices["axes"].shape == (1, len(names))
assert [str(cell[0]) for cell in matrices["axes"][0]] == names, matrices["axes"]

columns = {name: name.replace(".", "_") for name in rows[0]}
assert sorted([*columns.values(), "axes"]) == sorted(arrays) == sorted(matrices)
for column, name in columns.items():
    values = [float(row[column]) if row[column] else numpy.nan for row in rows]
    if name in names:
        axis = names.index(name)
        assert arrays[name].shape == (shape[axis],) and matrices[name].shape == (1, shape[axis]), name
    else:
        assert arrays[name].shape == matrices[name].shape == shape, name
    assert matrices[name].dtype == "float64", name
    assert arrays[name].dtype == ("int64" if name == "cell" or name.startswith("n_") else "float64"), name
    for cell, value in enumerate(values):
        place = numpy.unravel_index(cell, shape)
        if name in names:
            found = [arrays[name][place[axis]], matrices[name][0, place[axis]]]
        else:
            found = [arrays[name][place], matrices[name][place]]
        assert numpy.array_equal(found, [value, value], equal_nan=True), (name, place, found, value)
print("NumPy and SciPy agree with the CSV file")
