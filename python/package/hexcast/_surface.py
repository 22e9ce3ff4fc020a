"""Surfaces from files, bytes, arrays and the mesh objects of other libraries."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._error import Error, InvalidType, missing
from ._hexcast import Surface

__all__ = ["Surface", "SurfaceLike", "surface"]

#: What :func:`surface` takes. Mesh objects of other libraries are known by their attributes, so this is any object.
SurfaceLike = Union[str, "os.PathLike[str]", bytes, Surface, "tuple[ArrayLike, ArrayLike]", Any]

Arrays = tuple[Any, Any]


def surface(source: SurfaceLike, name: Optional[str] = None, *, deviation: Optional[float] = None) -> Surface:
    """Reads a surface once, for any number of meshes.

    :param source: one of

        - the name of a file (STL, OBJ, PLY, OFF, 3MF, GLB; STEP and IGES with ``pip install hexcast[step]``), or, but of the last two, its
          bytes;
        - a tuple ``(vertices, faces)``: coordinates of shape (n, 3), and for each triangle the numbers of three vertices,
          counted from 0, of shape (m, 3);
        - an array of corners of shape (m, 3, 3): triangle, corner, coordinate;
        - a mesh of trimesh (``vertices``, ``faces``), PyVista (``points``, ``regular_faces``), Open3D (``vertices``,
          ``triangles``) or numpy-stl (``vectors``). Scenes of several meshes are for :func:`hexcast.mesh`.

    :param name: its name in reports; by default that of the file.
    :param deviation: of STEP and IGES, largest distance of the triangles from the surfaces, in mm; by default a tenth of a cell of 128 along
        the longest axis. :func:`hexcast.mesh` chooses it by its own cells, if it gets the name of the file.
    :returns: the surface. Coordinates are 32-bit floats, as in STL files: others are rounded to these.
    :raises hexcast.Error: ``io``; an ``stl-`` code where a file cannot be understood; ``stl-empty`` without triangles;
        ``stl-not-finite``; ``cad-program`` where nothing converts STEP and IGES; ``job-value`` for arrays of other shapes, and for faces
        with vertices that are not there.

    >>> import hexcast
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> hexcast.surface((corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), name="corner").n_facets
    4
    """
    if isinstance(source, Surface):
        return source
    if isinstance(source, (str, os.PathLike)):
        if not os.path.exists(source):
            raise missing(source)
        return Surface.from_file(os.fspath(source), deviation)
    name = "surface" if name is None else name
    if isinstance(source, (bytes, bytearray, memoryview)):
        return Surface.from_bytes(name, bytes(source))
    vertices, faces = arrays_of(source, name)
    return Surface.from_arrays(name, numbers(vertices, name), indices(faces, name))


def scene_parts(source: Any) -> Optional[list[tuple[str, Any]]]:
    """Names and meshes of a scene of trimesh, or of a MultiBlock of PyVista and those in it; None for anything else."""
    if hasattr(source, "graph") and hasattr(source, "geometry"):
        parts = []
        for node in source.graph.nodes_geometry:
            transform, name = source.graph[node]
            placed = source.geometry[name].copy()
            placed.apply_transform(transform)
            parts.append((str(node), placed))
        return parts
    if hasattr(source, "n_blocks") and hasattr(source, "get_block_name"):
        parts = []
        for index in range(source.n_blocks):
            name, block = source.get_block_name(index) or f"block {index + 1}", source[index]
            inner = scene_parts(block)
            if inner is not None:
                parts += [(f"{name}/{of}", made) for of, made in inner]
            elif block is not None:
                parts.append((name, block if hasattr(block, "is_all_triangles") else surface_of(block)))
        return parts
    return None


def surface_of(block: Any) -> Any:
    """The surface of a block of PyVista that is none, such as a grid."""
    try:
        # newer versions want to be told
        return block.extract_surface(algorithm=None)
    except TypeError:
        return block.extract_surface()


def arrays_of(source: Any, name: str) -> Arrays:
    """Vertices and faces of a mesh object, a pair of arrays, or an array of corners."""
    if isinstance(source, tuple) and len(source) == 2:
        return source
    if hasattr(source, "vectors"):
        source = source.vectors
    for vertices, faces in (("vertices", "faces"), ("vertices", "triangles")):
        if hasattr(source, vertices) and hasattr(source, faces):
            return getattr(source, vertices), getattr(source, faces)
    if hasattr(source, "points") and hasattr(source, "is_all_triangles"):
        triangles = source if source.is_all_triangles else source.triangulate()
        return triangles.points, triangles.regular_faces
    if isinstance(source, (np.ndarray, Sequence)):
        corners = np.asarray(source)
        if corners.ndim == 3 and corners.shape[1:] == (3, 3):
            return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
        raise wrong(name, f"an array of shape {corners.shape} is no list of corners of shape (m, 3, 3)")
    if scene_parts(source) is not None:
        raise wrong(name, f"a {type(source).__qualname__} is many surfaces; hexcast.mesh takes it as a geometry each")
    raise InvalidType(*wrong(name, f"{type(source).__module__}.{type(source).__qualname__} has no vertices and faces").args)


def numbers(vertices: Any, name: str) -> NDArray[np.float32]:
    """Coordinates as 32-bit floats."""
    array = np.asarray(vertices)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "fiu":
        raise wrong(name, f"vertices are numbers of shape (n, 3), not {array.dtype} of shape {array.shape}")
    # what is too large becomes infinite, and is refused as such; a copy, as other threads may write to the caller's array
    with np.errstate(over="ignore"):
        return np.array(array, dtype=np.float32, order="C")


def indices(faces: Any, name: str) -> NDArray[np.int64]:
    """Numbers of vertices as 64-bit integers."""
    array = np.asarray(faces)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise wrong(name, f"faces are whole numbers of shape (m, 3), not {array.dtype} of shape {array.shape}")
    return np.array(array, dtype=np.int64, order="C")


def wrong(name: str, problem: str) -> Error:
    hint = "give a file, bytes, (vertices, faces), or a triangle mesh of trimesh, PyVista or Open3D; several as a list"
    return Error(f"{name}: {problem}", "job-value", hint)
