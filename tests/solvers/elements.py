"""Modes of a square lattice of dielectric rods by finite elements: what those of any grid are held to. It shares nothing with hexcast.

H along the rods is a wave of Bloch's vector times what all cells have alike, on curved triangles of six points with quadratic functions; Gmsh makes them.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import meshio
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh

#: A cell of the lattice with a rod, in lengths of triangles; opposite sides have the same points.
GEOMETRY = """
Point(1) = {{0, 0, 0, {h}}}; Point(2) = {{1, 0, 0, {h}}}; Point(3) = {{1, 1, 0, {h}}}; Point(4) = {{0, 1, 0, {h}}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{4, 3}}; Line(4) = {{1, 4}};
Point(10) = {{{x}, {y}, 0, {h}}};
Point(11) = {{{x} + {r}, {y}, 0, {h}}}; Point(12) = {{{x}, {y} + {r}, 0, {h}}};
Point(13) = {{{x} - {r}, {y}, 0, {h}}}; Point(14) = {{{x}, {y} - {r}, 0, {h}}};
Circle(11) = {{11, 10, 12}}; Circle(12) = {{12, 10, 13}}; Circle(13) = {{13, 10, 14}}; Circle(14) = {{14, 10, 11}};
Curve Loop(1) = {{1, 2, -3, -4}}; Curve Loop(2) = {{11, 12, 13, 14}};
Plane Surface(1) = {{1, 2}}; Plane Surface(2) = {{2}};
Periodic Curve {{2}} = {{4}} Translate {{1, 0, 0}}; Periodic Curve {{3}} = {{1}} Translate {{0, 1, 0}};
Physical Surface(1) = {{1}}; Physical Surface(2) = {{2}};
"""
#: Of triangles: places by their first two barycentric coordinates, and weights; exact up to degree 6 (Dunavant 1985).
RULE = [
    (0.0254224531851035, 0.063089014491502, 0.063089014491502),
    (0.0583931378631895, 0.249286745170910, 0.249286745170910),
    (0.0414255378091870, 0.053145049844817, 0.310352451033784),
]


def places() -> tuple[np.ndarray, np.ndarray]:
    """Barycentric coordinates of all places of the rule, and their weights, which add up to the area of the triangle (0, 0), (1, 0), (0, 1)."""
    found = {(weight, of) for weight, a, b in RULE for of in ((a, b), (b, a), (a, 1 - a - b), (1 - a - b, a), (b, 1 - a - b), (1 - a - b, b))}
    weights, first = zip(*sorted(found))
    x, y = np.array(first).T
    return np.array([1 - x - y, x, y]), np.array(weights)


def modes_of_rods(folder: Path, eps: float, radius: float, centre: tuple[float, float], vector: np.ndarray, size: float) -> np.ndarray:
    """The first three, as frequencies by c / lattice: off by a fourth power of the size of triangles."""
    (folder / "cell.geo").write_text(GEOMETRY.format(h=size, x=centre[0], y=centre[1], r=radius))
    subprocess.run(["gmsh", "-2", "-order", "2", "-format", "msh22", "cell.geo", "-o", "cell.msh"], cwd=folder, check=True, capture_output=True)
    read = meshio.read(folder / "cell.msh")
    used, corners = np.unique(read.cells_dict["triangle6"], return_inverse=True)
    points, corners = read.points[used, :2], corners.reshape(-1, 6).T
    per_eps = np.where(read.cell_data_dict["gmsh:physical"]["triangle6"] == 2, 1 / eps, 1.0)

    (a, b, c), weights = places()
    values = np.array([a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a])
    zero = 0 * a
    along_x = [1 - 4 * a, 4 * b - 1, zero, 4 * (a - b), 4 * c, -4 * c]
    along_y = [1 - 4 * a, zero, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)]
    steps = np.stack([along_x, along_y], axis=1)
    jacobi = np.einsum("ned,nkq->dkeq", points[corners], steps)
    det = jacobi[0, 0] * jacobi[1, 1] - jacobi[0, 1] * jacobi[1, 0]
    inverse = np.array([[jacobi[1, 1], -jacobi[0, 1]], [-jacobi[1, 0], jacobi[0, 0]]]) / det
    slopes = np.einsum("nkq,kdeq->ndeq", steps, inverse) + 1j * vector[None, :, None, None] * values[:, None, None, :]
    area = abs(det) * weights
    stiffness = np.einsum("ndeq,mdeq,eq,e->nme", slopes.conj(), slopes, area, per_eps)
    mass = np.einsum("nq,mq,eq->nme", values, values, area)

    # points of opposite sides are one
    _, unknown = np.unique(np.round(points % 1, 9) % 1, axis=0, return_inverse=True)
    rows, columns = (np.broadcast_to(of, mass.shape).ravel() for of in (unknown.ravel()[corners][:, None], unknown.ravel()[corners][None]))
    stiff, heavy = (sparse.csc_matrix((of.ravel(), (rows, columns))) for of in (stiffness, mass))
    return np.sort(np.sqrt(abs(eigsh(stiff, 3, heavy, sigma=1e-3, return_eigenvectors=False)))) / (2 * np.pi)
