"""NIfTI, written with nibabel."""
import itertools

import nibabel
import numpy as np
from common import affine, array, folder, holds, turned


def niftis():
    at = folder("nifti")
    oblique = affine((0.9, 1.1, 2.5), (10, -20, 30), turned(25) @ np.diag([-1, 1, 1.0]))

    def put(name, data, kind=nibabel.Nifti1Image, place=oblique, slope=1, inter=0, change=lambda header: None, big=False, **options):
        image = kind(data.T, place, dtype=data.dtype)
        if big:
            image = kind(data.T, place, header=kind.header_class(endianness=">"), dtype=data.dtype)
        image.header.set_slope_inter(slope, inter)
        change(image.header)
        nibabel.save(image, str(at / name))
        return nibabel.load(str(at / name)).affine

    codes = "uint8 int8 int16 uint16 int32 uint32 int64 uint64 float32 float64".split()
    for dtype, (version, kind) in itertools.product(codes, [(1, nibabel.Nifti1Image), (2, nibabel.Nifti2Image)]):
        low = -30 if dtype[0] in "if" else 1
        if version == 2 and dtype not in ("int16", "float64"):
            continue
        name = f"{dtype}_{version}.nii.gz"
        holds(f"nifti/{name}", 2, low, put(name, array(dtype, 2, low), kind))
    for kind, version in [(nibabel.Nifti1Image, 1), (nibabel.Nifti2Image, 2)]:
        name = f"big_{version}.nii"
        holds(f"nifti/{name}", 100, -3000, put(name, array("int16", 100, -3000), kind, big=True))
        name = f"little_{version}.nii"
        holds(f"nifti/{name}", 100, -3000, put(name, array("int16", 100, -3000), kind))
    for kind, version in [(nibabel.Nifti1Pair, 1), (nibabel.Nifti2Pair, 2)]:
        for name in [f"pair_{version}.hdr", f"packed_pair_{version}.hdr.gz"]:
            place = put(name.replace(".hdr", ".img"), array("uint16", 9, 1), kind)
            holds(f"nifti/{name}", 9, 1, place)
            holds(f"nifti/{name}".replace(".hdr", ".img"), 9, 1, place)

    image = nibabel.Nifti1Image(array("int16").T, oblique)
    image.header.set_slope_inter(0.25, -12.5)
    nibabel.save(image, str(at / "scaled.nii"))
    assert (nibabel.load(str(at / "scaled.nii")).get_fdata().T == array("float64", 0.25, -12.5)).all()
    holds("nifti/scaled.nii", 0.25, -12.5, image.affine)
    # Slope 0: values are not scaled.
    name = "no_slope.nii"
    place = put(name, array("int16", 100, -3000))
    raw = bytearray((at / name).read_bytes())
    raw[112:120] = np.array([0, 5], "<f4").tobytes()
    (at / name).write_bytes(raw)
    holds(f"nifti/{name}", 100, -3000, place)

    def only_q(header):
        header.set_qform(oblique, 1)
        header.set_sform(None, 0)

    name = "qform.nii"
    holds(f"nifti/{name}", 1, 0, put(name, array("uint8"), change=only_q))

    def both(header):
        header.set_qform(affine((1, 2, 3)), 1)
        header.set_sform(oblique, 2)

    name = "both.nii"
    holds(f"nifti/{name}", 1, 0, put(name, array("uint8"), change=both))
    name = "spaced.nii"
    put(name, array("uint8"), place=None, change=lambda h: (h.set_qform(None, 0), h.set_sform(None, 0), h.set_zooms((0.5, 1.5, 2))))
    holds(f"nifti/{name}", 1, 0, affine((0.5, 1.5, 2)))
    name = "extended.nii"
    image = nibabel.Nifti1Image(array("uint8").T, oblique)
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension("comment", b"of some length " * 9))
    nibabel.save(image, str(at / name))
    holds(f"nifti/{name}", 1, 0, image.affine)
    name = "times.nii.gz"
    place = put(name, array("int16", 3, -5, (2,)))
    for frame in [None, 1]:
        holds(f"nifti/{name}", 3, -5 + 180 * (frame or 0), place, frame=frame)
    # Vectors: five axes, one time point.
    name = "vectors.nii"
    place = put(name, array("float32", 3, -5, (2, 1)))
    for channel in [None, 1]:
        holds(f"nifti/{name}", 3, -5 + 180 * (channel or 0), place, channel=channel)
    rgb = np.zeros((3, 4, 5), dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
    for n, c in enumerate("RGB"):
        rgb[c] = array("uint8", 1, 60 * n)
    name = "rgb.nii"
    place = put(name, rgb)
    for channel in [None, 2]:
        holds(f"nifti/{name}", 1, 60 * (channel or 0), place, channel=channel)
    name = "flat.nii"
    image = nibabel.Nifti1Image(array("uint8")[0].T, oblique)
    nibabel.save(image, str(at / name))
    holds(f"nifti/{name}", 1, 0, image.affine, dims=(5, 4, 1))
