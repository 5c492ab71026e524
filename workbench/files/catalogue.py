"""Where bodies, environments and studies are found by name.

A name with a slash or an ending is a path, first from the folder of the file that names it, then
from the current folder. A bare name is looked for beside the naming file's catalogue, in the
current folder, and in what came with the workbench.
"""

from __future__ import annotations

from pathlib import Path

from workbench.errors import InputError, one_of
from workbench.files.names import spelled
from workbench.files.yaml_text import Document

__all__ = ["find", "find_beside", "is_file", "is_folder", "is_there", "names", "roots"]


def roots() -> list[Path]:
    """Folders that may hold `bodies/`, `environments/`, `studies/`: the current one, then what is
    installed."""
    package = Path(__file__).resolve().parents[1]
    return [Path.cwd(), package / "data", package.parent]


def find(kind: str, name: str, inner: str = "", *, near: Path | None = None) -> Path:
    """Find the file of a catalogue entry.

    Parameters
    ----------
    kind
        "bodies", "environments" or "studies".
    name
        The name of the entry, or the path of a file; of a folder that lies where the program runs, or
        beside the file that names it, the name alone will do.
    inner
        The file inside an entry's folder ("environment.yaml"), or "" where entries are single files
        NAME.yaml.
    near
        The folder of the file that names it.

    Raises
    ------
    InputError
        With what there is.
    """
    if "/" in name or "\\" in name or name.endswith((".yaml", ".yml")) or name in (".", ".."):
        return _at_path(name, inner, near)
    for root in ([near.parent] if near else []) + roots():
        entry = root / kind / spelled(root / kind, name if inner else f"{name}.yaml")
        path = entry / inner if inner else entry
        if is_file(path):
            return path
    beside = (near or Path()) / name / inner
    if inner and is_file(beside):
        return beside
    raise InputError(
        f"no {kind} entry named {name!r}; {one_of(name, names(kind, inner, near=near))}"
    )


def _at_path(name: str, inner: str, near: Path | None) -> Path:
    """The file at a path that begins in a folder or where the program runs; the one inside it where
    the path is that of an entry's folder."""
    folders = ([near] if near else []) + [Path.cwd()]
    for folder in folders:
        path = folder / spelled(folder, name)
        for candidate in (path, path / inner) if inner else (path,):
            # what is no regular file is refused as such by who reads it
            if is_there(candidate) and not is_folder(candidate):
                return candidate
    looked = ", ".join(str(folder) for folder in dict.fromkeys(folders))
    raise InputError(f"{name}: no such file (looked from {looked})")


def find_beside(document: Document, key: tuple[str | int, ...], name: str) -> Path:
    """A file that a body file names: beside it, or in the catalogue of bodies. InputError where it
    is in neither."""
    here = Path(document.file).parent
    for folder in (here, *(root / "bodies" for root in roots())):
        path = folder / spelled(folder, name)
        if is_file(path):
            return path
    raise InputError(
        f"{document.where(key)}: {key[-1]}: no such file {name!r} in {here} or among the bodies"
    )


def is_file(path: Path) -> bool:
    """True for a file; False too where the name cannot be one (too long) or its folder may not be
    entered."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_folder(path: Path) -> bool:
    """True for a folder; False too where the name cannot be one."""
    try:
        return path.is_dir()
    except OSError:
        return False


def is_there(path: Path) -> bool:
    """True for a file or folder; False too where the name cannot be one."""
    try:
        return path.exists()
    except OSError:
        return False


def names(kind: str, inner: str = "", *, near: Path | None = None) -> list[str]:
    """The bare names that `find` knows from here, or from a file in the folder `near`, sorted."""
    found: set[str] = set()
    for root in ([near.parent] if near else []) + roots():
        pattern = f"{kind}/*/{inner}" if inner else f"{kind}/*.yaml"
        files = [p for p in root.glob(pattern) if inner or (is_file(p) and _is_entry(kind, p))]
        found |= {p.parent.name if inner else p.stem for p in files}
    return sorted(found)


def _is_entry(kind: str, path: Path) -> bool:
    """True where a YAML file beside others is an entry by itself and not something that entries
    refer to."""
    key = {"bodies": "body:", "studies": "study:"}.get(kind)
    text = path.read_text(encoding="utf-8", errors="replace")
    return key is None or any(line.startswith(key) for line in text.splitlines())
