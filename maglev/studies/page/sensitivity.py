"""Sobol indices of a study's metrics by SALib, where the design allows them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa

from maglev.studies.page.text import metrics_of
from maglev_files.extras import lacking


@dataclass(frozen=True)
class Indices:
    """Sobol indices of one metric, by what varies: first order and total, each with its 95 % confidence."""

    metric: str
    first: dict[str, float]
    first_confidence: dict[str, float]
    total: dict[str, float]
    total_confidence: dict[str, float]


def sensitivity(table: pa.Table, about: Mapping[str, Any]) -> tuple[list[Indices], list[str]]:
    """Indices of every metric that has some, and sentences that say why others, or all, have none."""
    names = [parameter["name"] for parameter in about["vary"]]
    if about["design"]["kind"] != "saltelli":
        return [], [f"Sobol indices need a design of kind 'saltelli'; this one is '{about['design']['kind']}'."]
    if about["correlated"]:
        return [], ["Sobol indices need what varies to be independent; some of it is correlated."]
    if any(why is not None for why in table["failure"].to_pylist()):
        return [], ["Sobol indices need every sample; some were not completed."]
    if missing := lacking("SALib", "study", "a Sobol index"):
        return [], [f"{missing}."]
    from SALib.analyze import sobol

    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    computed, constant, endless = [], [], []
    for name, _, values in metrics_of(table):
        if len(values) < table.num_rows or not np.isfinite(values).all():
            endless.append(name)
        elif values.min() == values.max():
            constant.append(name)
        else:
            # SALib draws its resamples from NumPy's generator of that seed: the same page for the same study.
            said = sobol.analyze(problem, values, calc_second_order=False, seed=about["design"]["seed"])
            computed.append(Indices(name, *(dict(zip(names, map(float, said[key]), strict=True))
                                            for key in ("S1", "S1_conf", "ST", "ST_conf"))))
    notes = []
    if endless:
        notes.append(f"None of {', '.join(endless)}: not finite in every sample, such as a band in which one never "
                     "settled.")
    if constant:
        notes.append(f"None of {', '.join(constant)}: the same in every sample.")
    return computed, notes
