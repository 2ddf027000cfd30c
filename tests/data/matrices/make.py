"""Writes the files of this folder: matrices as other programs write them, by which the readers are tested.

    python make.py numpy       NumPy 2.4.6 and SciPy 1.17.1: .mat, .mtx (Matrix Market), .npz, .npy, .rua
    python make.py pynastran   pyNastran 1.4.1: .pch
    python make.py octave      GNU Octave 7.3.0: octave-*.mat
    python make.py calculix    CalculiX 2.20 (ccx): .sti, .mas, .dof and ccx-substructure.mtx
    python make.py hand        no program: Abaqus, Ansys and MAT files in the order of bytes of other processors

pyNastran wants NumPy below version 2, so that it needs an environment of its own. Abaqus and Ansys cannot be had here:
their files are written by this script from what their manuals say of the formats.

The model has 8 degrees of freedom: translations 1 and 3 of the nodes 11, 12, 23 and 24. Its matrices are M (mass), C
(damping), G (gyroscopic, skew), K (stiffness) and KF (friction, not symmetric, at the nodes 12 and 23 alone). All numbers have
few digits, so that every format holds them exactly. `model.csv` has the entries other than zero.
"""

import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
NODES = (11, 12, 23, 24)
MAP = [(node, direction) for node in NODES for direction in (1, 3)]
SIZE = len(MAP)


def model():
    """The matrices, as lists of rows."""
    zero = lambda: [[0.0] * SIZE for _ in range(SIZE)]
    mass, damping, gyroscopic, stiffness, friction = (zero() for _ in range(5))
    for i in range(SIZE):
        mass[i][i] = 0.25 + 0.125 * i
        damping[i][i] = 1.5 + 0.25 * i
        stiffness[i][i] = 125000.0 + 2500.0 * i
    for i in range(SIZE - 2):
        mass[i][i + 2] = mass[i + 2][i] = 0.03125
        damping[i][i + 2] = damping[i + 2][i] = -0.5
        stiffness[i][i + 2] = stiffness[i + 2][i] = -50000.0 - 1250.0 * i
    for i in range(0, SIZE, 2):
        stiffness[i][i + 1] = stiffness[i + 1][i] = 3125.5
        gyroscopic[i][i + 1], gyroscopic[i + 1][i] = -0.75, 0.75
    # The tangential forces (direction 1) of the pair of nodes 12 and 23 follow from their distance (direction 3).
    for row, sign in ((2, 1.0), (4, -1.0)):
        friction[row][3], friction[row][5] = sign * 30000.0, -sign * 30000.0
    return {"M": mass, "C": damping, "G": gyroscopic, "K": stiffness, "KF": friction}


def entries(matrix):
    return [(i, j, value) for i, row in enumerate(matrix) for j, value in enumerate(row) if value]


def write(name, text):
    (HERE / name).write_text(text, encoding="ascii")


def numpy():
    import numpy as np
    import scipy.io
    import scipy.sparse as sp

    dense = {name: np.array(matrix) for name, matrix in model().items()}
    sparse = {name: sp.csc_matrix(matrix) for name, matrix in dense.items()}
    write("model.csv", "matrix,row,column,value\n" + "".join(
        f"{name},{i},{j},{value!r}\n" for name, matrix in model().items() for i, j, value in entries(matrix)))
    # K is full, in the smallest type that holds it; `inside` is no matrix, `flags` has truth values.
    mixed = {**sparse, "K": dense["K"], "inside": {"K": dense["K"]}, "words": "brake", "wave": dense["K"] * 1j,
             "flags": sparse["KF"] != 0, "bits": dense["M"] != 0, "counts": np.arange(9, dtype=np.int16).reshape(3, 3),
             "singles": np.array([[0.5, 2.0], [0.0, -1.5]], dtype=np.float32), "list": np.zeros((3, 1))}
    scipy.io.savemat(HERE / "scipy-plain.mat", mixed, do_compression=False)
    scipy.io.savemat(HERE / "scipy-compressed.mat", mixed, do_compression=True)
    scipy.io.savemat(HERE / "scipy-v4.mat", {"K": dense["K"]}, format="4")
    for name, symmetry in (("M", "symmetric"), ("C", "symmetric"), ("G", "skew-symmetric"), ("K", "symmetric"),
                           ("KF", "general")):
        scipy.io.mmwrite(HERE / f"scipy-{name}.mtx", sparse[name], symmetry=symmetry)
    scipy.io.mmwrite(HERE / "scipy-K-array.mtx", dense["K"], symmetry="symmetric")
    scipy.io.mmwrite(HERE / "scipy-G-array.mtx", dense["G"], symmetry="skew-symmetric")
    scipy.io.mmwrite(HERE / "scipy-KF-array.mtx", dense["KF"], symmetry="general")
    scipy.io.mmwrite(HERE / "scipy-integer.mtx", sp.csc_matrix(dense["KF"].astype(int)), symmetry="general")
    sp.save_npz(HERE / "scipy-K-csr.npz", sp.csr_array(dense["K"]))
    sp.save_npz(HERE / "scipy-M-csc.npz", sparse["M"], compressed=False)
    sp.save_npz(HERE / "scipy-KF-coo.npz", sp.coo_matrix(dense["KF"]))
    sp.save_npz(HERE / "scipy-C-dia.npz", sp.dia_matrix(dense["C"]))
    sp.save_npz(HERE / "scipy-G-bsr.npz", sp.bsr_matrix(dense["G"], blocksize=(2, 2)))
    np.savez(HERE / "numpy-plain.npz", **dense)
    np.savez_compressed(HERE / "numpy-compressed.npz", **{**dense, "K": np.asfortranarray(dense["K"]), "wave": 1j * dense["K"]})
    np.save(HERE / "numpy-K.npy", dense["K"])
    np.save(HERE / "numpy-M-big-endian.npy", dense["M"].astype(">f4"))
    for name in ("M", "K", "KF"):
        scipy.io.hb_write(HERE / f"scipy-{name}.rua", sparse[name])


def pynastran():
    from pyNastran.bdf.bdf import BDF

    for file, width, is_double in (("nastran-small.pch", 8, False), ("nastran-wide.pch", 16, False),
                                   ("nastran-double.pch", 16, True)):
        text = "$ Written by pyNastran\n"
        bulk = BDF(debug=False)
        for name, form, matrix in (("MAAX", 6, "M"), ("BAAX", 6, "C"), ("GAAX", 1, "G"), ("KAAX", 6, "K"),
                                   ("K2PP", 1, "KF")):
            kept = [entry for entry in entries(model()[matrix]) if form == 1 or entry[0] >= entry[1]]
            kept.sort(key=lambda entry: (entry[1], entry[0]))
            places = lambda which: [MAP[entry[which]] for entry in kept]
            bulk.add_dmig(name, form, 2 if is_double else 1, 0, 0, 0, places(1), places(0), [entry[2] for entry in kept])
            text += bulk.dmig[name].write_card(size=width, is_double=is_double)
        write(file, text)


def octave():
    lines = ["[m, i, j, v] = textread('model.csv', '%s %d %d %f', 'delimiter', ',', 'headerlines', 1);"]
    for name in model():
        lines.append(f"p = strcmp(m, '{name}'); {name} = sparse(i(p) + 1, j(p) + 1, v(p), {SIZE}, {SIZE});")
    lines.append("K = full(K); note = 'brake'; parts = {K, 1}; inside.K = K;")
    for option in ("v6", "v7", "text"):
        names = "M C G K KF note parts inside" if option != "text" else "KF"
        lines.append(f"save -{option} octave-{option}.mat {names}")
    subprocess.run(["octave", "--no-gui", "--quiet", "--eval", "\n".join(lines)], cwd=HERE, check=True)


BRICK = """*NODE,NSET=NALL
11,0.,0.,0.
12,2.,0.,0.
13,2.,1.,0.
14,0.,1.,0.
25,0.,0.,1.
26,2.,0.,1.
27,2.,1.,1.
28,0.,1.,1.
*ELEMENT,TYPE=C3D8,ELSET=EALL
1,11,12,13,14,25,26,27,28
*NSET,NSET=RETAINED
25,26,27
*MATERIAL,NAME=IRON
*ELASTIC
1.1e5,.26
*DENSITY
7.1e-9
*SOLID SECTION,ELSET=EALL,MATERIAL=IRON
*BOUNDARY
11,1,3
12,1,3
13,1,3
14,1,3
*STEP
"""


def calculix():
    """One brick of iron (N, mm, t) that is held at four of its nodes."""
    steps = {
        "brick": "*FREQUENCY,SOLVER=MATRIXSTORAGE\n3\n",
        "substructure": "*SUBSTRUCTURE GENERATE\n*RETAINED NODAL DOFS\nRETAINED,1,3\n*SUBSTRUCTURE MATRIX OUTPUT,"
                        "STIFFNESS=YES,OUTPUT FILE=USER DEFINED,FILE NAME=ccx-substructure\n",
    }
    with tempfile.TemporaryDirectory() as folder:
        for job, step in steps.items():
            (Path(folder) / f"{job}.inp").write_text(BRICK + step + "*END STEP\n")
            subprocess.run(["ccx", job], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        for name in ("brick.sti", "brick.mas", "brick.dof", "ccx-substructure.mtx"):
            shutil.copy(Path(folder) / name, HERE / name.replace("brick", "ccx-brick"))


def hand():
    matrices = model()
    matrix_input(matrices)
    coordinate(matrices)
    substructure(matrices)
    ansys(matrices)
    big_endian(matrices)


def matrix_input(matrices):
    """Abaqus: *MATRIX OUTPUT, FORMAT=MATRIX INPUT. A symmetric matrix has its lower triangle. Node 12 is held in direction 2,
    which Abaqus keeps as a degree of freedom with 1e36 on the diagonal of the stiffness."""
    line = lambda i, j, value: f"{i[0]},{i[1]}, {j[0]},{j[1]}, {value:.15e}\n"
    for name, file in (("M", "MASS2"), ("C", "DMPV2"), ("K", "STIF2"), ("KF", "STIF3")):
        kept = [(i, j, value) for i, j, value in entries(matrices[name]) if name == "KF" or i >= j]
        lines = [(MAP[i], MAP[j], value) for i, j, value in kept]
        held = (12, 2)
        if name == "K":
            lines += [(held, held, 1e36), (held, (11, 1), 0.0), (held, (12, 1), -17.0), ((12, 3), held, 25.0)]
        if name == "M":
            lines += [(held, held, 0.375)]
        write(f"abaqus_{file}.mtx", "".join(line(*entry) for entry in sorted(lines)))


def coordinate(matrices):
    """Abaqus: *MATRIX OUTPUT, FORMAT=COORDINATE. Rows count from 1."""
    for name, file in (("K", "STIF4"), ("KF", "STIF5"), ("M", "MASS4")):
        kept = [(i, j, value) for i, j, value in entries(matrices[name]) if name == "KF" or i <= j]
        write(f"abaqus-coordinate_{file}.mtx", "".join(f"{i + 1:>9}{j + 1:>9}   {value:.15E}\n" for i, j, value in kept))


def substructure(matrices):
    """Abaqus: *SUBSTRUCTURE MATRIX OUTPUT, OUTPUT FILE=USER DEFINED. Each row starts a line, of four numbers at most."""
    text = "** \n** SUBSTRUCTURE Z1\n** \n*USER ELEMENT,NODES=      4,LINEAR\n** ELEMENT NODES\n**       11,       12,\n"
    text += "**       23,       24\n       1,     3\n"
    for kind, name in (("STIFFNESS", "K"), ("MASS", "M"), ("VISCOUS DAMPING", "C")):
        text += f"*MATRIX,TYPE={kind}\n"
        for i, row in enumerate(matrices[name]):
            for start in range(0, i + 1, 4):
                values = row[start:min(start + 4, i + 1)]
                text += ",".join(f"{value:21.13E}" for value in values) + ("," if start + 4 <= i else "") + "\n"
    write("abaqus-substructure.mtx", text)


def ansys(matrices):
    """Ansys: HBMAT, ASCII. Symmetric matrices have their lower triangle; one number a line."""
    for name, kind, file in (("K", "RSA", "ansys-K.matrix"), ("KF", "RUA", "ansys-KF.matrix"), ("M", "RSA", "ansys-M.matrix")):
        kept = sorted((j, i, value) for i, j, value in entries(matrices[name]) if kind == "RUA" or i >= j)
        starts = [1 + sum(entry[0] < column for entry in kept) for column in range(SIZE + 1)]
        counts = (len(starts), len(kept), len(kept), 0)
        text = f"{'Stiffness matrix from file.full':<72}{'ANSYS':<8}\n" + "".join(f"{n:14d}" for n in (sum(counts), *counts))
        text += f"\n{kind:<14}" + "".join(f"{n:14d}" for n in (SIZE, SIZE, len(kept), 0))
        text += f"\n{'(1I10)':<16}{'(1I10)':<16}{'(1P,1D25.15)':<20}{'(1P,1D25.15)':<20}\n"
        text += "".join(f"{start:10d}\n" for start in starts) + "".join(f"{row + 1:10d}\n" for _, row, _ in kept)
        text += "".join(f"{value:25.15E}\n".replace("E", "D") for *_, value in kept)
        write(file, text)


def big_endian(matrices):
    """A MAT file, level 5, as a processor of the other order of bytes writes it: KF sparse, K full with integers of two
    bytes in it where they suffice."""
    def element(kind, data):
        return struct.pack(">II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def matrix(kind, name, nonzeros, *parts):
        head = element(6, struct.pack(">II", kind, nonzeros)) + element(5, struct.pack(">ii", SIZE, SIZE))
        # Two bytes of a name are packed into the tag.
        short = struct.pack(">HH", len(name), 1) + name.ljust(4, b"\0")
        return element(14, head + short + b"".join(parts))

    kept = sorted((j, i, value) for i, j, value in entries(matrices["KF"]))
    starts = [sum(entry[0] < column for entry in kept) for column in range(SIZE + 1)]
    sparse = matrix(5, b"KF", len(kept), element(5, struct.pack(f">{len(kept)}i", *(row for _, row, _ in kept))),
                    element(5, struct.pack(f">{SIZE + 1}i", *starts)),
                    element(3, struct.pack(f">{len(kept)}h", *(int(value) for *_, value in kept))))
    columns = [matrices["K"][i][j] for j in range(SIZE) for i in range(SIZE)]
    full = matrix(6, b"K", 0, element(9, struct.pack(f">{SIZE * SIZE}d", *columns)))
    header = b"MATLAB 5.0 MAT-file, written by hand".ljust(124) + struct.pack(">H", 0x0100) + b"MI"
    (HERE / "hand-big-endian.mat").write_bytes(header + sparse + full)


if __name__ == "__main__":
    for part in sys.argv[1:]:
        {"numpy": numpy, "pynastran": pynastran, "octave": octave, "calculix": calculix, "hand": hand}[part]()
