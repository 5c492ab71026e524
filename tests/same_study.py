"""The same study written otherwise: mirrored, turned, moved, in other units, in another order.

`write_same` reads a study and its environment, and writes both anew into a folder; `answers` says
what a run of either found, in words and numbers that both should share.
"""

from __future__ import annotations

import math
import random
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

import workbench as wb
from tests.conftest import ROOT

LIMBS = "SM|UA|LA|HN|UL|LL|F|C|S|E|W|H|K|A"
SIDED = re.compile(rf"^([LR])({LIMBS})(/.*)?$")
PLACES = ("srp", "at", "point", "position", "on", "origin", "wheel", "picked")
WAYS = ("by", "move", "along", "axis", "direction")
UNITS = {"m": 1.0, "mm": 1000.0, "cm": 100.0, "in": 1.0 / 0.0254}
LENGTHS = {
    *("srp", "depth", "at", "point", "position", "on", "origin", "by", "move", "forward", "up"),
    *("left", "at_most", "at_least", "below", "above", "measures", "picked", "points", "travel"),
    *("farther_back", "farther_forward", "lower", "higher", "characters", "radius", "aims"),
}
"""Keys with lengths below them; angles and shares stand under some of them too, see `_plain`."""


@dataclass(frozen=True)
class Same:
    """How a study is written: mirrored left to right, turned [degrees] about the vertical, moved
    [m], lengths in a unit, lists in another order (a seed), the mesh with y up."""

    mirrored: bool = False
    turned: float = 0.0
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)
    unit: str = "mm"
    order: int | None = None
    y_up: bool = False
    turn: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        c = round(math.cos(math.radians(self.turned)), 15)
        s = round(math.sin(math.radians(self.turned)), 15)
        flip = np.diag([1.0, -1.0 if self.mirrored else 1.0, 1.0])
        object.__setattr__(self, "turn", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ flip)

    def place(self, point, scale):
        """A point, in units of which `scale` are a metre."""
        return (self.turn @ np.array(point) + scale * np.array(self.moved)).tolist()

    def way(self, vector):
        """A direction or a displacement."""
        return (self.turn @ np.array(vector)).tolist()

    def yaw(self, degrees):
        """A heading."""
        return (-degrees if self.mirrored else degrees) + self.turned

    def side(self, name):
        """The name of a side, a segment, a joint or a subpart."""
        if not self.mirrored:
            return name
        if found := SIDED.match(name):
            name = ("R" if found[1] == "L" else "L") + found[2] + (found[3] or "")
        return re.sub(r"\b(left|right)\b", _other, name)

    def shuffled(self, values):
        """A list, or a mapping's items, in another order."""
        values = list(values)
        if self.order is not None:
            random.Random(self.order).shuffle(values)
        return values


def _other(found):
    return {"left": "right", "right": "left"}[found[1]]


def write_same(study: Path, folder: Path, how: Same) -> Path:
    """Write a study and its environment otherwise; return the study's new file."""
    said = _loaded(study)
    source = ROOT / "environments" / said["environment"] / "environment.yaml"
    if not source.exists():
        source = study.parent / said["environment"]
    folder.mkdir(parents=True, exist_ok=True)
    _write_environment(source, folder / "there", how)
    said["environment"] = "there/environment.yaml"
    for case in said["cases"]:
        for action in case["people"].values():
            if "motion" in action:
                _write_motion(study.parent, folder, action["motion"], how, UNITS[said["length"]])
    said = _study(said, how)
    path = folder / study.name
    path.write_text(yaml.safe_dump(said, sort_keys=False, width=200))
    return path


def _write_motion(source: Path, folder: Path, motion, how: Same, scale: float) -> None:
    """A motion in the project's own table: mirrored in the file, put elsewhere by the study."""
    head, rows = [], []
    for line in (source / motion["file"]).read_text().splitlines():
        (head if line.startswith("#") else rows).append(line)
    names = [name.strip() for name in rows[0].split(",")]
    table = np.array([[float(value) for value in row.split(",")] for row in rows[1:]])
    for k, name in enumerate(names):
        joint, _, rest = name.partition(".")
        if how.mirrored and (name.split()[0] in ("y", "qx", "qz") or "_left [" in rest):
            table[:, k] *= -1.0
        names[k] = f"{how.side(joint)}.{rest}" if rest else name
    text = [*head, ", ".join(names), *(", ".join(map(repr, row)) for row in table.tolist())]
    (folder / motion["file"]).parent.mkdir(parents=True, exist_ok=True)
    (folder / motion["file"]).write_text("\n".join(text) + "\n")
    motion["move"] = how.place(motion.get("move", (0.0, 0.0, 0.0)), scale)
    motion["yaw"] = how.yaw(motion.get("yaw", 0.0))


def _loaded(path: Path):
    """A YAML file as plain values; `on` is a key of the files and no truth value."""
    text = re.sub(r"(?<=[{ ])on:", '"on":', path.read_text())
    return yaml.safe_load(text)


def _study(said, how):
    scale = UNITS[said["length"]]
    said["people"] = {name: _role(role, how, scale) for name, role in said["people"].items()}
    said["postures"] = {
        name: posture | {"angles": _angles(posture.get("angles", {}), how)}
        for name, posture in said.get("postures", {}).items()
    }
    for case in said["cases"]:
        case["people"] = {name: _action(one, how) for name, one in case["people"].items()}
    for criterion in said["criteria"]:
        _criterion(criterion, how, scale)
    for point in said.get("signals", {}).get("points", []):
        point["segment"] = how.side(point["segment"])
        if how.mirrored and "at" in point:
            point["at"][1] *= -1.0
    for force in said.get("contact_forces", []):
        if "segments" in force:
            force["segments"] = [how.side(name) for name in force["segments"]]
    for key in ("moved", "changes"):
        for row in said.get(key, []):
            for name in ("by", "move"):
                if name in row:
                    row[name] = how.way(row[name])
    for key in ("reach_maps", "reach_envelopes"):
        for row in said.get(key, []):
            if "hand" in row:
                row["hand"] = how.side(row["hand"])
    said = _in_unit(said, how)
    names = how.shuffled(said["people"])
    said["people"] = {name: said["people"][name] for name in names}
    for case in said["cases"]:
        case["people"] = {name: case["people"][name] for name in names}
    said["criteria"] = how.shuffled(said["criteria"])
    return said


def _role(role, how, scale):
    role = dict(role)
    if "at" in role:
        at = dict(role["at"])
        at["segment"] = how.side(at["segment"])
        at["position"] = how.place(at["position"], scale)
        attitude = dict(at.get("attitude", {}))
        attitude["yaw"] = how.yaw(attitude.get("yaw", 0.0))
        if "roll" in attitude and how.mirrored:
            attitude["roll"] = -attitude["roll"]
        role["at"] = at | {"attitude": attitude}
    if "stand" in role:
        stand = dict(role["stand"])
        stand["on"] = how.place(stand["on"], scale)
        stand["yaw"] = how.yaw(stand.get("yaw", 0.0))
        if how.mirrored and "left" in stand.get("area", {}):
            low, high = stand["area"]["left"]
            stand["area"] = stand["area"] | {"left": [-high, -low]}
        role["stand"] = stand
    return role


def _angles(angles, how):
    if not how.mirrored:
        return angles
    return {
        " ".join(how.side(joint) for joint in joints.split()): {
            re.sub(r"(left|right)$", _other, motion): value for motion, value in motions.items()
        }
        for joints, motions in angles.items()
    }


def _action(action, how):
    action = dict(action)
    for key in ("predicted", "driver"):
        if key in action:
            action[key] = dict(action[key]) | {
                limbs: {how.side(side): name for side, name in action[key][limbs].items()}
                for limbs in ("hands", "feet")
                if limbs in action[key]
            }
    if "hands" in action:
        action["hands"] = {how.side(side): name for side, name in action["hands"].items()}
    if "angles" in action:
        action["angles"] = _angles(action["angles"], how)
    return action


def _criterion(criterion, how, scale):
    for key in ("segments", "subparts"):
        if key in criterion:
            criterion[key] = [how.side(name) for name in criterion[key]]
    if "hand" in criterion:
        criterion["hand"] = how.side(criterion["hand"])
    if "direction" in criterion:
        criterion["direction"] = how.way(criterion["direction"])
    if "origin" in criterion:
        criterion["origin"] = how.place(criterion["origin"], scale)


def _write_environment(source: Path, folder: Path, how: Same) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    said = _loaded(source)
    scale = UNITS[said["length"]]
    for mesh in said["meshes"]:
        text = (source.parent / mesh["file"]).read_text()
        assert mesh.get("length", "m") == "m"
        (folder / mesh["file"]).write_text(_obj(text, how))
        if how.y_up:
            mesh |= {"up": "y", "forward": "z"}
    for part in said.get("parts", {}).values():
        for allowed in part.get("allow", []):
            if allowed["segments"] != "all":
                allowed["segments"] = [how.side(name) for name in allowed["segments"]]
    for seat in said.get("seats", {}).values():
        seat["srp"] = how.place(seat["srp"], scale)
        seat["yaw"] = how.yaw(seat.get("yaw", 0.0))
    points = said.get("points", {})
    said["points"] = {name: how.place(point, scale) for name, point in points.items()}
    for control in said.get("controls", {}).values():
        control["at"] = how.place(control["at"], scale)
    for adjustment in said.get("adjustments", {}).values():
        if "along" in adjustment:
            adjustment["along"] = how.way(adjustment["along"])
        else:
            about = adjustment["about"]
            about["point"] = how.place(about["point"], scale)
            # an axis of turns is mirrored the other way round than a direction
            sign = -1.0 if how.mirrored else 1.0
            about["axis"] = (sign * np.array(how.way(about["axis"]))).tolist()
    for thing in (*said.get("instruments", {}).values(), *said.get("mirrors", {}).values()):
        if "face" in thing:
            thing["face"] = how.way(thing["face"])
        if "aims" in thing:
            thing["aims"] = how.place(thing["aims"], scale)
    said = _in_unit(said, how)
    for key in ("controls", "points", "seats", "parts", "instruments", "mirrors"):
        if key in said:
            said[key] = {name: said[key][name] for name in how.shuffled(said[key])}
    (folder / "environment.yaml").write_text(yaml.safe_dump(said, sort_keys=False, width=200))


def write_plain(source: Path, folder: Path) -> None:
    """Write an environment as one OBJ file in metres, z up, which is what `write_same` understands."""
    environment = wb.load_environment(source)
    part = np.repeat(environment.polygon_part, np.diff(environment.triangle_start))
    lines = []
    count = 0
    for k, name in enumerate(environment.parts):
        used, corners = np.unique(environment.triangles[part == k], return_inverse=True)
        lines.append(f"o {name}")
        lines += ["v {!r} {!r} {!r}".format(*at) for at in environment.vertices[used].tolist()]
        faces = (corners.reshape(-1, 3) + count + 1).tolist()
        lines += ["f {} {} {}".format(*face) for face in faces]
        count += len(used)
    (folder / "parts.obj").write_text("\n".join(lines) + "\n")
    said = _loaded(source)
    said["meshes"] = [{"file": "parts.obj", "length": "m", "up": "z", "forward": "x"}]
    (folder / "environment.yaml").write_text(yaml.safe_dump(said, sort_keys=False))


def _obj(text: str, how: Same) -> str:
    """An OBJ file of objects in metres, moved; in another order where that is asked for."""
    objects: dict[str, list[list[int]]] = {}
    points = []
    name = ""
    for line in text.splitlines():
        words = line.split()
        if line.startswith("o "):
            name = words[1]
            objects[name] = []
        elif line.startswith("v "):
            points.append(how.place([float(word) for word in words[1:4]], 1.0))
        elif line.startswith("f "):
            objects[name].append([int(word.split("/")[0]) for word in words[1:]])
    lines = []
    number: dict[int, int] = {}
    for name in how.shuffled(objects):
        lines.append(f"o {name}")
        for face in objects[name]:
            for corner in face:
                if corner not in number:
                    number[corner] = len(number) + 1
                    x, y, z = points[corner - 1]
                    lines.append("v {!r} {!r} {!r}".format(*((y, z, x) if how.y_up else (x, y, z))))
        for face in objects[name]:
            turned = face[::-1] if how.mirrored else face
            lines.append("f " + " ".join(str(number[corner]) for corner in turned))
    return "\n".join(lines) + "\n"


def _in_unit(said, how):
    """A file's lengths in another unit."""
    factor = UNITS[how.unit] / UNITS[said["length"]]
    if factor == 1.0:
        return said
    return {**_scaled(said, factor, False), "length": how.unit}


def _scaled(value, factor, lengths):
    if isinstance(value, dict):
        if value.get("check") in ("stops", "share", "injury"):
            return value
        return {
            key: _scaled(one, factor, (lengths or key in LENGTHS) and not _plain(value, key))
            for key, one in value.items()
        }
    if isinstance(value, list):
        return [_scaled(one, factor, lengths) for one in value]
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return value * factor if lengths and number else value


def _plain(where, key):
    """Whether what stands under a key is an angle, a direction or a number without a unit."""
    turned = (key == "travel" and "about" in where) or isinstance(where.get("points"), int)
    angles = (
        "tilt",
        "axis",
        "yaw",
        "attitude",
        "direction",
        "face",
        "along",
        "back_angle",
        "cushion_angle",
    )
    return turned or key in (*angles, "down", "zone")


def answers(study: Path, how: Same) -> dict[tuple[str, ...], float]:
    """What a run of a study finds, by what it is about; the names of sides as before mirroring."""
    result = wb.run(wb.load_study(str(study)))
    found: dict[tuple[str, ...], float] = {}
    for verdict in result.verdicts:
        key = (verdict.criterion.name, verdict.motion, verdict.row)
        found["verdict", *key, "passed"] = float(verdict.passed)
        if verdict.worst is not None:
            found["verdict", *key, "margin"] = verdict.worst.margin
        if verdict.share is not None:
            found["verdict", *key, "share"] = verdict.share.rate
    for postures in result.postures:
        for person in postures.people:
            found["seat", person.name, "forward"] = person.forward
            stands = person.role.seat is None and how.mirrored
            found["seat", person.name, "up"] = -person.up if stands else person.up
            for case, row in zip(postures.cases, person.margin.tolist(), strict=True):
                for joint, margin in zip(person.body.joints, row, strict=True):
                    if math.isfinite(margin):
                        found["joint", person.name, case, how.side(joint)] = margin
        for reach in postures.reaches:
            limb = how.side(reach.limb)
            key = (reach.person, reach.case, reach.control, str(reach.zone), how.side(reach.hand))
            if reach.reached:  # of two that miss it by as much either may be told
                found["reach", *key, "by", limb] = 1.0
            found["reach", *key, "miss"] = reach.miss
            found["reach", *key, "overlap"] = reach.overlap
    tables = result.tables() if result.population is not None or result.motions else {}
    for table in ("people", "shares", "figures"):
        for column, values in tables.get(table, {}).items():
            about = re.sub(r"(?<=by the )(left|right)\b", lambda m: how.side(m[1]), column)
            if values.dtype.kind in "fiub":
                for row, value in enumerate(values.tolist()):
                    if not math.isnan(value):
                        found[table, about, str(row)] = float(value)
    return found


def differences(one, other, tolerance):
    """What two answers do not share, the largest difference first."""
    rows = []
    for key in one.keys() | other.keys():
        gap = abs(one.get(key, math.inf) - other.get(key, math.inf))
        if not gap <= tolerance:
            rows.append((gap, key, one.get(key), other.get(key)))
    return sorted(rows, key=lambda row: (-row[0], row[1]))
