"""Picture of a run that left its baseline: what was expected, what came, and where they part."""

from pathlib import Path

from maglev.baselines.baseline import Baseline
from maglev.baselines.deviation import Deviation, samples_of
from maglev.cosim.master import Recording
from maglev.pictures import new_figure, write_figure

MOST = 6   # signals, that of the deviation among them


def picture_file(folder: Path, name: str) -> Path:
    return folder / f"{name}.check.png"


def write_picture(path: Path, title: str, baseline: Baseline, recording: Recording, deviation: Deviation) -> None:
    """Write a picture, a row for each signal: both curves, and their difference. MaglevError without matplotlib."""
    names = [deviation.signal, *(name for name in baseline.columns if name != deviation.signal)][:MOST]
    samples = samples_of(baseline, recording)
    figure = new_figure(11.0, 1.0 + 1.6 * len(names))
    figure.suptitle(f"{title}: off from t = {deviation.time:.6g} s")
    rows = figure.subplots(len(names), 2, sharex=True, squeeze=False)
    for (curves, differences), name in zip(rows, names, strict=True):
        curves.plot(recording.time, recording.columns[name], linewidth=1.2, label="now")
        curves.plot(baseline.time, baseline.columns[name], "k.", markersize=3.0, label="baseline")
        differences.plot(baseline.time, samples[name] - baseline.columns[name], "k.-", markersize=3.0, linewidth=0.8)
        for axes in (curves, differences):
            axes.axvline(deviation.time, color="tab:red", linewidth=0.8)
        curves.set_ylabel(name, fontsize="small")
    rows[0, 0].legend(loc="upper right", fontsize="small")
    rows[0, 1].set_title("now − baseline", fontsize="small")
    for axes in rows[-1]:
        axes.set_xlabel("t, s")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_figure(path, figure)
