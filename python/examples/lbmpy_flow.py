"""Flow round the body in an STL file, by the lattice Boltzmann method of lbmpy.

    python lbmpy_flow.py spot.stl

Needs lbmpy and a C compiler.
"""

import sys

import numpy as np
from lbmpy import LBStencil, Method, Stencil
from lbmpy.boundaries import NoSlip
from lbmpy.lbstep import LatticeBoltzmannStep

import hexcast

STEPS = 200
FORCE = 1e-5


def main(file: str) -> None:
    # an empty box around the body, 40 cells from end to end of it
    mesh = hexcast.mesh(file, cells=40, padding={"cells": [12, 8, 8]}, backend="cpu")
    # lbmpy has the axes x, y, z
    solid = mesh.flags.T != 0
    flow = LatticeBoltzmannStep(
        domain_size=mesh.dims,
        periodicity=True,
        stencil=LBStencil(Stencil.D3Q19),
        method=Method.SRT,
        relaxation_rate=1.6,
        force=(FORCE, 0, 0),
    )


    def is_solid(*centres: np.ndarray) -> np.ndarray:
        """Whether cells are of the body; those beyond the box are those of the other side."""
        cells = [np.floor(centre).astype(int) % n for centre, n in zip(centres, mesh.dims)]
        return solid[tuple(cells)]

    flow.boundary_handling.set_boundary(NoSlip("body"), mask_callback=is_solid)
    flow.run(STEPS)
    velocity = np.asarray(flow.velocity[:, :, :])[..., 0]
    fluid = ~solid
    # far from the body the fluid is about as fast as the force alone would make it
    print(f"{solid.sum()} cells of the body, {fluid.sum()} of the fluid")
    print(f"speed along x: {velocity[fluid].mean():.3e} in the fluid, {STEPS * FORCE:.3e} without a body")


if __name__ == "__main__":
    main(sys.argv[1])
