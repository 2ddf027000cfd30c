"""Opens the gallery of reproduced figures in a real browser.

Usage: gallery.py CHROMIUM gallery.html [FOLDER for screenshots]
"""

import sys
from pathlib import Path

from pages import fits, in_all_windows, listen

chromium, gallery, *screenshots = sys.argv[1:]
url = Path(gallery).resolve().as_uri()


def check(page, name):
    said = listen(page, lambda message: True, ("file:", "data:"))
    page.goto(url)
    fits(page, name)
    if screenshots:
        page.screenshot(path=f"{screenshots[0]}/gallery-{name}.png", full_page=True)

    # Every picture is large enough to be read, says what it shows, and has a text behind it that the keyboard opens.
    pictures = page.locator("figure svg[role=img]")
    assert pictures.count() == page.locator("figure").count() > 0
    for i in range(pictures.count()):
        picture = pictures.nth(i)
        assert len(picture.get_attribute("aria-label")) > 20
        box = picture.bounding_box()
        drawn = float(picture.get_attribute("viewBox").split()[2])
        assert box["width"] >= 0.75 * drawn, f"{name}: a picture is drawn at {box['width']} of {drawn} pixels"
    first = page.locator("figure").first
    first.locator("summary").focus()
    page.keyboard.press("Enter")
    assert "┤" in first.locator("pre").inner_text() or "|" in first.locator("pre").inner_text()

    # The text behind a picture does not make the page wider than the window.
    page.evaluate("document.querySelectorAll('details').forEach((details) => { details.open = true; })")
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, f"{name}: with all texts open the page is {width} pixels wider than the window"

    # Links lead to their sections.
    for link in page.locator("nav a").all():
        assert page.locator(link.get_attribute("href")).count() == 1

    def luminance(selector, what):
        colour = page.evaluate(f"getComputedStyle(document.querySelector('{selector}')).{what}")
        red, green, blue = [float(part) for part in colour[colour.index("(") + 1 : -1].split(",")[:3]]
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    is_dark = luminance("body", "backgroundColor") < 128
    assert is_dark == name.endswith("dark") and is_dark == (luminance("body", "color") > 128)

    page.emulate_media(media="print")
    assert page.locator("figure details pre").first.is_hidden(), "texts behind pictures are not printed"
    assert not said, said


in_all_windows(chromium, check)
print("gallery: read at 1400 and 400 pixels, light and dark, by keyboard and on paper")
