"""Links: lattice Boltzmann in a pipe, with walls from flags and with walls where links have them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import hexcast
from pipe import flow, pipe_of, save_pipe


def test_links_make_a_pipe_second_order(tmp_path: Path) -> None:
    save_pipe(tmp_path)
    cells = (8, 16, 32)
    off: dict[bool, list[float]] = {True: [], False: []}
    for n in cells:
        hexcast(*pipe_of(n), "--links", "pipe.npz", "--stencil", "D3Q19", cwd=tmp_path)
        for is_interpolated, of in off.items():
            of.append(flow(tmp_path / "pipe.npz", n, is_interpolated=is_interpolated))
    orders = {kind: -np.polyfit(np.log(cells), np.log(of), 1)[0] for kind, of in off.items()}
    print("with links off by", off[True], "from flags", off[False], "orders", orders)
    assert orders[True] > 1.9
    assert off[True][-1] < 6e-4
    assert off[False][-1] > 10 * off[True][-1]
