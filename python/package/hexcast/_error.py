"""What can go wrong."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """Something that hexcast cannot do: ``str(error)`` is a sentence with the numbers, and what to do about it.

    >>> import hexcast
    >>> try:
    ...     hexcast.mesh("nothing.stl", cells=64)
    ... except hexcast.Error as error:
    ...     print(error.code)
    io
    """

    #: Stable identifier for programs, such as ``"stl-truncated"`` or ``"job-value"``.
    code: str
    #: What to do about it; may be empty.
    hint: str
    #: The sentence alone.
    message: str

    def __init__(self, message: str, code: str, hint: str = "") -> None:
        # these are the arguments that pickle calls it with
        super().__init__(message, code, hint)
        self.message, self.code, self.hint = message, code, hint

    def __str__(self) -> str:
        return f"{self.message} ({self.hint})" if self.hint else self.message


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
