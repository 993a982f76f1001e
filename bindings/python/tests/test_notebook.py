"""A volume in a notebook."""

import base64
import io
import re

import nbclient
import nbformat
import numpy as np
from PIL import Image

CELLS = [
    """import numpy as np
import layersplat
z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
view = layersplat.volshow(np.exp(-4 * (x**2 + 2 * y**2 + z**2)), cmap="fire", opacity="linear", size=(80, 60))
view""",
    "view.azimuth, view.zoom = 75, 1.5\nview",
    "layersplat.volshow(np.zeros((3, 3)))",
]


WITHOUT_ANYWIDGET = "import sys; sys.modules['anywidget'] = None\n"


def executed(cells, tmp_path, monkeypatch):
    # Keeps the user's configuration out of the test.
    for name in ["IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR"]:
        monkeypatch.setenv(name, str(tmp_path / name))
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, timeout=180, kernel_name="python3", allow_errors=True).execute()
    return notebook.cells


def test_a_volume_shows_itself_in_a_notebook(tmp_path, monkeypatch):
    cells = executed([WITHOUT_ANYWIDGET + CELLS[0], *CELLS[1:]], tmp_path, monkeypatch)
    shown = [picture(cell) for cell in cells[:2]]
    assert shown[0].shape == (60, 80, 4) and shown[0][..., :3].max() > 100
    assert not np.array_equal(*shown)
    error = cells[2].outputs[0]
    assert (error.output_type, error.ename) == ("error", "InvalidValue") and "2 axes" in error.evalue


def test_a_live_view_leaves_its_picture_in_the_saved_notebook(tmp_path, monkeypatch):
    cells = executed(CELLS[:2], tmp_path, monkeypatch)
    stills = []
    for cell in cells:
        still, widget = (output.data for output in cell.outputs)
        assert widget["application/vnd.jupyter.widget-view+json"]["model_id"] in still["text/html"]
        data = re.search(r'src="data:image/png;base64,([^"]+)"', still["text/html"])[1]
        stills.append(np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))))
    assert stills[0].shape == (60, 80, 4) and stills[0][..., :3].max() > 100
    assert not np.array_equal(*stills)
    # The same widget: both cells show one view.
    assert len({cell.outputs[1].data["application/vnd.jupyter.widget-view+json"]["model_id"] for cell in cells}) == 1


def picture(cell):
    (output,) = [output for output in cell.outputs if output.output_type == "execute_result"]
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(output.data["image/png"]))))
