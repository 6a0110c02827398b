"""A run of two bars on two workers, with all files, for all tests."""

from collections.abc import Iterator
from pathlib import Path

import crumple
import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def bars() -> Path:
    """Folder of the job."""
    return ROOT / "cases/bars"


@pytest.fixture(scope="session")
def results(bars: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[crumple.Results]:
    """Results of the job, with ten output steps."""
    out = tmp_path_factory.mktemp("bars") / "out"
    changes = {"output.field_interval": 0.00623}
    yield crumple.run(bars, workers=2, out=out, set=changes, progress=False)
