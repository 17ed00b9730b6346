"""The notebook of the guide: every cell is run, proves its own claims, and its plots are drawn."""

import json
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "guide" / "prices.ipynb"


def test_the_notebook_runs_and_its_plots_can_be_drawn(tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    monkeypatch.setattr(pyplot, "show", lambda: None)
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    names: dict[str, object] = {}
    for number, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert not cell["outputs"], "outputs go stale: they are not kept"
            exec(compile("".join(cell["source"]), f"{NOTEBOOK.name}, cell {number}", "exec"), names)
    figures = pyplot.get_fignums()
    assert len(figures) == 2
    for figure in figures:
        picture = tmp_path / f"{figure}.png"
        pyplot.figure(figure).savefig(picture)
        pixels = pyplot.imread(picture)
        assert pixels[..., :3].min() < 0.5 and pixels[..., :3].std() > 0.05, "an empty picture"
    pyplot.close("all")
