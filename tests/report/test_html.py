"""The HTML report as a file: complete, self-contained, safe against hostile names."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from diagnosis_example import FLOOR, KINDS, diagnosis_example, without_nominal
from diagnosis_page import page_of, written

from symid.diagnosis import EffectParameter
from symid.diagnosis.effects import LIBRARY
from symid.errors import SettingError
from symid.report.pages.diagnosis_page import effect_catalogue
from symid.report.pages.page import html_path

LOADING = {"src", "srcset", "href", "data", "action", "poster", "background"}
"""Attributes that make a browser load something."""


class Content(HTMLParser):
    """Tags, addresses and visible text of a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.cells: list[str] = []
        self.text = ""
        self._inside: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attributes if name in LOADING]
        if tag in ("script", "style"):
            self._inside.append(tag)
        if tag in ("td", "th"):
            self.cells.append("")

    def handle_endtag(self, tag):
        if self._inside and self._inside[-1] == tag:
            self._inside.pop()

    def handle_data(self, data):
        if not self._inside:
            self.text += data
            if self.cells:
                self.cells[-1] += data


UNLIKE = ("two effects", "no gap", "recording")
"""Kinds whose pages have all sections, those that have no effects, and a fault of the recording."""


@pytest.mark.parametrize("kind", UNLIKE)
def test_a_page_is_small_enough_to_be_mailed(kind):
    assert len(page_of(kind)) < 1_200_000


@pytest.mark.usefixtures("plain_pages")
@pytest.mark.parametrize("kind", KINDS)
def test_a_page_states_verdict_gap_causes_parameters_and_next_step(kind):
    found = diagnosis_example(kind)
    content = Content(written(found))
    first_heading = content.text.index("How large the gap is")
    assert content.text.index(found.sentence) < first_heading
    for level in (found.gap.nominal, found.gap.reidentified, *found.gap.steps, found.gap.noise_floor):
        assert f"{level.rms:.4g}" in [cell.strip() for cell in content.cells]
    for text in (found.next_experiment, *found.assumptions, *found.faults, *found.logs):
        assert text in content.text
    for change in found.parameters:
        assert change.name in content.cells
    assert content.text.count("had absorbed it") == sum(change.absorbed for change in found.parameters)
    assert content.text.count("accepted") == len(found.effects)


@pytest.mark.parametrize("kind", UNLIKE)
def test_a_page_loads_nothing(kind):
    page = page_of(kind)
    content = Content(page)
    assert [address for address in content.addresses if not address.startswith(("#", "data:text/csv"))] == []
    assert not set(content.tags) & {"link", "iframe", "object", "embed", "base", "form", "img"}
    style = "".join(re.findall(r"<style>(.*?)</style>", page, re.DOTALL))
    assert "url(" not in style
    assert "@import" not in style


def test_hostile_names_stay_text():
    hostile = "</script><script>window.hostile = 1</script><img src=x onerror='hostile()'>\"'&"
    found = diagnosis_example("two effects")
    first, *others = found.effects
    named = replace(first, at=hostile, parameters={hostile: EffectParameter(1.0, 0.1, hostile)})
    attacked = replace(
        found,
        sentence=hostile,
        logs=(hostile,),
        gap=replace(found.gap, signal=hostile, unit=hostile),
        effects=(named, *others),
        parameters=tuple(replace(change, name=hostile + change.name) for change in found.parameters),
        maps={hostile: tuple(replace(cell, label=hostile) for cell in found.maps["band"])},
        faults=(hostile,),
        assumptions=(hostile,),
        next_experiment=hostile,
    )
    content, benign = Content(written(attacked)), Content(page_of("two effects"))
    assert content.tags.count("script") == benign.tags.count("script")
    assert "img" not in content.tags
    assert content.text.count(hostile) >= 20


@pytest.mark.usefixtures("plain_pages")
def test_missing_nominal_values_are_reported():
    content = Content(written(without_nominal(diagnosis_example("effect"))))
    assert "no nominal values given" in content.text
    assert "nan" not in content.text.lower()


def test_a_log_of_minutes_makes_no_larger_file():
    assert len(written(diagnosis_example("effect", seconds=50.0))) < 4e6


@pytest.mark.usefixtures("plain_pages")
def test_a_gap_of_a_thousand_floors_is_drawn_on_a_logarithmic_scale():
    found = diagnosis_example("effect")
    large = replace(found.gap.nominal, rms=1244 * FLOOR)
    text = Content(written(replace(found, gap=replace(found.gap, nominal=large)))).text
    assert "Logarithmic scale" in text
    assert "1244 ×" in text


@pytest.mark.usefixtures("plain_pages")
def test_nothing_known_of_the_floor_or_the_spectrum_is_no_obstacle():
    found = diagnosis_example("unexplained")
    nothing = np.full(3, np.nan)
    empty = replace(
        found,
        gap=replace(found.gap, noise_floor=replace(found.gap.noise_floor, rms=0.0, relative=0.0)),
        spectrum=replace(
            found.spectrum, frequency=np.arange(3.0), reidentified=nothing, explained=nothing, noise=nothing
        ),
        maps={},
        alternatives=(),
        parameters=(),
    )
    assert found.sentence in Content(written(empty)).text


@pytest.mark.parametrize("name", ["report.pdf", "report", "missing/report.html"])
def test_a_file_that_cannot_be_a_page_is_refused_with_its_name(name, tmp_path):
    with pytest.raises(SettingError, match="report"):
        html_path(tmp_path / name)


def test_the_page_holds_the_schematic_of_the_axis():
    found = diagnosis_example(UNLIKE[0])
    pages = (page_of(UNLIKE[0]), written(found))
    drawing, again = (re.search("<figure class.*?</figure>", page, re.DOTALL)[0] for page in pages)
    for body in found.axis.bodies:
        assert f'id="body {body.name}"' in drawing
        assert f">{body.name}<" in drawing
    assert drawing == again


@pytest.mark.parametrize("kind", UNLIKE)
def test_pages_have_one_main_part_and_each_identifier_once(kind):
    page = page_of(kind)
    without_scripts = re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    names = re.findall(r'\sid="([^"]*)"', without_scripts)
    assert len(names) == len(set(names))
    assert without_scripts.count("<main>") == without_scripts.count("</main>") == 1
    assert set(re.findall(r'href="#([^"]*)"', re.search("<nav.*?</nav>", page, re.DOTALL)[0])) <= set(names)


@pytest.mark.usefixtures("plain_pages")
def test_an_accepted_effect_is_never_among_those_that_are_folded_away():
    found = diagnosis_example("effect")
    last = found.alternatives[0]
    others = tuple(replace(last, effect=f"other_{k}", probability=0.01) for k in range(12))
    page = written(replace(found, alternatives=(*others, last)))
    section = re.search('<section id="candidates".*?>.*?</section>', page, re.DOTALL)[0]
    before, folded = section.split("<details>")
    assert "accepted" in before
    assert "<td>13</td>" in before
    assert "accepted" not in folded
    assert "<summary>4 more</summary>" in folded


@pytest.mark.usefixtures("plain_pages")
def test_a_card_says_what_its_parameters_mean_and_what_to_do_on_the_machine():
    found = diagnosis_example("effect")
    text = Content(written(found)).text
    assert found.effects
    for one in found.effects:
        entry = effect_catalogue()[one.effect]
        assert f"Law. {entry.law}" in text
        assert f"On the machine. {entry.remedy}" in text


@pytest.mark.parametrize("effect", LIBRARY, ids=lambda effect: effect.name)
def test_the_catalogue_knows_every_effect_as_plain_text(effect):
    entry = effect_catalogue()[effect.name]
    for text in (entry.law, entry.remedy):
        assert text.endswith((".", ")"))
        assert "](" not in text
        assert "**" not in text
        assert "`" not in text
