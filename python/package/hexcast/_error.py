"""What can go wrong."""

from __future__ import annotations


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
    """Something about a mesh that its reader should know: the sentences of ``report["warnings"]``."""
