"""The JSON Schemas for editors: one file beside the options of every choice, and one beside the primary config.

The files follow from `conf/` and from the classes that it names. `make lint`, and so `make test`, renews them with
`python -m rl_design_space.catalogue.schemas`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from rl_design_space._paths import CONF
from rl_design_space.catalogue import documents
from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import Schema, schemas_of
from rl_design_space.catalogue.keys import Keys
from rl_design_space.catalogue.openness import opened
from rl_design_space.catalogue.options import constraints_only
from rl_design_space.catalogue.search import HYDRA_GROUPS, Search, searched
from rl_design_space.config.compose import CONFIG_NAME
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.config.target import imported
from rl_design_space.plan.constraint import Constraint
from rl_design_space.plan.variations import Variations
from rl_design_space.run.settings import Settings

#: Hydra ignores it: options are files that end in .yaml.
FILE_NAME = "schema.json"
_STUDY = "study"
_PRIMARY = "a whole configuration"
#: Keys that hold one value.
_PLAIN = ("seed", *(key for key in docstring_of(Settings).fields if key != "tracking"))


def schema_files(conf: Path = CONF) -> dict[str, Path]:
    """Return the path of each schema, by the pattern of the files that it describes, as editors expect it."""
    folders = sorted(path.parent for path in conf.rglob(FILE_NAME) if path.parent != conf)
    of_groups = {f"**/{folder.relative_to(conf).as_posix()}/*.yaml": folder / FILE_NAME for folder in folders}
    return {**of_groups, f"**/conf/{CONFIG_NAME}.yaml": conf / FILE_NAME}


def generated() -> dict[str, str]:
    """Return the text of every schema file, by its path relative to the folder of the shipped configuration."""
    with searched() as search:
        return {
            (Path(group) / FILE_NAME).as_posix(): json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
            for group, schema in _schemas(search)
        }


def main() -> None:
    """Write the files that are out of date, and print their paths."""
    for path, text in generated().items():
        file = CONF / path
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
            print(f"wrote {file}")


def _schemas(search: Search) -> Iterator[tuple[str, Schema]]:
    """Yield the schema of each folder of the configuration; that of the primary config has an empty name."""
    keys = Keys(search)
    groups = {group: keys.description(group) for group in (*search.groups, *HYDRA_GROUPS)}
    values: dict[str, list[Schema]] = {}
    for group, description in groups.items():
        if group == _STUDY:
            continue
        kinds = _targets(search, group)
        schemas = schemas_of(kinds)
        yield group, documents.document(group, description, documents.component(kinds, schemas), schemas.definitions)
        if group in OPTION_GROUPS:
            values |= {group: [{"description": description, "type": "string"}]}
            for schema in schemas.classes.values():
                _collect(values, group, schema)

    path = keys.target("task")
    schemas = schemas_of({path: imported("task._target_", path)})
    _collect(values, "task", schemas.classes[path])
    held = {key: opened({**keys.parameter(key).schema, "description": keys.description(key)}) for key in _PLAIN}
    held["task"] = {**documents.changed(schemas.classes[path]), "description": keys.description("task")}
    top_groups = {group: description for group, description in groups.items() if group in search.groups}
    content = documents.primary(held, top_groups)
    yield "", documents.document("rl-design-space", _PRIMARY, content, schemas.definitions)

    values["seed"] = [keys.parameter("seed").schema | {"description": keys.description("seed")}]
    yield _STUDY, _study(groups[_STUDY], {key: _any_of(found) for key, found in values.items()}, keys.names)


def _study(description: str, values: Mapping[str, Schema], tops: Sequence[str]) -> Schema:
    from rl_design_space import report

    kinds = {f"{report.__name__}.{name}": getattr(report, name) for name in report.__all__}
    reports, parts = schemas_of(kinds), schemas_of({"constraint": Constraint, "variations": Variations})
    tops = [*tops, "hydra"]
    content = documents.study(
        documents.component(kinds, reports, inherited=False), **parts.classes, keys=values, tops=tops
    )
    definitions = {**reports.definitions, **parts.definitions, "changes": documents.changes(values, tops)}
    return documents.document(_STUDY, description, content, definitions)


def _targets(search: Search, group: str) -> dict[str, type]:
    """Return the classes of this package that the options of a group name, by `_target_`."""
    nodes = [search.node(f"{group}/{option}") for option in search.options(group)]
    paths = sorted({node["_target_"] for node in nodes if "rl_design_space." in str(node.get("_target_"))})
    return {path: imported(f"{group}._target_", path) for path in paths}


def _collect(values: dict[str, list[Schema]], prefix: str, schema: Schema) -> None:
    for name, field in schema["properties"].items():
        values.setdefault(f"{prefix}.{name}", []).append(field)


def _any_of(schemas: Sequence[Schema]) -> Schema:
    """Return the schema of a value that several classes have, with the description of the first one."""
    checks = [constraints_only(schema) for schema in schemas]
    distinct = [check for place, check in enumerate(checks) if check not in checks[:place]]
    words = {"description": schemas[0]["description"]} if "description" in schemas[0] else {}
    return words | (distinct[0] if len(distinct) == 1 else {"anyOf": distinct})


if __name__ == "__main__":
    main()
