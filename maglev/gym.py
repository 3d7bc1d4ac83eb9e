"""Gymnasium environments of the stages, registered as this module is imported.

>>> import gymnasium
>>> import maglev.gym
>>> sorted(name for name in gymnasium.registry if name.startswith("maglev/"))
['maglev/Stage-v0', 'maglev/Stage2DOF-v0', 'maglev/Stage3DOF-v0', 'maglev/Stage5DOF-v0']

The first is of any stage: `gymnasium.make("maglev/Stage-v0", stage="mine.toml")`.
"""

from gymnasium.envs.registration import register

from maglev.files.packages import require_own_packages

require_own_packages()

from maglev.descriptions.packaged import PACKAGED_STAGES  # noqa: E402  # ours, as is known now

# The environments end their episodes themselves, by a time in seconds. Tests do the work of gymnasium's checker.
for suffix, given in (("", {}), *((stage.suffix, {"stage": stage.name}) for stage in PACKAGED_STAGES.values())):
    register(f"maglev/Stage{suffix}-v0", entry_point="maglev.many.environment:StageEnv",
             vector_entry_point="maglev.many.vector_environment:StageVectorEnv", kwargs=given)
