"""Known answers by hexcast and by openEMS, gprMax, Meep and snappyHexMesh: how far each is off, and what its mesh and its run take.

usage: compare.py HEXCAST FOLDER [--quick]; prints a row a line, as JSON

Every mesh and every run is a process of its own, on one thread; processor time and memory are those of that process.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "tests/solvers"))
import pipes
import rods
import yee
from cavity import theory
from pipe import pipe_of, save_pipe
from ringing import MIDDLE, SECONDS, WIDTH, frequency_of

ENVIRONMENT = {
    **os.environ,
    **{name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")},
    "WM_PROJECT_DIR": "/usr/share/openfoam",
}
#: For which Debian's Meep is.
MEEP = ["/usr/bin/python3", HERE / "meep_modes.py"]
SOLVE = [sys.executable, HERE / "solve.py"]
Cost = dict[str, float]


def measured(*command: object, cwd: Path, code: int = 0) -> tuple[str, Cost]:
    """What a command printed and took."""
    launcher = [sys.executable, "-I", "-S", HERE / "measured.py", cwd / "cost.json"]
    words = [str(word) for word in (*launcher, *command)]
    done = subprocess.run(words, cwd=cwd, env=ENVIRONMENT, text=True, capture_output=True, check=False)
    if done.returncode != code:
        sys.exit(f"{command}: exit code {done.returncode}\n{(done.stdout + done.stderr)[-3000:]}")
    return done.stdout, json.loads((cwd / "cost.json").read_text())


def row(problem: str, program: str, cells: int, off: float, mesh: Cost, run: Cost) -> None:
    print(json.dumps({"problem": problem, "program": program, "cells": cells, "off": off, "mesh": mesh, "run": run}), flush=True)


def number(said: str) -> float:
    return float(said.split()[0])


def openems(folder: Path, structure: str, size: float) -> tuple[float, Cost, Cost]:
    """Rings a ball of radius 1 cm: its frequency, what making the operator alone takes, and the whole run."""
    lines = [lines.split(",") for lines in re.findall(r"<.Lines[^>]*>([^<]*)<", structure)]
    x, y, z = (min(range(len(of)), key=lambda at: abs(float(of[at]))) for of in lines)
    dt = size * 1e-2 / 299792458 / np.sqrt(3)

    def line(x: int) -> str:
        ends = "".join(f'<P{i} X="{lines[0][x]}" Y="{lines[1][y]}" Z="{lines[2][z + i - 1]}"/>' for i in (1, 2))
        return f'<Primitives><Box Priority="30">{ends}</Box></Primitives>'

    added = f"""<Excitation ID="8" Name="e" Number="0" Enabled="1" Frequency="0" Delay="0" Type="0" Excite="0,0,1" PropDir="0,0,0">{line(x)}</Excitation>
<ProbeBox ID="9" Name="ut" Number="0" Type="0" Weight="1" NormDir="-1">{line(x + round(0.2 / size))}</ProbeBox></Properties>"""
    settings = f"""<FDTD NumberOfTimesteps="{int(1.05 * SECONDS / dt)}" endCriteria="1e-30" f_max="80e9"><Excitation Type="0" f0="{MIDDLE}" fc="{WIDTH}"/>
<BoundaryCond xmin="PEC" xmax="PEC" ymin="PEC" ymax="PEC" zmin="PEC" zmax="PEC"/></FDTD>"""
    structure = re.sub(r"<\?xml.*?\?>", "", structure).replace("</Properties>", added)
    (folder / "run.xml").write_text(f'<?xml version="1.0"?><openEMS>{settings}{structure}</openEMS>')
    command = ["openEMS", "run.xml", "--engine=multithreaded", "--numThreads=1"]
    # which is an error to openEMS
    _, made = measured(*command, "--no-simulation", cwd=folder, code=1)
    _, run = measured(*command, cwd=folder)
    time, voltage = np.loadtxt(folder / "ut", comments="%", unpack=True)[:2]
    return frequency_of(time, voltage), made, run


def with_own_ball(structure: str, low: np.ndarray, high: np.ndarray) -> str:
    """The lines of hexcast's file with openEMS's own box and sphere."""
    ends = "".join(f'<P{i} X="{p[0]}" Y="{p[1]}" Z="{p[2]}"/>' for i, p in ((1, low), (2, high)))
    own = f"""<Properties><Metal ID="0" Name="metal"><Primitives><Box Priority="10">{ends}</Box></Primitives></Metal>
<Material ID="1" Name="ball"><Property Epsilon="1"/><Primitives><Sphere Priority="20" Radius="1"><Center X="0" Y="0" Z="0"/></Sphere></Primitives></Material></Properties>"""
    return re.sub(r"<Properties>.*</Properties>", own, structure, flags=re.DOTALL)


def gprmax(folder: Path, geometry: str, low: np.ndarray, size: float) -> tuple[float, Cost, Cost]:
    """The same by gprMax, whose domain begins at 0."""
    x, y, z = size * np.rint(-low / size) * 1e-2
    (folder / "run.in").write_text(
        f"""#title: ball
#omp_threads: 1
#time_window: {SECONDS}
#pml_cells: 0
{geometry}
#waveform: gaussiandot 1 {MIDDLE} w
#hertzian_dipole: z {x!s} {y!s} {z!s} w
#rx: {x + size * round(0.2 / size) * 1e-2!s} {y!s} {z!s}
"""
    )
    command = [sys.executable, "-m", "gprMax", "run.in"]
    _, made = measured(*command, "--geometry-only", cwd=folder)
    _, run = measured(*command, cwd=folder)
    with h5py.File(folder / "run.h5") as file:
        voltage = file["rxs/rx1/Ez"][:].astype(float)
        return frequency_of(np.arange(len(voltage)) * file.attrs["dt"], voltage), made, run


def balls(hexcast: str, folder: Path, sizes: list[int]) -> None:
    """TM011 of a ball in metal."""
    yee.save_ball(folder)
    of_theory = theory(10.0)
    for cells in sizes:
        size, n, low = yee.box(cells)
        job = yee.ball_of(cells, unit="cm")

        def add(program: str, frequency: float, mesh: Cost, run: Cost, cells: int = cells) -> None:
            row("ball", program, cells, frequency / of_theory - 1, mesh, run)

        for stable, name in (("0.125", "hexcast `--conformal`, NumPy"), ("0.25", "the same, `--stable 0.25`")):
            _, mesh = measured(hexcast, *job, "--conformal", "ball.npz", "--stable", stable, cwd=folder)
            said, run = measured(*SOLVE, "ball", "ball.npz", cwd=folder)
            add(name, number(said), mesh, run)
        _, mesh = measured(hexcast, *job, "-o", "b.csx.xml", cwd=folder)
        structure = (folder / "b.csx.xml").read_text()
        found, _, run = openems(folder, structure, size)
        add("openEMS, cells of hexcast", found, mesh, run)
        found, made, run = openems(folder, with_own_ball(structure, low, low + n * size), size)
        add("openEMS, its own sphere", found, made, run)
        _, mesh = measured(hexcast, *job, "-o", "b.in", cwd=folder)
        found, _, run = gprmax(folder, "#include_file: b.in", low, size)
        add("gprMax, cells of hexcast", found, mesh, run)
        side, step = n * size * 1e-2, size * 1e-2
        middle = " ".join(str(float(-at * 1e-2)) for at in low)
        own = f"""#domain: {side} {side} {side}
#dx_dy_dz: {step} {step} {step}
#box: 0 0 0 {side} {side} {side} pec
#sphere: {middle} 0.01 free_space y"""
        found, made, run = gprmax(folder, own, low, size)
        add("gprMax, its own sphere", found, made, run)
        _, made = measured(*MEEP, "ball", cells, "averaged", "mesh", cwd=folder)
        said, run = measured(*MEEP, "ball", cells, "averaged", cwd=folder)
        add("Meep, its own sphere", number(said) * 299792458 / 1e-2, made, run)


def guides(hexcast: str, folder: Path, sizes: list[int]) -> None:
    """TE11 of a round waveguide in metal."""
    yee.save_guide(folder)
    for cells in sizes:
        _, mesh = measured(hexcast, *yee.guide_of(cells), "--conformal", "guide.npz", cwd=folder)
        said, run = measured(*SOLVE, "guide", "guide.npz", cells, cwd=folder)
        row("guide", "hexcast `--conformal`, SciPy", cells, number(said), mesh, run)
        _, made = measured(*MEEP, "guide", cells, "averaged", "mesh", cwd=folder)
        said, run = measured(*MEEP, "guide", cells, "averaged", cwd=folder)
        row("guide", "Meep, its own cylinder", cells, number(said) * 2 * np.pi / yee.OF_WAVEGUIDE - 1, made, run)


def lattices(hexcast: str, folder: Path, sizes: list[int]) -> None:
    """The first mode of a lattice of dielectric rods."""
    rods.save_rod(folder)
    for cells in sizes:
        for kind, name, output in (("full", "tensors", "--tensors"), ("flags", "flags", "--staggered")):
            _, mesh = measured(hexcast, *rods.rods_of(cells), output, "eps.npz" if kind == "full" else "yee.npz", cwd=folder)
            said, run = measured(*SOLVE, "rods", folder, cells, kind, cwd=folder)
            row("rods", f"hexcast, {name}, SciPy", cells, number(said) / rods.MODES[0] - 1, mesh, run)
        for kind, name in (("averaged", "its own smoothing"), ("sharp", "without smoothing")):
            _, made = measured(*MEEP, "rods", cells, kind, "mesh", cwd=folder)
            said, run = measured(*MEEP, "rods", cells, kind, cwd=folder)
            row("rods", f"Meep, {name}", cells, number(said) / rods.MODES[0] - 1, made, run)


def boltzmann(hexcast: str, folder: Path, sizes: list[int]) -> None:
    """Poiseuille's flow by lattice Boltzmann."""
    save_pipe(folder)
    for cells in sizes:
        _, mesh = measured(hexcast, *pipe_of(cells), "--links", "pipe.npz", "--stencil", "D3Q19", cwd=folder)
        for kind, name in (("flags", "half-way from flags"), ("links", "Bouzidi with links")):
            said, run = measured(*SOLVE, "pipe", "pipe.npz", cells, kind, cwd=folder)
            row("boltzmann", f"hexcast, {name}, NumPy", cells, number(said), mesh, run)


def main(hexcast: str, folder: Path, *, is_quick: bool) -> None:
    sizes = [16] if is_quick else [16, 32, 48, 64]
    balls(hexcast, folder, sizes)
    guides(hexcast, folder, [16] if is_quick else [16, 32, 64, 128])
    lattices(hexcast, folder, [16] if is_quick else [16, 32, 64, 128])
    boltzmann(hexcast, folder, [8] if is_quick else [8, 16, 32])
    for one in pipes.flows(hexcast, folder, measured, [8] if is_quick else [8, 16]):
        row("pipe", *one)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]).absolute(), is_quick="--quick" in sys.argv)
