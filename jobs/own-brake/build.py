"""Builds own-brake.mat: a disc between two pads, made of bricks by scikit-fem, as matrices for `kind = "matrices"`.

    python build.py [--coarse | --refine] [--format FORMAT] [--out FOLDER]

Needs scikit-fem, numpy and scipy (tried with 12.0, 2.4 and 1.17). Formats: mat (the default), matrix-market, npz, abaqus,
abaqus-coordinate, dmig, harwell-boeing. The mesh has 3316 degrees of freedom; 880 with --coarse, for tests of formats, and
about 97,000 with --refine. Units: m, kg, N, s.

The brake
---------
The disc is an annulus, 64 to 135 mm, 20 mm thick, clamped at its inner edge: cast iron, E = 1.1e11 N/m^2, nu = 0.26,
7100 kg/m^3. On each of its faces lies a pad of 60 degrees from r = 92.4 mm to the outer edge, 12 mm thick: nu = 0.3,
2600 kg/m^3, and a modulus E that is left open. The nodes of a pad's back cannot move in the plane; a piston of 2e8 N/m and
0.25 kg, in equal shares for all of these nodes, holds each pad axially.

Every node of a pad's face lies on a node of the disc. Between them acts the normal force p = k A (w_disc - w_pad), where A is
the share of the face that belongs to the node. The friction mu p acts on the disc against its rotation, and on the pad with
it. It depends on w alone and acts on u and v: its matrix is not symmetric, and this is where flutter comes from.

The terms
---------
M            mass
K0           stiffness of disc and pistons
K_lining     of the pads, for E = 1
K_contact    of the contact, for k = 1 N/m^3, without friction
K_friction   of friction, for k = 1 and mu = 1

    K = K0 + E K_lining + k K_contact + mu k K_friction,    C = alpha M + beta (K0 + E K_lining)

with E = 8e9 N/m^2, k = 5e12 N/m^3, alpha = 20 1/s, beta = 5e-7 s.
"""

import argparse
from pathlib import Path

import numpy as np
import scipy.io
import scipy.sparse as sparse
from skfem import Basis, BilinearForm, ElementHex1, ElementVector, FacetBasis, LinearForm, MeshHex
from skfem.helpers import ddot, dot, sym_grad, trace

INNER, OUTER, THICKNESS, PAD_THICKNESS = 0.064, 0.135, 0.020, 0.012
PISTON_STIFFNESS, PISTON_MASS = 2e8, 0.25
# Bricks: around the disc (a pad takes a sixth of them), along its radius (a pad takes three fifths), through disc and pad.
MESHES = {"coarse": (24, 5, 1, 1), "usual": (60, 5, 2, 2), "refine": (216, 15, 8, 4)}


def bricks(angles, radii, heights, closed):
    """A mesh of trilinear bricks in cylinder coordinates."""
    angle, radius, height = np.meshgrid(angles, radii, heights, indexing="ij")
    points = np.array([radius * np.cos(angle), radius * np.sin(angle), height]).reshape(3, -1)
    number = np.arange(points.shape[1]).reshape(angle.shape)
    if closed:
        number = np.concatenate([number, number[:1]])
    a, r, h = (n - 1 for n in number.shape)
    # The order of corners of scikit-fem.
    corners = [(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 0), (1, 1, 1)]
    return MeshHex(points, np.array([number[i : i + a, j : j + r, k : k + h].ravel() for i, j, k in corners]))


def body(mesh, modulus, poisson, density):
    """Its degrees of freedom, three a node, mass and stiffness."""
    basis = Basis(mesh, ElementVector(ElementHex1()), intorder=3)
    first, second = modulus * poisson / (1 + poisson) / (1 - 2 * poisson), modulus / 2 / (1 + poisson)

    @BilinearForm
    def stiffness(u, v, _):
        return first * trace(sym_grad(u)) * trace(sym_grad(v)) + 2 * second * ddot(sym_grad(u), sym_grad(v))

    @BilinearForm
    def mass(u, v, _):
        return density * dot(u, v)

    return basis.nodal_dofs, mass.assemble(basis), stiffness.assemble(basis)


def shares(mesh, height):
    """The area of the face at this height that belongs to each node: the integral of its shape function."""
    facets = mesh.facets_satisfying(lambda x: np.isclose(x[2], height))
    return LinearForm(lambda v, _: v).assemble(FacetBasis(mesh, ElementHex1(), facets=facets, intorder=3))


def build(size="usual"):
    """The matrices by name, and (node, direction) of each degree of freedom, both from 1."""
    around, along, through, through_pad = MESHES[size]
    angles, radii = 2 * np.pi * np.arange(around) / around, np.linspace(INNER, OUTER, along + 1)
    face, back = THICKNESS / 2, THICKNESS / 2 + PAD_THICKNESS
    disc = bricks(angles, radii, np.linspace(-face, face, through + 1), closed=True)
    on_pad = angles[: around // 6 + 1], radii[2 * along // 5 :]
    pads = [bricks(*on_pad, side * np.linspace(face, back, through_pad + 1)[::side], closed=False) for side in (1, -1)]

    bodies = [body(disc, 1.1e11, 0.26, 7100.0), *(body(pad, 1.0, 0.3, 2600.0) for pad in pads)]
    sizes = [m.shape[0] for _, m, _ in bodies]
    starts = np.cumsum([0, *sizes[:-1]])
    dofs = [start + numbers for start, (numbers, _, _) in zip(starts, bodies, strict=True)]
    empty = [sparse.csr_matrix((n, n)) for n in sizes]
    terms = {
        "M": sparse.block_diag([m for _, m, _ in bodies]),
        "K0": sparse.block_diag([bodies[0][2], *empty[1:]]),
        "K_lining": sparse.block_diag([empty[0], bodies[1][2], bodies[2][2]]),
    }

    total = sum(sizes)
    fixed = [dofs[0][:, np.isclose(np.hypot(*disc.p[:2]), INNER)].ravel()]
    pistons, contact, friction = np.zeros(total), [], []
    node_at = {tuple(point): node for node, point in enumerate(np.round(disc.p.T, 9) + 0.0)}
    for pad, dof, side in zip(pads, dofs[1:], (1, -1), strict=True):
        backs = np.flatnonzero(np.isclose(pad.p[2], side * back))
        fixed.append(dof[:2, backs].ravel())
        pistons[dof[2, backs]] = 1.0 / len(backs)
        areas = shares(pad, side * face)
        for node in np.flatnonzero(np.isclose(pad.p[2], side * face)):
            x, y, _ = pad.p[:, node]
            on_disc = dofs[0][:, node_at[tuple(np.round(pad.p[:, node], 9) + 0.0)]]
            along_sliding = np.array([-y, x]) / np.hypot(x, y)
            for sign, column in ((1.0, on_disc[2]), (-1.0, dof[2, node])):
                pressure = side * sign * areas[node]
                # K q is minus the force: the disc is pushed back by p and held by mu p, the pad the other way round.
                contact += [(on_disc[2], column, side * pressure), (dof[2, node], column, -side * pressure)]
                for direction, cosine in enumerate(along_sliding):
                    friction += [(on_disc[direction], column, pressure * cosine)]
                    friction += [(dof[direction, node], column, -pressure * cosine)]
    terms["M"] = terms["M"] + PISTON_MASS * sparse.diags(pistons)
    terms["K0"] = terms["K0"] + PISTON_STIFFNESS * sparse.diags(pistons)
    for name, entries in (("K_contact", contact), ("K_friction", friction)):
        rows, columns, values = zip(*entries, strict=True)
        terms[name] = sparse.coo_matrix((values, (rows, columns)), (total, total))

    free = np.setdiff1d(np.arange(total), np.concatenate(fixed))
    nodes = np.vstack([free // 3 + 1, free % 3 + 1]).T
    return {name: cleaned(term.tocsc()[free][:, free], name) for name, term in terms.items()}, nodes


def cleaned(matrix, name):
    """Without stored zeros, and exactly symmetric where it is meant to be."""
    if name != "K_friction":
        matrix = (matrix + matrix.T) / 2
    matrix.data[abs(matrix.data) < 1e-14 * abs(matrix.data).max()] = 0.0
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix.tocsc()


def triangle(matrix):
    """Rows, columns (from 1), values by columns, and whether only the lower triangle is given."""
    symmetric = (matrix != matrix.T).nnz == 0
    part = sparse.coo_matrix(sparse.tril(matrix).tocsc() if symmetric else matrix.tocsc())
    return part.row + 1, part.col + 1, part.data, symmetric


def write_abaqus(path, matrix, nodes):
    """*MATRIX OUTPUT, FORMAT=MATRIX INPUT: row node and degree of freedom, column node and degree of freedom, value."""
    rows, columns, values, symmetric = triangle(matrix)
    with open(path, "w") as file:
        file.write(f"**\n** ASSEMBLE, TYPE={'SYMMETRIC' if symmetric else 'UNSYMMETRIC'}\n**\n")
        for r, c, v in zip(rows, columns, values, strict=True):
            (a, i), (b, j) = nodes[r - 1], nodes[c - 1]
            file.write(f"{a:d},{i:d}, {b:d},{j:d}, {v:.15e}\n")


def write_abaqus_coordinate(path, matrix, _):
    """*MATRIX OUTPUT, FORMAT=COORDINATE: row, column, value, from 1."""
    with open(path, "w") as file:
        for r, c, v in zip(*triangle(matrix)[:3], strict=True):
            file.write(f"{r:10d} {c:10d} {v:24.15e}\n")


def write_dmig(path, matrix, nodes):
    """A punch file in wide fields, as PARAM,EXTOUT,DMIGPCH writes it: ten digits, one triangle where IFO is 6."""
    rows, columns, values, symmetric = triangle(matrix)
    name = path.stem.upper().replace("_", "")[:8]
    with open(path, "w") as file:
        file.write(f"DMIG    {name:<8}{0:8d}{6 if symmetric else 1:8d}{2:8d}{0:8d}\n")
        last = None
        for r, c, v in zip(rows, columns, values, strict=True):
            if c != last:
                node, direction = nodes[c - 1]
                file.write(f"{'DMIG*':<8}{name:<16}{node:16d}{direction:16d}\n")
                last = c
            node, direction = nodes[r - 1]
            file.write(f"{'*':<8}{node:16d}{direction:16d}{f'{v:.9E}'.replace('E', 'D'):>16}\n")


def write_harwell_boeing(path, matrix, _):
    """Assembled, RSA (one triangle) or RUA, as HBMAT of Ansys writes it in ASCII."""
    rows, columns, values, symmetric = triangle(matrix)
    n = matrix.shape[0]
    pointers = 1 + np.concatenate([[0], np.cumsum(np.bincount(columns - 1, minlength=n))])
    blocks = []
    for numbers, each, text in ((pointers, 8, "{:10d}"), (rows, 8, "{:10d}"), (values, 3, "{:25.16E}")):
        blocks.append(["".join(map(text.format, numbers[i : i + each])) for i in range(0, len(numbers), each)])
    with open(path, "w") as file:
        file.write(f"{path.stem:<72}{path.stem[:8]:<8}\n")
        file.write("".join(f"{n:14d}" for n in (sum(map(len, blocks)), *map(len, blocks), 0)) + "\n")
        file.write(f"{'RSA' if symmetric else 'RUA':<14}" + "".join(f"{k:14d}" for k in (n, n, len(values), 0)) + "\n")
        file.write(f"{'(8I10)':<16}{'(8I10)':<16}{'(3E25.16)':<20}{'':<20}\n")
        for block in blocks:
            file.write("\n".join(block) + "\n")


def write_matrix_market(path, matrix, _):
    scipy.io.mmwrite(path, matrix, precision=17)


def write_npz(path, matrix, _):
    sparse.save_npz(path, matrix)


WRITERS = {
    "matrix-market": (".mtx", write_matrix_market),
    "npz": (".npz", write_npz),
    "abaqus": (".mtx", write_abaqus),
    "abaqus-coordinate": (".mtx", write_abaqus_coordinate),
    "dmig": (".pch", write_dmig),
    "harwell-boeing": (".hb", write_harwell_boeing),
}


def main():
    parser = argparse.ArgumentParser(description="Builds the matrices of a brake.")
    mesh = parser.add_mutually_exclusive_group()
    mesh.add_argument("--coarse", dest="size", action="store_const", const="coarse", default="usual")
    mesh.add_argument("--refine", dest="size", action="store_const", const="refine")
    parser.add_argument("--format", choices=["mat", *WRITERS], default="mat")
    parser.add_argument("--out", type=Path, default=Path())
    arguments = parser.parse_args()
    terms, nodes = build(arguments.size)
    arguments.out.mkdir(parents=True, exist_ok=True)
    name = {"usual": "own-brake", "coarse": "own-brake-coarse", "refine": "own-brake-fine"}[arguments.size]
    if arguments.format == "mat":
        scipy.io.savemat(arguments.out / f"{name}.mat", terms, do_compression=True)
    else:
        suffix, write = WRITERS[arguments.format]
        for key, matrix in terms.items():
            write(arguments.out / f"{key}{suffix}", matrix, nodes)
    print(f"{len(nodes)} degrees of freedom")


if __name__ == "__main__":
    main()
