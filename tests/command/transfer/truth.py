"""Evaluates ParaView presets with VTK and writes vtk.json beside this file. Needs `pip install vtk`; the committed file was made with 9.7.2."""

import json
import pathlib

import vtk

SPACES = {
    "RGB": vtk.VTK_CTF_RGB,
    "HSV": vtk.VTK_CTF_HSV,
    "Lab": vtk.VTK_CTF_LAB,
    "Diverging": vtk.VTK_CTF_DIVERGING,
    "Lab/CIEDE2000": vtk.VTK_CTF_LAB_CIEDE2000,
    "Step": vtk.VTK_CTF_STEP,
}
COLORS = {
    "blue to red": [-1, 0.23, 0.3, 0.75, 3, 0.71, 0.016, 0.15],
    "primaries": [0, 1, 0, 0, 10, 0, 1, 0, 20, 0, 0, 1, 40, 1, 0.5, 1],
    "through grey": [0, 0, 0, 0, 1, 0.8, 0.2, 0.1, 2, 0.5, 0.5, 0.5, 3, 0.1, 0.3, 0.9, 5, 1, 1, 1],
    "purple to orange": [0, 0.8, 0.1, 0.5, 1, 0.9, 0.6, 0.2],
}
CURVES = {
    "linear": [0, 0, 0.5, 0, 10, 0.7, 0.5, 0],
    "early and late": [0, 0.1, 0.2, 0, 10, 0.9, 0.9, 0, 20, 0.3, 0.5, 0],
    "soft": [0, 0, 0.5, 0.2, 10, 1, 0.3, 0.5, 20, 0.2, 0.5, 0],
    "sharp": [0, 0.05, 0.7, 0.9, 10, 0.8, 0.4, 0.95, 20, 0, 0.5, 0],
    "steps": [0, 0.2, 0.3, 1, 10, 0.6, 0.75, 0.995, 20, 0.1, 0.5, 0],
    "hardly": [0, 0, 0.6, 0.009, 10, 1, 0.6, 0.011, 20, 0, 0.5, 0],
}
SAMPLES = 40


def values(points):
    """Evenly spaced values, also beyond both ends. They avoid the control points, where steps are discontinuous."""
    first, last = points[0], points[-4]
    step = (last - first) / SAMPLES
    return [round(first - step + step * (i + 0.37), 6) for i in range(SAMPLES + 2)]


def colors(name, space, wrap):
    points = COLORS[name]
    function = vtk.vtkColorTransferFunction()
    function.SetColorSpace(SPACES[space])
    function.SetHSVWrap(wrap)
    for i in range(0, len(points), 4):
        function.AddRGBPoint(*points[i : i + 4])
    at = values(points)
    preset = {"Name": f"{name}, {space}, {wrap}", "ColorSpace": space, "HSVWrap": wrap, "RGBPoints": points}
    return {"preset": preset, "values": at, "colors": [[round(c, 6) for c in function.GetColor(v)] for v in at]}


def opacities(name):
    points = CURVES[name]
    function = vtk.vtkPiecewiseFunction()
    for i in range(0, len(points), 4):
        function.AddPoint(*points[i : i + 4])
    at = values(points)
    preset = {"Name": name, "ColorSpace": "RGB", "RGBPoints": [0, 1, 1, 1], "Points": points}
    return {"preset": preset, "values": at, "opacities": [round(function.GetValue(v), 6) for v in at]}


cases = [colors(name, space, 0) for name in COLORS for space in SPACES]
cases += [colors(name, "HSV", 1) for name in COLORS]
cases += [opacities(name) for name in CURVES]
lines = ",\n".join(json.dumps(case, separators=(",", ":")) for case in cases)
pathlib.Path(__file__).with_name("vtk.json").write_text(f"[\n{lines}\n]\n")
