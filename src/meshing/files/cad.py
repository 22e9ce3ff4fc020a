"""A STEP or IGES file -> its bodies as triangles, by Open CASCADE: a line of JSON and a 3MF file on standard output.

hexcast runs this in a process of its own, which can be ended at any time. The bodies and their names are those that the page
and the npm package give: the names of the assemblies and of the body, separated by slashes.

Arguments: file; step or iges; length of the unit in mm; its name in 3MF; largest distance of triangles from the surface, in that
unit, or 0; the same as a share of the longest side of the box. Exit codes: 3 where there is no Open CASCADE, 4 where it cannot
read the file; both with a sentence on standard error.
"""

import sys

# nothing of the folder that it runs in
sys.path[:] = [folder for folder in sys.path if folder]

import io
import json
import os
import re
import zipfile
from collections import Counter
from xml.sax.saxutils import quoteattr

try:
    import OCP
    from OCP.Bnd import Bnd_Box
    from OCP.BRep import BRep_Tool
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.IGESCAFControl import IGESCAFControl_Reader
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED, TopAbs_SHAPE, TopAbs_SHELL, TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

    try:
        from OCP.TDF import TDF_LabelSequence as Labels
    except ImportError:  # since OCP 8
        from OCP.collections import Sequence_TDF_Label as Labels
    # since OCP 8 without an ending
    face_of = getattr(TopoDS, "Face_s", None) or TopoDS.Face
except ImportError as error:
    print(error, file=sys.stderr)
    sys.exit(3)

# radians between the normals of triangles side by side, at most
ANGLE = 0.5
CORE = "http://schemas.microsoft.com/3dmanufacturing"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
TYPES = (
    f'{XML}<Types xmlns="{PACKAGE}/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    f'{XML}<Relationships xmlns="{PACKAGE}/relationships">'
    f'<Relationship Target="/3D/3dmodel.model" Id="model" Type="{CORE}/2013/01/3dmodel"/></Relationships>'
)


def read(file, kind):
    """Returns a document with the shapes of a file, their names and places, in mm."""
    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    reader = STEPCAFControl_Reader() if kind == "step" else IGESCAFControl_Reader()
    reader.SetNameMode(True)
    if reader.ReadFile(file) != IFSelect_RetDone or not reader.Transfer(document):
        print("Open CASCADE cannot read it", file=sys.stderr)
        sys.exit(4)
    return document


def name_of(label):
    name = TDataStd_Name()
    return name.Get().ToExtString() if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""


def labels(fill):
    found = Labels()
    fill(found)
    return [found.Value(at) for at in range(1, found.Length() + 1)]


def faces_of(shape, beside=TopAbs_SHAPE):
    return list(parts(shape, TopAbs_FACE, beside))


def parts(shape, kind, beside=TopAbs_SHAPE):
    explorer = TopExp_Explorer(shape, kind, beside)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def bodies(tool, label, place, path):
    """Yields the names that lead to each body, and its faces."""
    of = label
    if XCAFDoc_ShapeTool.IsReference_s(label):
        of = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(label, of)
        place = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
    name = name_of(of)
    path = [*path, name] if name else path
    if XCAFDoc_ShapeTool.IsAssembly_s(of):
        for part in labels(lambda found: XCAFDoc_ShapeTool.GetComponents_s(of, found)):
            yield from bodies(tool, part, place, path)
        return
    shape = XCAFDoc_ShapeTool.GetShape_s(of).Moved(place)
    for solid in [*parts(shape, TopAbs_SOLID), *parts(shape, TopAbs_SHELL, TopAbs_SOLID)]:
        part = TDF_Label()
        own = name_of(part) if tool.FindSubShape(of, solid, part) else ""
        yield ([*path, own] if own and own != name else path), faces_of(solid)
    loose = faces_of(shape, TopAbs_SHELL)
    if loose:
        yield path, loose


def plain(name):
    """A name without what separates the settings of a file on the command line, or cannot be shown."""
    return re.sub(r"[\s\x00-\x1f\x7f-\x9f\ud800-\udfff,:/]+", " ", name).strip()[:100]


def write_body(model, faces, mm):
    """Writes the corners and triangles of a body; returns how many triangles."""
    corners, triangles = [], []
    for face in faces:
        location = TopLoc_Location()
        surface = BRep_Tool.Triangulation_s(face_of(face), location)
        if surface is None:
            continue
        move = location.Transformation()
        first = len(corners) - 1
        for at in range(1, surface.NbNodes() + 1):
            point = surface.Node(at).Transformed(move)
            corners.append(f'<vertex x="{point.X() / mm:.9g}" y="{point.Y() / mm:.9g}" z="{point.Z() / mm:.9g}"/>\n')
        flips = (face.Orientation() == TopAbs_REVERSED) != move.IsNegative()
        for at in range(1, surface.NbTriangles() + 1):
            a, b, c = surface.Triangle(at).Get()
            b, c = (c, b) if flips else (b, c)
            triangles.append(f'<triangle v1="{first + a}" v2="{first + b}" v3="{first + c}"/>\n')
    model.write(f"<mesh><vertices>\n{''.join(corners)}</vertices><triangles>\n{''.join(triangles)}</triangles></mesh>")
    return len(triangles)


def main(file, kind, mm, unit, deviation, share):
    mm, deviation, share = float(mm), float(deviation), float(share)
    document = read(file, kind)
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    free = labels(tool.GetFreeShapes)
    box = Bnd_Box()
    for label in free:
        BRepBndLib.Add_s(XCAFDoc_ShapeTool.GetShape_s(label), box)
    if not deviation and not box.IsVoid():
        low, high = box.CornerMin(), box.CornerMax()
        deviation = share * max(high.X() - low.X(), high.Y() - low.Y(), high.Z() - low.Z()) / mm
    model = io.StringIO()
    model.write(f'{XML}<model unit="{unit}" xmlns="{CORE}/core/2015/02"><resources>\n')
    times, n_bodies = Counter(), 0
    for label in free:
        BRepMesh_IncrementalMesh(XCAFDoc_ShapeTool.GetShape_s(label), deviation * mm, False, ANGLE, True)
        for path, faces in bodies(tool, label, TopLoc_Location(), []):
            name = "/".join(part for part in map(plain, path) if part) or "body"
            times[name] += 1
            name = name if times[name] == 1 else f"{name} {times[name]}"
            model.write(f'<object id="{n_bodies + 1}" name={quoteattr(name)} type="model">')
            n_bodies += write_body(model, faces, mm) > 0
            model.write("</object>\n")
    items = "".join(f'<item objectid="{at + 1}"/>' for at in range(n_bodies))
    model.write(f"</resources><build>{items}</build></model>\n")
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as files:
        files.writestr("[Content_Types].xml", TYPES)
        files.writestr("_rels/.rels", RELATIONS)
        files.writestr("3D/3dmodel.model", model.getvalue())
    head = {"deviation": deviation, "bodies": n_bodies, "program": f"Open CASCADE {OCP.__version__}"}
    out.write(json.dumps(head).encode() + b"\n" + archive.getvalue())
    out.flush()


if __name__ == "__main__":
    # Open CASCADE prints on standard output
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    main(*sys.argv[1:])
