"""The flow through a pipe by OpenFOAM, on cells of hexcast and of snappyHexMesh, beside Poiseuille's."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import foam
import numpy as np
from conftest import rod, save

#: In mm; the pressure over the density in m^2 / s^2.
RADIUS, LENGTH, PRESSURE = 5.0, 20.0, 1.6e-5

SNAPPY = """castellatedMesh true; snap true; addLayers false; geometry {tube.stl {type triSurfaceMesh; name tube;}}
castellatedMeshControls {maxLocalCells 1000000; maxGlobalCells 2000000; minRefinementCells 0; nCellsBetweenLevels 1; features ();
refinementSurfaces {tube {level (0 0);}} resolveFeatureAngle 30; refinementRegions {} locationInMesh (0.0101 0.0001 0.0001); allowFreeStandingZoneFaces true;}
snapControls {nSmoothPatch 3; tolerance 2; nSolveIter 30; nRelaxIter 5; nFeatureSnapIter 10; implicitFeatureSnap true; explicitFeatureSnap false; multiRegionFeatureSnap false;}
addLayersControls {relativeSizes true; layers {} expansionRatio 1; finalLayerThickness 0.3; minThickness 0.1; nGrow 0; featureAngle 30; nRelaxIter 3; nSmoothSurfaceNormals 1;
nSmoothNormals 3; nSmoothThickness 10; maxFaceThicknessRatio 0.5; maxThicknessToMedialRatio 0.3; minMedianAxisAngle 90; nBufferCellsNoExtrude 0; nLayerIter 50;}
meshQualityControls {maxNonOrtho 65; maxBoundarySkewness 20; maxInternalSkewness 4; maxConcave 80; minVol 1e-16; minTetQuality 1e-30; minArea -1; minTwist 0.02;
minDeterminant 0.001; minFaceWeight 0.05; minVolRatio 0.01; minTriangleTwist -1; nSmoothScale 4; errorReduction 0.75; relaxed {maxNonOrtho 75;}} mergeTolerance 1e-6;"""


def block(cells: int) -> str:
    """Cells around the pipe, for snappyHexMesh to cut: as large as hexcast's across, twice as long."""
    n = cells + 2
    x, w = LENGTH * 1e-3, n * RADIUS / cells * 1e-3
    corners = " ".join(f"({a} {b} {c})" for c in (-w, w) for a, b in ((0, -w), (x, -w), (x, w), (0, w)))
    ends = "xMin {type patch; faces ((0 4 7 3));} xMax {type patch; faces ((1 2 6 5));}"
    sides = "sides {type wall; faces ((0 1 5 4) (3 7 6 2) (0 3 2 1) (4 5 6 7));}"
    return f"convertToMeters 1; vertices ({corners}); blocks (hex (0 1 2 3 4 5 6 7) ({cells} {n} {n}) simpleGrading (1 1 1)); boundary ({ends} {sides});"


def solve(case: Path, walls: str, measured: Callable) -> tuple[float, dict]:
    """How far the flow out of a pipe is off, and what the solver takes."""
    speed = f'"{walls}" {{type noSlip;}} "x.*" {{type zeroGradient;}}'
    pressure = f'xMin {{type fixedValue; value uniform {PRESSURE};}} xMax {{type fixedValue; value uniform 0;}} "{walls}" {{type zeroGradient;}}'
    foam.fields(case, speed, pressure)
    _, run = measured("simpleFoam", "-case", case, cwd=case.parent)
    last = max((path for path in case.iterdir() if path.name.isdigit()), key=lambda path: int(path.name))
    poiseuille = np.pi * (RADIUS * 1e-3) ** 4 * PRESSURE / (8e-6 * LENGTH * 1e-3)
    return foam.flow_out(last, "xMax") / poiseuille - 1, run


def flows(hexcast: str, folder: Path, measured: Callable, sizes: list[int]) -> Iterator[tuple]:
    """Program, cells across, how far the flow is off, and the costs of mesh and run."""
    facets = rod(RADIUS, 30.0, 720) - np.array([5.0, 0, 0])
    save(folder / "tube.stl", facets)
    for cells in sizes:
        box = ["--domain", f"0,{-RADIUS},{-RADIUS},{LENGTH},{RADIUS},{RADIUS}", "--dims", f"{cells},{cells},{cells}"]
        for name, more in (("whole cells", []), ("`--cut`", ["--cut"])):
            case = folder / f"pipe{cells}{len(more)}"
            foam.system(case)
            _, mesh = measured(hexcast, "mesh", "tube.stl:name=fluid", *box, "--unit", "mm", "--backend", "cpu", *more, "-o", case / "a.foam", cwd=folder)
            off, run = solve(case, "y.*|z.*|background", measured)
            yield f"hexcast, {name}", cells, off, mesh, run
        case = folder / f"snappy{cells}"
        foam.system(case)
        (case / "constant/triSurface").mkdir(parents=True)
        save(case / "constant/triSurface/tube.stl", facets * 1e-3)
        foam.write(case / "system/blockMeshDict", "dictionary", block(cells))
        foam.write(case / "system/snappyHexMeshDict", "dictionary", SNAPPY)
        _, blocks = measured("blockMesh", "-case", case, cwd=folder)
        _, mesh = measured("snappyHexMesh", "-overwrite", "-case", case, cwd=folder)
        mesh = {"s": blocks["s"] + mesh["s"], "mib": max(blocks["mib"], mesh["mib"])}
        off, run = solve(case, "tube|sides", measured)
        yield "snappyHexMesh", cells, off, mesh, run
