"""Whether a graphics processor gives the bits of this processor, and how fast: batches and environments.

First 65,536 differing stages in a run of 1.5 s, on both: all metrics must have the same bits, also where what samples
have in common is constant. So must 256 environments, in what they see and what it is worth, until each has ended and
begun anew. Then 100,000 samples of 3dof-setpoints-improved with all metrics, without constants and with them: the whole
call, and the kernel alone, in steps of a stage a second; and steps of many environments. Without a graphics processor
it says why it is left out. The exit code is 1 where bits differ.
"""

import argparse
import math
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any
from unittest.mock import patch

import numpy as np

import maglev
from maglev.cosim.blocks.graphics_processor import require_device
from maglev.gym.stages import Stages
from maglev.schema.loading import load_plan
from maglev.studies.batch import graphics_processor
from maglev.studies.batch.graphics_processor import Begun, Device

RUN = "3dof-setpoints-improved"
SHORT = """\
extends = ["loops/3dof.toml", "gains/3dof-improved.toml", "references/3dof-setpoints.toml"]
name = "short"
title = "The beginning of the setpoints"
stop_time = "1.5 s"
"""


def differing(samples: int) -> dict[str, Any]:
    """Values of so many stages, no two of which are the same."""
    random = np.random.default_rng(1)
    return {"plant.y.mass": np.linspace(6.5, 7.5, samples),
            "plant.y.position_start": random.uniform(0.0245, 0.0255, samples),
            "controller.current_limit": random.uniform(4.0, 8.0, samples)}


def same_bits(samples: int) -> bool:
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "short.toml"
        path.write_text(SHORT, encoding="utf-8")
        there, here = (maglev.batch(path, differing(samples), device=device) for device in ("gpu", "cpu"))
    differ = [name for name in here.columns if there[name].tobytes() != here[name].tobytes()]
    stages = len(np.unique(np.column_stack([*here.columns.values()]), axis=0))
    print(f"{samples:,} samples of 1.5 s, {stages:,} of them with metrics of their own, {len(here.columns)} metrics: "
          f"{'bits differ in ' + ', '.join(differ) if differ else 'the same bits'}")
    return not differ and there.failures == here.failures


def environments(count: int, device: str, **options: Any) -> Stages:
    return Stages(count, "3dof", device=device, reference="hold", **options)


def same_environments(count: int) -> bool:
    """Compare environments on both processors, with noise and pushes, for one and a half episodes."""
    here, there = (environments(count, device, duration=0.02, measurement={"y.noise": "1 um"}, parameters={
        "y.force": {"at": (0.0, 0.01), "then": (-50.0, 50.0)}}) for device in ("cpu", "gpu"))
    here.reset(seed=1)
    there.reset(seed=1)
    here.action_space.seed(1)
    differ, ended = 0, 0
    for _ in range(150):
        actions = here.action_space.sample()
        one, other = here.step(actions), there.step(actions)
        differ += any(there.here(found).tobytes() != expected.tobytes()
                      for found, expected in zip(other[:4], one[:4], strict=True))
        ended += int((one[2] | one[3]).sum())
    print(f"{count} environments of a stage, {ended} ends in 150 steps: "
          f"{f'bits differ in {differ} of the steps' if differ else 'the same bits'}")
    return not differ


def speed_of_environments(count: int) -> None:
    """Time steps of environments, before one falls: another episode takes its time here."""
    envs = environments(count, "gpu")
    envs.reset(seed=1)
    actions = envs.xp.zeros(envs.commands.shape)
    for _ in range(3):
        envs.step(actions)
    start = perf_counter()
    for _ in range(20):
        envs.step(actions)
    apart = (perf_counter() - start) / 20   # what ends is on this processor, so a step waits for the other one
    print(f"{count:,} environments: {1e3 * apart:.2f} ms a step of all, {count / apart:.3g} steps a second"
          f"{', some begun anew' if envs.over.any() else ''}")


def speed(samples: int) -> None:
    """Time a study, then the kernel alone, which does not run beside this processor there."""
    plan = load_plan(RUN)
    steps = samples * round(plan.stop_time / plan.step)
    kernel, launch = [], Device.launch

    def timed(device: Device, begun: Begun) -> dict[str, Any]:
        start = perf_counter()
        arrays = launch(device, begun)
        device.cupy.cuda.Device().synchronize()
        kernel.append(perf_counter() - start)
        return arrays

    start = perf_counter()
    maglev.batch(RUN, differing(samples), device="gpu")
    whole = perf_counter() - start
    with patch.object(Device, "launch", timed):
        maglev.batch(RUN, differing(samples), device="gpu")
    print(f"{samples:,} samples of {RUN}, {steps:,} steps of a stage with all metrics: {whole:.1f} s in all, "
          f"{sum(kernel):.1f} s to send and run them: {steps / whole:.3g} and {steps / sum(kernel):.3g} steps a second")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compared", type=int, default=65_536, help="samples that are compared")
    parser.add_argument("--timed", type=int, default=100_000, help="samples that are timed")
    asked = parser.parse_args()
    try:
        require_device("gpu")
    except maglev.MaglevError as error:
        print(f"left out: {error}")
        return
    ways = [patch.object(graphics_processor, "WORTH_SPECIALISING", worth) for worth in (math.inf, 0.0)]
    same = [same_environments(256)]
    for way, words in zip(ways, ("nothing constant", "what is common constant"), strict=True):
        print(f"{words}:")
        with way:
            same.append(same_bits(asked.compared))
            if all(same):
                speed(asked.timed)
    if not all(same):
        raise SystemExit(1)
    for count in (4_096, 65_536):
        speed_of_environments(count)


if __name__ == "__main__":
    main()
