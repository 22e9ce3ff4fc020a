"""Scenes: after each edit the mesh is that of the whole job, and what changed is listed."""

from __future__ import annotations

import numpy as np
import pytest

import hexcast
from hexcast.shapes import box, sphere

SIZE = {"domain": (-2, -2, -2, 2, 2, 2), "dims": (30, 34, 38), "backend": "cpu"}


def test_scenes_are_whole_meshes():
    rng = np.random.default_rng(5)
    wall = hexcast.surface(box((-1.5, -1.5, -1.5), (1.5, 1.5, -1)), name="wall")
    ball = hexcast.surface(sphere((0, 0, 0), 0.8), name="ball")
    scene = hexcast.scene([wall, {"source": ball, "flag": 9}], **SIZE)
    flags = scene.mesh.flags.copy()
    first = scene.mesh
    kept = flags.copy()
    n_whole = n_cells = 0
    for step in range(60):
        entry = {"source": ball, "flag": 9 - step % 2, "translate": rng.uniform(-1, 1, 3), "rotate": rng.uniform(0, 90, 3)}
        parts = [wall, entry, {"source": ball, "scale": 0.5}][: 2 + step % 2]
        update = scene.update(parts)
        whole = hexcast.mesh(parts, **SIZE)
        n_whole += update.whole is not None
        index, before, after = update.changed.cells()
        n_cells += len(index)
        place = (index[:, 2], index[:, 1], index[:, 0])
        assert (flags[place] == before).all() and (before != after).all()
        flags[place] = after
        assert (flags == whole.flags).all() and (scene.mesh.flags == whole.flags).all()
        assert scene.mesh.names == whole.names
    assert n_whole < 10 and n_cells > 1000
    # earlier meshes stay
    assert (first.flags == kept).all()


def test_scenes_say_why_they_mesh_the_whole(spot):
    surface = hexcast.surface(spot)
    scene = hexcast.scene(surface, cells=20, backend="cpu")
    moved = scene.update({"source": surface, "translate": (1, 0, 0)})
    assert (moved.whole, moved.changed) == ("box", None)
    asked = scene.update(surface, links={"fluid": [0]})
    assert asked.whole == "asked"
    # options stay
    again = scene.update(surface)
    assert again.whole == "asked" and again.rays == scene.mesh.report["rays"]
    assert len(again.changed.rays) == 0 and len(scene.mesh.links.q) > 0
    assert scene.mesh.report["backend"] == "cpu"


def test_scenes_stay_as_they_are_after_errors(spot):
    surface = hexcast.surface(spot)
    scene = hexcast.scene(surface, domain=(-1, -1, -1, 1, 1, 1), cells=20, backend="cpu")
    before = scene.mesh.flags.copy()
    with pytest.raises(hexcast.Error, match="padding"):
        scene.update(surface, padding=-1)

    assert (scene.mesh.flags == before).all()
    nothing = scene.update({"source": surface, "scale": 0.001})
    assert nothing.whole is None and scene.mesh.report["backend"] is None
    assert [finding["code"] for finding in nothing.findings] == ["no-cell-thin"]
