"""Outcomes of procedures that nobody evaluated."""

from math import inf

from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue, ValueTable
from maglev.scenario.claims import ProcedureClaim
from maglev.scenario.procedure import ProcedureSettings

HOSTILE = '</script><script>alert("1 & 2")</script> [red]x[/red] [/] %{y}'

GAP, THRUST = "air gap (mm)", "L (m/(s² A))"


def cogging_claim(text: str = "The cogging force is 2 N", source: str = "p. 34, Fig. 4.9") -> ProcedureClaim:
    """A claim that the outcomes here reproduce."""
    return ProcedureClaim(text=text, source=source, value="cogging_force", relation="about", target=2.0, digits=1)


def chart(number: str | None = "4.9", label: str = "parabola fit", caption: str = "Thrust over the air gap.",
          panels: int = 1) -> Chart:
    """A chart with a line and marks in every panel."""
    curves = (Curve(label, [10.0, 15.0, 20.0], [1.0 / 3.0, 0.25, 0.125], margin=[0.05, 1.0 / 30.0, inf]),
              Curve("estimator", [10.0, 20.0], [0.3, 0.1], marked=True))
    return Chart(number, caption, (Panel(GAP, THRUST, curves),) * panels)


def outcome(name: str = "2dof-thrust", *, title: str = "Thrust by parabolas", charts: tuple[Chart, ...] = (chart(),),
            tables: tuple[ValueTable, ...] | None = None, notes: tuple[str, ...] = ("C3 is not excited.",),
            claims: tuple[ProcedureClaim, ...] = (cogging_claim(),), runs: tuple[str, ...] = ()) -> Outcome:
    """An outcome with one of everything."""
    if tables is None:
        tables = (ValueTable("Constants", ("constant", "thesis", "here"),
                             (("C1", "14.2", "14.1"), ("C2", "791", "790"))),)
    settings = ProcedureSettings(kind="parabolas", name=name, title=title, claims=list(claims))
    return Outcome(settings, runs, (ProcedureValue("cogging_force", 2.1, gap=0.01),), tables, charts, notes)


def hostile_outcome() -> Outcome:
    """An outcome whose texts would break a page, or a table in a terminal, that does not escape them."""
    (panel,) = chart(label=HOSTILE).panels
    return outcome(title=HOSTILE, charts=(Chart("4.9", HOSTILE, (Panel(HOSTILE, HOSTILE, panel.curves),)),),
                   tables=(ValueTable(HOSTILE, (HOSTILE,), ((HOSTILE,),)),), notes=(HOSTILE,),
                   claims=(cogging_claim(HOSTILE, HOSTILE),))
