"""The signatures that notebooks complete and help() shows."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def with_options(options: type[Any], without: tuple[str, ...] = ()) -> Callable[[Function], Function]:
    """Gives a function that takes options by ``**`` the signature with their names."""

    def name(function: Function) -> Function:
        own = signature(function)
        parameters = [of for of in own.parameters.values() if of.kind is not Parameter.VAR_KEYWORD]
        parameters += [
            Parameter(option, Parameter.KEYWORD_ONLY, default=None, annotation=kind)
            for option, kind in options.__annotations__.items()
            if option not in without
        ]
        function.__dict__["__signature__"] = own.replace(parameters=parameters)
        return function

    return name
