"""The design choices, one module each. Every option is a frozen, validated value that yields data for the learner.

A new option is a dataclass in the module of its choice and a YAML file in `conf/`. Nothing has to be listed here: this
package offers every public class and function that the modules below define.
"""

# ruff: noqa: F403, F405
from typing import TYPE_CHECKING

from rl_design_space.design.actions import *
from rl_design_space.design.adaptive import *
from rl_design_space.design.aggregated import *
from rl_design_space.design.chance import *
from rl_design_space.design.controllers import *
from rl_design_space.design.curriculum import *
from rl_design_space.design.double_q import *
from rl_design_space.design.dyna import *
from rl_design_space.design.exploration import *
from rl_design_space.design.learned_in_lanes import *
from rl_design_space.design.learner import *
from rl_design_space.design.msa import *
from rl_design_space.design.multi_step_learners import *
from rl_design_space.design.observing import *
from rl_design_space.design.on_policy import *
from rl_design_space.design.own_learner import *
from rl_design_space.design.point import *
from rl_design_space.design.representation import *
from rl_design_space.design.reward import *
from rl_design_space.design.sight import *
from rl_design_space.design.stage import *
from rl_design_space.design.task import *
from rl_design_space.design.without import *
from rl_design_space.design.world import *

if not TYPE_CHECKING:  # type checkers follow the star imports, and take a computed list for an empty one
    #: What the modules define, without what they import. A constant does not know its module.
    __all__ = ["MOVES", "UNKNOWN", "WAIT"]
    __all__ += sorted(
        name for name, value in globals().items() if str(getattr(value, "__module__", "")).startswith(f"{__name__}.")
    )
