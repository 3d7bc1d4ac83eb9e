"""Every run of the packaged scenarios, read once for all tests that go through them."""

from maglev.scenario.layers import packaged_files
from maglev.scenario.loading import load_plans

RUNS = tuple(run for name in packaged_files() for run in load_plans(name))
