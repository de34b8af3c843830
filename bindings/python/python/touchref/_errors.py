"""Why there is no result."""

from __future__ import annotations

from typing import Any


class TouchrefError(ValueError):
    """There is no result: either the input is wrong (:class:`InputError`), or it gives no frame to trust (:class:`Refused`).

    >>> import touchref
    >>> try:
    ...     touchref.fixture("cylinder-plan")
    ... except touchref.TouchrefError as error:
    ...     print(error.code, error.details["nearest"])
    unknown-fixture cylinder-plane
    """

    __module__ = "touchref"

    def __init__(self, details: dict[str, Any]) -> None:
        super().__init__(details)
        self.details: dict[str, Any] = details
        """All that is known of it: what `error` holds in the JSON document ``touchref.error/1``."""

    @property
    def code(self) -> str:
        """The code by which programs know it: ``ambiguous``, ``unknown-surface``, ..."""
        return str(self.details["code"])

    @property
    def message(self) -> str:
        """What is wrong, in words."""
        return str(self.details["message"])

    @property
    def help(self) -> str:
        """What to do about it; empty where nothing is known."""
        return str(self.details.get("help", ""))

    def __str__(self) -> str:
        # What comes from no file has a place in none.
        places = ("file", "line", "column") if self.details.get("file") else ()
        place = [str(self.details[key]) for key in places if key in self.details]
        at = f"\nat {':'.join(place)}" if place else ""
        return f"{self.message} [{self.code}]{at}" + (f"\nhelp: {self.help}" if self.help else "")


class InputError(TouchrefError):
    """The input or the call is wrong; exit status 2 of the command line."""

    __module__ = "touchref"


class Refused(TouchrefError):
    """The input is sound, but gives no frame to trust, or none that can be told; exit status 1 of the command line."""

    __module__ = "touchref"


def of_document(document: str, refused: bool) -> TouchrefError:
    """The error of a document ``touchref.error/1``."""
    import json

    details = json.loads(document)["error"]
    return Refused(details) if refused else InputError(details)


def invalid(message: str, key: str, help: str = "") -> InputError:
    """An argument that is wrong."""
    return InputError({"code": "invalid-input", "message": message, "help": help, "key": key})
