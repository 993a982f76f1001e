"""PyVista's remote rendering by trame: the same volume, transfer function and size as the viewer's. Prints its address.

remote.py VOLUME.raw[.gz] PORT MAPPER SIZE, and on standard input JSON of {"colors": [[value, [r, g, b]]...], "opacities": [[value, opacity]...],
"dims": [...]}. MAPPER: fixed_point or gpu.
"""

import gzip
import json
import sys

import numpy as np
import pyvista as pv
from trame_pyvista.ui import plotter_ui
from trame.app import get_server
from trame.ui.html import DivLayout

path, port, mapper, size = sys.argv[1], int(sys.argv[2]), sys.argv[3], int(sys.argv[4])
transfer = json.load(sys.stdin)
opened = gzip.open(path) if path.endswith(".gz") else open(path, "rb")
values = np.frombuffer(opened.read(), np.uint8)

pv.OFF_SCREEN = True
plotter = pv.Plotter(off_screen=True, window_size=(size, size))
plotter.background_color = "black"
grid = pv.ImageData(dimensions=transfer["dims"])
grid["values"] = values
actor = plotter.add_volume(grid, scalars="values", mapper=mapper, shade=True, show_scalar_bar=False)
colors, opacities = actor.prop.GetRGBTransferFunction(), actor.prop.GetScalarOpacity()
colors.RemoveAllPoints()
opacities.RemoveAllPoints()
for value, (r, g, b) in transfer["colors"]:
    colors.AddRGBPoint(value, r, g, b)
for value, opacity in transfer["opacities"]:
    opacities.AddPoint(value, opacity)
actor.prop.SetScalarOpacityUnitDistance(1.0)
actor.prop.SetInterpolationTypeToLinear()
plotter.camera.parallel_projection = True
plotter.reset_camera()
print("renderer", plotter.render_window.GetClassName(), actor.mapper.GetClassName(), flush=True)

server = get_server(client_type="vue3")
with DivLayout(server) as layout:
    layout.root.style = "position: fixed; inset: 0; margin: 0"
    # The defaults of remote rendering: JPEG of quality 60 and full size while a hand moves, the best at rest.
    plotter_ui(plotter, mode="server", default_server_rendering=True, add_menu=False, server=server)
server.start(port=port, host="127.0.0.1", open_browser=False, show_connection_info=False)
