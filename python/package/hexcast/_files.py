"""Writes files beside their names, and gives them these when all is written."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, Optional, Union

from . import _hexcast
from ._error import Error

#: zlib level where the caller does not say, as in the command.
DEFAULT_LEVEL = 6
#: Endings of what is compressed then.
COMPRESSED = (".vti", ".vtr", ".npz", ".hxc", ".zarr", ".zarr.zip")


def save(
    mesh: _hexcast.RawMesh,
    path: Union[str, os.PathLike[str]],
    compress: Union[int, Literal["none"], None],
    bits: bool,
    table: Optional[Mapping[int, int]],
) -> None:
    """See :meth:`hexcast.Mesh.save`."""
    name = os.fspath(path)
    level = level_of(compress, name)
    is_store = name.lower().endswith(".zarr")
    if is_store and (bits or table):
        raise Error("Zarr holds the flags, a byte each", "job-conflict", "use .raw or .npy for bits, and these or .npz for a map")
    if "://" not in name:
        check_not_read(mesh, Path(name))
    with replace(path) as new:
        if is_store:
            mesh.write_zarr(name, new, level)
            return
        sidecar = mesh.write(name, new, level, (bits, numbers_of(table)))
        if sidecar is not None:
            new.with_name("new.json").write_text(sidecar, encoding="utf-8")


@contextmanager
def replace(path: Union[str, os.PathLike[str]]) -> Iterator[Path]:
    """A path to write a file or a folder to, which gets its name when all is written; so does the file ``new.json`` beside it."""
    name = os.fspath(path)
    if "://" in name:
        with tempfile.TemporaryDirectory(prefix="hexcast-") as folder:
            new = Path(folder, "new")
            yield new
            upload(new, name)
        return
    target = Path(name)
    try:
        with tempfile.TemporaryDirectory(prefix=".hexcast-", dir=target.parent) as folder:
            new = Path(folder, "new")
            if target.suffix.lower() == ".zarr":
                check_replaceable(target)
            yield new
            if new.is_dir():
                if target.exists():
                    target.rename(Path(folder, "old"))
                new.rename(target)
                return
            sidecar = new.with_name("new.json")
            if sidecar.exists():
                sidecar.replace(target.with_name(target.name + ".json"))
            new.replace(target)
    except Error:
        raise
    except OSError as error:
        raise Error(f"{target} cannot be written: {error}", "io", "make sure that the folder is there and yours") from error


def upload(new: Path, url: str) -> None:
    """Copies a file, or a store with its metadata last, to a place of fsspec's, such as a bucket."""
    scheme = url.split("://")[0]
    try:
        # it has no types
        fsspec: Any = import_module("fsspec")
        system, place = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError) as error:
        message = f"{url}: {error}"
        raise Error(message, "io", f"install fsspec and what it needs for {scheme}://, for a bucket s3fs") from error
    files = [new] if new.is_file() else sorted(new.rglob("*"), key=lambda file: (file.name == "zarr.json", file))
    try:
        if system.isdir(place) and not system.exists(f"{place}/zarr.json"):
            raise Error(f"{url} exists and is not a Zarr store", "io", "name another")
        if system.isdir(place):
            system.rm(place, recursive=True)
        for file in filter(Path.is_file, files):
            system.pipe_file(place if file == new else f"{place}/{file.relative_to(new).as_posix()}", file.read_bytes())
        sidecar = new.with_name("new.json")
        if sidecar.exists():
            system.pipe_file(f"{place}.json", sidecar.read_bytes())
    except OSError as error:
        raise Error(f"{url} cannot be written: {error}", "io", "make sure that the bucket is there and yours") from error


def numbers_of(table: Optional[Mapping[int, int]]) -> Optional[list[int]]:
    """What is written for each flag in its place."""
    if table is None:
        return None
    numbers = list(range(256))
    for flag, number in table.items():
        if not (0 <= int(flag) <= 255 and 0 <= int(number) <= 255):
            raise Error(f"map has {flag}: {number}", "job-value", "flags and what is written for them are 0 to 255")
        numbers[int(flag)] = int(number)
    return numbers


def level_of(compress: Union[int, Literal["none"], None], name: str) -> Optional[int]:
    """The zlib level; None for none."""
    if compress is None:
        return DEFAULT_LEVEL if name.lower().endswith(COMPRESSED) else None
    if compress == "none":
        return None
    if not isinstance(compress, int) or not 1 <= compress <= 9:
        raise Error(f"compress is {compress!r}", "job-value", 'give 1 (fast) to 9 (small), or "none"')
    return compress


def check_not_read(mesh: _hexcast.RawMesh, target: Path) -> None:
    """Refuses to write over a surface of the mesh, by whatever name, or to replace a folder that has one."""
    files = [Path(of["file"]) for of in json.loads(mesh.report).get("inputs", []) if of.get("blake3") is not None]
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
