"""A slice of a mesh by coordinates, with xarray.

    python xarray_slice.py spot.stl

Needs xarray.
"""

import sys

import hexcast


def main(file: str) -> None:
    data = hexcast.mesh(file, cells=64, unit="m", backend="cpu").to_xarray()
    # the plane of cells whose centres are nearest to z = 0
    plane = data.flag.sel(z=0.0, method="nearest")
    for row in plane.values[::-2]:
        print("".join(".#"[flag] for flag in row))
    share = float((plane != 0).mean())
    print(f"{share:.1%} of the plane at z = {float(plane.z):.4f} {plane.z.units} is inside")


if __name__ == "__main__":
    main(sys.argv[1])
