import pytest

from maglev.scenario.quantities import metric_text, printed


@pytest.mark.parametrize(("value", "unit", "text"), [
    (12e-6, "m", "12 µm"), (0.1e-3, "m", "0.1 mm"), (-0.05e-3, "m", "-50 µm"), (1.2345e-3, "m", "1.23 mm"),
    (0.0, "m", "0 mm"),
    (4.56e-6, "rad", "4.56 µrad"), (2e-3, "rad", "2 mrad"), (0.02, "s", "20 ms"), (0.5, "s", "0.5 s"),
    (0.0542, "A", "0.0542 A"),
    (0.3234, "1", "32.3 %"), (12.345, "1", "1234 %"), (768.24, "", "768.2"), (0.2, "m/s", "200 mm/s")])
def test_one_rule_prints_all_values(value: float, unit: str, text: str) -> None:
    assert printed(value, unit) == text


def test_a_value_in_a_wanted_unit_has_four_digits() -> None:
    assert printed(0.019876, "m", "mm") == "19.88 mm"
    assert metric_text("settling time to 10 µm of x", float("inf"), "s") == "not settled"
    assert metric_text("stop contact time", float("inf"), "s") == "never"
