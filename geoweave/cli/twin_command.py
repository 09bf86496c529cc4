"""The command that puts an exported pattern together in simulation: ``geoweave twin``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import about, as_json, new_folder, print_json, print_table, status, timed

if TYPE_CHECKING:
    from geoweave.cli.options import Say
    from geoweave.fabrication import Pattern
    from geoweave.rods import Step
    from geoweave.twin import Likeness, Twin


@click.command()
@click.argument("source", metavar="DIR|PATTERN", type=click.Path(exists=True))
@click.option("-o", "output", metavar="DIR", help="Folder for twin.json; that of the pattern if not given.")
@click.option("--anyway", is_flag=True, help="Put together also a pattern that contradicts itself.")
@as_json
def twin(source: str, output: str | None, anyway: bool, as_json: bool) -> None:
    """Put a pattern.json together in simulation, and say whether the woven object comes back."""
    from geoweave.pipeline import (
        earlier_report,
        listed_files,
        text_jobs,
        write_reported,
        write_texts,
    )
    from geoweave.rods import read_weave

    path = Path(source)
    path = path / "pattern.json" if path.is_dir() else path
    folder = new_folder(str(path.parent) if output is None else output)
    seconds: dict[str, float] = {}
    with status() as say:
        with timed(seconds, "read"):
            pattern = _read(path)
            # Only to compare with, after the twin has been made of the pattern alone.
            beside = {
                what: read_weave(path.with_name(name))
                for what, name in (("woven", "relaxed.json"), ("designed", "weave.json"))
                if path.with_name(name).is_file()
            }
        say("putting the strips together")
        with about(str(path)):
            made = _made(pattern, anyway, say)
        seconds |= made.seconds
        with timed(seconds, "compare"):
            found = _found(made, beside)
        if found and not made.side_known:
            # The pattern alone allows two mirror images; the one that was meant is compared.
            say("putting the mirror image together")
            image = _made(pattern, anyway, say, mirrored=True)
            other = _found(image, beside)
            seconds = {key: value + image.seconds.get(key, 0.0) for key, value in seconds.items()}
            if next(iter(other.values())).ribbons.rms < next(iter(found.values())).ribbons.rms:
                made, found = image, other
        target = next(iter(found.values()), None)
        said = {
            **made.metrics(),
            "woven": found["woven"].document() if "woven" in found else None,
            "designed": found["designed"].document() if "designed" in found else None,
            "comes_back": None if target is None else target.comes_back,
        }
        with timed(seconds, "write"):
            document = made.document(target)
            document["metrics"]["twin"] = said
            texts = {"twin.json": json.dumps(document, allow_nan=False) + "\n"}
            listed = listed_files(folder)
            if "pattern.json" in listed and folder.samefile(path.parent):
                # The report says so too, and lists the twin, so that the next weave takes it away.
                report = earlier_report(folder) | {"twin": said}
                files = write_reported(text_jobs(texts), report, folder, kept=listed)
            else:
                files = write_texts(texts, folder)
    seconds["total"] = sum(seconds.values())
    genus = beside["designed"]["surface"]["genus"] if "designed" in beside else None
    result = {
        "pattern": str(path),
        "ribbons": len(pattern.strips),
        "crossings": len(pattern.ribbons),
        **said,
        "genus_designed": genus,
        "seconds": {key: round(value, 4) for key, value in seconds.items()},
        "files": [str(each) for each in files.values()],
    }
    if as_json:
        print_json(result)
        return
    print_table(str(path), _rows(result, made, found))
    click.echo(sentence(made, target, "relaxed.json" if "woven" in found else "weave.json"))


def _made(pattern: Pattern, anyway: bool, say: Say, *, mirrored: bool = False) -> Twin:
    from geoweave.twin import assembled

    def told(step: Step) -> None:
        say(f"relaxing: step {step.number}, forces balance to {step.gradient:.1g}")

    return assembled(pattern, anyway=anyway, mirrored=mirrored, callback=told)


def _found(made: Twin, beside: Mapping[str, Any]) -> dict[str, Likeness]:
    """How far a twin is from each of the weaves."""
    names = {"woven": "relaxed.json", "designed": "weave.json"}
    return {what: made.compared(document, names[what]) for what, document in beside.items()}


def sentence(made: Twin, target: Likeness | None, name: str) -> str:
    """What a maker is told in the end."""
    from geoweave.twin import contradiction_sentence

    strips, doubts = made.pattern.strips, made.contradictions
    if target is None:
        return "The strips go together; no relaxed.json or weave.json is beside the pattern to compare with."
    far = f"{target.crossings.mean:.1%} of the diagonal in the mean, {target.crossings.largest:.1%} at most"
    one, other = (strips[r].label for r in made.pattern.ribbons[target.worst])
    where = f"{target.crossings.largest * target.diagonal:.3g} mm, where {one} crosses {other}"
    if not target.comes_back:
        return f"The object does not come back: its crossings are {far} from those of {name} ({where})."
    end = f" Check {contradiction_sentence(made.pattern, doubts[0])}." if doubts else ""
    return f"The object comes back: its crossings are {far} from those of {name} ({where}).{end}"


def _read(path: Path) -> Pattern:
    """Read a pattern, or say in one sentence why not."""
    from geoweave.errors import FieldError
    from geoweave.fabrication import Pattern

    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FieldError(
            f"{path}: cannot be read ({error.strerror}); make one with 'geoweave weave --formats pattern'"
        ) from error
    except ValueError as error:
        raise FieldError(f"{path}: is not JSON ({error}); write the pattern again") from error
    if not isinstance(document, dict):
        raise FieldError(f"{path}: is not a pattern; give a pattern.json of 'geoweave weave'")
    return Pattern.from_document(document, str(path))


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number or 'no'} {what}s"


def _rows(result: dict[str, Any], made: Twin, found: dict[str, Likeness]) -> list[tuple[str, str]]:
    """What the table for people says."""
    net, doubts = result["topology"], result["topology"]["contradictions"]
    closed = f"they close into a surface of genus {net['genus']} with {_count(net['openings'], 'opening')}"
    if result["genus_designed"] is not None:
        same = net["genus"] == result["genus_designed"]
        closed += ", as designed" if same else f"; the design has genus {result['genus_designed']}"
    strain, bow = result["strain"], result["bow"]
    rows = [
        ("ribbons", f"{result['ribbons']:,}"),
        ("crossings", f"{result['crossings']:,}"),
        ("faces", f"{net['faces']:,}; {closed}"),
        *(("  doubtful", text) for text in doubts[:5]),
        *([("  ", f"and {len(doubts) - 5} more such places")] if len(doubts) > 5 else []),
        ("outside", "known" if result["side_known"] else "none: the mirror image is as possible"),
        ("at rest", f"{'yes' if made.rest.converged else 'nearly'}, after {result['steps']} steps"),
        ("stretched", f"{strain['largest']:+.2%} at most, {strain['ribbon']}"),
        ("bow", f"{bow['largest']:.3g} mm at most, {bow['ribbon']}; strips are straight"),
    ]
    for what, each in found.items():
        off = each.crossings
        sizes = f"mean {off.mean:.2%} of the diagonal, rms {off.rms:.2%}, at most {off.largest:.2%}"
        rows.append((f"from {what}", f"crossings: {sizes}"))
        rows.append(("", f"along ribbons: mean {each.ribbons.mean:.2%}; of the shapes: {each.hausdorff:.2%}"))
    rows += [
        ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in result["seconds"].items())),
        ("written to", ", ".join(result["files"])),
    ]
    return rows
