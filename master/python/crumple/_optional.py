"""Packages that only parts of this package need."""

from __future__ import annotations

import importlib
from typing import Any

EXTRAS = {"pandas": "histories", "pyvista": "fields", "requests": "service"}
"""Extra of this package that installs each of them."""


def module(name: str) -> Any:
    """Imports a package.

    Raises `ImportError` if it is missing; the message says how to install it.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise missing(name) from error


def missing(name: str) -> ImportError:
    """Returns the exception for a package that is missing."""
    text = f"this needs the package {name}: pip install 'crumple[{EXTRAS[name]}]'"
    return ImportError(text, name=name)
