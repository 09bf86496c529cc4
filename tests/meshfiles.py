"""Small surfaces as arrays, and arrays as the bytes of mesh files."""

import numpy as np

FORMATS = {
    "obj": "obj",
    "off": "off",
    "ply": "ply",
    "ply-little": "ply",
    "ply-big": "ply",
    "stl": "stl",
    "stl-text": "stl",
}
"""Encoding -> extension."""


def octahedron():
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    above = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]])
    below = np.array([[2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    return points, np.concatenate([above, below])


def sphere(rounds=2):
    """An octahedron, each face cut into four, ``rounds`` times, with vertices pushed out to radius 1."""
    points, faces = octahedron()
    for _ in range(rounds):
        sides = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
        ends, place = np.unique(sides, axis=0, return_inverse=True)
        middle = len(points) + place.reshape(-1, 3)
        points = np.concatenate([points, points[ends].mean(axis=1)])
        a, b, c = faces.T
        x, y, z = middle.T
        faces = np.concatenate([np.stack(f, axis=1) for f in ((a, z, y), (z, b, x), (y, x, c), (x, y, z))])
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points, faces


def sheet(n=4):
    """A flat square of n x n cells, of two triangles each."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.1 * x.ravel() * y.ravel()], axis=1)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = corner, corner + n + 1, corner + n + 2, corner + 1
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def moebius_strip(n=12):
    angle = np.arange(n) * 2 * np.pi / n
    across = np.stack(
        [np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], 1
    )
    middle = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    points = np.concatenate([middle - 0.3 * across, middle + 0.3 * across])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    low, high = (np.stack([i, j + side], axis=1) for side in (0, n))
    low[-1, 1], high[-1, 1] = n, 0  # after one turn the two rims have changed places
    faces = [[low[:, 0], low[:, 1], high[:, 1]], [low[:, 0], high[:, 1], n + i]]
    return points, np.concatenate([np.stack(face, axis=1) for face in faces])


def fin():
    """Three triangles on one edge."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], dtype=float)
    return points, np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])


def soup():
    """Twelve triangles that touch nowhere."""
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    return np.concatenate([one + 2.0 * k for k in range(12)]), np.arange(36).reshape(-1, 3)


def encode(kind, points, faces):
    """The bytes of a file; ``kind`` is a key of FORMATS. STL has single precision."""
    points, faces = np.asarray(points, dtype=float), np.asarray(faces).reshape(-1, 3)
    if kind == "obj":
        rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        return "\n".join([*rows, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()), ""]).encode()
    if kind == "off":
        rows = [f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        rows += [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
        return "\n".join(["OFF", f"{len(points)} {len(faces)} 0", *rows, ""]).encode()
    if kind == "stl-text":
        lines = ["solid test"]
        for corners in points[faces].tolist():
            lines += ["facet normal 0 0 0", " outer loop"]
            lines += [f"  vertex {x!r} {y!r} {z!r}" for x, y, z in corners]
            lines += [" endloop", "endfacet"]
        return "\n".join([*lines, "endsolid test", ""]).encode()
    if kind == "stl":
        rows = np.zeros(len(faces), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
        rows["c"] = points[faces]
        return bytes(80) + np.uint32(len(faces)).astype("<u4").tobytes() + rows.tobytes()
    order, name = {"ply": ("=", "ascii"), "ply-little": ("<", "binary_little_endian")}.get(
        kind, (">", "binary_big_endian")
    )
    header = ["ply", f"format {name} 1.0", "comment a test", f"element vertex {len(points)}"]
    header += [f"property double {axis}" for axis in "xyz"]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    start = "\n".join(header).encode()
    if order == "=":
        rows = [f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        return start + "\n".join([*rows, *(f"3 {a} {b} {c}" for a, b, c in faces.tolist()), ""]).encode()
    rows = np.zeros(len(faces), dtype=[("n", "u1"), ("corners", order + "i4", 3)])
    rows["n"], rows["corners"] = 3, faces
    return start + points.astype(order + "f8").tobytes() + rows.tobytes()


def write(folder, stem, kind, points, faces):
    """Write the file and return its path."""
    path = folder / f"{stem}.{FORMATS[kind]}"
    path.write_bytes(encode(kind, points, faces))
    return path


def hostile(folder):
    """Files that must be refused: label -> (path, a word of the message)."""
    points, faces = octahedron()
    wrong, far = points.copy(), faces.copy()
    wrong[2, 1] = np.nan
    far[3, 1] = 99
    flat = np.outer(np.arange(6.0), [1.0, 2.0, 3.0])
    cases = {
        "nan": (wrong, faces, "finite", ("obj", "off", "ply", "ply-little", "ply-big", "stl", "stl-text")),
        "range": (points, far, "vertex", ("obj", "off", "ply", "ply-little", "ply-big")),
        "flat": (flat, faces, "area", tuple(FORMATS)),
        "one-place": (np.ones((6, 3)), faces, "one place", tuple(FORMATS)),
        "fin": (*fin(), "more than two faces", tuple(FORMATS)),
        "moebius": (*moebius_strip(), "Moebius", tuple(FORMATS)),
        "cloud": (points, np.empty((0, 3), int), "point cloud", ("obj", "off", "ply", "ply-little")),
        "soup": (*soup(), "soup", tuple(FORMATS)),
    }
    found = {}
    for label, (vertices, triangles, word, kinds) in cases.items():
        for kind in kinds:
            found[f"{label}-{kind}"] = (write(folder, f"{label}-{kind}", kind, vertices, triangles), word)
    for kind, extension in FORMATS.items():
        whole = encode(kind, points, faces)
        for label, data, word in (
            ("empty", b"", "empty"),
            ("truncated", whole[: 2 * len(whole) // 3], "cannot be read"),
            ("garbage", bytes(range(256)) * 8, "cannot be read"),
            ("text", b"Dear reader,\nthis is no mesh at all.\n", "cannot be read"),
        ):
            path = folder / f"{label}-{kind}.{extension}"
            path.write_bytes(data)
            found[f"{label}-{kind}"] = (path, word)
    huge = 4_000_000_000
    for name, data in (
        ("huge.off", f"OFF\n{huge} {huge} 0\n0 0 0\n".encode()),
        ("huge.stl", bytes(80) + (huge).to_bytes(4, "little") + bytes(50)),
        ("huge.ply", encode("ply-little", points, faces).replace(b"vertex 6", b"vertex %d" % huge)),
        ("huge-faces.ply", encode("ply-little", points, faces).replace(b"face 8", b"face %d" % huge)),
        ("huge-text.ply", encode("ply", points, faces).replace(b"vertex 6", b"vertex %d" % huge)),
        ("big-polygon.ply", encode("ply", points, faces).replace(b"\n3 ", b"\n3000000000 ")),
        ("packed.obj.gz", b"\x1f\x8b" + bytes(40)),
        ("picture.png", b"\x89PNG\r\n"),
        ("no-extension", encode("off", points, faces)),
    ):
        (folder / name).write_bytes(data)
        found[name] = (folder / name, "")
    (folder / "folder.obj").mkdir()
    found["folder"] = (folder / "folder.obj", "folder")
    found["missing"] = (folder / "missing.obj", "no such file")
    found["missing-folder"] = (folder / "none" / "missing.obj", "no such file")
    found["below-a-file"] = (folder / "huge.off" / "missing.obj", "no such file")
    return found
