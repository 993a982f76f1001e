"""Image objects, each in its own axis order."""

import nibabel
import numpy as np
import pytest
import SimpleITK
import xarray

import layersplat

SPACING = (1.2, 0.9, 1.0)
"""Spacing along z, y, x."""


def nifti(array, affine=None):
    return nibabel.Nifti1Image(np.ascontiguousarray(array.transpose()), np.diag([1.0, 0.9, 1.2, 1.0]) if affine is None else affine)


def test_nibabel_is_x_y_z(array, picture, tmp_path):
    expected = picture(array, SPACING)
    image = nifti(array)
    assert image.shape == (28, 24, 20)
    assert np.array_equal(picture(image), expected)
    nibabel.save(image, tmp_path / "image.nii.gz")
    again = nibabel.load(tmp_path / "image.nii.gz")
    # The file holds its spacing as float32.
    assert np.allclose(layersplat.Volume(again).spacing, [1.0, 0.9, 1.2]) and layersplat.Volume(again).dtype == "uint8"
    assert np.array_equal(picture(again, (1.0, 0.9, 1.2)), expected)


def test_a_fourth_axis_of_one_is_none(array, picture):
    one = nibabel.Nifti1Image(array.transpose()[..., None], np.diag([1.0, 0.9, 1.2, 1.0]))
    assert np.array_equal(picture(one), picture(array, SPACING))
    two = nibabel.Nifti1Image(np.stack([array.transpose()] * 2, -1), np.eye(4))
    with pytest.raises(layersplat.InvalidValue, match="4 axes"):
        layersplat.Volume(two)


def test_affines_turn_and_mirror(array, picture):
    """A scan that is stored mirrored and rotated is shown in its world orientation."""
    camera = layersplat.Camera((80, 40, 60), (13.5, 11.5, 9.5), scale=20)
    expected = picture(array, camera=camera, background="black")
    stored = array.transpose()[::-1].transpose(2, 0, 1)
    # Stored axis 0 is z, axis 1 is x reversed, axis 2 is y.
    affine = np.array([[0, -1, 0, 27], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]])
    found = picture(nibabel.Nifti1Image(np.ascontiguousarray(stored), affine), camera=camera, background="black").astype(int)
    # Traversal along other axes rounds differently.
    assert np.abs(found - expected).max() <= 1
    sheared = np.eye(4)
    sheared[0, 1] = 0.3
    with pytest.raises(layersplat.InvalidValue, match="sheared"):
        layersplat.Volume(nifti(array, sheared))


def test_a_real_scan(shared):
    image = nibabel.load(shared("../formats/ch2bet.nii.gz"))
    volume = layersplat.Volume(image)
    assert volume.shape == image.shape[::-1] and np.allclose(volume.spacing, nibabel.affines.voxel_sizes(image.affine))
    assert np.allclose(volume.origin, image.affine[:3, 3])
    found = layersplat.render(volume, size=48)
    assert np.array_equal(found, layersplat.render(image, size=48)) and found[..., :3].max() > 100


def test_simpleitk(array, picture):
    image = SimpleITK.GetImageFromArray(array)
    image.SetSpacing(SPACING[::-1])
    assert image.GetSize() == (28, 24, 20)
    assert np.array_equal(picture(image), picture(array, SPACING))
    image.SetOrigin((5.0, 6.0, 7.0))
    image.SetDirection((0, 1, 0, 1, 0, 0, 0, 0, 1))
    volume = layersplat.Volume(image)
    del image
    assert volume.origin == (5.0, 6.0, 7.0)
    # Its x axis is the world's y axis.
    assert np.allclose(volume.centre, [5 + 0.9 * 11.5, 6 + 13.5, 7 + 1.2 * 9.5])
    assert volume.range == (array.min(), array.max())


def test_itk_images_live_as_long_as_their_volumes(array, picture):
    volume = layersplat.Volume(SimpleITK.GetImageFromArray(array))
    # Allocations that could reuse the memory of a freed image.
    others = [SimpleITK.GetImageFromArray(np.full(array.shape, 255, np.uint8)) for _ in range(20)]
    assert np.array_equal(picture(volume), picture(array)) and len(others) == 20


def labelled(array, **coordinates):
    z, y, x = array.shape
    at = {"z": 1.2 * np.arange(z), "y": 0.9 * np.arange(y), "x": 1.0 * np.arange(x), **coordinates}
    return xarray.DataArray(array, dims=("z", "y", "x"), coords=at)


def test_xarray_goes_by_names(array, picture):
    expected = picture(array, SPACING)
    image = labelled(array)
    assert np.array_equal(picture(image), expected)
    for order in [("x", "y", "z"), ("y", "z", "x")]:
        assert np.array_equal(picture(image.transpose(*order)), expected), order
    # Spacing in the order of the image's axes.
    turned = layersplat.Volume(image.transpose("y", "z", "x"), (2.0, 3.0, 1.0))
    assert turned.spacing == (1.0, 2.0, 3.0)
    others = xarray.DataArray(array, dims=("depth", "row", "column"))
    assert np.array_equal(picture(others), picture(array))


def test_xarray_has_coordinates(array, picture):
    falling = labelled(array[:, ::-1], y=(0.9 * np.arange(array.shape[1]))[::-1])
    assert layersplat.Volume(falling).origin == (0.0, 0.9 * (array.shape[1] - 1), 0.0)
    camera = layersplat.Camera((80, 40, 60), (13.5, 10.4, 11.4), scale=20)
    view = {"camera": camera, "background": "black"}
    assert np.abs(picture(falling, **view).astype(int) - picture(array, SPACING, **view)).max() <= 1
    with pytest.raises(layersplat.InvalidValue, match="coordinates of x are not evenly spaced"):
        layersplat.Volume(labelled(array, x=np.arange(array.shape[2]) ** 2.0))
    with pytest.raises(layersplat.InvalidValue, match="4 axes"):
        layersplat.Volume(xarray.DataArray(np.zeros((2, 3, 4, 5)), dims=("time", "z", "y", "x")))
