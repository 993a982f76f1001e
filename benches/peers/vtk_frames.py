"""Times VTK's fixed-point ray caster over one turn, with layersplat's camera and transfer function. Prints JSON.

vtk_frames.py RAW TRANSFER.json --step S --frames N [--size PIXELS] [--shaded] [--surface STL] [--opacity O] [--picture FRAME PNG]
RAW is NAME_XxYxZ_uint8.raw. Surfaces of an opacity below 1 are drawn by the mapper for GPUs, with depth peeling of volumes: the fixed-point ray
caster draws them behind the volume.
"""

import argparse
import json
import os
import re
import statistics
import time

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk

ELEVATION = 20.0


def volume_mapper(path, step, opacity):
    dims = [int(n) for n in re.search(r"_(\d+)x(\d+)x(\d+)_uint8", os.path.basename(path)).groups()]
    image = vtk.vtkImageData()
    image.SetDimensions(dims)
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.fromfile(path, numpy.uint8), deep=True))
    if opacity is not None and opacity < 1:
        mapper = vtk.vtkOpenGLGPUVolumeRayCastMapper()
        mapper.SetInputData(image)
        mapper.AutoAdjustSampleDistancesOff()
        mapper.UseJitteringOff()
        mapper.SetImageSampleDistance(1)
        mapper.SetSampleDistance(step)
        return mapper, numpy.array(dims)
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    # One ray per pixel at a fixed step, on all cores.
    mapper.SetNumberOfThreads(os.cpu_count())
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetIntermixIntersectingGeometry(opacity is not None)
    mapper.SetImageSampleDistance(1)
    mapper.SetMinimumImageSampleDistance(1)
    mapper.SetSampleDistance(step)
    mapper.SetInteractiveSampleDistance(step)
    return mapper, numpy.array(dims)


def volume_property(path, shaded):
    preset = json.load(open(path))[0]
    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for value, red, green, blue in zip(*[iter(preset["RGBPoints"])] * 4):
        color.AddRGBPoint(value, red, green, blue)
    for value, alpha, _, _ in zip(*[iter(preset["Points"])] * 4):
        opacity.AddPoint(value, alpha)
    look = vtk.vtkVolumeProperty()
    look.SetColor(color)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(1)
    look.SetInterpolationTypeToLinear()
    look.SetShade(shaded)
    look.SetAmbient(0.2)
    look.SetDiffuse(0.7)
    look.SetSpecular(0.3)
    look.SetSpecularPower(20)
    return look


def surface_actor(path, opacity):
    reader, mapper, actor = vtk.vtkSTLReader(), vtk.vtkPolyDataMapper(), vtk.vtkActor()
    reader.SetFileName(path)
    mapper.SetInputConnection(reader.GetOutputPort())
    actor.SetMapper(mapper)
    actor.GetProperty().SetOpacity(opacity)
    return actor


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("raw")
    parser.add_argument("transfer")
    parser.add_argument("--step", type=float, default=1)
    parser.add_argument("--frames", type=int, default=25)
    parser.add_argument("--size", type=int, default=512, help="pixels per side")
    parser.add_argument("--shaded", action="store_true")
    parser.add_argument("--surface")
    parser.add_argument("--opacity", type=float, default=1)
    parser.add_argument("--picture", nargs=2)
    options = parser.parse_args()

    mapper, dims = volume_mapper(options.raw, options.step, options.opacity if options.surface else None)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(volume_property(options.transfer, options.shaded))
    window, renderer = vtk.vtkRenderWindow(), vtk.vtkRenderer()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(options.size, options.size)
    # The update rate of a still picture, so that the mapper does not reduce quality.
    window.SetDesiredUpdateRate(1e-5)
    window.AddRenderer(renderer)
    renderer.AddVolume(volume)
    if options.surface:
        renderer.AddActor(surface_actor(options.surface, options.opacity))
        renderer.SetUseDepthPeeling(options.opacity < 1)
        renderer.SetUseDepthPeelingForVolumes(options.opacity < 1)
        renderer.SetMaximumNumberOfPeels(8)
        renderer.SetOcclusionRatio(0)
    centre, diagonal = (dims - 1) / 2, numpy.linalg.norm(dims - 1)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(diagonal / 2)
    camera.SetFocalPoint(*centre)
    camera.SetViewUp(0, 1, 0)

    def frame(azimuth):
        a, e = numpy.radians(azimuth), numpy.radians(ELEVATION)
        direction = numpy.array([numpy.cos(e) * numpy.sin(a), numpy.sin(e), numpy.cos(e) * numpy.cos(a)])
        camera.SetPosition(*(centre + direction * 2 * diagonal))
        camera.SetClippingRange(0.9 * diagonal, 3.1 * diagonal)
        window.Render()
        window.WaitForCompletion()

    frame(0)  # gradients, tables, threads
    times, cpu_times = [], []
    for n in range(options.frames):
        started, cpu_started = time.perf_counter(), time.process_time()
        frame(360 * n / options.frames)
        times.append((time.perf_counter() - started) * 1e3)
        cpu_times.append((time.process_time() - cpu_started) * 1e3)
        if options.picture and n == int(options.picture[0]):
            grab, writer = vtk.vtkWindowToImageFilter(), vtk.vtkPNGWriter()
            grab.SetInput(window)
            grab.ReadFrontBufferOff()
            grab.ShouldRerenderOff()
            writer.SetInputConnection(grab.GetOutputPort())
            writer.SetFileName(options.picture[1])
            writer.Write()
    print(json.dumps({"median_ms": statistics.median(times), "cpu_ms": statistics.mean(cpu_times), "version": vtk.vtkVersion().GetVTKVersion()}))


main()
