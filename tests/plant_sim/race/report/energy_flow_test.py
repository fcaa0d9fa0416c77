# SPDX-License-Identifier: Apache-2.0
"""Labels of the energy flow: for any energies and width each node has one, inside the picture, none over another."""
import json
import random

import pytest
from report_reader import opened, run

LOSSES = ["battery_r0_heat", "battery_rc_heat", "contactor_heat", "bleed_heat", "low_voltage", "inverter_heat",
          "motor_heat", "driveline_heat", "aero", "rolling", "cornering", "tyre_slip", "brake_front", "brake_rear"]
STORES = ["battery_rc_stored", "dc_link_stored", "kinetic", "climb"]  # below zero: they gave energy back
DRAW = """
(terms, width) => {
  document.getElementById("drawn")?.remove();
  const box = voltlap.element("div", { id: "drawn", class: "flow", style: `width:${width}px` });
  document.body.append(box);
  new voltlap.EnergyFlow({ box, terms }).draw();
  const of = (part) => { const r = part.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
  const labels = [...box.querySelectorAll(".flow-label")].map((part) => [part.dataset.name, part.innerText, of(part)]);
  const nodes = echarts.getInstanceByDom(box).getOption().series[0].data.map(({ name }) => name);
  return { box: of(box), labels, nodes };
}
"""


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    return opened(browser.page(run(tmp_path_factory.mktemp("flow"), "--laps", "1")[1]))


def drawn_energies(draw):
    """Losses of any size, some of them nothing, and stores that took or gave; the cells gave what is left."""
    terms = {name: draw.choice([0.0, 1.0, 1.0]) * 10 ** draw.uniform(-4, 1) for name in LOSSES}
    terms |= {name: draw.choice([-1.0, 0.0, 1.0]) * 10 ** draw.uniform(-4, 0.5) for name in STORES}
    total = sum(terms.values())
    if total <= 0:  # a report draws no flow then
        terms["brake_front"] += 1.0 - total
    return terms | {"battery_chemical": sum(terms.values())}


def overlaps(labels):
    return [(a[0], b[0]) for i, a in enumerate(labels) for b in labels[:i]
            if min(a[2][2], b[2][2]) - max(a[2][0], b[2][0]) > 0.01
            and min(a[2][3], b[2][3]) - max(a[2][1], b[2][1]) > 0.01]


@pytest.mark.parametrize("width", [320, 366, 519, 760, 1100])
def test_labels_never_lie_over_each_other(page, width):
    seed = random.randrange(2**32)
    draw = random.Random(seed)
    for number in range(60):
        terms = drawn_energies(draw)
        picture = page.run(f"({DRAW})({json.dumps(terms)}, {width})")
        words = f"seed {seed}, width {width}, draw {number}: {terms}"
        left, top, right, bottom = picture["box"]
        assert sorted(name for name, _, _ in picture["labels"]) == sorted(picture["nodes"]), words
        for name, text, (x0, y0, x1, y1) in picture["labels"]:
            assert x0 >= left - 0.5 and y0 >= top - 0.5 and x1 <= right + 0.5 and y1 <= bottom + 0.5, f"{name}: {words}"
            assert text.startswith(name), words
        assert overlaps(picture["labels"]) == [], words
    assert page.complaints() == []


def test_a_car_that_ends_slower_than_it_began_has_its_motion_below_the_cells(page):
    terms = {name: 0.0 for name in [*LOSSES, *STORES]} | {"brake_front": 1.5, "battery_r0_heat": 0.2, "kinetic": -0.02}
    picture = page.run(f"({DRAW})({json.dumps(terms | {'battery_chemical': 1.68})}, 700)")
    at = {name: box for name, _, box in picture["labels"]}
    assert at["left in motion"][1] > at["cells"][3] and "−0.020 kWh" in str(picture["labels"])


def test_labels_that_do_lie_over_each_other_are_seen(page):
    page.run(f"({DRAW})({json.dumps(drawn_energies(random.Random(1)))}, 700)")
    boxes = page.run("""(() => { const parts = [...document.querySelectorAll('#drawn .flow-label')];
      parts[1].style.transform = parts[0].style.transform;
      return parts.map((part) => { const r = part.getBoundingClientRect();
                                   return [part.dataset.name, '', [r.left, r.top, r.right, r.bottom]]; }); })()""")
    assert overlaps(boxes)
