"""Draws a volume by pynari, in Python, and compares the picture with that of the command.

Run by ../test: LD_LIBRARY_PATH leads to the device, and the first argument is the command.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pynari as anari
from PIL import Image

SIZE = (160, 120)
COLORS = np.array([[0.1, 0.2, 0.9], [0.9, 0.8, 0.2], [1.0, 0.3, 0.1]], np.float32)
OPACITIES = np.array([0.0, 0.1, 0.3, 0.6, 0.9], np.float32)
POSITION, CENTRE = np.array([60.0, 40.0, 70.0]), np.array([13.5, 11.5, 9.5])
LIGHT = (0.5, -1.0, -1.0)
AMBIENT, FIELD_OF_VIEW = 0.2, 0.4


def voxels():
    """Three blobs in a box whose sides differ, indexed z, y, x."""
    z, y, x = np.mgrid[0:20, 0:24, 0:28].astype(np.float32)
    blob = lambda cx, cy, cz, r: np.exp(-((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) / r**2)
    return np.clip(blob(9, 9, 9, 6) + 0.8 * blob(20, 14, 7, 4) + 0.6 * blob(14, 18, 15, 5), 0, 1).astype(np.float32)


def drawn(values, channel):
    """The picture by pynari, row 0 at the top."""
    device = anari.newDevice("layersplat")
    field = device.newSpatialField("structuredRegular")
    # pynari takes a shape as x, y, z, and memory as x fastest.
    field.setParameter("data", anari.ARRAY3D, device.newArray(anari.FLOAT32, values.reshape(values.shape[::-1])))
    field.commitParameters()
    volume = device.newVolume("transferFunction1D")
    volume.setParameter("value", anari.SPATIAL_FIELD, field)
    volume.setParameter("color", anari.ARRAY, device.newArray(anari.float3, COLORS))
    volume.setParameter("opacity", anari.ARRAY, device.newArray(anari.FLOAT32, OPACITIES))
    volume.commitParameters()
    light = device.newLight("directional")
    light.setParameter("direction", anari.float3, LIGHT)
    light.commitParameters()
    world = device.newWorld()
    world.setParameterArray("volume", anari.VOLUME, [volume])
    world.setParameterArray("light", anari.LIGHT, [light])
    world.commitParameters()
    camera = device.newCamera("perspective")
    camera.setParameter("position", anari.float3, tuple(map(float, POSITION)))
    camera.setParameter("direction", anari.float3, tuple(map(float, CENTRE - POSITION)))
    camera.setParameter("up", anari.float3, (0.0, 1.0, 0.0))
    camera.setParameter("fovy", anari.FLOAT32, FIELD_OF_VIEW)
    camera.setParameter("aspect", anari.FLOAT32, SIZE[0] / SIZE[1])
    camera.commitParameters()
    renderer = device.newRenderer("default")
    renderer.setParameter("ambientRadiance", anari.FLOAT32, AMBIENT)
    renderer.commitParameters()
    frame = device.newFrame()
    frame.setParameter("size", anari.uint2, SIZE)
    frame.setParameter("channel.color", anari.DATA_TYPE, channel)
    frame.setParameter("renderer", anari.OBJECT, renderer)
    frame.setParameter("camera", anari.OBJECT, camera)
    frame.setParameter("world", anari.OBJECT, world)
    frame.commitParameters()
    frame.render()
    pixels = np.asarray(frame.get("channel.color"))
    return pixels.reshape(SIZE[1], SIZE[0], 4)[::-1]


def expected(command, values, folder):
    """The picture of the command."""
    np.save(folder / "volume.npy", values)
    places = np.unique(np.concatenate([np.linspace(0, 1, len(COLORS)), np.linspace(0, 1, len(OPACITIES))]))
    component = lambda c: np.interp(places, np.linspace(0, 1, len(COLORS)), COLORS[:, c])
    opacity = np.interp(places, np.linspace(0, 1, len(OPACITIES)), OPACITIES)
    rows = np.stack([places, component(0), component(1), component(2), opacity], 1)
    (folder / "transfer.csv").write_text("".join(",".join(f"{n:.9g}" for n in row) + "\n" for row in rows))
    camera = {"output": str(folder / "expected.png"), "position": list(POSITION), "focal_point": list(CENTRE)}
    camera |= {"view_up": [0, 1, 0], "perspective": float(np.degrees(FIELD_OF_VIEW))}
    (folder / "camera.ndjson").write_text(json.dumps(camera) + "\n")
    towards = ",".join(str(-c) for c in LIGHT)
    options = ["--cameras", folder / "camera.ndjson", "--size", f"{SIZE[0]}x{SIZE[1]}", "--transfer", folder / "transfer.csv"]
    options += [f"--light={towards}", "--kernel", "linear", "--unit-distance", "1", "--background", "black"]
    subprocess.run([command, "render", folder / "volume.npy", *options], check=True, stdout=subprocess.DEVNULL)
    return np.asarray(Image.open(folder / "expected.png").convert("RGB"))


def main():
    values = voxels()
    with tempfile.TemporaryDirectory() as folder:
        wanted = expected(sys.argv[1], values, Path(folder)).astype(int)
    plain = drawn(values, anari.UFIXED8_VEC4)
    assert plain.dtype == np.uint8 and (plain[..., 3] == 255).all(), plain.dtype
    off = np.abs(plain[..., :3].astype(int) - wanted).max()
    assert (wanted.max(axis=2) > 20).sum() > 1000, "the volume fills a part of the picture"
    assert off <= 1, f"UFIXED8_VEC4 is off by {off} steps"
    encoded = drawn(values, anari.UFIXED8_RGBA_SRGB)[..., :3].astype(float) / 255
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    off_srgb = np.abs(linear * 255 - wanted).max()
    assert off_srgb <= 2, f"UFIXED8_RGBA_SRGB is off by {off_srgb:.2f} steps"
    print(f"pynari: off by {off} steps of a byte from the command; decoded sRGB by {off_srgb:.2f}")
    if len(sys.argv) > 2:
        Image.fromarray(np.ascontiguousarray(plain)).save(sys.argv[2])


main()
