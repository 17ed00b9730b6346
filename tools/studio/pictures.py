"""The pictures of the guide."""

PICTURE_SECONDS = 500
# Enough for a mind that is worth a picture.
PICTURE_BUDGETS = ["phase.fusion.budget.episodes=300", "phase.attention.budget.episodes=900"]


def photograph(page, pictures):
    """The pictures of the guide, light and dark: a trained mind that attends, and how it learned to."""
    page.click("#tab-curves")
    page.click("#train")
    page.until("[...document.getElementById('driver').options].some(o => o.text === 'ACL, trained here')",
               "attention control is trained", 400)
    page.click("#stop")
    page.until("document.getElementById('training-note').textContent.startsWith('stopped')", "the rest can wait")
    page.choose("phase", "attention")
    page.click("#tab-stage")
    page.choose("driver", page.ask("[...document.getElementById('driver').options].findIndex(o => o.text === 'ACL, trained here')"))
    page.choose("speed", "16")
    if page.ask("document.querySelector('#run .word').textContent === 'Run'"):
        page.click("#run")
    page.until("Number(document.getElementById('scrub').max) > 0 && Number(document.getElementById('scrub').value) > 500",
               "it drives", 120)
    page.click("#run")
    page.click("#scenes li:nth-child(4) button")
    page.until("document.querySelectorAll('#looks b').length > 0", "it looks")
    for scheme in ("light", "dark"):
        page.scheme(scheme, "reduce")
        for tab in ("stage", "curves"):
            page.size(1440, 900 if tab == "stage" else 1060)
            page.click(f"#tab-{tab}")
            page.ask("(scrollTo(0, 0), document.activeElement.blur(), new Promise(done => setTimeout(done, 2600)))")
            page.shoot(pictures / f"studio-{tab}-{scheme}.png")
