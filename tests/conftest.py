"""The zoo: small named fixtures that all tests share."""

from __future__ import annotations

import os
import signal
import subprocess
from functools import cache
from pathlib import Path

os.environ.setdefault("NO_COLOR", "1")
os.environ.setdefault("WORKBENCH_CACHE", "off")

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

import workbench as wb
from workbench.files import environments, yaml_text
from workbench.files.meshes import reading
from workbench.files.meshes.assembly import build_environment
from workbench.files.meshes.parts import RawPart
from workbench.files.postures import load_postures, posture_path, posture_pose

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared" / "data"
"""Real inputs, which are too large for the repository or not ours to give away."""
REFERENCE = SHARED.parent / "reference"
"""Tables to compare with, which are no part of the repository either."""
FOLDERS = (".ci", "benchmarks", "bodies", "docs", "environments", "studies", "tests", "workbench")
"""Folders of the repository, for where it is no checkout and nobody knows what is tracked."""

settings.register_profile(
    "tests",
    deadline=None,
    derandomize=True,
    max_examples=int(os.environ.get("WORKBENCH_EXAMPLES", "25")),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
settings.load_profile("tests")

ONE_ARM = """
body: one_arm
length: mm
segments:
  BASE: {name: base, number: 1, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 50]]}
  UPPER:
    name: upper arm
    number: 2
    mass: 2
    directions: {front: +x, left: +y, top: +z}
    spheres: [[0, 0, 150, 40], [0, 0, 0, 40], [0, 0, -150, 40]]
  LOWER:
    name: lower arm
    number: 3
    mass: 1
    directions: {front: +x, left: +y, top: +z}
    twist_along: WRIST
    spheres: [[0, 0, 100, 30], [20, 0, 0, 30], [20, 0, -100, 30]]
  HAND:
    name: hand
    number: 4
    mass: 0.5
    directions: {back: -y, top: -z, left: +x}
    spheres: [[0, 0, 50, 30], [0, 0, -50, 20, fingertip, top], [30, 0, 0, 15, thumb tip]]
joints:
  SHOULDER:
    name: shoulder
    number: 1
    between: [BASE, UPPER]
    at: {BASE: [0, 0, 0], UPPER: [0, 0, 150]}
    stop: cone
    swing:
      - {motion: [flexion, extension], axis: -y, limits: [113, 20]}
      - {motion: [abduction, adduction], axis: -x, limits: [53, 31]}
    twist: {motion: [medial_rotation, lateral_rotation], axis: +z, limits: [39, 34]}
  ELBOW:
    name: elbow
    number: 2
    between: [UPPER, LOWER]
    at: {UPPER: [0, 0, -150], LOWER: [0, 0, 100]}
    stop: hinge
    play: 2
    swing:
      - {motion: [flexion, extension], axis: -y, limits: [142, 0]}
      - {motion: [abduction, adduction], axis: -x, limits: [0, 0]}
    twist: {motion: [medial_rotation, lateral_rotation], axis: +z, limits: [35, 43]}
    couplings:
      - {limit: medial_rotation, driver: ELBOW.flexion, from: [0, 90], to: [0, 35]}
  WRIST:
    name: wrist
    number: 3
    between: [LOWER, HAND]
    at: {LOWER: [0, 0, -100], HAND: [0, 0, 50]}
    stop: free
    swing:
      - {motion: [flexion, extension], axis: +x, limits: [90, 80]}
      - {motion: [radial_deviation, ulnar_deviation], axis: -y, limits: [27, 40]}
    twist: {motion: [pronation, supination], axis: +z, limits: [77, 113]}
allowances:
  - {between: [BASE, LOWER], depth: 5}
"""


CORE = {
    "test_accommodation_shares",
    "test_bad_bodies",
    "test_bad_studies",
    "test_blend",
    "test_camera",
    "test_collide",
    "test_compare",
    "test_crash_frames",
    "test_decimals",
    "test_doubt",
    "test_driving",
    "test_environments",
    "test_exports",
    "test_family",
    "test_forward",
    "test_golden",
    "test_house",
    "test_index_cache",
    "test_marks",
    "test_motions",
    "test_newton",
    "test_outline",
    "test_packaging",
    "test_people",
    "test_placed_laws",
    "test_polygons",
    "test_populations",
    "test_pulses",
    "test_reach",
    "test_readme",
    "test_report_pictures",
    "test_results",
    "test_scanline",
    "test_signals",
    "test_sizes",
    "test_stops",
    "test_study",
    "test_units",
    "test_yaml",
}
"""Modules of the core tier: fast ones that between them reach every room of the package."""
FIRST = (
    "test_catalogue",
    "test_sweep",
    "test_fast",
    "test_body_fit",
    "test_fast_cells",
    "test_hiding",
    "test_crash_restraints",
    "test_markers",
    "test_render",
    "test_seat_people",
    "test_arguments",
)
"""Modules that two workers begin with: they compile most. While one worker goes through the
catalogue, which compiles seats and reaches, the other compiles what the catalogue needs little of."""


def pytest_configure(config):
    """Make warnings errors in collection and in tests, but not while the plugins of others load.
    Keep the order of modules where workers share them. Let Ctrl-C work in children, also where a
    shell ignores it for what runs in the background."""
    config.addinivalue_line("filterwarnings", "error")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(config.option, "loadscopereorder"):  # there is pytest-xdist
        config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)  # before tests are deselected by their markers
def pytest_collection_modifyitems(items):
    """Mark the core tier, and put the modules that take longest first."""
    for item in items:
        if item.path.stem in CORE and item.get_closest_marker("nightly") is None:
            item.add_marker("core")
    ranks = {name: rank for rank, name in enumerate(FIRST)}
    items.sort(key=lambda item: ranks.get(item.path.stem, len(FIRST)))


LARGE_TEXT = 20_000
"""Characters from which on a text is parsed once, not in each test: the shipped bodies have more."""
LARGE_MESH = 1000
"""Faces from which on a mesh is built once."""


@pytest.fixture(scope="session", autouse=True)
def large_files_are_parsed_once():
    """Keep what large texts and meshes give, by content: hundreds of tests load the same few.

    Each step depends on its arguments alone, and nobody changes what it gives.
    """
    parse, build = cache(yaml_text.parse_yaml), environments.build_environment
    read_obj, memory = reading.FORMATS[".obj"]
    read, built = cache(read_obj), {}

    def parsed(text, file):
        return (parse if len(text) > LARGE_TEXT else parse.__wrapped__)(text, file)

    def was_read(path, data):
        return (read if len(data) > LARGE_TEXT else read_obj)(path, data)

    def was_built(name, parts, *, solid, notes=()):
        parts, solid, notes = tuple(parts), tuple(solid), tuple(notes)
        if sum(len(part.faces) for part in parts) <= LARGE_MESH:
            return build(name, parts, solid=solid, notes=notes)
        arrays = ((part.name, part.vertices.tobytes(), part.faces.tobytes()) for part in parts)
        key = hash((name, solid, notes, *arrays))
        if key not in built:
            built[key] = build(name, parts, solid=solid, notes=notes)
        environment, faults = built[key]
        return environment, list(faults)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(yaml_text, "parse_yaml", parsed)
        patch.setattr(environments, "build_environment", was_built)
        patch.setitem(reading.FORMATS, ".obj", (was_read, memory))
        yield


ABSENT = "real input absent"


def real_input(path: Path) -> Path:
    """The path of a real input; the test that asks is skipped where it is absent."""
    if not path.exists():
        pytest.skip(f"{ABSENT}: {path.name}")
    return path


def needs_real_input(path: Path) -> pytest.MarkDecorator:
    """Skip a test, or all tests of a module, where a real input is absent."""
    return pytest.mark.skipif(not path.exists(), reason=f"{ABSENT}: {path.name}")


def pytest_terminal_summary(terminalreporter):
    """Say how many tests were skipped because their real inputs are absent."""
    skipped = terminalreporter.stats.get("skipped", [])
    absent = [report for report in skipped if ABSENT in str(report.longrepr)]
    if absent:
        counted = "1 test was" if len(absent) == 1 else f"{len(absent)} tests were"
        terminalreporter.write_line(f"{counted} skipped: real inputs are absent from {SHARED}")


@cache
def repository_files(root: Path = ROOT) -> tuple[Path, ...]:
    """The files of the repository: those that git tracks, so that a stray folder in a checkout is
    nobody's concern."""
    try:
        done = subprocess.run(
            ["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=True
        )
        names = [name for name in done.stdout.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        names = []
    files = [root / name for name in names]
    if not files:
        files = [
            *root.glob("*"),
            *(path for folder in FOLDERS for path in (root / folder).rglob("*")),
        ]
    return tuple(
        sorted(path for path in files if path.is_file() and "__pycache__" not in path.parts)
    )


def tracked(*patterns: str) -> list[Path]:
    """The files of the repository that match a pattern from its root ("studies/*.yaml")."""
    known = set(repository_files())
    return sorted({path for pattern in patterns for path in ROOT.glob(pattern)} & known)


@pytest.fixture(scope="session")
def one_arm(tmp_path_factory):
    """A base, two arm segments and a hand; 700 mm of arm hanging down; hand-checkable numbers."""
    path = tmp_path_factory.mktemp("zoo") / "one_arm.yaml"
    path.write_text(ONE_ARM)
    return wb.load_body(path)


@pytest.fixture(scope="session")
def two_spheres(tmp_path_factory):
    """Two spheres of 10 mm that share no joint: middle and end of a chain of three, 100 mm
    apart."""
    text = """
body: two_spheres
length: mm
segments:
  A: {name: first, number: 1, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 10, ball]]}
  M:
    {name: rod, number: 2, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 1], [100, 0, 0, 1]]}
  B: {name: second, number: 3, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 10]]}
joints:
  J: &joint
    name: one
    number: 1
    between: [A, M]
    at: {A: [0, 0, 0], M: [0, 0, 0]}
    stop: free
    swing:
      - {motion: [flexion, extension], axis: +y, limits: [180, 180]}
      - {motion: [bend_left, bend_right], axis: -x, limits: [180, 180]}
    twist: {motion: [turn_left, turn_right], axis: +z, limits: [180, 180]}
  K:
    name: two
    number: 2
    between: [M, B]
    at: {M: [100, 0, 0], B: [0, 0, 0]}
    stop: free
    swing:
      - {motion: [flexion, extension], axis: +y, limits: [180, 180]}
      - {motion: [bend_left, bend_right], axis: -x, limits: [180, 180]}
    twist: {motion: [turn_left, turn_right], axis: +z, limits: [180, 180]}
"""
    path = tmp_path_factory.mktemp("zoo") / "two_spheres.yaml"
    path.write_text(text.replace("&joint", ""))
    return wb.load_body(path)


@pytest.fixture(scope="session")
def bubbleman():
    return wb.load_body("bubbleman")


@pytest.fixture(scope="session")
def postures(bubbleman):
    """The posture library for bubbleman, checked."""
    return load_postures(posture_path("bubbleman"), bubbleman)[0]


@pytest.fixture(scope="session")
def library(bubbleman, postures):
    """Bubbleman in all named postures, placed; and their names."""
    poses = wb.join_poses([posture_pose(bubbleman, postures, name) for name in postures.postures])
    return wb.place(bubbleman, poses), list(postures.postures)


BOX = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
BOX_FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip


def box_part(name, low, high):
    return RawPart(name, np.asarray(low) + BOX * (np.asarray(high, dtype=float) - low), BOX_FACES)


def environment_of(*parts, solid="auto"):
    """An environment of raw parts."""
    made, faults = build_environment("made", parts, solid=[solid] * len(parts))
    assert not faults
    return made


@pytest.fixture(scope="session")
def unit_box():
    """One solid cube of 1 m at the origin."""
    return environment_of(box_part("box", [0, 0, 0], [1, 1, 1]))


@pytest.fixture(scope="session")
def box_cab():
    """Floor, wall and post: three solid boxes around the one arm."""
    return environment_of(
        box_part("floor", [-1, -1, -0.9], [1, 1, -0.8]),
        box_part("wall", [0.4, -1, -0.8], [0.45, 1, 0.5]),
        box_part("post", [-0.2, 0.15, -0.8], [-0.1, 0.25, 0.5]),
    )


@pytest.fixture
def random_arm(one_arm):
    """Make P random poses of the one arm."""

    def make(count, seed=0, spread=1.0):
        rng = np.random.default_rng(seed)
        q = rng.normal(size=(count, 3, 4))
        q[..., 0] += 1 / max(spread, 1e-9)
        q /= np.linalg.norm(q, axis=-1, keepdims=True)
        world = np.zeros((count, 3, 4))
        world[:, :, :3] = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
        world[:, 0, :3] *= np.sign(np.linalg.det(world[:, :, :3]))[:, None]
        world[:, :, 3] = rng.normal(size=(count, 3)) * 0.3
        return wb.Poses(q, 0, world)

    return make


@pytest.fixture(scope="session")
def trainer():
    """The shipped study of two people in the trainer, open at the bench."""
    from workbench.study.bench.state import open_study

    return open_study(wb.load_study("trainer_clearance"))


@pytest.fixture(scope="session")
def placement(trainer):
    """The people of that study where they are as it is opened."""
    from workbench.study.bench.placing import placed_people

    return placed_people(trainer, trainer.start)
