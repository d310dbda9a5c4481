"""What is asserted of a loop in every rig of a set."""

from collections.abc import Callable, Iterable, Mapping

from pneuservo.errors import InputError
from pneuservo.testing.words import Run

Check = Callable[[Run], None]

# Rigs whose failures are shown in full.
_SHOWN = 3


def assert_robust(
    runs: Mapping[str, Run] | Iterable[tuple[str, Run]], *checks: Check, share: float = 1.0
) -> None:
    """Assert that runs of a loop pass checks in every rig of a set, or in a share of them.

    Parameters
    ----------
    runs : mapping or iterable of (str, Simulation or Recording)
        Name and run of each rig, such as from `pneuservo.testing.closed_loops`.
    *checks : callable
        Each takes a run and asserts something of it.
    share : float, optional
        Of the rigs that have to pass, for sets that are drawn [-].

    Raises
    ------
    AssertionError
        When fewer pass; the message names how many failed, and of the first what.
    InputError
        When there is nothing to check.

    Examples
    --------
    >>> from pneuservo.testing import assert_settles_within, closed_loops
    >>> set_of_rigs = closed_loops("sliding-mode", {"load.mass": "1.8, 12 kg"}, demand="15,24 mm")
    >>> assert_robust(set_of_rigs, lambda run: assert_settles_within(run, "200 ms"))
    """
    __tracebackhide__ = True
    if not 0.0 < share <= 1.0:
        raise InputError(f"share is {share:g}; it has to be greater than 0, and 1 at most")
    if not checks:
        raise InputError("assert_robust: no check is given, so that nothing is asserted")
    named = runs.items() if isinstance(runs, Mapping) else runs
    count, failures = 0, []
    for name, run in named:
        count += 1
        failed = list(_failures(run, checks))
        if failed:
            failures.append(f"{name}:\n  " + "\n  ".join(failed))
    if not count:
        raise InputError("assert_robust: there is no run, so that nothing is asserted")
    if len(failures) > (1.0 - share) * count + 1e-9:
        needed = "all have" if share == 1.0 else f"{100 * share:.4g} % have"
        lines = [f"{len(failures)} of {count} rigs fail, {needed} to pass", *failures[:_SHOWN]]
        if len(failures) > _SHOWN:
            lines.append(f"and {len(failures) - _SHOWN} more")
        raise AssertionError("\n".join(lines))


def _failures(run: Run, checks: Iterable[Check]) -> Iterable[str]:
    for check in checks:
        try:
            check(run)
        except AssertionError as problem:
            yield str(problem).replace("\n", "\n  ")
