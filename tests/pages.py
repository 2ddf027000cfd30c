"""What the browser tests of all pages share."""

from playwright.sync_api import sync_playwright

# Milliseconds in which only what hangs does not come.
PATIENCE = 600_000


def listen(page, messages, schemes):
    """Console messages that `messages` picks, errors, and every address outside the file that the page asks for."""
    said = []
    page.on("console", lambda message: said.append(message.text) if messages(message) else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url) if not request.url.startswith(schemes) else None)
    return said


def fits(page, name):
    """The page is not wider than the window."""
    width = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert width <= 0, f"{name}: the page is {width} pixels wider than the window"


def in_all_windows(chromium, *checks):
    """Runs checks, each with a new page, in wide and narrow windows, light and dark."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"], timeout=PATIENCE)
        for width, scheme in [(1400, "light"), (400, "light"), (1400, "dark")]:
            context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
            context.set_default_timeout(PATIENCE)
            for check in checks:
                check(context.new_page(), f"{width}-{scheme}")
            context.close()
        browser.close()
