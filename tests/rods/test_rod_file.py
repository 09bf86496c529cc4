import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp

from geoweave.errors import RodError
from geoweave.files import OutputError
from geoweave.rods.rod_file import Rod, RodCrossing, RodFile, read_rods, write_rods
from geoweave.weave.interlacing import greedy, judged, optimal

PEER = Path(__file__).resolve().parents[3] / "shared" / "peer"
needs_peers = pytest.mark.skipif(not PEER.is_dir(), reason="RibbonSim's files are not beside the checkout")


def ring(count, radius, height, **options):
    """A closed rod whose directors point up."""
    angle = 2 * np.pi * np.arange(count) / count
    points = np.c_[radius * np.cos(angle), radius * np.sin(angle), np.full(count, height)]
    return Rod(points, np.tile([0.0, 0.0, 1.0], (count, 1)), np.full(count, 0.1), closed=True, **options)


def bar(count, **options):
    points = np.c_[np.linspace(-2, 2, count), np.zeros(count), np.zeros(count)]
    return Rod(points, np.tile([0.0, 0.0, 1.0], (count - 1, 1)), np.full(count - 1, 0.1), **options)


def sample():
    rng = np.random.default_rng(0)
    rods = (
        ring(12, np.pi / 3, 0.0, angles=rng.normal(size=12), color=4),
        bar(9, visible=False, segment_colors=np.arange(8)),
    )
    crossings = (
        RodCrossing((0, 1), (0, 6), (0.0, 1 / 3), 1000.0),
        RodCrossing((1, 0), (1, 6), (0.75, 0.0), 1 / 7),
    )
    return RodFile(rods, crossings, 0.002, 1e8, 0.0)


def same(one, two):
    assert (one.thickness, one.young, one.density) == (two.thickness, two.young, two.density)
    assert one.crossings == two.crossings
    assert len(one.rods) == len(two.rods)
    for a, b in zip(one.rods, two.rods, strict=True):
        for field in dataclasses.fields(Rod):
            np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name))


def older(text, version):
    """The same rods as an older version would hold them."""
    lines = text.splitlines()
    head, rods, tail = lines[2:7], [], []
    for start in range(7, len(lines)):
        if lines[start] == "" and len(rods) < int(head[0]):
            n, closed, *look = lines[start + 1 : start + 5]
            points, directors, angles, widths, _ = lines[start + 5 : start + 10]
            later = ([*look], [angles]) if version == 1 else ([], [])
            rods.append([n, closed, *later[0], points, directors, *later[1], widths])
            tail = lines[start + 10 :]
    return "\n".join([*(["-217", "1"] if version == 1 else []), *head, *itertools.chain(*rods), *tail])


def test_every_digit_comes_back(tmp_path):
    write_rods(tmp_path / "a.rod", sample())
    back = read_rods(tmp_path / "a.rod")
    same(back, sample())
    write_rods(tmp_path / "b.rod", back)
    assert (tmp_path / "a.rod").read_bytes() == (tmp_path / "b.rod").read_bytes()
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.rod", "b.rod"]


@pytest.mark.parametrize("version", [0, 1])
def test_older_versions(tmp_path, version):
    write_rods(tmp_path / "new.rod", sample())
    (tmp_path / "old.rod").write_text(older((tmp_path / "new.rod").read_text(), version))
    back, content = read_rods(tmp_path / "old.rod"), sample()
    rods = [dataclasses.replace(rod, segment_colors=None) for rod in content.rods]
    if version == 0:
        rods = [dataclasses.replace(rod, angles=None, visible=True, color=0) for rod in rods]
    same(back, dataclasses.replace(content, rods=tuple(rods)))


def test_arclengths_along_rods():
    placed = sample().placed()
    assert placed.closed.tolist() == [True, False]
    assert placed.ribbons.tolist() == [[0, 1], [1, 0]]
    side = 2 * np.pi / 3 * np.sin(np.pi / 12)
    np.testing.assert_allclose(placed.arclengths, [[0.0, 3 + 1 / 6], [0.875, 6 * side]], rtol=1e-14)


@needs_peers
@pytest.mark.parametrize(("name", "rods", "crossings"), [("cone60", 10, 35), ("torus7", 10, 84)])
def test_peer_files(tmp_path, name, rods, crossings):
    content = read_rods(PEER / f"{name}.rod")
    assert (len(content.rods), len(content.crossings)) == (rods, crossings)
    write_rods(tmp_path / "again.rod", content)
    same(read_rods(tmp_path / "again.rod"), content)
    # the two points of each crossing lie on each other, but for what the simulated rods give way
    for one in content.crossings:
        ends = [
            content.rods[rod].centerline[s : s + 2] for rod, s in zip(one.rods, one.segments, strict=True)
        ]
        gap = np.diff([(1 - t) * a + t * b for (a, b), t in zip(ends, one.places, strict=True)], axis=0)
        assert np.linalg.norm(gap) < 0.02


def fewest_broken(crossings):
    """The same optimum from another program, with a side for each crossing and no word about cycles."""
    first, second, _, parity = crossings.relations
    count, wishes = len(crossings), len(first)
    row = np.arange(wishes)
    # x_first + x_second + z - 2 k = parity, over sides x, broken wishes z and k in {0, 1}
    matrix = np.zeros((wishes, count + 2 * wishes))
    np.add.at(matrix, (row, first), 1)
    np.add.at(matrix, (row, second), 1)
    matrix[row, count + row], matrix[row, count + wishes + row] = 1, -2
    cost = np.concatenate([np.zeros(count), np.ones(wishes), np.zeros(wishes)])
    solved = milp(
        cost, integrality=np.ones(len(cost)), bounds=Bounds(0, np.where(cost == 0, 2, 1)),
        constraints=[
            LinearConstraint(matrix, parity, parity),
            LinearConstraint(np.eye(len(cost))[:count], 0, 1),
        ],
    )  # fmt: skip
    assert solved.status == 0
    return round(solved.fun)


@needs_peers
@pytest.mark.parametrize("name", ["cone60", "torus7"])
def test_peer_weaves_alternate(name):
    """The paper's cone can alternate throughout, its torus cannot; what it can do is proven twice over."""
    crossings = read_rods(PEER / f"{name}.rod").placed()
    found = optimal(crossings)
    assert found.proven
    assert judged(crossings, found.over).broken.sum() == found.broken.sum() == fewest_broken(crossings)
    assert (found.broken.sum() == 0) == (name == "cone60")
    assert all(greedy(crossings, seed).alternation < found.alternation for seed in range(5))


def changed(text, old, new):
    assert old in text
    return text.replace(old, new, 1)


def test_hostile_files(tmp_path):
    file = tmp_path / "bad.rod"
    write_rods(file, sample())
    good = file.read_text()
    lines = good.splitlines()

    def refused(text, *words):
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(RodError) as caught:
            read_rods(file)
        message = str(caught.value)
        assert message.startswith(f"{file}: ")
        assert "\n" not in message
        for word in words:
            assert word in message, message

    def with_line(number, new):
        return "\n".join([*lines[: number - 1], new, *lines[number:]])

    def with_word(number, place, new):
        words = lines[number - 1].split()
        words[place] = new
        return with_line(number, " ".join(words))

    refused("", "line 1", "cut short")
    refused(b"\x00\xff\x80", "byte 1", "numbers only")
    refused(changed(good, "-217\n2", "-217\n3"), "line 2", "version", "from 1 to 2")
    refused(changed(good, "-217\n2", "-217"), "line ")
    refused(with_line(3, "-1"), "line 3", "number of rods", "-1")
    refused(with_line(3, "1.5"), "line 3", "1.5")
    refused(with_line(3, "9" * 30), "line 3")
    refused(with_line(3, "1"), "line ")
    refused(with_line(3, "3"), "line ")
    refused(with_line(4, "3"), "a rod of crossing 2", "cut short")
    refused(with_line(5, "0"), "thickness is 0")
    refused(with_line(6, "nan"), "line 6", "'nan'")
    refused(with_line(9, "999999999999"), "rod 0 need 2,999,999,999,997", "cut short")
    refused(with_line(9, "1000000"), "rod 0 need 3,000,000")
    refused(with_line(10, "2"), "line 10", "closed flag of rod 0")
    refused(with_word(13, 4, "nan"), "line 13", "'nan'", "vertices of rod 0")
    refused(with_word(13, 4, "1e999"), "line 13", "1e999 among the vertices of rod 0 is beyond 1e+50")
    refused(with_word(13, 4, "0x10"), "line 13", "'0x10'")
    refused(with_word(13, 4, "1_0"), "line 13", "'1_0'")
    # directors that have no direction square to their segment
    zeros = " ".join(["0"] * len(lines[13].split()))
    refused(with_line(14, zeros), "line 9", "rod 0: director 0", "unit vector")
    refused(with_word(16, 3, "-0.1"), "line 9", "segment 3", "width -0.1")
    refused(with_word(17, 0, "0.5"), "line 9", "colours")
    points = lines[12].split()
    refused(with_line(13, " ".join([*points[:3], *points[:3], *points[6:]])), "segment 0 has no length")
    refused(with_word(len(lines), 0, "2"), f"line {len(lines)}", "crossing 1 names rod 2 of 2")
    refused(with_word(len(lines), 2, "8"), f"line {len(lines)}", "segment 8 of rod 1, which has 8")
    refused(with_word(len(lines), 4, "1.5"), f"line {len(lines)}", "1.5 of a segment")
    refused(with_word(len(lines), 6, "-1"), "stiffness -1")
    refused(with_word(len(lines) - 1, 2, "zero"), f"line {len(lines) - 1}", "'zero'")
    # cut anywhere, down to the last number, which may lose digits
    for end in np.linspace(0, good.rindex(" "), 60).astype(int):
        refused(good[:end])
    file.unlink()
    with pytest.raises(RodError, match="cannot be read"):
        read_rods(file)


def test_values_refuse_what_files_must_not_hold(tmp_path):
    with pytest.raises(RodError, match="1 vertex but needs 2"):
        Rod(np.zeros((1, 3)), np.zeros((0, 3)), np.zeros(0))
    with pytest.raises(RodError, match="2 vertices but needs 3"):
        Rod(np.eye(3)[:2], np.eye(3)[:2], np.ones(2), closed=True)
    with pytest.raises(RodError, match="directors are of shape"):
        Rod(np.eye(3), np.eye(3), np.ones(2))
    for color in (-1, 0.5, 10**18):
        with pytest.raises(RodError, match="whole number from 0 on"):
            bar(4, color=color)
    with pytest.raises(RodError, match="segment to itself"):
        dataclasses.replace(sample(), crossings=(RodCrossing((0, 0), (3, 3), (0.1, 0.9)),))
    with pytest.raises(RodError, match="Young's modulus is nan"):
        dataclasses.replace(sample(), young=np.nan)
    with pytest.raises(OutputError, match="no folder"):
        write_rods(tmp_path / "nowhere" / "a.rod", sample())
