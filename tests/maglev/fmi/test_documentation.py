"""The page and the icon of every FMU: sketch, equations that are typeset, units, and icons that can be told apart."""

import re
import struct
import zipfile
import zlib
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from controller_fmu.block_diagrams import own_class
from controller_fmu.drawings import WRITTEN_ICON
from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.files.fmi_units import typeset_unit
from maglev.fmi.documentation import documentation, icon_of, mathml, numeral, typeset
from maglev.fmi.icon import SIZE, disc, png_icon, rectangle, stroke
from maglev.fmi.sketch import symbol

SMALL = 32   # px, of an icon in a list
MATHML = "{http://www.w3.org/1998/Math/MathML}"


def pixels(png: bytes) -> np.ndarray:
    """Colours of a PNG without filters, shape (SIZE, SIZE, 3)."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    place, chunks = 8, {}
    while place < len(png):
        length, = struct.unpack(">I", png[place:place + 4])
        kind, content = png[place + 4:place + 8], png[place + 8:place + 8 + length]
        assert struct.unpack(">I", png[place + 8 + length:place + 12 + length])[0] == zlib.crc32(kind + content)
        chunks[kind] = content
        place += 12 + length
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8).reshape(SIZE, 1 + 3 * SIZE)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(SIZE, SIZE, 3).astype(float)


def small(name: str) -> np.ndarray:
    """Icon of an FMU at the size of a list."""
    factor = SIZE // SMALL
    return pixels(png_icon(icon_of(definition(name)))).reshape(SMALL, factor, SMALL, factor, 3).mean(axis=(1, 3))


@pytest.mark.usefixtures("slow")
def test_icons_can_be_told_apart_in_a_list() -> None:
    """Those of two FMUs differ clearly in some pixels, those of two kinds in many, also without colours.

    The loops are a kind, with the sign of the controller in a corner.
    """
    icons = {name: small(name) for name in DEFINITIONS}
    for one, other in combinations(DEFINITIONS, 2):
        difference = np.abs(icons[one].mean(axis=2) - icons[other].mean(axis=2)) > 60.0
        twins = one[:-4] == other[:-4] and not one.startswith("Plant")
        loops = one.startswith("ClosedLoop") and other.startswith("ClosedLoop")
        assert difference.sum() >= (3 if twins else 10 if loops else 30), f"{one}, {other}: {difference.sum()} pixels"


def test_shapes_cover_what_they_should() -> None:
    def covered(*shapes: tuple) -> float:
        return float((255.0 - pixels(png_icon(shapes))).mean() / 255.0)

    assert covered(rectangle(10, 20, 30, 40, "#000000")) == pytest.approx(0.12, abs=0.002)
    assert covered(disc(50, 50, 30, "#000000")) == pytest.approx(np.pi * 0.09, rel=0.02)
    assert covered(*stroke([(20, 20), (80, 20)], 10, "#000000")) == pytest.approx(0.06 + np.pi * 0.0025, rel=0.02)
    assert covered(rectangle(0, 0, 50, 50, "#000000"), rectangle(0, 0, 50, 50, "#ffffff")) == 0.0


@pytest.mark.parametrize("name", DEFINITIONS)
def test_pages_are_typeset_and_have_a_sketch(name: str) -> None:
    page = documentation(definition(name), "1")
    assert page == documentation(definition(name), "1")
    assert "\\" not in page and "<sub>" not in page and "<sup>" not in page, "TeX or an index that is not typeset"
    sketch, = re.findall(r'<div class="sketch" .*?</svg></div>', page)
    assert len(ElementTree.fromstring(sketch).attrib["aria-label"].split()) > 10
    equations = [ElementTree.fromstring(text) for text in re.findall(r"<math .*?</math>", page, re.DOTALL)]
    assert sum(equation.get("display") == "block" for equation in equations) >= 3
    # What latex2mathml does not know, and what it reads as one word, it leaves as an ordinary letter or character.
    for equation in equations:
        assert not [mi.text for mi in equation.iter(f"{MATHML}mi") if "&" in (mi.text or "") or "\\" in (mi.text or "")]
    for v in definition(name).variables:
        assert f'<td class="unit">{typeset_unit(v.unit)}</td>' in page
    assert not re.search(r'(?:src|href)="(?!#|data:)', page), "it needs nothing else"


# One of each kind, and what has other equations where the platform tilts.
SOME = [name for name in DEFINITIONS if "3DOF" in name or name in ("Plant5DOF", "Regulator5DOF", "LinearRegulator5DOF",
                                                                   "Estimator5DOF")]
of_some = pytest.mark.parametrize("names", [SOME, pytest.param(tuple(DEFINITIONS), marks=pytest.mark.thorough)],
                                  ids=["some", "all"])


@of_some
def test_a_sketch_is_whole_and_can_be_read_on_a_phone(browser, names: Sequence[str]) -> None:
    """Every text of it is seen without scrolling, its letters as large as they are drawn, and within its picture."""
    context = browser.new_context(offline=True, viewport={"width": 390, "height": 844}, is_mobile=True)
    tab = context.new_page()
    hard = {}
    for name in names:
        tab.set_content(documentation(definition(name), "1"))
        letters, page, cut, icon = tab.evaluate("""(() => {
            const sketch = document.querySelector(".sketch"), texts = [...sketch.querySelectorAll("text")];
            const { width } = sketch.querySelector("svg").getBoundingClientRect();
            const scale = width / sketch.querySelector("svg").viewBox.baseVal.width;
            const sizes = [...sketch.querySelectorAll("text, tspan")]
                .map((each) => parseFloat(getComputedStyle(each).fontSize));
            const cut = texts.filter((text) => {
                const box = text.getBoundingClientRect(), whole = text.closest("svg").getBoundingClientRect();
                return box.left < whole.left - 1 || box.right > Math.min(whole.right + 1, innerWidth);
            });
            return [scale * Math.min(...sizes), Math.max(sketch.scrollWidth, document.documentElement.scrollWidth),
                    cut.map((text) => text.textContent),
                    document.querySelector("link[rel=icon]").href.startsWith("data:image/svg+xml,%3Csvg")];
        })()""")
        if letters < 11 or page > 390 or cut or not icon:
            hard[name] = letters, page, cut, icon
    context.close()
    assert hard == {}


@pytest.mark.thorough
@of_some
def test_paper_and_a_phone_cut_no_equation(browser, names: Sequence[str]) -> None:
    """On paper nothing is wider than A4; on a phone, equations stand below each other, and a long one scrolls."""
    context = browser.new_context(offline=True)
    tab = context.new_page()
    wide = {}
    for name in names:
        tab.set_content(documentation(definition(name), "1"))
        for media, width in (("print", 718), ("screen", 390)):
            tab.emulate_media(media=media)
            tab.set_viewport_size({"width": width, "height": 844})
            beyond = tab.evaluate("""() => [...document.querySelectorAll("math, table")]
                .filter((each) => each.getBoundingClientRect().right > innerWidth - 7)
                .filter((each) => matchMedia("print").matches || each.matches("math ~ math"))
                .map((each) => each.textContent.slice(0, 60))""")
            if beyond:
                wide[name, media] = beyond
    context.close()
    assert wide == {}


def test_equations_that_a_space_parts_are_wrapped_as_several() -> None:
    assert mathml(r"a = b, \qquad c", display=True).count("<math") == 2
    assert mathml(r"\text{a \qquad b} \left( c \qquad d \right)", display=True).count("<math") == 1


def test_units_are_written_as_people_do() -> None:
    assert [typeset_unit(unit) for unit in ("m/s2", "N.s/m", "m/(s2.T2)", "1/s5", "")] == [
        "m/s²", "N·s/m", "m/(s²·T²)", "1/s⁵", ""]
    units = {v.unit for name in DEFINITIONS for v in definition(name).variables}
    assert len({typeset_unit(unit) for unit in units}) == len(units)
    assert not any(re.search(r"[A-Za-z]\d|\.", typeset_unit(unit)) for unit in units)


@pytest.mark.parametrize(("value", "text"), [(0.0002, "0.0002"), (-1000.0, "−1000"), (1e-6, "10⁻⁶"), (-1e15, "−10¹⁵"),
                                             (2.5e7, "2.5 · 10⁷"), (0.0, "0"), (4.71238898038469, "4.71238898038469")])
def test_numbers_are_written_as_people_do(value: float, text: str) -> None:
    assert numeral(value) == text


def test_symbols_have_indices() -> None:
    text = ElementTree.fromstring(symbol(0, 0, "i_d, i_{qα}"))
    assert "".join(text.itertext()) == "id, iqα"
    assert [part.text for part in text.iter("tspan") if part.get("class") == "index"] == ["d", "qα"]
    # What is lowered is raised again.
    assert [float(part.get("dy", 0)) for part in text.iter("tspan")] == [0.0, 4.0, -4.0, 4.0]


def test_equations_of_a_text_are_typeset() -> None:
    text = typeset(r"a \(i_d\) b \[\ddot g = G\] c &lt;")
    assert re.sub(r"<math.*?</math>", "M", text) == "a M b <div>M</div> c &lt;"
    assert 'display="inline"' in text and 'display="block"' in text


@pytest.mark.usefixtures("slow")
def test_users_controllers_have_a_face() -> None:
    assert png_icon(tuple(WRITTEN_ICON.drawn())) not in {png_icon(icon_of(definition(name))) for name in DEFINITIONS}
    assert all("<svg" in own_class(sampled) for sampled in (0, 1))


@pytest.mark.few(12)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_both_kinds_have_the_same_face(fmus: Path, native_fmus: Path, name: str) -> None:
    faces = []
    for folder in (fmus, native_fmus):
        with zipfile.ZipFile(folder / f"{name}.fmu") as archive:
            faces.append([archive.read(file) for file in ("model.png", "documentation/index.html")])
    assert faces[0] == faces[1]
