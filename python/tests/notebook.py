"""Executes the notebook of the guide and writes its page: ``python notebook.py [--check]``.

The page is ``docs/guide/src/notebook.md``, its pictures are in ``docs/figures``. ``--check`` changes
nothing, and fails if the page differs.
"""

from __future__ import annotations

import base64
import sys
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[2]
NOTEBOOK = ROOT / "examples" / "python" / "austin.ipynb"
PAGE = ROOT / "docs" / "guide" / "src" / "notebook.md"
FIGURES = ROOT / "docs" / "figures"
MOST = 10
"""The most lines of a cell."""

HEAD = """<!-- `cargo xtask test --only python` holds this page to the notebook. -->

"""
FOOT = """
The notebook is [austin.ipynb](../../../examples/python/austin.ipynb). `python/tests/notebook.py` executes
it, and writes this page.
"""


def pictures(cell: Any) -> list[bytes]:
    """The pictures of a cell as PNG."""
    data = [dict(output.get("data", {})) for output in cell.outputs]
    return [base64.b64decode(one["image/png"]) for one in data if "image/png" in one]


def main(check: bool) -> int:
    book: Any = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(book, timeout=120, resources={"metadata": {"path": folder}})
        client.execute()
    page, drawn = [], 0
    for cell in book.cells:
        if cell.cell_type == "markdown":
            page.append(cell.source)
            continue
        lines = [line for line in cell.source.splitlines() if line.strip()]
        assert len(lines) <= MOST, f"a cell has {len(lines)} lines:\n{cell.source}"
        page.append(f"```python\n{cell.source}\n```")
        for picture in pictures(cell):
            assert picture.startswith(b"\x89PNG") and len(picture) > 5_000
            drawn += 1
            name = f"notebook-{drawn}.png"
            page.append(f"![What the cell draws](../../figures/{name})")
            if not check:
                (FIGURES / name).write_bytes(picture)
    text = HEAD + "\n\n".join(page) + "\n" + FOOT
    assert drawn >= 10, f"{drawn} pictures"
    print(f"{len(book.cells)} cells, {drawn} pictures")
    if not check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.read_text("utf-8") != text:
        print(f"{PAGE} is not what the notebook says: python python/tests/notebook.py")
        return 1
    missing = [n for n in range(1, drawn + 1) if not (FIGURES / f"notebook-{n}.png").is_file()]
    print(f"pictures that are missing: {missing}" if missing else "the page is the notebook's")
    return int(bool(missing))


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv))
