"""Opens a report in a real browser and compares what it shows with the Parquet file.

Usage: browser.py CHROMIUM REPORT.html SURFACE.parquet [FOLDER for screenshots]
"""

import math
import re
import sys
from pathlib import Path

import pandas as pd
from playwright.sync_api import sync_playwright

chromium, report, surface, *screenshots = sys.argv[1:]
surface = pd.read_parquet(surface)
url = Path(report).resolve().as_uri()


def close(shown, expected):
    assert math.isclose(float(shown), expected, rel_tol=1e-4, abs_tol=1e-12), (shown, expected)


def numbers_of(text):
    """Expected values, P, interval and counts, as the page tells them."""
    found = re.search(r"P = (\S+) \(.*?interval: (\S+) to (\S+)\); (\d+) of (\d+) samples unstable", text)
    assert found, text
    return [float(number) for number in found.groups()]


def check_selected(page, rows):
    """The sentence below the map is that of one row."""
    text = page.inner_text("#selected")
    preload = float(re.search(r"Preload Δ = ([^,]+)", text).group(1))
    friction = float(re.search(r"fₛ = ([^,]+)", text).group(1))
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
    page.wait_for_timeout(400)


def check(page, name):
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url) if not request.url.startswith(("file:", "data:", "blob:")) else None)
    page.goto(url)
    page.wait_for_selector("#map .nsewdrag")
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, f"{name}: the page is {width} pixels wider than the window"
    overlap = page.evaluate(
        "document.getElementById('selected').getBoundingClientRect().top"
        " - document.querySelector('#map .main-svg').getBoundingClientRect().bottom"
    )
    assert overlap >= -1, f"{name}: the map covers {-overlap} pixels of the text below it"
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

    # What the mouse is over is told beside it.
    box = page.locator("#map .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector("#map .hovertext")
    hovered = page.locator("#map .hovertext").first.text_content()
    p, *_ = numbers_of(hovered)
    assert any(math.isclose(p, known, rel_tol=1e-4, abs_tol=1e-12) for known in rows.p_unstable), hovered

    # The table behind the picture has every number of it.
    page.click("#map-section summary")
    page.wait_for_selector("#numbers td")
    table = [row.split("\t") for row in page.inner_text("#numbers").splitlines()]
    frictions = [float(value) for value in table[0][1:]]
    assert len(table) - 1 == rows.preload.nunique() and len(frictions) == rows.static_friction.nunique()
    for preload, *shown in table[1:]:
        for friction, p in zip(frictions, shown):
            near = (rows.preload - float(preload)).abs() + (rows.static_friction - friction).abs()
            close(p, rows.loc[near.idxmin()].p_unstable)
    assert not said, said


with sync_playwright() as playwright:
    browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
    for width, scheme in [(1400, "light"), (400, "light"), (1400, "dark")]:
        context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        check(context.new_page(), f"{width}-{scheme}")
        context.close()
    browser.close()
print("report: mouse, keyboard, slider, hover and table show the numbers of the file at 1400 and 400 pixels")
