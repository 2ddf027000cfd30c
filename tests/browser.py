"""Opens a report in a real browser and compares what it shows with the Parquet file.

Usage: browser.py CHROMIUM REPORT.html SURFACE.parquet TWO.html FIRST.parquet DIFFERENCES.parquet [FOLDER for screenshots]

TWO.html is the report of two runs, of which the first has Sobol indices; DIFFERENCES.parquet is of `stickslip compare`.
"""

import math
import re
import sys
from pathlib import Path

import pandas as pd

from pages import fits, in_all_windows, listen

chromium, report, surface, two, first, differences, *screenshots = sys.argv[1:]
surface, first, differences = (pd.read_parquet(file) for file in (surface, first, differences))
url, url_of_two = (Path(file).resolve().as_uri() for file in (report, two))


def close(shown, expected):
    assert math.isclose(float(shown), expected, rel_tol=1e-4, abs_tol=1e-12), (shown, expected)


def numbers_of(text):
    """Expected values, P, interval and counts, as the page shows them."""
    found = re.search(r"P = ([\d.e-]+)\s*\(.*?interval: (\S+) to (\S+)\);\s*(\d+) of (\d+) samples unstable", text)
    assert found, text
    return [float(number) for number in found.groups()]


def check_selected(page, rows):
    """The sentence below the map is that of one row."""
    text = page.inner_text("#selected")
    preload = float(re.search(r"Preload Δ = ([^,]+)", text).group(1))
    friction = float(re.search(r"fs = ([^,]+)", text).group(1))
    near = (rows.preload - preload).abs() + (rows.static_friction - friction).abs()
    row = rows.loc[near.idxmin()]
    close(preload, row.preload)
    close(friction, row.static_friction)
    p, low, high, unstable, samples = numbers_of(text)
    close(p, row.p_unstable)
    close(low, row.p_low)
    close(high, row.p_high)
    assert (unstable, samples) == (row.n_unstable, row.n_samples), (text, row)
    return row


def click_on_map(page, right, up):
    """Clicks at a share of the width and the height of the map."""
    box = page.locator("#map .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + right * box["width"], box["y"] + (1 - up) * box["height"])
    page.mouse.down()
    page.mouse.up()
    # The page has dealt with it by now; a second click sooner would be a double click.
    page.wait_for_timeout(400)


# The boxes of parts of the plots on a page, as far as they are seen: left, top, right, bottom.
BOXES = """([plots, parts]) => [...document.querySelectorAll(plots)].filter((plot) => plot.offsetParent).map((plot) =>
  [...plot.querySelectorAll(parts)].filter((part) => part.textContent || !part.matches("text")).map((part) => {
    const box = part.getBoundingClientRect();
    return [box.left, box.top, box.right, box.bottom];
  }).filter(([left, top, right, bottom]) => left < right && top < bottom))"""


def check_room(page, name):
    """Nothing covers a plot, no label another one, and pictures have the size of their letters in any window."""

    def boxes(parts, plots=".plot.js-plotly-plot"):
        return page.evaluate(BOXES, [plots, parts])

    panels, bars, legends = boxes(".nsewdrag"), boxes(".modebar-group"), boxes(".legend .bg")
    assert panels and all(map(len, panels)) and all(map(len, bars)), (name, panels, bars)
    for [(_, top, _, bottom)], bar, legend in zip(panels, bars, legends):
        assert all(of[3] <= top + 1 for of in bar), f"{name}: a tool bar ends at {bar}, the plot begins at {top}"
        assert all(of[1] >= bottom for of in legend), f"{name}: a legend begins at {legend}, the plot ends at {bottom}"
    [labels] = boxes(".textpoint text", "#map")
    assert len(labels) > 1, (name, labels)
    for i, a in enumerate(labels):
        for b in labels[:i]:
            apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            assert apart, f"{name}: labels of lines at {a} and {b}"
    scales = page.evaluate(
        "[...document.querySelectorAll('.picture svg')].map((of) => of.getBoundingClientRect().width / of.viewBox.baseVal.width)"
    )
    assert all(scale > 0.99 for scale in scales), f"{name}: pictures are scaled by {scales}"


def listening(page):
    """What the page complains about or asks for; Plotly makes blobs."""
    return listen(page, lambda message: message.type in ("error", "warning"), ("file:", "data:", "blob:"))


def check(page, name):
    said = listening(page)
    page.goto(url)
    page.wait_for_selector("#map .nsewdrag")
    fits(page, name)
    overlap = page.evaluate(
        "document.getElementById('selected').getBoundingClientRect().top"
        " - document.querySelector('#map .main-svg').getBoundingClientRect().bottom"
    )
    assert overlap >= -1, f"{name}: the map covers {-overlap} pixels of the text below it"
    check_room(page, name)
    if screenshots:
        page.screenshot(path=f"{screenshots[0]}/{name}.png", full_page=True)

    # Another speed by its slider, then points by the mouse and by the keyboard.
    slider = page.locator("#controls input")
    assert slider.count() == 1
    slider.focus()
    page.keyboard.press("End")
    speed = surface.rotating_speed_rad_s.max()
    assert f"= {speed:g} rad/s" in page.inner_text("#controls output")
    rows = surface[surface.rotating_speed_rad_s == speed]
    check_selected(page, rows)
    seen = set()
    for right, up in [(0.2, 0.3), (0.8, 0.9), (0.95, 0.1)]:
        click_on_map(page, right, up)
        seen.add(check_selected(page, rows).name)
    assert len(seen) == 3, seen
    before = check_selected(page, rows)
    page.focus("#map")
    page.keyboard.press("ArrowUp")
    after = check_selected(page, rows)
    assert after.preload > before.preload and after.static_friction == before.static_friction

    # What the mouse is over is shown beside it.
    box = page.locator("#map .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector("#map .hovertext")
    hovered = page.locator("#map .hovertext").first.text_content()
    p, *_ = numbers_of(hovered)
    assert any(math.isclose(p, known, rel_tol=1e-4, abs_tol=1e-12) for known in rows.p_unstable), hovered

    # The table behind the picture has every number of it.
    page.click("#map-section summary")
    page.wait_for_selector("#map-section td")
    table = [row.split("\t") for row in page.inner_text("#map-section table").splitlines()]
    frictions = [float(value) for value in table[0][1:]]
    assert len(table) - 1 == rows.preload.nunique() and len(frictions) == rows.static_friction.nunique()
    for preload, *shown in table[1:]:
        for friction, p in zip(frictions, shown):
            near = (rows.preload - float(preload)).abs() + (rows.static_friction - friction).abs()
            close(p, rows.loc[near.idxmin()].p_unstable)
    assert not said, said


def nearest(rows, preload, friction):
    near = (rows.preload - float(preload)).abs() + (rows.static_friction - float(friction)).abs()
    return rows.loc[near.idxmin()]


def check_two(page, name):
    """Two runs: the difference of the second from the first, and the Sobol indices of the first."""
    said = listening(page)
    page.goto(url_of_two)
    page.wait_for_selector("#map .nsewdrag")
    fits(page, name)
    check_room(page, name)
    buttons = page.locator("#controls input[type=radio]")
    assert buttons.count() == 3
    assert page.locator("#along-horizontal .legendtext").all_text_contents() == ["drawn", "other"]

    click_on_map(page, 0.3, 0.6)
    preload, friction = re.search(r"Preload Δ = ([^,]+), .*fs = ([^,]+),", page.inner_text("#selected")).groups()
    row = nearest(first, preload, friction)
    page.click("#sensitivity-section summary")
    page.wait_for_selector("#sensitivity-section td")
    table = [line.split("\t") for line in page.inner_text("#sensitivity-section table").splitlines()]
    names = ["preload", "static_friction", "damping.tangential"]
    assert [line[0] for line in table[1:]] == ["Preload Δ", "Static friction coefficient fs", "Tangential damping of the pad cx"]
    for of, (_, *shown) in zip(names, table[1:]):
        for number, column in zip(shown, ["first_order_{}", "first_order_{}_error", "total_{}", "total_{}_error"]):
            close(number, row[column.format(of)])
    assert page.locator("#sensitivity .bars .point").count() == 6

    buttons.nth(2).check()
    page.locator("#sensitivity-section").wait_for(state="hidden")
    seen = set()
    for right, up in [(0.2, 0.3), (0.5, 0.5), (0.9, 0.9)]:
        click_on_map(page, right, up)
        text = page.inner_text("#selected")
        preload, friction = re.search(r"Preload Δ = ([^,]+), .*fs = ([^,]+),", text).groups()
        row = nearest(differences, preload, friction)
        shown = re.search(r"difference = (\S+) \(.*together: (\S+) to (\S+)\); P = (\S+) and (\S+)$", text).groups()
        for number, column in zip(shown, ["difference", "difference_low", "difference_high", "p_second", "p_first"]):
            close(number, row[column])
        seen.add(shown)
    assert len(seen) == 3, seen
    surely = ((differences.difference_low > 0).sum(), (differences.difference_high < 0).sum())
    answer = page.inner_text("#answer")
    found = re.search(r"is larger than that of drawn in (\d+), and smaller in (\d+)", answer)
    assert tuple(map(int, found.groups())) == surely and max(surely) > 0, (found, surely)
    strokes = page.locator("#map .scatterlayer .trace").first.locator("path.point").count()
    assert strokes == len(differences) - sum(surely), strokes
    if screenshots:
        page.screenshot(path=f"{screenshots[0]}/two-{name}.png", full_page=True)
    assert not said, said


in_all_windows(chromium, check, check_two)
print("reports: mouse, keyboard, slider, hover and tables show the numbers of the files at 1400 and 400 pixels")
