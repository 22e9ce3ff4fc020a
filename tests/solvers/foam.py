"""Cases of OpenFOAM: the dictionaries that every program wants, and reading fields in text."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from conftest import run

SCHEMES = """
ddtSchemes {default steadyState;} gradSchemes {default Gauss linear;}
divSchemes {default none; div(phi,U) Gauss linear; div((nuEff*dev2(T(grad(U))))) Gauss linear;}
laplacianSchemes {default Gauss linear corrected;} interpolationSchemes {default linear;} snGradSchemes {default corrected;}
"""
SOLUTION = """
solvers {
    p {solver PCG; preconditioner DIC; tolerance 1e-14; relTol 0.001;}
    U {solver smoothSolver; smoother symGaussSeidel; tolerance 1e-14; relTol 0.01;}
}
SIMPLE {consistent yes; nNonOrthogonalCorrectors 0; residualControl {p 1e-6; U 1e-7;}}
relaxationFactors {equations {U 0.9;}}
"""
CONTROL = """
application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 300; deltaT 1;
writeControl timeStep; writeInterval 300; writeFormat ascii; writePrecision 12;
"""


def write(path: Path, kind: str, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"FoamFile {{version 2.0; format ascii; class {kind}; object {path.name};}}\n{text}\n")


def system(case: Path) -> None:
    for name, text in (("controlDict", CONTROL), ("fvSchemes", SCHEMES), ("fvSolution", SOLUTION)):
        write(case / "system" / name, "dictionary", text)


def fields(case: Path, speed: str, pressure: str) -> None:
    """Water at rest, given what holds at the patches."""
    at = "internalField uniform"
    write(case / "0/U", "volVectorField", f"dimensions [0 1 -1 0 0 0 0]; {at} (0 0 0); boundaryField {{{speed}}}")
    write(case / "0/p", "volScalarField", f"dimensions [0 2 -2 0 0 0 0]; {at} 0; boundaryField {{{pressure}}}")
    write(case / "constant/transportProperties", "dictionary", "transportModel Newtonian; nu 1e-6;")
    write(case / "constant/turbulenceProperties", "dictionary", "simulationType laminar;")


def flow(case: Path, speed: str, pressure: str) -> Path:
    """Solves for the laminar flow of water between walls, given what holds at the patches; the folder of the last step."""
    fields(case, speed, pressure)
    run("simpleFoam", "-case", case, cwd=case.parent)
    return max((path for path in case.iterdir() if path.name.isdigit()), key=lambda path: int(path.name))


def flow_out(folder: Path, patch: str) -> float:
    """The flow through a patch, in the fields of a step."""
    text = (folder / "phi").read_text()
    flux = re.search(r"value\s+nonuniform List<scalar>\s*\d*\s*\(([^)]*)\)", text[text.index(patch) :])
    assert flux is not None
    return sum(map(float, flux[1].split()))


def values(path: Path) -> np.ndarray:
    """The values inside of a field in text: a number or three for each cell."""
    text = path.read_text()
    start = text.index("(", text.index("nonuniform")) + 1
    rows = text[start : text.index("\n)", start)].split("\n")
    return np.array([[float(word) for word in row.strip("() ").split()] for row in rows if row.strip()])
