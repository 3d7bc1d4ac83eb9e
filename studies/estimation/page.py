"""What the study found, as tables of a page."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from maglev.judging.verdicts import REPRODUCED, ClaimResult, Verdict
from maglev.schema.judged.claims import Claim
from studies.estimation.evidence import Judged, counts, residual
from studies.estimation.roughness import Estimate, Sums, over_tracks, spread
from studies.estimation.settings import Settings

BEGIN = "<!-- estimation: made by `python -m studies.estimation` -->\n"
END = "<!-- end of estimation -->\n"


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


@dataclass(frozen=True)
class RoughRow:
    """What the evidence says without roughness, the first of the rows, and with it, the others."""

    label: str
    sums: Sums
    flown: Sequence[Sequence[Judged]]   # one for each track


def page(settings: Settings, scales: Sequence[ScaleRow], estimates: Sequence[Estimate], rows: Sequence[RoughRow],
         scaled: Mapping[str, Sequence[Judged]], causes: Mapping[str, Sequence[Judged]]) -> str:
    """All tables: scales of friction, roughness at every scale, what it does to what is held out, printed numbers."""
    return "\n".join([scale_table(settings, scales), estimate_table(settings, estimates), rough_table(settings, rows),
                      changes_table(settings, rows), number_table(settings, rows, {**scaled, **causes}),
                      cause_table(rows[0].flown[0], causes)])


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


def estimate_table(settings: Settings, estimates: Sequence[Estimate]) -> str:
    """The rms of every axis at every scale of friction, and how likely the sentences for training are."""
    axes = " | ".join(name.split(".")[1] for name in settings.roughness.rms)
    lines = [f"| Coulomb friction, and roughness of | {axes} | training |",
             "|---" * (len(settings.roughness.rms) + 2) + "|"]
    best = max(estimates, key=lambda each: each.log_likelihood)
    for each in estimates:
        label = f"× {each.scale:g}, rms in m/s²"
        values = " | ".join(f"{each.rms[name]:.3g}" for name in settings.roughness.rms)
        lines.append(f"| {f'**{label}**' if each is best else label} | {values} | {each.log_likelihood:.1f} |")
    return "\n".join([*lines, ""])


def rough_table(settings: Settings, rows: Sequence[RoughRow]) -> str:
    """How likely the evidence is, and how much of it reproduces on a track in the mean."""
    lines = ["| | training: likelihood | sentences | held out: likelihood | sentences | bounds | parabolas: likelihood "
             "|", "|---" * 7 + "|"]
    for row in rows:
        means = [mean_of(row.flown, True, "reproduced", settings), mean_of(row.flown, False, "reproduced", settings),
                 mean_of(row.flown, False, "met", settings)]
        lines.append(f"| {row.label} | {row.sums.training:.1f} | {means[0]:.1f} | {row.sums.held_out:.1f} | "
                     f"{means[1]:.1f} | {means[2]:.1f} | {row.sums.parabolas:.1f} |")
    legend = ("Likelihood: natural logarithm, of the sentences that can be tested. Sentences and bounds: reproduced "
              "and met on a track, in the mean of the tracks.")
    return "\n".join([*lines, "", legend, ""])


def mean_of(flown: Sequence[Sequence[Judged]], training: bool, verdict: Verdict, settings: Settings) -> float:
    """How many claims have a verdict, in the mean of the tracks."""
    return sum(each.result.verdict == verdict for judged in flown for each in judged
               if (each.owner in settings.training) is training) / len(flown)


def changes_table(settings: Settings, rows: Sequence[RoughRow]) -> str:
    """Sentences held out that other tracks than a fifth judge otherwise than without roughness."""
    without, rough = rows[:2]
    lines = ["| held out | claim | criterion | without | with roughness | reproduced on |", "|---" * 6 + "|"]
    tracks = over_tracks(rough.flown)
    for each in without.flown[0]:
        results = tracks.get(each.key, ())
        good = sum(result.verdict == "reproduced" for result in results)
        if each.owner in settings.training or not results or (
                good >= 0.8 * len(results) if each.result.verdict == "reproduced" else good <= 0.2 * len(results)):
            continue
        claim = each.result.claim
        numbers = "" if claim.measured is not None and claim.measured.yes_no else spread_text(claim, results)
        lines.append(f"| `{each.owner}` | {claim.text} | {claim.criterion} | {each.result.measured_text}: "
                     f"{each.result.verdict} | {numbers} | {good} of {len(results)} |")
    return "\n".join([*lines, ""])


def spread_text(claim: Claim, results: Sequence[ClaimResult]) -> str:
    """Median, and first to last tenth of what was measured."""
    found = spread(results)
    return f"{claim.printed(found.median)} ({claim.printed(found.low)} … {claim.printed(found.high)})"


def number_table(settings: Settings, rows: Sequence[RoughRow], causes: Mapping[str, Sequence[Judged]]) -> str:
    """Every printed number with what is measured, what it is over tracks, and the cause that comes nearest to it."""
    lines = ["| printed number | | here | with roughness: median (10 … 90 %) | the printed one is | nearest of the "
             "other causes tried | that gives |", "|---" * 7 + "|"]
    tracks = over_tracks(rows[1].flown)
    by_cause = {words: {each.key: each.result.measured for each in judged} for words, judged in causes.items()}
    for each in rows[0].flown[0]:
        claim, target = each.result.claim, each.result.claim.target
        if claim.figure is not None or claim.kind != "number" or not isinstance(target, float):
            continue
        found = spread(tracks[each.key])
        inside = "inside" if found.low <= target <= found.high else "outside"
        median = "reproduced" if abs(found.median - target) <= REPRODUCED * target else "missed"
        chose = ", it chose the rms" if each.owner in settings.training else ""
        tried = {words: float(values[each.key] or math.inf) for words, values in by_cause.items() if each.key in values}
        words, value = min(tried.items(), key=lambda item: miss_by(item[1], target))
        nearest = miss_by(value, target) < miss_by(float(each.result.measured or math.inf), target)
        lines.append(f"| `{each.owner}`: {claim.criterion} | {claim.source} | {each.result.measured_text} | "
                     f"{spread_text(claim, tracks[each.key])} | {inside}, median {median}{chose} | "
                     f"{words if nearest else 'none'} | {claim.printed(value) if nearest else ''} |")
    return "\n".join([*lines, ""])


def cause_table(judged: Sequence[Judged], causes: Mapping[str, Sequence[Judged]]) -> str:
    """What every other cause makes of the printed numbers that do not reproduce."""
    lines = [f"| not reproduced | here | {' | '.join(causes)} |", "|---" * (len(causes) + 2) + "|"]
    by_key = [{each.key: each.result.measured_text for each in others} for others in causes.values()]
    for each in judged:
        claim = each.result.claim
        missed = each.result.verdict not in ("reproduced", "not testable")
        if claim.figure is None and claim.kind == "number" and missed:
            cells = [each.result.measured_text, *(values.get(each.key) or "–" for values in by_key)]
            lines.append(f"| `{each.owner}`: {claim.criterion} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def miss_by(value: float, target: float) -> float:
    """By how much a value misses another one, as a factor, logarithmically."""
    return math.inf if not 0.0 < value < math.inf else abs(math.log(value / target))


def write_between(path: Path, text: str) -> None:
    """Put text between the markers of a page; ValueError where they are missing."""
    before, begin, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{path}: expected the lines {BEGIN.strip()} and {END.strip()}")
    path.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
