"""Pictures: something is drawn, nothing is cut off, colours mean what they should, bytes repeat."""

from __future__ import annotations

import io
import json

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
import trimesh
from matplotlib.colors import to_rgb
from PIL import Image

from geoweave import viz
from geoweave.curves.tracing import geodesic_curvature, streamlines
from geoweave.errors import RenderError
from geoweave.fields.face_field import FaceField, signed_curl
from geoweave.surface.mesh import TriMesh
from geoweave.viz import style
from geoweave.viz.gallery import panel_scene


@pytest.fixture(scope="module")
def sphere() -> TriMesh:
    ball = trimesh.creation.icosphere(3)
    return TriMesh(ball.vertices, ball.faces)


@pytest.fixture(scope="module")
def circles(sphere):
    return streamlines(
        FaceField.from_ambient(sphere, np.cross([0.0, 0.0, 1.0], sphere.barycenters)), share=0.1
    )


@pytest.fixture(scope="module")
def meridians(sphere):
    return streamlines(
        FaceField.from_ambient(sphere, np.tile([0.0, 0.0, 1.0], (sphere.n_faces, 1))), share=0.1
    )


@pytest.fixture
def poles(sphere) -> np.ndarray:
    indices = np.zeros(sphere.n_vertices, dtype=np.int64)
    indices[np.argmax(sphere.vertices[:, 2])] = 1
    return indices


def lightness(pixels: np.ndarray) -> np.ndarray:
    return pixels.astype(float) @ [0.2126, 0.7152, 0.0722]


def near(pixels: np.ndarray, colour: str, reach: float = 30.0) -> np.ndarray:
    return np.linalg.norm(pixels.astype(float) - 255 * np.array(to_rgb(colour)), axis=-1) < reach


def blank_frame(pixels: np.ndarray, width: int) -> bool:
    """Whether a frame of this many pixels is the ground on all four sides."""
    inside = np.zeros(pixels.shape[:2], dtype=bool)
    inside[width:-width, width:-width] = True
    return bool((pixels[~inside] == 255).all())


@pytest.mark.parametrize("elevation", [-40.0, 10.0, 80.0])
@pytest.mark.parametrize("stretch", [(1, 1, 1), (4, 1, 1), (1, 1, 4)])
def test_a_scene_fills_the_picture_and_is_not_cut_off(sphere, elevation, stretch):
    scene = viz.Scene(viz.View(azimuth=25, elevation=elevation))
    scene.add_surface(TriMesh(sphere.vertices * stretch + [7.0, -3.0, 2.0], sphere.faces))
    pixels = scene.draw(160)
    assert blank_frame(pixels, 1)
    drawn = (pixels < 250).any(axis=2)
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    # a margin of 3 % of the longer side, and nothing more, is left on every side
    most = 0.04 * max(drawn.shape) + 2
    assert rows[0] < most
    assert len(drawn) - 1 - rows[-1] < most
    assert columns[0] < most
    assert drawn.shape[1] - 1 - columns[-1] < most
    light = lightness(pixels)[drawn]
    assert np.median(light) > 110  # an off-white surface, most of it in the light
    assert np.ptp(light) > 40  # and yet shaded


def test_a_surface_of_any_size_looks_the_same(sphere):
    pictures = []
    for scale in (1e-6, 1.0, 1e6):
        scene = viz.Scene()
        scene.add_surface(TriMesh(sphere.vertices * scale, sphere.faces))
        pictures.append(scene.draw(80).astype(int))
    assert np.abs(pictures[0] - pictures[1]).mean() < 1.0
    assert np.abs(pictures[2] - pictures[1]).mean() < 1.0


def test_up_is_up(sphere):
    for up, sign in (("z", 1), ("-z", -1), ("y", 1), ("x", 1)):
        axis = "xyz".index(up[-1])
        values = sign * sphere.barycenters[:, axis]
        scene = viz.Scene(viz.View(azimuth=40, elevation=0, up=up))
        scene.add_surface(sphere, values=values)
        pixels = scene.draw(100).astype(int)
        warm = pixels[..., 0] - pixels[..., 2]
        assert warm[15:35, 40:60].mean() > 30  # the positive, red end
        assert warm[-35:-15, 40:60].mean() < -10  # the negative, blue end


def test_occlusion_darkens_a_groove():
    rings = np.stack([np.linspace(-1, 1, 161)] * 40, axis=1)
    angle = np.linspace(0, 2 * np.pi, 41)[:-1]
    radius = 1 - 0.75 * np.exp(-((rings / 0.12) ** 2))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), rings], axis=2).reshape(-1, 3)
    a = (np.arange(160)[:, None] * 40 + np.arange(40)).ravel()
    b = (np.arange(160)[:, None] * 40 + (np.arange(40) + 1) % 40).ravel()
    faces = np.concatenate([np.stack([a, b, b + 40], 1), np.stack([a, b + 40, a + 40], 1)])
    scene = viz.Scene(viz.View(azimuth=0, elevation=0))
    scene.add_surface(TriMesh(points, faces))
    light = lightness(scene.draw(200))
    column = light[:, light.shape[1] // 2]
    assert column[95:105].min() < 0.75 * np.median(column[30:70])


def test_curved_lines_are_warm_and_straight_lines_are_dark(sphere, circles, meridians):
    amber, slate = style.sequential()(1.0)[:3], style.sequential()(0.0)[:3]

    def shares(curves):
        scene = viz.Scene(viz.View(elevation=30))
        scene.add_surface(sphere)
        scene.add_curves(curves, 0.015, values=np.abs(geodesic_curvature(curves)), limits=(0.0, 1.0))
        pixels = scene.draw(300)
        return near(pixels, amber, 45).mean(), near(pixels, slate, 45).mean()

    circle, meridian = shares(circles), shares(meridians)
    assert circle[0] > 5 * meridian[0]
    assert meridian[1] > 2 * circle[1]


def test_numbers_in_captions():
    shown = {0.0: "0", 1e-8: "10⁻⁸", 2.5e-6: "2.5 · 10⁻⁶", 1e-3: "10⁻³", 0.05: "0.05", 1e3: "1,000"}
    assert {value: style.scientific(value) for value in shown} == shown


def test_maps_are_uniform_and_centred():
    at = np.linspace(0, 1, 64)
    lab = style._to_oklab(style.sequential()(at)[:, :3])
    assert (np.diff(lab[:, 0]) > 0).all()
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    # the path turns at its stops, where a chord is a little shorter than the arc
    assert steps.max() < 1.4 * steps.min()
    signed = style.diverging()
    assert np.allclose(signed(0.5)[:3], to_rgb(style.SURFACE), atol=0.02)
    ends = style._to_oklab(np.array([signed(0.0)[:3], signed(1.0)[:3]]))
    assert abs(ends[0, 0] - ends[1, 0]) < 0.03
    assert np.allclose(style._from_oklab(style._to_oklab(signed(at)[:, :3])), signed(at)[:, :3], atol=1e-6)


def test_singularities_are_dots_of_their_sign(sphere, poles):
    def red_and_blue(indices):
        scene = panel_scene(viz.Panel("one", mesh=sphere, indices=indices, view=viz.View(elevation=70)))
        pixels = scene.draw(300)
        return near(pixels, style.SOURCE, 60).sum(), near(pixels, style.SADDLE, 60).sum()

    assert red_and_blue(0 * poles) == (0, 0)
    plus, minus = red_and_blue(poles), red_and_blue(-poles)
    assert plus[0] > 5
    assert plus[1] == 0
    assert minus[0] == 0
    assert minus[1] > 5


def test_seams_are_blue_bars(sphere):
    def blue(seams):
        scene = panel_scene(viz.Panel("one", mesh=sphere, seams=seams, view="sphere"))
        return near(scene.draw(300), style.BLUE, 40).sum()

    assert blue(np.arange(0)) == 0
    assert blue(np.arange(sphere.n_edges)) > blue(np.arange(sphere.n_edges // 2)) > 20


def test_a_gallery_keeps_a_margin_and_one_scale(sphere, circles, meridians):
    panels = [viz.Panel("Circles", circles, "1,280 faces"), viz.Panel("Meridians", meridians, "1,280 faces")]
    picture = viz.streamline_gallery(panels, width=800)
    assert blank_frame(picture.pixels, 6)
    # both halves hold a model, and below there are words
    drawn = lightness(picture.pixels) < 245
    assert drawn[20:300, :400].mean() > 0.3
    assert drawn[20:300, 400:].mean() > 0.3
    assert picture.alt == "Streamlines on Circles, Meridians"
    high = viz.curvature_scale(panels).high
    assert viz.curvature_scale(panels[:1]).high >= high > viz.curvature_scale(panels[1:]).high


def test_curl_on_the_surface_gets_a_bar_of_its_own(sphere, meridians):
    field = FaceField.from_ambient(sphere, np.cross([0.0, 0.0, 1.0], sphere.barycenters)).normalized()
    panel = viz.Panel("Curl", meridians, face_values=signed_curl(field), view="sphere")
    scale = viz.curl_scale([panel])
    assert scale.low == -scale.high
    picture = viz.streamline_gallery([panel], width=900)
    pixels = picture.pixels
    bar = np.flatnonzero(near(pixels[:, 450:], style.diverging()(0.02)[:3], 25).any(axis=1))
    assert bar.size > 0
    assert bar.max() > len(pixels) - 130


def test_pictures_repeat_to_the_byte_and_ignore_the_users_settings(circles, poles):
    def draw() -> bytes:
        panels = [viz.Panel("Circles", circles, indices=poles, view="sphere")]
        return viz.streamline_gallery(panels, width=500).png()

    once = draw()
    with mpl.rc_context({"font.size": 30, "axes.facecolor": "black", "savefig.dpi": 30}):
        assert draw() == once
        assert mpl.rcParams["font.size"] == 30


def test_a_png_keeps_its_colours_and_says_nothing_of_its_making(circles):
    picture = viz.streamline_gallery([viz.Panel("Circles", circles)], width=600)
    encoded = picture.png()
    image = Image.open(io.BytesIO(encoded))
    assert image.size == picture.pixels.shape[1::-1]
    assert image.info.keys() <= {"transparency", "gamma"}
    decoded = np.asarray(image.convert("RGB")).astype(float)
    assert np.abs(decoded - picture.pixels).mean() < 2.5
    ground = (picture.pixels == 255).all(axis=2)
    assert (decoded[ground] == 255).all()
    smaller = Image.open(io.BytesIO(picture.png(300)))
    assert smaller.width == 300
    limit = len(encoded) // 2
    assert len(picture.png_within(limit)) <= limit
    with pytest.raises(RenderError, match="does not fit"):
        picture.png_within(100)


def test_a_notebook_shows_a_small_png(circles):
    picture = viz.streamline_gallery([viz.Panel("Circles", circles)], width=1400, alt="circles on a ball")
    bundle = picture._repr_mimebundle_()
    assert len(bundle["image/png"]) <= 300_000
    assert Image.open(io.BytesIO(bundle["image/png"])).width <= 1100
    assert bundle["text/plain"] == "Picture('circles on a ball')"


def test_publishing_writes_picture_numbers_and_provenance(tmp_path, monkeypatch, sphere, circles):
    monkeypatch.setenv("GEOWEAVE_FIGURES", str(tmp_path / "figures"))
    picture = viz.streamline_gallery([viz.Panel("Circles", circles)], width=400)
    table = pd.DataFrame({"model": ["sphere"], "curl": [1.0 / 3.0], "faces": [sphere.n_faces]})
    params = {"faces": np.int64(5), "share": 0.1, "models": ("a", "b"), "weights": np.array([1.0, 2.0])}

    def publish(profile: str = "default"):
        return viz.publish(
            "fig99_test", picture, table=table, params=params, inputs={"sphere": sphere}, profile=profile
        )

    assert publish() is picture
    folder = tmp_path / "figures"
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert sorted(first) == ["fig99_test.csv", "fig99_test.json", "fig99_test.png"]
    assert first["fig99_test.csv"] == b"model,curl,faces\nsphere,0.333333,1280\n"
    record = json.loads(first["fig99_test.json"])
    assert record["parameters"] == {"faces": 5, "share": 0.1, "models": ["a", "b"], "weights": [1.0, 2.0]}
    assert record["inputs"]["sphere"]["faces"] == 1280
    assert len(record["inputs"]["sphere"]["sha256"]) == 64
    assert {"geoweave", "numpy", "vtk", "pyvista"} <= record["versions"].keys()
    assert str(tmp_path) not in first["fig99_test.json"].decode()
    publish()
    assert first == {path.name: path.read_bytes() for path in folder.iterdir()}
    publish("paper")
    assert (folder / "paper" / "fig99_test.png").read_bytes() == first["fig99_test.png"]


def test_the_digest_of_a_mesh_depends_on_every_number(sphere):
    moved = sphere.vertices.copy()
    moved[0, 0] += 1e-12
    digests = {
        viz.mesh_digest(sphere),
        viz.mesh_digest(TriMesh(moved, sphere.faces)),
        viz.mesh_digest(TriMesh(sphere.vertices, np.roll(sphere.faces, 1, axis=0))),
    }
    assert len(digests) == 3
    assert viz.mesh_digest(TriMesh(sphere.vertices, sphere.faces)) in digests


def test_the_chart_of_alternations_draws_three_curves():
    energies, changes = np.geomspace(3.0, 1.0, 21), np.geomspace(1e-1, 1e-6, 20)
    both = viz.alternation_chart(energies, changes, 0.3 * changes).pixels
    assert (both != viz.alternation_chart(energies, changes, np.zeros(20)).pixels).any()
    assert (both != viz.alternation_chart(energies, changes, 0.3 * changes, mark=30).pixels).any()
    with pytest.raises(RenderError, match="one energy more"):
        viz.alternation_chart(energies, energies, changes)


def test_the_convergence_chart_draws_both_curves_and_the_dotted_line():
    steps = np.arange(21)
    curls, changes = 1 + 10 * np.exp(-steps / 4), 0.3 * np.exp(-steps[1:] / 5)
    with_line = viz.convergence_chart(curls, changes, reference=12.0).pixels
    without = viz.convergence_chart(curls, changes).pixels
    assert near(with_line, style.BLUE).sum() > near(without, style.BLUE).sum()
    assert near(without, style.RED).sum() > 2000
    assert blank_frame(with_line, 6)
    with pytest.raises(RenderError, match="one curl more"):
        viz.convergence_chart(curls, curls)


def test_the_chart_of_drops_shows_ours_and_the_papers():
    ours = viz.Drop("Cow", 20.0, 7.0)
    both = viz.Drop("Cow", 20.0, 7.0, 13.36, 4.19)
    grey = [near(viz.drop_chart([row]).pixels, "#a9a59c", 12).sum() for row in (ours, both)]
    assert grey[1] > grey[0] + 1000
    with pytest.raises(RenderError, match="at least one model"):
        viz.drop_chart([])


def test_what_cannot_be_drawn_is_refused(sphere, circles):
    with pytest.raises(RenderError, match="at least one panel"):
        viz.streamline_gallery([])
    with pytest.raises(RenderError, match="no view is kept for 'nessie'"):
        viz.streamline_gallery([viz.Panel("Nessie", circles, view="nessie")])
    with pytest.raises(RenderError, match="neither curves nor a mesh"):
        _ = viz.Panel("Empty").surface
    with pytest.raises(RenderError, match="holds no surface"):
        viz.Scene().draw(50)
    with pytest.raises(RenderError, match="up axis"):
        _ = viz.View(up="w").axes
    with pytest.raises(RenderError, match="cannot name a figure"):
        viz.publish("../escape", viz.streamline_gallery([viz.Panel("Circles", circles)], width=200))
