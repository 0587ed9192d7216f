"""Finding and loading scenarios: a Python script that defines `simulation`, or a result, which carries its own."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from mol_compactons.configuration import did_you_mean
from mol_compactons.errors import InputError, require
from mol_compactons.results.form import reading
from mol_compactons.results.opening import open_result
from mol_compactons.simulation import Simulation

SCRIPT_MARK = "__scenario_script__"
"""What marks the module of a script that was run here, which another script of the same name may replace."""

_PATH_LOCK = threading.RLock()


def folder() -> Path:
    """Where the scenarios that come with the package are."""
    package = Path(__file__).parent.parent
    installed = package / "scenario_scripts"
    return installed if installed.is_dir() else package.parent / "scenarios"


def listing() -> dict[str, str]:
    """The scenarios that come with the package: name and first line of the docstring."""
    lines = {}
    for path in sorted(folder().glob("*.py")):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        lines[path.stem] = docstring.splitlines()[0] if docstring else ""
    return lines


def load(target: str) -> Simulation:
    """The simulation of a scenario script, of a scenario of the package by its name, or of a result.

    Parameters
    ----------
    target : str
        ``scenarios/two_bright.py``, ``two_bright`` or ``two_bright.nc``.

    Raises
    ------
    InputError
        If there is no such file, or it does not define a simulation.
    """
    path = Path(target)
    if path.suffix.lower() == ".nc":
        return from_result(path)
    if not path.is_file() and len(path.parts) == 1:
        path = folder() / f"{path.stem}.py"
    if not path.is_file():
        raise InputError(f"There is no scenario {target!r}; {did_you_mean(Path(target).stem, list(listing()))}")
    require(path.suffix == ".py", f"{path} is neither a script (.py) nor a result (.nc); give one of these.")
    simulation = getattr(run_as_module(path, path.stem), "simulation", None)
    if not isinstance(simulation, Simulation):
        raise InputError(f"{path} does not define a Simulation under the name 'simulation'; add one.")
    return simulation


def from_result(path: Path) -> Simulation:
    """The simulation that a result file carries."""
    with reading(path), open_result(path) as dataset:
        return Simulation.from_json(str(dataset.attrs["simulation"]))


def import_module(name: str) -> None:
    """Import a module of the user's own by its name, or a file by its path, so that its classes can be named.

    Parameters
    ----------
    name : str
        ``mine``, ``package.mine`` or ``folder/mine.py``; a module is looked for in the working folder too.

    Raises
    ------
    InputError
        If there is no such module, or it cannot be run.
    """
    if name.endswith(".py"):
        path = Path(name)
        require(path.is_file(), f"There is no file {name}; give the path of one, or the name of a module.")
        if not _is_loaded_from(path, path.stem):
            run_as_module(path, path.stem)
        return
    try:
        with _looking_in(Path.cwd()):
            importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name and name.startswith(error.name):
            raise InputError(
                f"There is no module {name!r}; give the name of one that Python finds, or the path of a file."
            ) from None
        raise InputError(f"The module {name} could not be imported ({error}); correct it.") from error
    except (Exception, SystemExit) as error:
        raise InputError(f"The module {name} could not be imported ({type(error).__name__}: {error}); correct it.") from error


def _is_loaded_from(path: Path, name: str) -> bool:
    file = getattr(sys.modules.get(name), "__file__", None)
    return file is not None and Path(file).resolve() == path.resolve()


def run_as_module(path: Path, name: str) -> ModuleType:
    """Run a script as the module of its name, so that the classes that it defines are found again by that name.

    Raises
    ------
    InputError
        If another module of that name is loaded, or the script fails.
    """
    before = sys.modules.get(name)
    require(
        before is None or _is_loaded_from(path, name) or getattr(before, SCRIPT_MARK, False),
        f"{path} cannot be run: another module of the name {name} is loaded; rename the file.",
    )
    specification = importlib.util.spec_from_file_location(name, path.resolve())
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    setattr(module, SCRIPT_MARK, True)
    sys.modules[name] = module
    try:
        with _looking_in(path.resolve().parent):
            specification.loader.exec_module(module)
    except BaseException as error:
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before
        if isinstance(error, InputError) or not isinstance(error, Exception | SystemExit):
            raise
        raise InputError(f"{path} could not be run ({type(error).__name__}: {error}); correct the script.") from error
    return module


@contextmanager
def _looking_in(folder: Path) -> Iterator[None]:
    """Modules are looked for in a folder too while inside, as where Python runs a script that stands there."""
    with _PATH_LOCK:
        sys.path.insert(0, str(folder))
        try:
            yield
        finally:
            sys.path.remove(str(folder))
