"""Shared by all scripts: arrays whose values encode the voxel index, and the list of the files' expected contents."""
import pathlib, shutil

import numpy as np

HERE = pathlib.Path(__file__).parent.parent / "files"
DIMS = (5, 4, 3)
LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
expected = []


def array(dtype, slope=1, intercept=0, more=()):
    """Indexed (z, y, x), preceded by the axes `more`."""
    count = int(np.prod(more + DIMS))
    return (np.arange(count) * slope + intercept).astype(dtype).reshape(more + DIMS[::-1])


def affine(spacing=(1, 1, 1), origin=(0, 0, 0), direction=np.eye(3)):
    m = np.eye(4)
    m[:3, :3] = np.asarray(direction, float) @ np.diag(spacing)
    m[:3, 3] = origin
    return m


def holds(name, slope=1, intercept=0, place=np.eye(4), dims=DIMS, strides=None, **options):
    """`strides`: the increments of i between adjacent voxels along x, y, z."""
    strides = strides or [1, dims[0], dims[0] * dims[1]]
    expected.append(dict(file=name, slope=float(slope), intercept=float(intercept), dims=list(dims), strides=list(strides),
                         affine=np.asarray(place, float)[:3].tolist(), **options))


def folder(name):
    path = HERE / name
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
