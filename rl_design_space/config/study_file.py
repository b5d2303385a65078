"""The config of a study, made of that without a study and the study's file, which spares a composition by Hydra."""

from __future__ import annotations

from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig, flag_override

from rl_design_space.config.assemble import reaches_out

_STUDY = "study"


def with_study(base: DictConfig, text: str, parser: OverridesParser, repository: Any) -> DictConfig | None:
    """Return the config that Hydra composes with a study; None if Hydra has to compose it, or to report an error.

    Args:
        base: the composed config without any override of the command line, which is changed.
        text: the override, `study=table4`.
        parser: parses overrides.
        repository: Hydra's repository of config files.
    """
    override = parser.parse_override(text)
    name = override.value()
    # As in the shipped config: there is a place for a study, and nothing is put into it.
    is_free = _STUDY not in base and base.hydra.runtime.choices.get(_STUDY, "") is None
    if text != f"{_STUDY}={name}" or not is_free or base.hydra.overrides.task:
        return None
    path = f"{_STUDY}/{name}"
    found = repository.load_config(path) if repository.config_exists(path) else None  # copies the file's content
    if found is None or reaches_out(found) or not isinstance(found.config, DictConfig):
        return None
    with flag_override(base, ["struct", "readonly"], False), flag_override(base.hydra, "readonly", False):
        base[_STUDY] = found.config
        base.hydra.runtime.choices[_STUDY] = name
        base.hydra.overrides.task.append(text)
        base.hydra.job.override_dirname = text
    return base
