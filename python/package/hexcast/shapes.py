"""Small closed surfaces for examples and tests, as vertices and faces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

Shape = tuple[NDArray[np.float64], NDArray[np.int64]]


def box(low: Sequence[float], high: Sequence[float]) -> Shape:
    """A box between two corners: 8 vertices of shape (8, 3), 12 faces of shape (12, 3), normals outwards."""
    corners = np.array(list(product(*zip(low, high))), np.float64)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))], np.int64)


def sphere(centre: Sequence[float], radius: float, steps: int = 32) -> Shape:
    """A sphere of ``steps`` rings from pole to pole and twice as many meridians, normals outwards."""
    n = 2 * steps
    polar = np.pi * np.arange(1, steps) / steps
    around = 2 * np.pi * np.arange(n) / n
    ring = np.stack([np.cos(around), np.sin(around)], axis=-1)
    rings = np.concatenate(
        [np.sin(polar)[:, None, None] * ring, np.broadcast_to(np.cos(polar)[:, None, None], (steps - 1, n, 1))], axis=-1
    )
    directions = np.concatenate([[[0, 0, 1]], rings.reshape(-1, 3), [[0, 0, -1]]])
    # the corners of each patch between two rings and two meridians
    first, here = np.arange(steps - 2)[:, None] * n + 1, np.arange(n)[None]
    a, b = first + here, first + (here + 1) % n
    sides = np.concatenate([np.stack([a, a + n, b], -1).reshape(-1, 3), np.stack([b, a + n, b + n], -1).reshape(-1, 3)])
    top, south, last = np.arange(n), len(directions) - 1, (steps - 2) * n + 1
    caps = [np.stack([np.zeros_like(top), top + 1, (top + 1) % n + 1], -1)]
    caps.append(np.stack([np.full_like(top, south), (top + 1) % n + last, top + last], -1))
    return np.asarray(centre) + radius * directions, np.concatenate([sides, *caps])
