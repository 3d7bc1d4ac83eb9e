"""What the study found, as tables of a page."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pmlsm.rigs import RIGS
from studies.estimation.evidence import Judged, better, changed, counts, residual
from studies.estimation.fit import PROFILE, Fit
from studies.estimation.settings import Rig, Settings

BEGIN = "<!-- estimation: made by `python -m studies.estimation` -->\n"
END = "<!-- end of estimation -->\n"
SMALL = 0.6   # standard deviation afterwards over that before, below which the evidence says something


@dataclass(frozen=True)
class ScaleRow:
    """What the evidence says of one scale of friction, with slot ripple beside it or without."""

    scale: float
    ripple: bool
    training: Sequence[Judged]
    held_out: Sequence[Judged]


def scale_row(settings: Settings, scale: float, ripple: bool, judged: Sequence[Judged]) -> ScaleRow:
    """The row of one scale, its evidence split."""
    held_out = [each for each in judged if each.owner not in settings.training]
    return ScaleRow(scale, ripple, [each for each in judged if each.owner in settings.training], held_out)


def best_scale(rows: Sequence[ScaleRow]) -> float:
    """The scale that reproduces most of the sentences for training; of equal ones the first."""
    return max(rows, key=lambda row: counts(row.training).sentences[0]).scale


def page(settings: Settings, scales: Sequence[ScaleRow], fits: Mapping[str, Fit], before: Sequence[Judged],
         after: Sequence[Judged]) -> str:
    """All tables: scales of friction, both counts on both sets, the estimates, their profiles, changed verdicts."""
    parts = [scale_table(settings, scales), count_table(settings, before, after)]
    parts += [table for rig in settings.rigs for table in (estimate_table(rig, fits[rig.name]),
                                                           profile_table(rig, fits[rig.name]))]
    return "\n".join([*parts, change_table(settings, before, after)])


def scale_table(settings: Settings, rows: Sequence[ScaleRow]) -> str:
    """Verdicts and misfit at every scale of friction; the one that training chooses is bold."""
    lines = ["| Coulomb friction | training: sentences | bounds | misfit | held out: sentences | bounds | misfit |",
             "|---" * 7 + "|"]
    best = best_scale([row for row in rows if not row.ripple])
    for row in rows:
        label = f"× {row.scale:g}" + (", slot ripple" if row.ripple else "")
        cells = [cell for judged in (row.training, row.held_out)
                 for cell in (*counts(judged).text, f"{misfit(settings, judged):.1f}")]
        lines.append(f"| {f'**{label}**' if row.scale == best and not row.ripple else label} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def misfit(settings: Settings, judged: Sequence[Judged]) -> float:
    """Half the sum of squares of the residuals."""
    return 0.5 * sum(residual(each.result, settings.largest_residual) ** 2 for each in judged)


def count_table(settings: Settings, before: Sequence[Judged], after: Sequence[Judged]) -> str:
    """Verdicts and misfit on training and held-out evidence, before and after, by stage."""
    lines = ["| evidence | sentences before | after | bounds before | after | misfit before | after |",
             "|---|---|---|---|---|---|---|"]
    for name, training in (("training", True), ("held out", False)):
        for stage in (*(rig.name for rig in settings.rigs), ""):
            label = f"{name}, {RIGS[stage].title}" if stage else f"**{name}, both**"
            lines.append(count_row(label, settings, *([each for each in judged if each.owner.startswith(stage) and
                                                       (each.owner in settings.training) is training]
                                                      for judged in (before, after))))
    lines.append(count_row("**all**", settings, before, after))
    legend = ("Sentences: reproduced / within 10 % / not reproduced. Bounds: met of those judged. Misfit: half the sum "
              "of squares of the residuals.")
    return "\n".join([*lines, "", legend, ""])


def count_row(label: str, settings: Settings, before: Sequence[Judged], after: Sequence[Judged]) -> str:
    (old, old_bounds), (new, new_bounds) = counts(before).text, counts(after).text
    old_misfit, new_misfit = misfit(settings, before), misfit(settings, after)
    return f"| {label} | {old} | {new} | {old_bounds} | {new_bounds} | {old_misfit:.1f} | {new_misfit:.1f} |"


def estimate_table(rig: Rig, found: Fit) -> str:
    """Assumed and estimated values, with one standard deviation, and whether the evidence says anything."""
    lines = [f"Estimates of the {RIGS[rig.name].title}: half the sum of squares falls from {found.cost_before:.3g} to "
             f"{found.cost:.3g}.", "", "| parameter | assumed | estimated | one standard deviation | by the evidence |",
             "|---|---|---|---|---|"]
    for parameter, u, deviation in zip(rig.parameters, found.u, found.deviations, strict=True):
        low, high = parameter.range(float(u), float(deviation))
        says = "yes" if deviation < SMALL else "hardly: the prior holds it"
        lines.append(f"| {parameter.name} | {parameter.assumed:g} {parameter.unit} | {parameter.value(float(u)):.3g} "
                     f"{parameter.unit} | {low:.3g} … {high:.3g} | {says} ({deviation:.2f}) |")
    return "\n".join([*lines, ""])


def profile_table(rig: Rig, found: Fit) -> str:
    """Profiles, and the strongest correlation of each parameter."""
    heads = " | ".join(f"{place:+g} σ" for place in PROFILE)
    lines = [f"| {rig.name}: held at | {heads} | most correlated with |", "|---" * (len(PROFILE) + 2) + "|"]
    for k, (parameter, row) in enumerate(zip(rig.parameters, found.profiles, strict=True)):
        others = [(abs(found.correlations[k][j]), j) for j in range(len(rig.parameters)) if j != k]
        j = max(others)[1]
        cells = " | ".join("–" if math.isnan(each) else f"{each:+.2f}" for each in row)
        lines.append(f"| {parameter.name} | {cells} | {rig.parameters[j].name}, {found.correlations[k][j]:+.2f} |")
    return "\n".join([*lines, ""])


def change_table(settings: Settings, before: Sequence[Judged], after: Sequence[Judged]) -> str:
    """Every verdict that changed."""
    lines = ["| verdicts that change | claim | criterion | before | after | |", "|---" * 6 + "|"]
    for old, new in changed(before, after):
        kind = "training" if old.owner in settings.training else "held out"
        way = "better" if better(old.result.verdict, new.result.verdict) else "**worse**"
        text = old.result.claim.text if old.result.claim.figure is None else old.result.claim.source
        lines.append(f"| {kind}, `{old.owner}` | {text} | {old.result.claim.criterion} | {old.result.measured_text}: "
                     f"{old.result.verdict} | {new.result.measured_text}: {new.result.verdict} | {way} |")
    return "\n".join([*lines, ""])


def write_between(path: Path, text: str) -> None:
    """Put text between the markers of a page; ValueError where they are missing."""
    before, begin, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{path}: expected the lines {BEGIN.strip()} and {END.strip()}")
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
