"""The architecture's rules, read from the code's own imports and texts."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MANIFESTS = [*ROOT.glob("*/pyproject.toml"), *ROOT.glob("services/*/pyproject.toml")]
PROJECTS = {path.parent.name: path.parent for path in sorted(MANIFESTS)}
SERVICES = ("nlu", "perception", "mapper", "dialogue", "viewer")
PROVIDES = {
    "eclipse-zenoh": "zenoh",
    "opencv-python-headless": "cv2",
    "rerun-sdk": "rerun",
    "pillow": "PIL",
}
CORE_FORBIDDEN = {
    "time",
    "datetime",
    "zenoh",
    "threading",
    "asyncio",
    "socket",
    "random",
    "secrets",
}
MAX_FILE_LINES = 320


def sources(project: str) -> Iterator[Path]:
    yield from sorted(PROJECTS[project].glob("doro_*/**/*.py"))


def imports(path: Path) -> set[str]:
    """Return the top-level names that a file imports, whether at its top or inside."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module.split(".")[0])
    return names


def declared(project: str) -> set[str]:
    """Return the import names that a project's pyproject declares, extras included."""
    table = tomllib.loads((PROJECTS[project] / "pyproject.toml").read_text(encoding="utf-8"))
    extras = table["project"].get("optional-dependencies", {})
    requirements = [
        *table["project"]["dependencies"],
        *(one for part in extras.values() for one in part),
    ]
    names = [re.split(r"[\[<>=!~; ]", requirement)[0] for requirement in requirements]
    provided = {PROVIDES.get(name, name.replace("-", "_")) for name in names}
    # msgspec is part of the wire package's interface: every message is a msgspec Struct.
    return provided | ({"msgspec"} if "doro_schemas" in provided else set())


def test_all_projects_are_found() -> None:
    assert {"schemas", "sim-feeder", "console", *SERVICES} <= set(PROJECTS)


@pytest.mark.parametrize("project", sorted(PROJECTS))
def test_imports_are_within_declared_dependencies(project: str) -> None:
    own = {path.name for path in PROJECTS[project].glob("doro_*")}
    allowed = declared(project) | own | set(sys.stdlib_module_names)
    wrong = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in sources(project)
        for name in imports(path) - allowed
    }
    assert not wrong


@pytest.mark.parametrize("service", SERVICES)
def test_services_do_not_import_each_other(service: str) -> None:
    allowed = {f"doro_{service}", "doro_schemas"}
    for path in sources(service):
        assert {name for name in imports(path) if name.startswith("doro_")} <= allowed, path


def test_only_the_bus_imports_zenoh() -> None:
    users = {
        path.relative_to(ROOT).as_posix()
        for project in PROJECTS
        for path in sources(project)
        if "zenoh" in imports(path)
    }
    assert users
    assert all(user.startswith("schemas/doro_schemas/bus/") for user in users)


def test_no_key_literal_outside_the_topic_table() -> None:
    table = ROOT / "schemas" / "doro_schemas" / "topics.py"
    for project in PROJECTS:
        for path in sources(project):
            if path == table:
                continue
            for node in ast.walk(_without_docstrings(path)):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    assert not re.search(r"\bdoro/", node.value), f"{path}:{node.lineno}"


@pytest.mark.parametrize("service", ["nlu", "perception", "mapper", "dialogue"])
def test_cores_read_no_clock_and_know_no_bus(service: str) -> None:
    shell = {"service.py", "__main__.py"}
    for path in sources(service):
        if path.name in shell or "train" in path.parts:
            continue
        assert not imports(path) & CORE_FORBIDDEN, path
        text = path.read_text(encoding="utf-8")
        assert "doro_schemas.bus" not in text, path
        assert "doro_schemas.runner" not in text, path


@pytest.mark.parametrize("project", sorted(PROJECTS))
def test_files_stay_small(project: str) -> None:
    long = {
        path.relative_to(ROOT).as_posix(): count
        for path in sources(project)
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > MAX_FILE_LINES
    }
    assert not long


def test_the_lock_names_no_host() -> None:
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert "://" not in text
    assert "file:" not in text
    assert "--hash=sha256:" in text


@pytest.mark.parametrize("project", sorted(PROJECTS))
def test_every_project_has_a_readme(project: str) -> None:
    text = (PROJECTS[project] / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) > 15


def _without_docstrings(path: Path) -> ast.Module:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [  # type: ignore[attr-defined]
                item
                for item in body
                if not (isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant))
            ] or [ast.Pass()]
    return tree
