"""CalculiX reads the elements that hexcast wrote, and a cantilever bends as Timoshenko says."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import Model, cuboid, hexcast, run, save, save_solids

NAMES = {1: "base", 2: "block", 9: "f_1_bar"}
SIDES = ("XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX")
#: What stands above two lines of numbers of a surface.
TITLES = ("   center of gravity and mean normal", "   area, normal force (+ = tension), shear force (size), torque and bending moment (size)")


def table(text: str, title: str) -> np.ndarray:
    """The rows of a table of a .dat file."""
    rows = []
    for line in text.split(title, 1)[1].split("\n")[1:]:
        words = line.split()
        if words and not words[0].lstrip("-").isdigit():
            break
        if words:
            rows.append([float(word) for word in words])
    return np.array(rows)


def test_the_same_cells(model: Model) -> None:
    hexcast("convert", "m.hxc", "m.inp", cwd=model.folder)
    deck = """*INCLUDE, INPUT=m.inp
*MATERIAL, NAME=SOFT
*ELASTIC
1e9, 0.2
*SOLID SECTION, ELSET=base, MATERIAL=SOFT
*SOLID SECTION, ELSET=f_1_bar, MATERIAL=SOFT
*BOUNDARY
XMIN, 1, 3
*STEP
*STATIC
*DSLOAD
S_f_1_bar, P, 1
*EL PRINT, ELSET=base, TOTALS=YES
EVOL
*EL PRINT, ELSET=block, TOTALS=YES
EVOL
*EL PRINT, ELSET=f_1_bar, TOTALS=YES
EVOL
"""
    deck += "".join(f"*NODE PRINT, NSET={side}\nU\n" for side in SIDES)
    deck += "".join(f"*SECTION PRINT, SURFACE=S_{name}, NAME=A{name}\nSOF\n" for name in NAMES.values())
    deck += "*END STEP\n"
    (model.folder / "run.inp").write_text(deck)
    run("ccx", "run", cwd=model.folder)
    text = (model.folder / "run.dat").read_text()
    nodes, elements = read(model)
    kept = model.of(1, 2, 9)
    order = np.argwhere(kept.transpose(2, 1, 0))[:, ::-1]
    corners = np.array([[nodes[point] for point in points] for points in elements.values()])
    numbers = np.array(list(elements)) - 1
    np.testing.assert_allclose(corners.mean(axis=1), model.centres[tuple(order[numbers].T)] * 1e-3, atol=1e-12)
    for flag, name in NAMES.items():
        rows = table(text, f"volume (element, volume) for set {name.upper()} and time")
        of_flag = np.flatnonzero(model.flags[tuple(order.T)] == flag)
        # CalculiX found these elements in the set, each of the volume of the cell that has this number
        np.testing.assert_array_equal(rows[:, 0].astype(int) - 1, of_flag)
        np.testing.assert_allclose(rows[:, 1], model.volumes[tuple(order[of_flag].T)] * 1e-9, rtol=1e-5)
    for place, side in enumerate(SIDES):
        found = table(text, f"displacements (vx,vy,vz) for set {side} and time")[:, 0].astype(int)
        end = model.lines[place // 2][-(place % 2)] * 1e-3
        assert sorted(found) == sorted(number for number, at in nodes.items() if abs(at[place // 2] - end) < 1e-12), side
    for flag, name in NAMES.items():
        # area and centre of the surface, as CalculiX adds them up
        said = text.split(f"statistics for surface set S_{name.upper()} ")[1].split("\n")
        centre, area = (np.array([float(word) for word in said[said.index(title) + 2].split()]) for title in TITLES)
        areas, centres = sides_of(model, flag)
        assert area[0] == pytest.approx(areas.sum() * 1e-6, rel=1e-6)
        np.testing.assert_allclose(centre[:3], (areas[:, None] * centres).sum(axis=0) / areas.sum() * 1e-3, rtol=1e-6)


def sides_of(model: Model, flag: int) -> tuple[np.ndarray, np.ndarray]:
    """Areas and middles of the faces between cells of a flag and others, and at the sides of the box."""
    padded = np.pad(model.flags.astype(int), 1, constant_values=-1)
    areas, middles = [], []
    for axis in range(3):
        sizes = np.meshgrid(*[np.diff(lines) for lines in model.lines], indexing="ij")
        across = np.prod([sizes[other] for other in range(3) if other != axis], axis=0)
        for shift in (1, -1):
            beside = np.roll(padded, shift, axis)[1:-1, 1:-1, 1:-1]
            outer = (model.flags == flag) & (beside != flag)
            areas.append(across[outer])
            middle = model.centres[outer].copy()
            middle[:, axis] -= shift * sizes[axis][outer] / 2
            middles.append(middle)
    return np.concatenate(areas), np.concatenate(middles)


def read(model: Model) -> tuple[dict[int, list[float]], dict[int, list[int]]]:
    """Nodes and elements of m.inp."""
    nodes: dict[int, list[float]] = {}
    elements: dict[int, list[int]] = {}
    part = ""
    for line in (model.folder / "m.inp").read_text().splitlines():
        if line.startswith("*"):
            part = line.split(",")[0]
        elif part in ("*NODE", "*ELEMENT"):
            words = line.split(",")
            if part == "*NODE":
                nodes[int(words[0])] = [float(word) for word in words[1:]]
            else:
                elements[int(words[0])] = [int(word) for word in words[1:]]
    return nodes, elements


def test_a_cantilever(tmp_path) -> None:
    """Tip of a beam of 20 x 1 x 1 mm under 1 N: L^3 / 3 E I + L / k G A."""
    save(tmp_path / "beam.stl", cuboid((0, 0, 0), (20, 1, 1)))
    arguments = ["beam.stl:E=2.1e11,nu=0.3", "--cell-size", "0.25", "--unit", "mm", "--backend", "cpu"]
    hexcast("mesh", *arguments, "-o", "m.inp", cwd=tmp_path)
    # the load of a node: as many quarters of an element's share as it has elements
    lines = (tmp_path / "m.inp").read_text().splitlines()
    start = lines.index("*NODE, NSET=NALL") + 1
    nodes = [line.split(",") for line in lines[start : start + 81 * 25]]
    tip = [(int(n), float(y), float(z)) for n, x, y, z in nodes if abs(float(x) - 0.02) < 1e-9]
    assert len(tip) == 25
    share = {n: (1 if y in (0, 1e-3) else 2) * (1 if z in (0, 1e-3) else 2) for n, y, z in tip}
    total = sum(share.values())
    loads = "\n".join(f"{n}, 3, {-part / total:.9e}" for n, part in share.items())
    (tmp_path / "run.inp").write_text(
        f"*INCLUDE, INPUT=m.inp\n*BOUNDARY\nXMIN, 1, 3\n*STEP\n*STATIC\n*CLOAD\n{loads}\n*NODE PRINT, NSET=XMAX\nU\n*END STEP\n"
    )
    run("ccx", "run", cwd=tmp_path)
    rows = table((tmp_path / "run.dat").read_text(), "displacements (vx,vy,vz) for set XMAX and time")
    length, side, modulus, nu = 0.02, 1e-3, 2.1e11, 0.3
    shear = modulus / 2 / (1 + nu)
    theory = length**3 / 3 / modulus / (side**4 / 12) + length / (5 / 6 * shear * side**2)
    print("tip", -rows[:, 3].mean(), "theory", theory)
    assert -rows[:, 3].mean() == pytest.approx(theory, rel=0.01)


def ring(inner: float, outer: float, height: float, sides: int = 256) -> dict[str, np.ndarray]:
    """A thick pipe around z as four solids."""
    turns = 2 * np.pi * (np.arange(sides + 1) % sides) / sides
    circle = np.stack([np.cos(turns), np.sin(turns)], 1)
    solids: dict[str, list] = {"bore": [], "outer": [], "low": [], "high": []}

    def quad(name: str, a, b, c, d) -> None:
        solids[name] += [[a, b, c], [a, c, d]]

    for one, other in zip(circle, circle[1:]):
        low, high = ([(*(p * r), z) for r in (inner, outer) for p in (one, other)] for z in (0.0, height))
        quad("bore", low[0], high[0], high[1], low[1])
        quad("outer", low[2], low[3], high[3], high[2])
        quad("low", low[0], low[1], low[3], low[2])
        quad("high", high[0], high[2], high[3], high[1])
    return {name: np.array(facets) for name, facets in solids.items()}


def test_a_pipe_with_pressure_in_its_bore_alone_widens_as_lame_says(tmp_path) -> None:
    """A quarter of a pipe between two planes: u = (1 + nu) p a^2 / E (b^2 - a^2) ((1 - 2 nu) r + b^2 / r)."""
    inner, outer, size = 1.0, 2.0, 1 / 24
    save_solids(tmp_path / "pipe.stl", ring(inner, outer, size))
    domain = ["--domain", f"0,0,0,{outer},{outer},{size}", "--dims", "48,48,1", "--unit", "mm", "--backend", "cpu"]
    hexcast("mesh", "pipe.stl:E=2.1e11,nu=0.3", *domain, "-o", "m.inp", "--patches", "solid", cwd=tmp_path)
    text = (tmp_path / "m.inp").read_text()
    names = [line.split("NAME=")[1].split(",")[0] for line in text.splitlines() if line.startswith("*SURFACE")]
    # the box cuts the pipe across x and y
    assert sorted(names) == ["S_pipe", "S_pipe_XMIN", "S_pipe_YMIN", "S_pipe_bore", "S_pipe_high", "S_pipe_low", "S_pipe_outer"]
    pressure = 1e6
    (tmp_path / "run.inp").write_text(
        f"""*INCLUDE, INPUT=m.inp
*BOUNDARY
XMIN, 1, 1
YMIN, 2, 2
NALL, 3, 3
*STEP
*STATIC
*DSLOAD
S_pipe_bore, P, {pressure}
*NODE PRINT, NSET=NALL
U
*END STEP
"""
    )
    run("ccx", "run", cwd=tmp_path)
    rows = table((tmp_path / "run.dat").read_text(), "displacements (vx,vy,vz) for set NALL and time")
    start = text.splitlines().index("*NODE, NSET=NALL") + 1
    places = {}
    for line in text.splitlines()[start:]:
        if line.startswith("*"):
            break
        number, *place = line.split(",")
        places[int(number)] = [float(word) for word in place]
    place = np.array([places[int(number)] for number in rows[:, 0]])[:, :2]
    radius = np.hypot(*place.T)
    moved = (rows[:, 1:3] * place).sum(axis=1) / radius
    a, b, modulus, nu = inner * 1e-3, outer * 1e-3, 2.1e11, 0.3
    theory = (1 + nu) * pressure * a**2 / modulus / (b**2 - a**2) * ((1 - 2 * nu) * radius + b**2 / radius)
    middle = (radius > 1.2e-3) & (radius < 1.8e-3)
    ratio = (moved / theory)[middle]
    print("pipe under pressure: moved by", ratio.mean(), "of Lame's solution, from", ratio.min(), "to", ratio.max())
    assert ratio.mean() == pytest.approx(1, rel=0.02)
