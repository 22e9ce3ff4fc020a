"""What can go wrong."""

from __future__ import annotations

import errno
import re
from typing import Any, cast


class Error(Exception):
    """Something that hexcast cannot do: ``str(error)`` is a sentence with the numbers, and what to do about it.

    Every error is also one of Python's own: a ``FileNotFoundError`` where there is no such file, another ``OSError`` where one cannot be
    read or written, a ``TypeError`` for an option that is not there or a value of the wrong type, a ``MemoryError`` where memory does not
    suffice, a ``RuntimeError`` where a GPU fails, and else a ``ValueError``.

    >>> import hexcast
    >>> try:
    ...     hexcast.mesh("nothing.stl", cells=64)
    ... except FileNotFoundError as error:
    ...     print(error.code, isinstance(error, hexcast.Error))
    io True
    """

    #: Stable identifier for programs, such as ``"stl-truncated"`` or ``"job-value"``.
    code: str
    #: What to do about it; may be empty.
    hint: str
    #: The sentence alone.
    message: str

    def __new__(cls, message: str, code: str, hint: str = "") -> Error:
        kind = kind_of(code) if cls is Error else cls
        # without arguments, which an OSError would take for its own
        made: Any = OSError.__new__(kind) if issubclass(kind, OSError) else Exception.__new__(kind)
        return cast(Error, made)

    def __init__(self, message: str, code: str, hint: str = "") -> None:
        super().__init__()
        self.args = (message, code, hint)
        self.message, self.code, self.hint = message, code, hint

    def __str__(self) -> str:
        return f"{self.message} ({self.hint})" if self.hint else self.message

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.message, self.code, self.hint)


class InvalidValue(Error, ValueError):
    """A value, or what a file holds, that cannot be used."""


class InvalidType(Error, TypeError):
    """An option that is not there, or a value of the wrong type."""


class SystemFailure(Error, OSError):
    """A file that cannot be read or written."""


class MissingFile(Error, FileNotFoundError):
    """A file that is not there."""

    def __init__(self, message: str, code: str, hint: str = "") -> None:
        super().__init__(message, code, hint)
        self.errno, self.strerror = errno.ENOENT, message


class OutOfMemory(Error, MemoryError):
    """What does not fit in memory."""


class GpuFailure(Error, RuntimeError):
    """A GPU that is not there, or that fails."""


#: Those of single codes; all others are values that cannot be used.
KINDS: dict[str, type[Error]] = {
    "io": SystemFailure,
    "memory": OutOfMemory,
    "no-adapter": GpuFailure,
    "device-failed": GpuFailure,
    "device-wrong": GpuFailure,
    "device-lost": GpuFailure,
}


def kind_of(code: str) -> type[Error]:
    """The class of an error by its code."""
    return KINDS.get(code, InvalidValue)


def of_library(message: str, code: str, hint: str) -> Error:
    """The error of the library, in the words of Python."""
    message = in_python(message)
    kind = InvalidType if WRONG_TYPE.search(message) else Error
    return kind(message, code, in_python(hint))


def in_python(text: str) -> str:
    """A sentence without what only users of the command and of job files know."""
    for pattern, words in WORDS:
        text = re.sub(pattern, words, text)
    # what is left of options has the name of the key
    return re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), text)


#: A text where none is wanted, or another thing where only a text, a list, a dict or a bool will do.
WRONG_TYPE = re.compile(r": it is (the text .*; give (?!one of|a flag)|\S+; give (a dict|a list|a text|True or False))")
#: Words of the command and of job files, and those of Python.
WORDS = (
    (r" \(--[^)]*\)", ""),
    (r"\((\w+), --[^)]*\)", r"(\1)"),
    (r"compare with the example: hexcast job example, or docs/job.schema.json", "help(hexcast.JobOptions) and help(hexcast.GeometryOptions) list them"),
    (r"\{ (\w+) = (\w+) \}", r'{"\1": \2}'),
    (r"`hexcast (\w+)`", r"hexcast.\1"),
    (r"give true or false", "give True or False"),
    (r"it is true;", "it is True;"),
    (r"it is false;", "it is False;"),
    (r"give (struct \w+|a table of its keys)", "give a dict"),
    (r"give string or map", "give a text"),
    (r"the job is not valid JSON", "the job has no JSON form"),
)


def missing(file: object) -> MissingFile:
    """The error of a file that is not there."""
    return MissingFile(f"{file}: there is no such file", "io", "look at its name and at the current folder")


class MeshWarning(UserWarning):
    """Something about a mesh that its reader should know: a finding of ``report["findings"]``; ``str(warning)`` is its sentence.

    >>> import warnings
    >>> import hexcast
    >>> from hexcast.shapes import box
    >>> with warnings.catch_warnings(record=True) as issued:
    ...     warnings.simplefilter("always")
    ...     mesh = hexcast.mesh([box((0, 0, 0), (8, 8, 8)), box((1, 1, 3), (7, 7, 3.1))], cells=8, backend="cpu")
    >>> issued[0].message.finding["code"]
    'no-cell-thin'
    """

    #: What was found, as data: ``code``, ``geometry``, ``points``, ``values``, ``remedies`` and others.
    finding: dict[str, Any]

    def __init__(self, finding: dict[str, Any]) -> None:
        # this is the argument that pickle calls it with
        super().__init__(finding)
        self.finding = finding

    def __str__(self) -> str:
        return str(self.finding["sentence"])
