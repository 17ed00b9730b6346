"""The programs of the guide: every block marked `python` is run, page by page, and proves its own claims."""

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "guide"
PAGES = sorted(page.name for page in GUIDE.glob("python*.md"))
NEEDS = {"python-experts.md": "sklearn", "python-data.md": "pandas", "python-sweeps.md": "optuna"}


@pytest.mark.parametrize("page", PAGES)
def test_the_programs_of_a_page_run(page, tmp_path, monkeypatch):
    if page in NEEDS:
        pytest.importorskip(NEEDS[page])
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (GUIDE / page).read_text(), re.MULTILINE | re.DOTALL)
    assert blocks, "a page without a program"
    names: dict[str, object] = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"{page}, block {number + 1}", "exec"), names)


def test_all_pages_are_known():
    assert PAGES == [
        "python-compare.md",
        "python-data.md",
        "python-experts.md",
        "python-sweeps.md",
        "python.md",
    ]
