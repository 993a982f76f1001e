"""DICOM series, written with pydicom. Where ITK can read them, it supplies the expected transforms and values."""
import io

import numpy as np
import SimpleITK as sitk
from PIL import Image
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import (DeflatedExplicitVRLittleEndian, EnhancedMRImageStorage, ExplicitVRBigEndian, ExplicitVRLittleEndian,
                         ImplicitVRLittleEndian, JPEG2000Lossless, JPEGBaseline8Bit, CTImageStorage, RLELossless)

from common import HERE, LPS, affine, array, folder, holds, turned

SPACING = (0.75, 1.25, 2.5)
ORIGIN = (10, -20, 30)


def uid(*numbers):
    return ".".join(["1.2.826.0.1.3680043.8.498", *map(str, numbers)])


def image(pixels, series=1, instance=1, syntax=ExplicitVRLittleEndian, storage=CTImageStorage, **more):
    """A single-frame or multi-frame image: pixels indexed (frame, y, x, channel); the first and the last axis are optional."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = storage, uid(series, instance)
    meta.TransferSyntaxUID = syntax
    found = Dataset()
    found.file_meta = meta
    found.SOPClassUID, found.SOPInstanceUID = storage, uid(series, instance)
    found.StudyInstanceUID, found.SeriesInstanceUID = uid(0), uid(series, 0)
    found.PatientName, found.Modality = "Nobody", "CT"
    found.SeriesNumber, found.InstanceNumber = series, instance
    channels = more.pop("SamplesPerPixel", 1)
    frames = pixels.ndim - 2 - (channels > 1)
    if frames:
        found.NumberOfFrames = pixels.shape[0]
    found.Rows, found.Columns = pixels.shape[frames:frames + 2]
    found.SamplesPerPixel = channels
    if channels > 1:
        found.PlanarConfiguration = 0
    found.PhotometricInterpretation = "RGB" if channels > 1 else "MONOCHROME2"
    found.BitsAllocated = found.BitsStored = 8 * pixels.dtype.itemsize
    found.HighBit = found.BitsStored - 1
    found.PixelRepresentation = int(pixels.dtype.kind == "i")
    found.PixelData = pixels.tobytes() + b"\0" * (pixels.nbytes % 2)
    found["PixelData"].VR = "OW" if pixels.dtype.itemsize > 1 else "OB"
    for name, value in more.items():
        setattr(found, name, value)
    return found


def place(z, direction=np.eye(3), tilt=0):
    """The position attributes of slice z. Each slice is shifted by `tilt` relative to the previous one."""
    position = np.asarray(ORIGIN) + direction @ [0, tilt * z, SPACING[2] * z]
    return dict(ImagePositionPatient=[round(float(p), 9) for p in position],
                ImageOrientationPatient=[round(float(d), 12) for d in direction[:, :2].T.ravel()],
                PixelSpacing=[SPACING[1], SPACING[0]], SliceThickness=SPACING[2])


def slices(at, data, direction=np.eye(3), names="bca", **more):
    """One file per slice, with names whose order is not that of the slices."""
    at.mkdir(exist_ok=True)
    for z, name in zip(range(len(data)), names):
        image(data[z], instance=9 - z, **place(z, direction), **more).save_as(at / f"{name}.dcm", enforce_file_format=True)


def of_itk(name, slope, intercept, **options):
    """Expects the affine transform that ITK returns for a folder, after comparing its values."""
    at = str(HERE / name)
    reader = sitk.ImageSeriesReader()
    reader.SetFileNames(reader.GetGDCMSeriesFileNames(at))
    found = reader.Execute()
    values = sitk.GetArrayFromImage(found).ravel()
    assert np.array_equal(values, slope * np.arange(values.size) + intercept), name
    direction = np.array(found.GetDirection()).reshape(3, 3)
    holds(name, slope, intercept, LPS @ affine(found.GetSpacing(), found.GetOrigin(), direction), dims=found.GetSize(), **options)


def dicoms():
    at = folder("dicom")
    upright = LPS @ affine(SPACING, ORIGIN)
    oblique = turned(30)
    data = array("int16", 100, -3000)
    slices(at / "oblique", data, oblique, RescaleSlope=2, RescaleIntercept=-5)
    of_itk("dicom/oblique", 200, -6005)
    holds("dicom/oblique/c.dcm", 200, -6005, LPS @ affine(SPACING, ORIGIN, oblique))
    slices(at / "backwards", data, np.diag([1, -1, 1.0]) @ np.diag([1, 1, -1.0]))
    of_itk("dicom/backwards", 100, -3000)
    for name, syntax in [("implicit", ImplicitVRLittleEndian), ("big", ExplicitVRBigEndian), ("deflated", DeflatedExplicitVRLittleEndian)]:
        slices(at / name, data.astype(">i2") if name == "big" else data, syntax=syntax)
        of_itk(f"dicom/{name}", 100, -3000)
    for dtype in ["uint8", "uint16", "int8", "int32", "uint32"]:
        low = -30 if dtype[0] == "i" else 1
        slices(at / dtype, array(dtype, 2, low))
        holds(f"dicom/{dtype}", 2, low, upright)
    # 12 stored bits, negative values, and unrelated bits above them.
    slices(at / "twelve", (array("int16", 30, -900) & 0xfff | 0x5000).astype("int16"), BitsStored=12, HighBit=11)
    holds("dicom/twelve", 30, -900, upright)
    # As PET scanners write: one rescale slope per slice.
    at_scales = at / "scales"
    at_scales.mkdir()
    for z, scale in enumerate([0.5, 1, 2]):
        stored = (array("int32", 4, 8)[z] / scale).astype("int16")
        made = image(stored, instance=z, RescaleSlope=scale, RescaleIntercept=-8, **place(z))
        made.save_as(at_scales / f"{z}.dcm", enforce_file_format=True)
    of_itk("dicom/scales", 4, 0)
    # Run-length encoded.
    for name, pixels in [("runs", data), ("runs_of_bytes", array("uint8", 4, 1))]:
        (at / name).mkdir()
        for z in range(3):
            made = image(pixels[z], instance=z, **place(z))
            made.compress(RLELossless, generate_instance_uid=False)
            made.save_as(at / name / f"{z}.dcm", enforce_file_format=True)
    # ITK does not decode these.
    holds("dicom/runs", 100, -3000, upright)
    holds("dicom/runs_of_bytes", 4, 1, upright)
    # One value per slice, which lossy JPEG preserves exactly.
    (at / "jpeg").mkdir()
    for z in range(3):
        flat = np.full((4, 5), 100 + 8 * z, "uint8")
        file = io.BytesIO()
        Image.fromarray(flat).save(file, "jpeg", quality=100)
        made = image(flat, instance=z, syntax=JPEGBaseline8Bit, **place(z))
        made.PixelData = encapsulate([file.getvalue()])
        made["PixelData"].is_undefined_length = True
        made.save_as(at / "jpeg" / f"{z}.dcm", enforce_file_format=True)
    holds("dicom/jpeg", 8, 100, upright, strides=[0, 0, 1])
    # Lossless JPEG, written by ITK.
    (at / "lossless").mkdir()
    for z in range(3):
        made = sitk.GetImageFromArray(array("uint16", 100, 7)[z:z + 1])
        made.SetSpacing(SPACING)
        made.SetOrigin((10, -20, 30 + 2.5 * z))
        for key, value in {"0020|000e": uid(7, 0), "0020|0032": "10\\-20\\" + str(30 + 2.5 * z), "0020|0037": "1\\0\\0\\0\\1\\0",
                           "0020|0013": str(z), "0008|0060": "CT"}.items():
            made.SetMetaData(key, value)
        writer = sitk.ImageFileWriter()
        writer.KeepOriginalImageUIDOn()
        writer.UseCompressionOn()
        writer.SetCompressor("JPEG")
        writer.SetFileName(str(at / "lossless" / f"{z}.dcm"))
        writer.Execute(made)
    holds("dicom/lossless", 100, 7, upright)
    # Two series, one of them with two time points.
    slices(at / "several", array("int16", 3, -5), names="abc", series=2, SeriesDescription="first")
    for time in range(2):
        for z in range(3):
            made = image(array("int16", 3, 1000 * time)[z], series=4, instance=1 + 3 * time + z, SeriesDescription="dynamic", **place(z))
            made.save_as(at / "several" / f"time_{time}_{z}.dcm", enforce_file_format=True)
    for series in ["2", "first", uid(2, 0)]:
        holds("dicom/several", 3, -5, upright, series=series)
    for frame in [None, 1]:
        holds("dicom/several", 3, 1000 * (frame or 0), upright, series="dynamic", frame=frame)
    holds("dicom/several/a.dcm", 3, -5, upright)
    # Unordered frames of two time points in one file.
    order = [(1, 0), (0, 2), (1, 2), (0, 0), (0, 1), (1, 1)]
    frames = np.stack([array("uint16", 7, 3 + 1000 * time)[z] for time, z in order])
    for name, pack in [("enhanced", False), ("enhanced_runs", True)]:
        made = image(frames, storage=EnhancedMRImageStorage)
        shared = Dataset()
        measures, orientation, values = Dataset(), Dataset(), Dataset()
        measures.PixelSpacing, measures.SliceThickness = [SPACING[1], SPACING[0]], 9
        orientation.ImageOrientationPatient = place(0, oblique)["ImageOrientationPatient"]
        values.RescaleSlope, values.RescaleIntercept, values.RescaleType = 0.5, 10, "US"
        shared.PixelMeasuresSequence, shared.PlaneOrientationSequence = [measures], [orientation]
        shared.PixelValueTransformationSequence = [values]
        made.SharedFunctionalGroupsSequence = [shared]
        made.PerFrameFunctionalGroupsSequence = []
        for time, z in order:
            position, content, own = Dataset(), Dataset(), Dataset()
            position.ImagePositionPatient = place(z, oblique)["ImagePositionPatient"]
            content.TemporalPositionIndex = time + 1
            own.PlanePositionSequence, own.FrameContentSequence = [position], [content]
            made.PerFrameFunctionalGroupsSequence.append(own)
        if pack:
            made.compress(RLELossless, generate_instance_uid=False)
        made.save_as(at / f"{name}.dcm", enforce_file_format=True)
        for frame in [None, 1]:
            holds(f"dicom/{name}.dcm", 3.5, 11.5 + 500 * (frame or 0), LPS @ affine(SPACING, ORIGIN, oblique), frame=frame)
    # A dose grid: frames at the offsets of GridFrameOffsetVector.
    dose = image(array("uint32", 4, 8), DoseGridScaling=0.25, GridFrameOffsetVector=[0, 2.5, 5], FrameIncrementPointer=0x3004000C, **place(0))
    dose.save_as(at / "dose.dcm", enforce_file_format=True)
    holds("dicom/dose.dcm", 1, 2, upright)
    # Colour images, interleaved and planar, without a position.
    colours = np.stack([array("uint8", 1, 60 * n) for n in range(3)], -1)
    image(colours, SamplesPerPixel=3).save_as(at / "colours.dcm", enforce_file_format=True)
    planes = image(colours, SamplesPerPixel=3, PlanarConfiguration=1)
    planes.PixelData = np.moveaxis(colours, -1, 1).tobytes()
    planes.save_as(at / "planes.dcm", enforce_file_format=True)
    for name in ["colours", "planes"]:
        for channel in [None, 2]:
            holds(f"dicom/{name}.dcm", 1, 60 * (channel or 0), channel=channel)
    # A TIFF header in the preamble, as some scanners write, and a second series in an unsupported encoding.
    (at / "both").mkdir()
    for z in range(3):
        made = image(data[z], instance=z, **place(z))
        made.preamble = b"II*\0" + b"\1\0\0\0" * 31
        made.save_as(at / "both" / f"{z}.dcm", enforce_file_format=True)
    other = image(np.zeros((64, 64), "uint8"), series=5)
    other.compress(JPEG2000Lossless, encoding_plugin="pylibjpeg", generate_instance_uid=False)
    other.save_as(at / "both" / "other.dcm", enforce_file_format=True)
    holds("dicom/both/1.dcm", 100, -3000, upright)
    holds("dicom/both", 100, -3000, upright, series="1")
    # Rejected series.
    bad = at / "refused"
    bad.mkdir()
    for name, positions in [("tilted", [place(z, tilt=0.8) for z in range(3)]), ("gap", [place(z) for z in [0, 1, 3, 4]]),
                            ("overview", [place(0), place(1, oblique), place(2)])]:
        (bad / name).mkdir()
        for n, where in enumerate(positions):
            image(data[n % 3], instance=n + 1, **where).save_as(bad / name / f"{n}.dcm", enforce_file_format=True)
    slices(bad / "unequal", data)
    image(data[0], instance=20, **place(0)).save_as(bad / "unequal" / "more.dcm", enforce_file_format=True)
    slices(bad / "sizes", data)
    image(data[0][:2], instance=20, **place(3)).save_as(bad / "sizes" / "more.dcm", enforce_file_format=True)
    made = image(np.zeros((64, 64), "uint8"))
    made.compress(JPEG2000Lossless, encoding_plugin="pylibjpeg", generate_instance_uid=False)
    made.save_as(bad / "jpeg2000.dcm", enforce_file_format=True)
    made = image(data[0])
    del made.PixelData
    made.save_as(bad / "no_pixels.dcm", enforce_file_format=True)
