"""Self-contained HTML pages."""

from functools import cache
from typing import Any

from pneuservo.diagnosis import Diagnosis
from pneuservo.report.diagnosis_figures import diagnosis_figures
from pneuservo.report.sessions import between_sessions_in_words
from pneuservo.report.words import farthest_off, headline, not_judged_in_words, quantity


def render(template: str, **content: Any) -> str:
    """Return a page made from a template.

    Parameters
    ----------
    template : str
        Name of a file in this package's ``templates``.
    **content
        What the template shows; text is escaped, pictures are marked safe there.

    Returns
    -------
    str
        HTML; it refers to no other file unless the template does.
    """
    return _environment().get_template(template).render(**content)


def diagnosis_content(diagnosis: Diagnosis, answer: dict[str, Any]) -> dict[str, Any]:
    """Return what the diagnosis section of a page shows.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.
    answer : dict
        Its document.

    Returns
    -------
    dict
        Content for the templates.
    """
    remark = ""
    if diagnosis.structure_remains and diagnosis.verdict != "unexplained":
        channel, fit = farthest_off(answer["fit"]["channels"])
        ratio = fit["after"]["used"] / fit["noise_rms"]
        remark = (
            f"What is left of the {channel.replace('_', ' ')} is {ratio:.3g} times its noise and "
            "not random: something else is missing, too."
        )
    return {
        "answer": answer,
        "rig": diagnosis.rig,
        "figures": diagnosis_figures(diagnosis, answer),
        # A recording stands once per judged channel among the cases.
        "recordings": list({id(c.recording): c.recording for c in diagnosis.cases}.values()),
        "ledger": diagnosis.search.ledger,
        "over_chance": {
            name: ratio
            for name, ratio in diagnosis.search.over_chance.items()
            if name in diagnosis.search.accepted
        },
        "remark": remark,
        "steady": diagnosis.model.steady,
        "between_sessions": between_sessions_in_words(answer),
        "not_judged": not_judged_in_words(answer),
    }


def diagnosis_page(diagnosis: Diagnosis, answer: dict[str, Any]) -> str:
    """Return the report of a diagnosis as one HTML page.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.
    answer : dict
        Its document.

    Returns
    -------
    str
        HTML with inline pictures; it needs no network.
    """
    return render("diagnosis_page.html", **diagnosis_content(diagnosis, answer))


@cache
def _environment() -> Any:
    from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

    environment = Environment(
        loader=PackageLoader("pneuservo.report"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(headline=headline, quantity=quantity)
    return environment
