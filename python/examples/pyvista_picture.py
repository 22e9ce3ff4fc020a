"""Draws the cells of a mesh with PyVista, without a window.

    python pyvista_picture.py spot.stl cells.png

Needs pyvista.
"""

import sys

import pyvista

import hexcast


def main(file: str, picture: str) -> None:
    # PyVista reads the file here, so that the surface comes from its arrays
    surface = pyvista.read(file)
    mesh = hexcast.mesh({"source": surface, "name": "spot"}, cells=64, backend="cpu")
    nx, ny, nz = mesh.dims
    grid = pyvista.ImageData(dimensions=(nx + 1, ny + 1, nz + 1), origin=mesh.origin, spacing=mesh.spacing)
    # VTK counts cells as hexcast does, x fastest
    grid.cell_data["flag"] = mesh.flags.ravel()
    cells = grid.threshold(0.5, scalars="flag")
    plotter = pyvista.Plotter(off_screen=True, window_size=(800, 600))
    plotter.add_mesh(cells, color="lightsteelblue", show_edges=True)
    plotter.add_mesh(surface, style="wireframe", color="black", opacity=0.1)
    plotter.screenshot(picture)
    print(f"{cells.n_cells} cells drawn in {picture}")


if __name__ == "__main__":
    main(*sys.argv[1:])
