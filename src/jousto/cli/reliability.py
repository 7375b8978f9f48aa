"""Command ``reliability``: probability that limits of a model are exceeded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import count
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import (
    Drawing,
    End,
    Limits,
    Model,
    On,
    Output,
    Trust,
    Vary,
    Workers,
    amount,
)
from jousto.cli.study_options import WAYS, check_choice, check_index, outcomes_of, read_study
from jousto.cli.terminal import FAILED, columns, facts, say

if TYPE_CHECKING:
    from jousto.design.reliability.form import FormResult
    from jousto.design.reliability.limit import LimitState
    from jousto.design.studies.parameters.parameter import Parameter

METHODS = ("form", "sorm", "mc", "is", "subset")
HEAD = ("", "mean", "deviation", "design point", "importance", "by mean", "by deviation")


@command()
def reliability(
    model: Model,
    limit: Limits = None,
    vary: Vary = None,
    method: Annotated[
        str,
        typer.Option(
            metavar="form|sorm|mc|is|subset",
            help="First or second order, Monte Carlo, importance or subset sampling.",
        ),
    ] = "form",
    target: Annotated[
        float | None,
        typer.Option(metavar="BETA", help="Index to be reached; how much reserve it leaves."),
    ] = None,
    output: Output = None,
    samples: Annotated[int, typer.Option(min=1, help="Of mc, is and each level of subset.")] = 1000,
    seed: Annotated[int, typer.Option(help="The same seed gives the same samples.")] = 0,
    workers: Workers = 1,
    on: On = "processes",
    t_end: End = None,
    picture: Drawing = None,
    trust: Trust = False,
) -> None:
    """Compute the probability that limits of a model are exceeded.

    The random variables are the parameters with a distribution; limits come from the model file or
    from --limit. "by mean" and "by deviation" are the changes of beta if the mean or the standard
    deviation of a variable increases by one standard deviation. -o writes a table with a row for
    each limit; the picture shows the limit with the largest probability.
    """
    from jousto.base.files import write_table
    from jousto.design.reliability.errors import DesignPointError, LimitStateError
    from jousto.design.reliability.from_study import limit_state
    from jousto.design.reliability.pma import pma
    from jousto.design.reliability.sampling import SamplingResult
    from jousto.design.studies.study import study
    from jousto.schema.read import read_model

    checks = (
        lambda: check_targets({output: ("csv",), picture: ()}),
        lambda: amount(t_end, "s", "--t-end"),
        lambda: check_choice("--method", method, METHODS),
        lambda: check_choice("--on", on, WAYS),
        lambda: check_index(target),
    )
    file = read_model(model, trust=trust)
    limits, parameters = read_study(limit, vary, file, ("distribution",), checks)
    made = study(file, parameters, outcomes_of(limits), t_end=amount(t_end, "s", "--t-end"))
    how = "threads" if workers == 1 and on == "processes" else on
    states = [
        limit_state(
            *(made, one),
            correlation=file.reliability.correlation or None,
            workers=workers,
            how=how,
        )
        for one in limits
    ]
    wanted = file.reliability.target if target is None else target
    rows: list[dict[str, Any]] = []
    found: list[Any] = []
    for one, state in zip(limits, states, strict=True):
        before = made.counts["runs"]
        say(one.text if one.name == one.left else f"{one.name}: {one.text}", style="bold")
        try:
            first, result = _analyse(state, method, samples, seed)
        except (DesignPointError, LimitStateError) as error:
            say(str(error), error=True, style="red")
            continue
        met = None
        try:
            met = None if wanted is None else pma(state, beta=wanted)
        except (DesignPointError, LimitStateError) as error:  # only the reserve is missing
            say(f"no reserve at the target: {error}", error=True, style="yellow")
        runs = made.counts["runs"] - before
        _show(first, result, met, parameters, runs)
        rows.append(_row(one.text, method, first, result, met, runs))
        found.append(result if isinstance(result, SamplingResult) else first)
    if output is not None and rows:
        head = list(dict.fromkeys(key for row in rows for key in row))
        table = write_table(output, head, ([row.get(key, "") for key in head] for row in rows))
        say(f"table in {table}", style="green")
    if picture is not None and found:
        from jousto.output.plot import plot

        worst = max(found, key=lambda one: float(one.probability))
        plot(worst, path=picture)
        say(f"picture of {worst.name} in {picture}", style="green")
    if len(found) < len(limits):
        raise typer.Exit(FAILED)


def _analyse(state: LimitState, method: str, samples: int, seed: int) -> tuple[Any, Any]:
    """Return the FORM result (None for sampling methods) and the result of the chosen method."""
    from jousto.design.reliability.form import form
    from jousto.design.reliability.sampling import importance_sampling, monte_carlo
    from jousto.design.reliability.sorm import sorm
    from jousto.design.reliability.subset import subset_simulation

    how: Any = {"samples": samples, "seed": seed, "failed": "count"}
    if method == "mc":
        return None, monte_carlo(state, **how)
    if method == "subset":
        return None, subset_simulation(state, **how)
    first = form(state)
    if method == "sorm":
        return first, sorm(first)
    return first, importance_sampling(first, **how) if method == "is" else first


def _show(
    first: FormResult | None, result: Any, met: Any, parameters: list[Parameter], runs: int
) -> None:
    """Print index, probability, number of calls and the importance of the variables."""
    lines = [("beta", f"{result.beta:.4g}"), ("Pf", f"{result.probability:.4g}")]
    if hasattr(result, "low"):
        if not result.failures:
            lines = [("Pf", "nothing failed: more samples, or another method")]
        interval = f"{result.low:.4g} to {result.high:.4g} with {result.confidence:.0%}"
        lines.append(("interval", interval))
        lines.append(("failed", f"{result.failures} of {result.samples}"))
        lines += [(f"{n} without a value", reason) for reason, n in result.reasons.items()]
    if hasattr(result, "tvedt"):
        lines[1:1] = [("beta by FORM", f"{result.form.beta:.4g}")]
    calls = result.calls + (0 if met is None else met.calls)
    lines.append(("calls", f"{calls}, {count(runs, 'run')}"))
    if met is not None:
        reached = "reached" if met.reliable else "missed"
        lines.append((f"target {met.target:g}", f"{reached}, reserve {met.value:.4g} there"))
    facts(lines)
    if first is None:
        return
    units = {p.name: "" if p.unit == "1" else f" {p.unit}" for p in parameters}
    rows: list[tuple[str, ...]] = [HEAD]
    for one in first.variables.randoms:
        name = one.name
        moments = [f"{one.mean:.4g}{units[name]}", f"{one.deviation:.3g}"]
        by = [f"{s[name] * one.deviation:+.3f}" for s in (first.by_mean, first.by_deviation)]
        share = f"{first.importance[name]:.1%}"
        rows.append((name, *moments, f"{float(first.x[name]):.4g}", share, *by))
    columns(rows, "<>")


def _row(
    text: str, method: str, first: FormResult | None, result: Any, met: Any, runs: int
) -> dict[str, Any]:
    """Return the table row of one limit as values by column heading."""
    row = {"limit": text, "method": method, "beta": result.beta, "Pf": result.probability}
    if hasattr(result, "low"):
        row |= {"Pf from": result.low, "Pf to": result.high}
    row |= {"calls": result.calls, "runs": runs}
    if met is not None:
        row |= {"target": met.target, "reserve": met.value}
    if first is None:
        return row
    for name in first.variables.names:
        row[f"{name} at the design point"] = float(first.x[name])
        row[f"importance of {name}"] = first.importance[name]
        row[f"d beta / d mean of {name}"] = first.by_mean[name]
        row[f"d beta / d deviation of {name}"] = first.by_deviation[name]
    return row
