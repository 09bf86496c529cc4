"""The command ``geoweave info``: what a mesh is, and what was mended."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import (
    as_json,
    components_option,
    faces_option,
    mesh_argument,
    print_json,
    print_table,
    repair_option,
    status,
    text_of,
)

if TYPE_CHECKING:
    from geoweave.meshing import Components


@click.command()
@mesh_argument
@as_json
@repair_option
@components_option
@faces_option
@click.option("-o", "output", metavar="OUT", help="Write the mended mesh (.obj, .off or .ply).")
def info(
    name: str, as_json: bool, repair: bool, components: Components, faces: int | None, output: str | None
) -> None:
    """Read a mesh file (or a named data set), mend it, and say what it is and what was mended."""
    from geoweave.files import check_output
    from geoweave.pipeline import MeshSource, prepared_surface

    source = MeshSource(name, faces, repair=repair, components=components)
    if output is not None:
        from geoweave.meshing import check_format

        check_format(output)
        check_output(output, name)
    with status() as say:
        prepared = prepared_surface(source, {}, say)
        if output is not None:
            from geoweave.meshing import write_mesh

            say(f"writing {output}")
            write_mesh(prepared.mesh, output)
    mesh, report = prepared.mesh, prepared.report
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    result: dict[str, Any] = {
        "mesh": name,
        "vertices": mesh.n_vertices,
        "edges": mesh.n_edges,
        "faces": mesh.n_faces,
        "components": mesh.n_components,
        "genus": mesh.genus,
        "boundary_loops": len(mesh.boundary_loops),
        "euler_characteristic": mesh.euler_characteristic,
        "area": float(mesh.face_areas.sum()),
        "mean_edge": mesh.mean_edge,
        "bounding_box": [low.tolist(), high.tolist()],
        "repairs": report.as_dict(),
        "notes": list(report.notes),
    }
    if output is not None:
        result["output"] = output
    if as_json:
        print_json(result)
        return
    size = " x ".join(f"{side:.5g}" for side in high - low)
    rows = [
        (key.replace("_", " "), text_of(result[key]))
        for key in result
        if isinstance(result[key], int | float)
    ]
    sentences = report.sentences() or ["none needed"]
    rows += [("size", size), ("repairs", sentences[0]), *(("", more) for more in sentences[1:])]
    rows += [("written to", output)] if output is not None else []
    print_table(name, rows)
