"""The structure holds: imports point one way, heavy packages load late, every file says what it is."""

from __future__ import annotations

import ast
import functools
import subprocess
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src" / "limner"
FILES = sorted(SRC.rglob("*.py"))

# What each part may import, beside itself. `base` is the ground that everybody stands on.
BASE = {"errors", "settings", "types", "stages", "storage", "units", "geometry", "bezier", "transforms"}
ALLOWED = {
    "errors": set(),
    "settings": {"errors"},
    "types": {"errors"},
    "stages": {"types"},
    "storage": {"errors", "types"},
    "units": {"errors", "types"},
    "geometry": {"types"},
    "bezier": {"types", "geometry"},
    "transforms": {"types"},
    "vision": BASE,
    "drawing": BASE,
    "motion": BASE,
    "targets": BASE,
    "simulation": BASE | {"motion", "targets"},
    "pipeline": BASE | {"vision", "drawing", "motion", "targets", "simulation"},
    "ros": BASE | {"vision", "motion", "pipeline", "targets"},
    "batch": BASE | {"vision", "drawing", "motion", "pipeline", "targets"},
    "evaluate": BASE | {"vision", "drawing", "motion", "simulation", "pipeline", "targets"},
    "studio": BASE | {"vision", "drawing", "motion", "pipeline", "targets"},
    "cli": BASE | {"vision", "motion", "simulation", "pipeline", "targets", "batch", "evaluate", "ros", "studio"},
    "__init__": BASE | {"vision", "drawing", "motion", "pipeline", "targets"},
    "__main__": {"cli"},
    "vpype_plugin": BASE | {"pipeline"},
}
# Packages that cost time or are optional: the only places that may name them.
HEAVY = {
    "cv2": {"vision", "targets", "evaluate", "simulation", "studio/worker.py", "batch/threads.py"},
    "PIL": {"vision/photo", "targets", "simulation"},
    "scipy": {"vision/landmarks/fmp"},
    "svgelements": {"targets/svg_read.py", "targets/flatten.py"},
    "tomli_w": {"settings.py"},
    "threadpoolctl": {"vision/landmarks/fmp/threads.py", "batch/threads.py"},
    "rich": {"cli"},
    "click": {"cli", "vpype_plugin.py"},
    "vpype": {"vpype_plugin.py"},
    "vpype_cli": {"vpype_plugin.py"},
    "serial": {"targets/serial_link.py"},
    "skimage": {"vision/landmarks/fmp/scenes.py"},
    "pillow_heif": {"vision/photo/decode.py"},
    "urdf_parser_py": {"motion/arm/urdf_file.py"},
    "pinocchio": {"motion/arm/numeric_ik.py"},
    "mujoco": {"simulation/physics.py"},
    "dask": {"batch/cluster.py"},
    "distributed": {"batch/cluster.py"},
    "fsspec": {"batch/remote.py"},
    "pyarrow": {"batch/manifest.py"},
    "toppra": {"motion/arm/retime.py"},
    "starlette": {"studio"},
    "uvicorn": {"studio/serve.py"},
    "rosbags": {"targets/bag.py"},
    "websockets": {"targets/bridge.py", "targets/fake_rosbridge.py", "evaluate/studio.py"},
    "rospy": {"ros/middleware.py"},
    "rosgraph": {"ros/middleware.py"},
    "actionlib": {"ros/middleware.py"},
    "actionlib_msgs": {"ros/middleware.py"},
    "genpy": {"ros/middleware.py"},
    "geometry_msgs": {"ros/middleware.py"},
    "nav_msgs": {"ros/middleware.py"},
    "sensor_msgs": {"ros/middleware.py"},
    "std_msgs": {"ros/middleware.py"},
    "std_srvs": {"ros/middleware.py"},
    "tf2_ros": {"ros/middleware.py"},
    "trajectory_msgs": {"ros/middleware.py"},
    "visualization_msgs": {"ros/middleware.py"},
}
# Of those the ones that an extra installs or that are slow to load: a file that names one can be imported without it.
LATE = {
    *("scipy", "pillow_heif", "skimage", "svgelements", "serial", "dask", "distributed", "fsspec", "pyarrow"),
    *("rosbags", "rospy", "websockets", "uvicorn", "mujoco", "pinocchio", "toppra", "urdf_parser_py"),
}


@functools.cache
def imported(path):
    """Full names of the modules a file imports, with whether the import runs when the file is imported."""
    return list(_imported(path))


def _imported(path):
    tree = ast.parse(path.read_text())
    late = {id(n) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef | ast.AsyncFunctionDef) for n in ast.walk(f)}
    typing_only = {
        id(n)
        for i in ast.walk(tree)
        if isinstance(i, ast.If) and "TYPE_CHECKING" in ast.dump(i.test)
        for n in ast.walk(i)
    }
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            yield name, id(node) not in late and id(node) not in typing_only


def part(path):
    return path.relative_to(SRC).parts[0].removesuffix(".py")


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SRC)))
def test_imports_point_one_way(path):
    here = part(path)
    for name, _ in imported(path):
        if name.split(".")[0] != "limner":
            continue
        there = [*name.split("."), "__init__"][1]
        if not (SRC / there).exists() and not (SRC / f"{there}.py").exists():
            there = "__init__"  # `from limner import __version__`
        if there == "__init__":
            assert name.endswith("__version__"), f"{path.name} imports the package itself: {name}"
            continue
        assert there == here or there in ALLOWED[here], f"{path.relative_to(SRC)} may not import {name}"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SRC)))
def test_heavy_packages_stay_in_their_place(path):
    where = str(path.relative_to(SRC))
    for name, at_import in imported(path):
        package = name.split(".")[0]
        if package in HEAVY:
            assert any(
                where.removesuffix(".py") == place.removesuffix(".py") or where.startswith(place + "/")
                for place in HEAVY[package]
            ), f"{where} may not import {package}"
        if package in LATE:
            assert not at_import, f"{where} must import {package} inside the function that needs it"


def test_the_tables_allow_no_more_than_is_done():
    done = {
        (part(path), name.split(".")[1]) for path in FILES for name, _ in imported(path) if name.startswith("limner.")
    }
    assert {here: {there for there in ALLOWED[here] - BASE if (here, there) not in done} for here in ALLOWED} == {
        here: set() for here in ALLOWED
    }
    named = {(name.split(".")[0], str(path.relative_to(SRC))) for path in FILES for name, _ in imported(path)}
    for package, places in HEAVY.items():
        for place in places:
            assert any(who == package and (where == place or where.startswith(place + "/")) for who, where in named)


def test_every_package_that_is_used_has_its_place():
    used = {name.split(".")[0] for path in FILES for name, _ in imported(path)} - set(sys.stdlib_module_names)
    assert used == {"limner", "numpy", *HEAVY}


def test_no_import_cycles():
    graph = {}
    for path in FILES:
        module = "limner." + ".".join(path.relative_to(SRC).with_suffix("").parts)
        graph[module.removesuffix(".__init__")] = {
            name for name, at_import in imported(path) if name.startswith("limner") and at_import
        }
    known = set(graph)
    edges = {
        a: {(n if n in known else n.rpartition(".")[0]) for n in names} & known - {a} for a, names in graph.items()
    }
    done, path = set(), []

    def visit(node):
        assert node not in path, f"import cycle: {' -> '.join([*path, node])}"
        if node in done:
            return
        path.append(node)
        for other in sorted(edges[node]):
            visit(other)
        path.pop()
        done.add(node)

    for node in sorted(edges):
        visit(node)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SRC)))
def test_each_file_opens_with_a_sentence(path):
    doc = ast.get_docstring(ast.parse(path.read_text()))
    assert doc, f"{path.relative_to(SRC)} has no opening sentence"
    assert doc.splitlines()[0].endswith((".", ":")), f"{path.relative_to(SRC)}: {doc.splitlines()[0]}"


def loaded_after(code):
    program = f"{code}\nimport sys; print(*sorted({{m.split('.')[0] for m in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_import_limner_is_light():
    assert not {"numpy", "cv2", "PIL", "rich", "scipy"} & loaded_after("import limner")


def test_the_command_line_is_light():
    assert not {"numpy", "cv2", "PIL", "scipy", "svgelements"} & loaded_after("import limner.cli")
