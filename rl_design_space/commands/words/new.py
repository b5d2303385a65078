"""Write starter files of your own component or study, with a test that passes."""

from __future__ import annotations

import keyword
import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from rl_design_space._paths import CONF
from rl_design_space.commands.arguments import Parser
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

_TEMPLATES = Path(__file__).parent / "templates"
#: Config groups for which there are templates.
KINDS = tuple(sorted(path.name.partition(".")[0] for path in _TEMPLATES.glob("*.yaml.jinja")))
#: Config groups of kinds that are not named like them.
_GROUPS = {"actions": "msa"}
#: The config folder if none is given.
_DEFAULT_FOLDER = "conf"


def main(arguments: Sequence[str]) -> None:
    """Write starter files, and print the next commands.

    Raises:
        ConfigError: the kind does not exist, the name cannot be used, or a file exists.
    """
    parser = Parser(
        prog="rl-design-space new",
        description="Write a module, an option and a test as the start of your own component; see docs/components.md.",
        epilog=f"KIND is one of {', '.join(KINDS)}. {user_config.FLAG} DIR is the config folder ({_DEFAULT_FOLDER}).",
    )
    parser.add_argument("kind", metavar="KIND", help="kind of component, e.g. representation")
    parser.add_argument("name", metavar="NAME", help="name of the option and its module, e.g. rings")
    parsed = parser.parse_args(arguments)
    folder = user_config.user_folder() or Path.cwd() / _DEFAULT_FOLDER
    for path in write_starter(parsed.kind, parsed.name, folder):
        print(f"wrote {user_config.shown(path)}")
    print("next:")
    for command in _commands(parsed.kind, parsed.name, folder):
        print(f"  {command}")


def write_starter(kind: str, name: str, folder: Path) -> list[Path]:
    """Write the starter files of a component or a study.

    Args:
        kind: one of `KINDS`.
        name: name of the option, the module and the test.
        folder: config folder; module and test are written next to it.

    Returns:
        The paths of the files.

    Raises:
        ConfigError: the kind does not exist, the name cannot be used, or a file exists.
    """
    if kind not in KINDS:
        raise ConfigError.unknown("kind", kind, KINDS)
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise ConfigError.at("NAME", name, "should be the name of a Python module in lower case, e.g. rings")
    group = _GROUPS.get(kind, kind)
    if (CONF / group / f"{name}.yaml").is_file():
        raise ConfigError.at(
            "NAME", name, f"a shipped {group} has this name, and yours would shadow it; choose another name"
        )
    texts = _texts(kind, name, folder)
    if existing := [user_config.shown(path) for path in texts if path.exists()]:
        raise ConfigError(f"{', '.join(existing)}: exists already; nothing was written")
    if kind != "study" and (known := find_spec(name)):
        raise ConfigError.at("NAME", name, f"a module has this name already, {known.origin}; choose another name")
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return list(texts)


def _texts(kind: str, name: str, folder: Path) -> dict[Path, str]:
    """Return the content of every file, by path."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    # The templates are Python and YAML, so nothing is escaped.
    templates = Environment(loader=FileSystemLoader(_TEMPLATES), undefined=StrictUndefined, keep_trailing_newline=True)
    group = _GROUPS.get(kind, kind)
    words = {"kind": group, "name": name, "class": _class_name(name), "conf": folder.name}
    words["needs"] = ', "representation=direction"' if kind == "actions" else ""
    files = {folder / group / f"{name}.yaml": f"{kind}.yaml"}
    test = f"test_{kind}.py" if (_TEMPLATES / f"test_{kind}.py.jinja").is_file() else "test_component.py"
    if kind != "study":
        files = {folder.parent / f"{name}.py": f"{kind}.py", **files}
    files[_test(kind, name, folder)] = test
    return {path: templates.get_template(f"{source}.jinja").render(words) for path, source in files.items()}


def _test(kind: str, name: str, folder: Path) -> Path:
    """Return the path of the test; that of a study differs, because a component may have the same name."""
    return folder.parent / (f"test_study_{name}.py" if kind == "study" else f"test_{name}.py")


def _class_name(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def _commands(kind: str, name: str, folder: Path) -> list[str]:
    flags = f"{user_config.FLAG} {user_config.shown(folder)}"
    run = f"rl-design-space {flags}"
    tests = [] if find_spec("pytest") else ["pip install pytest"]
    tests.append(f"python -m pytest {user_config.shown(_test(kind, name, folder))}")
    if kind == "study":
        return [*tests, f"{run} study={name} plan=true", f"{run} study={name}", f"rl-design-report {flags} {name}"]
    needs = " representation=direction" if kind == "actions" else ""
    return [*tests, f"{run} {_GROUPS.get(kind, kind)}={name}{needs} task.periods=50"]
