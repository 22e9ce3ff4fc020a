"""Writes files beside their names, and gives them these when all is written."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Literal, Optional, Union

from . import _hexcast
from ._error import Error

#: zlib level where the caller does not say, as in the command.
DEFAULT_LEVEL = 6


def save(
    mesh: _hexcast.RawMesh,
    path: Union[str, os.PathLike[str]],
    compress: Union[int, Literal["none"], None],
    bits: bool,
) -> None:
    """See :meth:`hexcast.Mesh.save`."""
    target = Path(path)
    level = level_of(compress, target)
    if bits and target.suffix.lower() == ".zarr":
        raise Error("Zarr has no bit-packed variant", "job-conflict", "use .raw or .npy")
    check_not_read(mesh, target)
    try:
        with tempfile.TemporaryDirectory(prefix=".hexcast-", dir=target.parent) as folder:
            new = Path(folder, "new")
            if target.suffix.lower() == ".zarr":
                check_replaceable(target)
                mesh.write_zarr(str(target), new, level)
                if target.exists():
                    target.rename(Path(folder, "old"))
                new.rename(target)
                return
            sidecar = mesh.write(str(target), new, level, bits)
            if sidecar is not None:
                beside = Path(folder, "sidecar")
                beside.write_text(sidecar, encoding="utf-8")
                beside.replace(target.with_name(target.name + ".json"))
            new.replace(target)
    except OSError as error:
        raise Error(f"{target} cannot be written: {error}", "io", "make sure that the folder is there and yours") from error


def level_of(compress: Union[int, Literal["none"], None], target: Path) -> Optional[int]:
    """The zlib level; None for none."""
    if compress is None:
        return DEFAULT_LEVEL if target.name.lower().endswith((".vti", ".hxc", ".zarr", ".zarr.zip")) else None
    if compress == "none":
        return None
    if not isinstance(compress, int) or not 1 <= compress <= 9:
        raise Error(f"compress is {compress!r}", "job-value", 'give 1 (fast) to 9 (small), or "none"')
    return compress


def check_not_read(mesh: _hexcast.RawMesh, target: Path) -> None:
    """Refuses to write over a surface of the mesh, by whatever name, or to replace a folder that has one."""
    files = [Path(of["file"]) for of in json.loads(mesh.report).get("inputs", []) if of.get("sha256") is not None]
    files = [file for file in files if file.is_file()]
    for written in (target, target.with_name(target.name + ".json")):
        for file in files:
            is_inside = target.suffix.lower() == ".zarr" and target.resolve() in file.resolve().parents
            if is_inside or (written.exists() and file.samefile(written)):
                raise Error(f"{target} would be written over {file}, an input of the mesh", "job-conflict", "give it another name")


def check_replaceable(folder: Path) -> None:
    """Refuses to replace what is no Zarr folder."""
    if folder.exists() and not (folder / "zarr.json").is_file():
        raise Error(f"{folder} exists and is not a Zarr folder", "io", "name another")
