#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""What peers need of a mesh, by the tools their users take: convex pieces (V-HACD, CoACD) and decimated meshes.

prepare.py vhacd    MESH.obj OUT.obj HULLS      V-HACD 4 with at most HULLS hulls of at most 64 vertices
prepare.py coacd    MESH.obj OUT.obj THRESHOLD  CoACD at this concavity, hulls reduced to 64 vertices, seed 0
prepare.py decimate MESH.obj OUT.obj TRIANGLES  quadric edge collapse, uniform over the mesh

OUT.obj: one `o` a piece; comments `# seconds S`, `# triangles N` are read back by clod-bench. Run by clod-bench tradeoff
in the venv that scripts/peers makes. Units and frame: those of MESH.obj. Decompositions are made at a size of 1 (V-HACD
merges vertices at an absolute distance) and scaled back.
"""
import sys
import time

import numpy

MOST_VERTICES = 64  # of a convex piece, as users reduce them


def read(path):
    vertices, faces = [], []
    with open(path) as file:
        for line in file:
            words = line.split()
            if words and words[0] == "v":
                vertices.append([float(w) for w in words[1:4]])
            elif words and words[0] == "f":
                faces.append([int(w) - 1 for w in words[1:4]])
    return numpy.array(vertices, dtype=numpy.float64), numpy.array(faces, dtype=numpy.int64)


def write(path, pieces, notes):
    first = 1
    with open(path, "w") as file:
        for key, value in notes.items():
            file.write(f"# {key} {value}\n")
        for number, (vertices, faces) in enumerate(pieces):
            file.write(f"o piece{number}\n")
            for x, y, z in vertices:
                file.write(f"v {float(x)!r} {float(y)!r} {float(z)!r}\n")
            for i, j, k in faces:
                file.write(f"f {i + first} {j + first} {k + first}\n")
            first += len(vertices)


def vhacd(vertices, faces, hulls):
    import vhacdx

    # The binding wants each face's corner count in front of it. V-HACD's own defaults up to 256 hulls; it would stop below
    # more, so those get finer voxels and a smaller error to stop at.
    counted = numpy.column_stack((numpy.full(len(faces), 3), faces)).astype(numpy.uint32).ravel()
    finer = {"resolution": 1_000_000, "minimumVolumePercentErrorAllowed": 0.1, "maxRecursionDepth": 14}
    return vhacdx.compute_vhacd(vertices, counted, maxConvexHulls=int(hulls), maxNumVerticesPerCH=MOST_VERTICES,
                                **(finer if int(hulls) > 256 else {}))


def coacd(vertices, faces, threshold):
    import coacd

    coacd.set_log_level("error")
    return coacd.run_coacd(coacd.Mesh(vertices, faces.astype(numpy.int32)), threshold=float(threshold), decimate=True,
                           max_ch_vertex=MOST_VERTICES, seed=0)


def decimate(vertices, faces, triangles):
    import pyfqmr

    simplifier = pyfqmr.Simplify()
    simplifier.setMesh(vertices, faces)
    simplifier.simplify_mesh(target_count=int(triangles), aggressiveness=3, preserve_border=True, max_iterations=200,
                             verbose=False)
    points, corners, _ = simplifier.getMesh()
    return [(points, corners)]


def main():
    tools = {"vhacd": vhacd, "coacd": coacd, "decimate": decimate}
    if len(sys.argv) != 5 or sys.argv[1] not in tools:
        sys.exit(__doc__)
    tool, mesh, output, amount = sys.argv[1:]
    vertices, faces = read(mesh)
    center = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    size = (vertices.max(axis=0) - vertices.min(axis=0)).max()
    start = time.perf_counter()
    pieces = tools[tool]((vertices - center) / size, faces, amount)
    seconds = time.perf_counter() - start
    if not len(pieces):
        sys.exit(f"prepare.py: {tool} gave nothing for {mesh}")
    pieces = [(numpy.asarray(points) * size + center, numpy.asarray(corners)) for points, corners in pieces]
    write(output, pieces, {"seconds": f"{seconds:.3f}", "triangles": sum(len(corners) for _, corners in pieces)})


if __name__ == "__main__":
    main()
