"""Meep alone, with its own shapes: frequency of a mode of a ball or a round waveguide in metal, of radius 1, or of a lattice of dielectric rods.

usage: meep_modes.py ball|guide|rods CELLS KIND (averaged | sharp) [mesh]; with "mesh" it makes the grid and ends
"""

import sys

import meep as mp

mp.verbosity(0)
what, cells, kind = sys.argv[1], int(sys.argv[2]), sys.argv[3]
if what == "rods":
    # as tests/solvers/rods.py has them
    simulation = mp.Simulation(
        cell_size=mp.Vector3(1, 1),
        resolution=cells,
        k_point=mp.Vector3(0.3, 0.1),
        geometry=[mp.Cylinder(0.2, center=mp.Vector3(0.013, -0.012), material=mp.Medium(epsilon=12))],
        sources=[mp.Source(mp.GaussianSource(0.28, fwidth=0.2), mp.Hz, mp.Vector3(0.11, 0.23))],
        eps_averaging=kind == "averaged",
    )
    listened = (mp.Hz, mp.Vector3(-0.21, 0.17), 0.28, 0.1)
    time = 100
else:
    # the grid lies around the centre as tests/solvers/yee.py has it
    size = 2 / cells
    side = size * (cells + 4)
    is_ball = what == "ball"
    x, y, z = (-size * part for part in (0.37, 0.21, 0.44))
    centre = mp.Vector3(x, y, z if is_ball else 0)
    shape = mp.Sphere(1, center=centre, material=mp.air) if is_ball else mp.Cylinder(1, center=centre, material=mp.air)
    field = mp.Ez if is_ball else mp.Hz
    mode = 0.43667 if is_ball else 0.29303
    source, probe = (centre, centre + mp.Vector3(0.2)) if is_ball else (centre + mp.Vector3(0.5, 0.2), centre + mp.Vector3(0.4, 0.4))
    simulation = mp.Simulation(
        cell_size=mp.Vector3(side, side, side if is_ball else 0),
        resolution=cells / 2,
        default_material=mp.metal,
        geometry=[shape],
        sources=[mp.Source(mp.GaussianSource(mode, fwidth=0.8 if is_ball else 0.3), field, source)],
    )
    listened = (field, probe, mode, 0.1)
    # 1.4 ns where the radius is 1 cm
    time = 42
if sys.argv[4:] == ["mesh"]:
    simulation.init_sim()
else:
    modes = mp.Harminv(*listened)
    simulation.run(mp.after_sources(modes), until_after_sources=time)
    print(max(modes.modes, key=lambda mode: abs(mode.amp)).freq)
