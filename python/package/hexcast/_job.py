"""From what a caller gives to a job and its surfaces."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from . import _hexcast
from ._error import Error, InvalidType, missing
from ._options import GEOMETRY_KEYS, JOB_KEYS, GeometryOptions
from ._surface import Surface, SurfaceLike, scene_parts, surface

#: A surface, or a dict with a surface and its options.
Geometry = Union[SurfaceLike, GeometryOptions]
#: One geometry, a list of them, or a job: a dict with the key ``geometries``, or the name of a job file.
JobLike = Union[Geometry, Sequence[Geometry], Mapping[str, Any]]

#: Options of which one takes the place of all others.
EXCLUSIVE = (
    ("cells", "dims", "cell_size", "max_cell_size", "tolerance", "lines", "graded"),
    ("window", "part"),
)
#: Those of a job that give way to other numbers of cells.
SIZES = ("cells", "dims", "cell_size", "max_cell_size", "tolerance")
#: Most cells where nobody says, as in the command: more are a typing error in a size more often than a wish.
DEFAULT_MAX_CELLS = 10**12
#: Share of the available memory that a mesh may take.
SHARE_OF_MEMORY = 0.75


def job_of(what: JobLike, options: Mapping[str, Any]) -> tuple[str, list[Optional[Surface]]]:
    """The job as JSON, and for each of its geometries the surface, or None where it is read from its file."""
    check_names(options, JOB_KEYS, "option")
    given = {key: value for key, value in options.items() if value is not None}
    job = base_of(what)
    for group in EXCLUSIVE:
        # a tolerance alone changes that of the job
        if any(key in given and key != "tolerance" for key in group):
            job = {key: value for key, value in job.items() if key not in group}
    if "domain" in given:
        # padding belongs to the box that is overridden
        job = {key: value for key, value in job.items() if key != "padding"}
    job.update(given)
    job = {"max_cells": DEFAULT_MAX_CELLS, "max_memory": default_max_memory(), **job}
    expanded = [one for entry in job["geometries"] for one in meshes_of(entry)]
    entries = [entry_of(entry, number) for number, entry in enumerate(expanded, 1)]
    job["geometries"] = [entry for entry, _ in entries]
    return to_json(job), [source for _, source in entries]


def base_of(what: JobLike) -> dict[str, Any]:
    """The job before the caller's options."""
    if isinstance(what, Mapping) and "geometries" in what:
        check_names(what, ("geometries", *JOB_KEYS), "key")
        return {key: value for key, value in what.items() if value is not None}
    if isinstance(what, (str, os.PathLike)) and Path(what).suffix.lower() in (".toml", ".json"):
        return read_job(Path(what))
    # two arrays in a list are a surface as they are in a tuple
    if isinstance(what, list) and len(what) == 2 and all(isinstance(of, np.ndarray) and of.ndim == 2 for of in what):
        what = (what[0], what[1])
    return {"geometries": what if isinstance(what, list) else [what]}


def meshes_of(entry: Any) -> list[Any]:
    """The geometries that an entry stands for: those of a scene, or itself."""
    options = entry if isinstance(entry, Mapping) else {"source": entry}
    parts = scene_parts(options.get("source"))
    if parts is None:
        return [entry]
    return [{"name": name, **options, "source": made} for name, made in parts]


def read_job(path: Path) -> dict[str, Any]:
    """Reads a job file; names in it are relative to its folder."""
    if not path.exists():
        raise missing(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Error(f"{path} cannot be read: {error}", "io", "name a job file, TOML or JSON") from error
    try:
        job: dict[str, Any] = json.loads(_hexcast.read_job(text, path.suffix.lower() == ".json"))
    except Error as error:
        raise Error(f"{path}: {error.message}", error.code, error.hint) from None
    for geometry in job["geometries"]:
        geometry["file"] = str(path.parent / geometry["file"])
    return job


def entry_of(entry: Geometry, number: int) -> tuple[dict[str, Any], Optional[Surface]]:
    """A geometry for the job's JSON, and its surface if that is in memory."""
    if isinstance(entry, Mapping):
        given: dict[str, Any] = {key: value for key, value in entry.items() if value is not None}
    else:
        given = {"file" if isinstance(entry, (str, os.PathLike)) else "source": entry}
    check_names(given, GEOMETRY_KEYS, "geometry key")
    if ("file" in given) == ("source" in given):
        raise Error(f"geometry {number} needs either file or source", "job-conflict", "give one of them")
    if "file" in given:
        if not os.path.exists(given["file"]):
            raise missing(given["file"])
        return given, None
    name = given.get("name", f"surface {number}")
    if not isinstance(name, str):
        raise InvalidType(f"the name of geometry {number} is {name!r}", "job-value", "give a text")
    made = surface(given.pop("source"), name=name)
    return {"file": made.name, **given}, made


def to_json(job: dict[str, Any]) -> str:
    """Writes a job; numbers and lists of NumPy become plain ones."""
    for key, value in job.items():
        try:
            json.dumps(value, default=plain, allow_nan=False)
        except TypeError as error:
            raise InvalidType(f"{key}: {error}", "job-value", "use numbers, texts, lists and dicts") from error
        except ValueError as error:
            raise Error(f"{key} is {value!r}", "job-value", "give finite numbers") from error
    return json.dumps(job, default=plain)


def plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__qualname__} is neither a number, a text, a list nor a dict")


def default_max_memory() -> Optional[int]:
    """Three quarters of the memory that the system and the container leave; None where the system does not say."""
    available = _hexcast.available_bytes()
    return None if available is None else int(SHARE_OF_MEMORY * available)


def check_names(given: Iterable[object], names: Sequence[str], what: str) -> None:
    """Refuses a name that is not one of these, and names the nearest."""
    for name in given:
        if name in names:
            continue
        near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.0)
        message = f'there is no {what} "{name}"; the nearest is "{near[0]}"'
        raise InvalidType(message, "job-value", f"{what}s are {', '.join(names)}")
