"""Writes files beside their names, and gives them these when all is written."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, Optional, Union

from . import _hexcast
from ._error import Error, MeshWarning

#: zlib level where the caller does not say, as in the command.
DEFAULT_LEVEL = 6
#: Endings of what is compressed then.
COMPRESSED = (".vti", ".vtr", ".npz", ".hxc", ".zarr", ".zarr.zip")


def save(mesh: _hexcast.RawMesh, path: Union[str, os.PathLike[str]], compress: Union[int, Literal["none"], None], options: Mapping[str, Any]) -> None:
    """See :meth:`hexcast.Mesh.save`."""
    name = os.fspath(path)
    level = None if compress is None else level_of(compress, name) or 0
    given = {"compress": level, **options}
    text = json.dumps({key: value for key, value in given.items() if value is not None})
    if "://" in name:
        with tempfile.TemporaryDirectory(prefix="hexcast-") as folder:
            new = Path(folder, name.rstrip("/").rsplit("/", 1)[-1])
            lacks = mesh.save(str(new), text, [])
            names = sorted(made.name for made in Path(folder).iterdir())
            if names not in ([new.name], [new.name, f"{new.name}.json"]):
                raise Error(f"{name} would be {len(names)} files: {', '.join(names)}", "job-conflict", "save it in a folder, and copy that")
            upload(new, name)
    else:
        lacks = mesh.save(name, text, inputs_of(mesh))
    for said in lacks:
        # the caller of Mesh.save
        warnings.warn(MeshWarning({"code": "file-lacks", "sentence": f"{name}: {said}"}), stacklevel=3)


@contextmanager
def replace(path: Union[str, os.PathLike[str]]) -> Iterator[Path]:
    """A path to write a file or a folder to, which gets its name when all is written."""
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
        sidecar = new.with_name(f"{new.name}.json")
        if sidecar.exists():
            system.pipe_file(f"{place}.json", sidecar.read_bytes())
    except OSError as error:
        raise Error(f"{url} cannot be written: {error}", "io", "make sure that the bucket is there and yours") from error


def level_of(compress: Union[int, Literal["none"], None], name: str) -> Optional[int]:
    """The zlib level; None for none."""
    if compress is None:
        return DEFAULT_LEVEL if name.lower().endswith(COMPRESSED) else None
    if compress == "none":
        return None
    if not isinstance(compress, int) or not 1 <= compress <= 9:
        raise Error(f"compress is {compress!r}", "job-value", 'give 1 (fast) to 9 (small), or "none"')
    return compress


def inputs_of(mesh: _hexcast.RawMesh) -> list[str]:
    """The files that a mesh was made of, which none of its own replaces."""
    return [of["file"] for of in json.loads(mesh.report).get("inputs", []) if of.get("blake3") is not None]


def check_replaceable(folder: Path) -> None:
    """Refuses to replace what is no Zarr folder."""
    if folder.exists() and not (folder / "zarr.json").is_file():
        raise Error(f"{folder} exists and is not a Zarr folder", "io", "name another")
