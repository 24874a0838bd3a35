"""The notebook of docs/: its cells run, in order."""

import json
import os

import pytest

import psivox

NOTEBOOK = os.path.join(os.environ["PSIVOX_ASSETS"], "..", "docs", "step-sizes.ipynb")


def test_notebook():
    matplotlib = pytest.importorskip("matplotlib", reason="no matplotlib (python3-matplotlib)")
    matplotlib.use("Agg")
    with open(NOTEBOOK, encoding="utf-8") as file:
        cells = json.load(file)["cells"]
    names = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            *statements, last = "".join(cell["source"]).split("\n")
            exec("\n".join(statements), names)
            result = eval(last, names) if last.startswith("psivox.") else exec(last, names)
            if isinstance(result, psivox.Image):
                assert result._repr_png_().startswith(b"\x89PNG")
    # what the plot shows: errors fall with the step, and wide steps are psi-balanced's
    errors = {(row["integrator"], row["step"]): row["rms"] for row in names["rows"]}
    assert errors["porter-duff", 0.25] < errors["porter-duff", 4] / 8
    assert errors["psi-balanced", 4] < errors["porter-duff", 4] / 3
    assert len(matplotlib.pyplot.gca().lines) == 3
