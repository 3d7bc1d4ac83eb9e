"""Every run of the packaged scenarios, read once for all tests that go through them."""

from maglev.schema.layers import packaged_files
from maglev.schema.loading import load_plans

RUNS = tuple(run for name in packaged_files() for run in load_plans(name))
