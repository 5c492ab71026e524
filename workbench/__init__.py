"""Human factors with sphere bodies: pose a body, put it into a cockpit, ask what it touches.

    import workbench as wb
    study = wb.load_study("trainer_clearance")
    result = wb.run(study)

Every public name is loaded where it is first used, so that `import workbench` costs no more than
NumPy. Public functions check their arguments (see workbench.model.arguments): a wrong one is a
UsageError that names it.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing, which takes some milliseconds to import
if TYPE_CHECKING:
    from typing import Any

    from workbench.draw.sources import scene_of as scene_of
    from workbench.draw.window import to_pyvista as to_pyvista
    from workbench.errors import InputError as InputError
    from workbench.errors import MissingPartError as MissingPartError
    from workbench.errors import UsageError as UsageError
    from workbench.errors import WorkbenchError as WorkbenchError
    from workbench.files.ansur import read_ansur as read_ansur
    from workbench.files.body.bodies import load_body as load_body
    from workbench.files.environments import environment_from_mesh as environment_from_mesh
    from workbench.files.environments import load_environment as load_environment
    from workbench.files.populations import load_population_model as load_population_model
    from workbench.files.study.reader import load_study as load_study
    from workbench.model.body import Body as Body
    from workbench.model.comparison import Comparison as Comparison
    from workbench.model.contacts import Clearance as Clearance
    from workbench.model.contacts import Contacts as Contacts
    from workbench.model.contacts import relation as relation
    from workbench.model.driving import Driver as Driver
    from workbench.model.driving import Package as Package
    from workbench.model.environment import Environment as Environment
    from workbench.model.episodes import Episodes as Episodes
    from workbench.model.moving import between as between
    from workbench.model.poses import Placed as Placed
    from workbench.model.poses import Poses as Poses
    from workbench.model.posing import join_poses as join_poses
    from workbench.model.posing import pose as pose
    from workbench.model.reach import Reach as Reach
    from workbench.model.result import Result as Result
    from workbench.model.study import Study as Study
    from workbench.people.boundary import boundary_cases as boundary_cases
    from workbench.people.draw import draw_people as draw_people
    from workbench.shape.fitting.decompose import decompose as decompose
    from workbench.shape.fitting.segmenting import Bones as Bones
    from workbench.shape.fitting.segmenting import fit_segments as fit_segments
    from workbench.shape.scaling.measure import measure as measure
    from workbench.shape.scaling.scale import scale as scale
    from workbench.shape.surface import sealed as sealed
    from workbench.solve.contact.collide import body_clearance as body_clearance
    from workbench.solve.contact.collide import body_contacts as body_contacts
    from workbench.solve.contact.collide import clearance as clearance
    from workbench.solve.contact.collide import collides as collides
    from workbench.solve.contact.collide import contacts as contacts
    from workbench.solve.contact.collide import self_contacts as self_contacts
    from workbench.solve.contact.episodes import body_episodes as body_episodes
    from workbench.solve.contact.episodes import episodes as episodes
    from workbench.solve.contact.episodes import self_episodes as self_episodes
    from workbench.solve.contact.sweep import body_sweep as body_sweep
    from workbench.solve.contact.sweep import self_sweep as self_sweep
    from workbench.solve.contact.sweep import sweep as sweep
    from workbench.solve.forward import place as place
    from workbench.solve.forward import rereference as rereference
    from workbench.solve.forward import update as update
    from workbench.solve.reaching.limbs import limb as limb
    from workbench.solve.reaching.reach import reach as reach
    from workbench.solve.reaching.reach_people import reach_people as reach_people
    from workbench.solve.seating.driving import driving_posture as driving_posture
    from workbench.solve.seating.driving_angles import driving_angles as driving_angles
    from workbench.solve.seating.packaging import eyellipse as eyellipse
    from workbench.solve.seating.packaging import seat_curve as seat_curve
    from workbench.solve.seating.seat_people import seat_people as seat_people
    from workbench.solve.stops import stops as stops
    from workbench.study.accommodation.compare import compare as compare
    from workbench.study.envelope.envelope import reach_envelope as reach_envelope
    from workbench.study.envelope.people import people_envelope as people_envelope
    from workbench.study.persons import person_body as person_body
    from workbench.study.reach_map import reach_map as reach_map
    from workbench.study.run import run as run

__version__ = "0.1.0"

_HOME: dict[str, str] = {
    "scene_of": "draw.sources",
    "to_pyvista": "draw.window",
    "InputError": "errors",
    "MissingPartError": "errors",
    "UsageError": "errors",
    "WorkbenchError": "errors",
    "load_body": "files.body.bodies",
    "environment_from_mesh": "files.environments",
    "load_environment": "files.environments",
    "load_study": "files.study.reader",
    "Body": "model.body",
    "Clearance": "model.contacts",
    "Contacts": "model.contacts",
    "relation": "model.contacts",
    "Driver": "model.driving",
    "Package": "model.driving",
    "driving_angles": "solve.seating.driving_angles",
    "driving_posture": "solve.seating.driving",
    "eyellipse": "solve.seating.packaging",
    "seat_curve": "solve.seating.packaging",
    "Environment": "model.environment",
    "Episodes": "model.episodes",
    "between": "model.moving",
    "Placed": "model.poses",
    "Poses": "model.poses",
    "join_poses": "model.posing",
    "pose": "model.posing",
    "Result": "model.result",
    "Study": "model.study",
    "body_clearance": "solve.contact.collide",
    "body_contacts": "solve.contact.collide",
    "clearance": "solve.contact.collide",
    "collides": "solve.contact.collide",
    "contacts": "solve.contact.collide",
    "self_contacts": "solve.contact.collide",
    "body_episodes": "solve.contact.episodes",
    "episodes": "solve.contact.episodes",
    "self_episodes": "solve.contact.episodes",
    "body_sweep": "solve.contact.sweep",
    "self_sweep": "solve.contact.sweep",
    "sweep": "solve.contact.sweep",
    "place": "solve.forward",
    "rereference": "solve.forward",
    "update": "solve.forward",
    "limb": "solve.reaching.limbs",
    "reach": "solve.reaching.reach",
    "reach_people": "solve.reaching.reach_people",
    "seat_people": "solve.seating.seat_people",
    "Reach": "model.reach",
    "stops": "solve.stops",
    "reach_map": "study.reach_map",
    "run": "study.run",
    "compare": "study.accommodation.compare",
    "people_envelope": "study.envelope.people",
    "reach_envelope": "study.envelope.envelope",
    "Comparison": "model.comparison",
    "person_body": "study.persons",
    "scale": "shape.scaling.scale",
    "Bones": "shape.fitting.segmenting",
    "decompose": "shape.fitting.decompose",
    "fit_segments": "shape.fitting.segmenting",
    "sealed": "shape.surface",
    "measure": "shape.scaling.measure",
    "boundary_cases": "people.boundary",
    "draw_people": "people.draw",
    "read_ansur": "files.ansur",
    "load_population_model": "files.populations",
}

__all__ = [
    "Body",
    "Bones",
    "Clearance",
    "Comparison",
    "Contacts",
    "Driver",
    "Environment",
    "Episodes",
    "InputError",
    "MissingPartError",
    "Package",
    "Placed",
    "Poses",
    "Reach",
    "Result",
    "Study",
    "UsageError",
    "WorkbenchError",
    "__version__",
    "between",
    "body_clearance",
    "body_contacts",
    "body_episodes",
    "body_sweep",
    "boundary_cases",
    "clearance",
    "collides",
    "compare",
    "contacts",
    "decompose",
    "draw_people",
    "driving_angles",
    "driving_posture",
    "environment_from_mesh",
    "episodes",
    "eyellipse",
    "fit_segments",
    "join_poses",
    "limb",
    "load_body",
    "load_environment",
    "load_population_model",
    "load_study",
    "measure",
    "people_envelope",
    "person_body",
    "place",
    "pose",
    "reach",
    "reach_envelope",
    "reach_map",
    "reach_people",
    "read_ansur",
    "relation",
    "rereference",
    "run",
    "scale",
    "scene_of",
    "sealed",
    "seat_curve",
    "seat_people",
    "self_contacts",
    "self_episodes",
    "self_sweep",
    "stops",
    "sweep",
    "to_pyvista",
    "update",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        from importlib import import_module

        found = getattr(import_module(f"workbench.{_HOME[name]}"), name)
        if callable(found) and not isinstance(found, type):
            found = import_module("workbench.model.arguments").checked(found)
            found.__module__ = __name__  # where pickle finds it
        globals()[name] = found
        return found
    raise AttributeError(f"module 'workbench' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
