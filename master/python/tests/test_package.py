"""The package as a whole: types, and the examples."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import crumple
import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All cells of a notebook run one after the other, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    cells = json.loads(notebook.read_text())["cells"]
    names: dict[str, Any] = {}
    for number, cell in enumerate(cell for cell in cells if cell["cell_type"] == "code"):
        code = compile("".join(cell["source"]), f"{notebook.name}, cell {number}", "exec")
        exec(code, names)


def test_the_page_of_the_manual_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All blocks of docs/guide/python.md run one after the other."""
    root = Path(__file__).parents[3]
    (tmp_path / "cases").symlink_to(root / "cases")
    monkeypatch.chdir(tmp_path)
    page = (root / "docs/guide/python.md").read_text()
    blocks = [part.split("```")[0] for part in page.split("```python\n")[1:]]
    assert len(blocks) == 4
    names: dict[str, Any] = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"block {number}", "exec"), names)


def test_there_are_examples() -> None:
    """The test above has something to run."""
    assert len(EXAMPLES) == 2


def test_all_types_are_right() -> None:
    """mypy finds no error in the package, by its strict rules."""
    root = Path(__file__).parents[3]
    package = Path(crumple.__file__).parent
    command = [sys.executable, "-m", "mypy", "--config-file", root / "pyproject.toml", package]
    checked = subprocess.run(command, cwd=package.parent, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
