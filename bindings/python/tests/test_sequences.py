"""Sequences of volumes in time."""

import itertools

import numpy as np
import pytest

import layersplat

STEPS = 4
SIZE = (48, 40)


@pytest.fixture(scope="module")
def arrays():
    """(t, z, y, x): noise that brightens."""
    noise = np.random.default_rng(1).integers(0, 50, (STEPS, 10, 12, 14))
    return (noise * (1 + np.arange(STEPS))[:, None, None, None]).astype(np.uint8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, arrays):
    folder = tmp_path_factory.mktemp("sequence")
    np.save(folder / "all.npy", arrays)
    for n, array in enumerate(arrays):
        np.save(folder / f"s{n}.npy", array)
    return folder


@pytest.fixture(params=["all.npy", "s%d.npy", "list", "strings"])
def sequence(request, folder):
    files = [folder / f"s{n}.npy" for n in range(STEPS)]
    sources = {"list": files, "strings": tuple(map(str, files))}
    return layersplat.VolumeSequence.open(sources.get(request.param, folder / request.param))


def test_steps_are_indexed_and_iterated(sequence, arrays):
    largest = [array.max() for array in arrays]
    assert len(sequence) == STEPS
    assert [step.range[1] for step in sequence] == largest
    assert [sequence[n].range[1] for n in range(-STEPS, STEPS)] == largest + largest
    assert [step.range[1] for step in sequence.play(range(3, -1, -2))] == [largest[3], largest[1]]
    assert list(sequence.play([])) == []
    assert sequence.overview().range == (arrays.min(), arrays.max())
    assert "4 steps" in repr(sequence)


def test_a_renderer_goes_from_step_to_step(sequence, arrays, transfer):
    renderer = layersplat.Renderer(sequence[0], transfer)
    camera = renderer.camera(SIZE, azimuth=20)
    expected = [layersplat.Renderer(array, transfer).render(camera, SIZE) for array in arrays]
    assert all((a != b).any() for a, b in itertools.combinations(expected, 2))
    for volume, picture in zip(sequence, expected):
        renderer.set_volume(volume)
        assert (renderer.render(camera, SIZE) == picture).all()
    # Arrays in memory need no sequence.
    for array, picture in zip(arrays, expected):
        renderer.set_volume(array)
        assert (renderer.render(camera, SIZE) == picture).all()


def test_options_hold_for_all_steps(folder, arrays):
    sequence = layersplat.VolumeSequence.open(folder / "all.npy", spacing=(1, 2, 3), background=7)
    assert all(step.spacing == (1, 2, 3) and step.background == 7 for step in sequence)


def test_what_is_no_sequence_is_refused(folder):
    open_sequence = layersplat.VolumeSequence.open
    sequence = open_sequence(folder / "all.npy")
    for wrong in [4, -5, 2**62]:
        with pytest.raises(IndexError, match="0 to 3"):
            sequence[wrong]
    with pytest.raises(IndexError, match="step 4"):
        sequence.play([0, 4])
    for wrong in ["1", None, slice(2)]:
        with pytest.raises(layersplat.InvalidType):
            sequence[wrong]
    with pytest.raises(layersplat.InvalidType, match="steps"):
        sequence.play("ab")
    with pytest.raises(layersplat.InvalidType, match="paths"):
        open_sequence(7)
    with pytest.raises(layersplat.InvalidValue):
        open_sequence([])
    with pytest.raises(FileNotFoundError):
        open_sequence(folder / "none.npy")
    np.save(folder / "other.npy", np.zeros((3, 3, 3), np.uint8))
    with pytest.raises(layersplat.InvalidFile, match="3x3x3"):
        open_sequence([folder / "s0.npy", folder / "other.npy"])


def test_a_step_that_cannot_be_read_raises_and_the_next_one_follows(tmp_path, arrays):
    for n in range(3):
        np.save(tmp_path / f"s{n}.npy", arrays[n])
    sequence = layersplat.VolumeSequence.open(tmp_path / "s%d.npy")
    (tmp_path / "s1.npy").unlink()
    steps = iter(sequence)
    assert next(steps).range[1] == arrays[0].max()
    with pytest.raises(FileNotFoundError):
        next(steps)
    assert next(steps).range[1] == arrays[2].max()
    assert next(steps, None) is None
