"""Changes of a job, as the command line takes them."""

from __future__ import annotations

from collections.abc import Mapping


def changes(given: Mapping[str, object] | None) -> list[str]:
    """Returns changes of a job as `key=value`, with values as in TOML."""

    def text(value: object) -> str:
        return str(value).lower() if isinstance(value, bool) else str(value)

    return [f"{key}={text(value)}" for key, value in (given or {}).items()]
