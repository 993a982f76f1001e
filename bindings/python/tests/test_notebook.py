"""A volume in a notebook."""

import base64
import io

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


def test_a_volume_shows_itself_in_a_notebook(tmp_path, monkeypatch):
    # Keeps the user's configuration out of the test.
    for name in ["IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR"]:
        monkeypatch.setenv(name, str(tmp_path / name))
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(notebook, timeout=180, kernel_name="python3", allow_errors=True).execute()
    shown = [picture(cell) for cell in notebook.cells[:2]]
    assert shown[0].shape == (60, 80, 4) and shown[0][..., :3].max() > 100
    assert not np.array_equal(*shown)
    error = notebook.cells[2].outputs[0]
    assert (error.output_type, error.ename) == ("error", "InvalidValue") and "2 axes" in error.evalue


def picture(cell):
    (output,) = [output for output in cell.outputs if output.output_type == "execute_result"]
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(output.data["image/png"]))))
