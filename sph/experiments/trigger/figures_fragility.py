"""Fragility curves with the brackets that they are fitted to."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from sph.experiments.trigger.boundaries import in_words
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.fragility import CONFIDENCE, brackets, steps
from sph.figures.style import LINE_STYLES, WIDTH, also_in_g, class_colours, curve_colours, label_panels, plain, styled, write_note
from sph.measures.metrics import CLASSES


@styled
def figure_fragility(critical: pd.DataFrame, fits: pd.DataFrame, curves: pd.DataFrame, searched: Searched, note: str = "") -> Figure:
    """Probability of reaching a class against the intensity, a panel per case: curve, interval band, and the brackets as bars.

    ``critical``, ``fits`` and ``curves`` as from their readers (``read_critical`` and so on).  Brackets stand at the share of the
    motions up to their middle; those that are open count in the shares and are given in the legend.  Curves end at the strongest shaking
    of the case that was simulated.  Raises ValueError for an empty table.
    """
    if critical.empty:
        raise ValueError("critical: no row to draw")
    cases = list(dict.fromkeys(critical["case"]))
    figure = Figure(figsize=(WIDTH, 3.0 * len(cases) + 0.3), layout="constrained")
    axes = figure.subplots(len(cases), 1, sharex=True, squeeze=False)[:, 0]
    lengths = [name for name in dict.fromkeys(fits["collapse_class"]) if name not in CLASSES]
    colours = dict(zip((*CLASSES, *lengths), (*class_colours(), *curve_colours(max(len(lengths), 2))), strict=False))
    for ax, case in zip(axes, cases, strict=True):
        strongest = critical.loc[critical["case"] == case, ["lower", "upper"]].max().max()
        for fit in fits[fits["case"] == case].to_dict("records"):
            name = str(fit["collapse_class"])
            number = CLASSES.index(name) - 1 if name in CLASSES else lengths.index(name)
            look = {"color": colours[name], "linestyle": LINE_STYLES[number % len(LINE_STYLES)]}
            curve = curves[(curves["case"] == case) & (curves["collapse_class"] == name) & (curves["intensity"] <= strongest)]
            rows = critical[(critical["case"] == case) & (critical["collapse_class"] == name)]
            if len(curve):
                ax.fill_between(
                    curve["intensity"], curve["probability_lower"], curve["probability_upper"], color=look["color"], alpha=0.2, linewidth=0
                )
            words = _words(fit, searched.intensity.shown_unit)
            if len(curve):
                ax.plot(curve["intensity"], curve["probability"], label=words, **look)
            low, high, share = steps(*brackets(rows))
            middle = 0.5 * (low + high)
            ax.errorbar(
                middle,
                share,
                xerr=0.5 * (high - low),
                fmt="o",
                markersize=3,
                elinewidth=0.8,
                color=look["color"],
                label=words if curve.empty else None,
            )
        ax.set(ylim=(0.0, 1.0), ylabel="probability of reaching it" if lengths else "probability of reaching the class")
        ax.set_xlim(left=0.0)
        ax.legend(
            loc="center left",
            bbox_to_anchor=(1.0, 0.5),
            title=f"curve, {CONFIDENCE:.0%} band, brackets\n(θ: median, β: dispersion)" if (curves["case"] == case).any() else "brackets",
        )
    axes[-1].set_xlabel(plain(searched.intensity.label))
    if searched.intensity.unit == "m/s2":
        also_in_g(axes[0], "x")
    label_panels(axes, map(plain, cases))
    write_note(figure, note)
    return figure


def _words(fit: dict[str, object], unit: str) -> str:
    """Class, parameters and counts of a fit."""
    name = in_words(str(fit["collapse_class"])).removeprefix("class ")
    parameters = "no fit" if fit["median"] != fit["median"] else plain(f"θ = {fit['median']:.3g} {unit}, β = {fit['dispersion']:.2g}")
    others = {"never": "never reach it", "at_lowest": "reached at the lowest", "undecided": "diverged", "braked": "braked"}
    others |= {"not_monotone": "not monotone"}
    counted = [f"{fit[column]} {words}" for column, words in others.items() if fit[column]]
    return "\n".join([name, parameters, f"{fit['motions']} motions" + "".join(f", {each}" for each in counted[:1]), *counted[1:]])
