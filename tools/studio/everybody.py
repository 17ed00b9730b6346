"""The page is for everybody: contrast, names, width, the keyboard alone, no motion."""

from .page import expect

LEAST_CONTRAST = 4.5
# Texts that are too pale for the page they stand on, by WCAG's formula.
PALE = """(() => {
  const rgb = text => (text.match(/[0-9.]+/g) || []).map(Number);
  const light = c => c.slice(0, 3).map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = e => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor);
    if (c.length === 3 || c[3] > 0.5) return c; } return [255, 255, 255]; };
  const pale = [];
  // A number in the decision space stands on its bar.
  const over = e => { const bar = e.closest('td')?.querySelector('i'), below = ground(e); if (!bar) return below;
    const [c, share] = [rgb(getComputedStyle(bar).backgroundColor), Number(getComputedStyle(bar).opacity)];
    return below.slice(0, 3).map((v, i) => share * c[i] + (1 - share) * v); };
  const judge = (e, front, back, least, words) => { const [a, b] = [light(front), light(back)];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < least) pale.push(`${contrast.toFixed(1)} ${e.tagName} ${words}`); };
  for (const e of document.querySelectorAll('main:not([hidden]) *, header *, footer *')) {
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    const style = getComputedStyle(e);
    if (own && !e.closest('canvas, :disabled, .hidden, title') && e.getClientRects().length)
      judge(e, rgb(e.closest('svg') ? style.fill : style.color), over(e), LEAST, e.textContent.trim().slice(0, 30));
    // The edge of what can be operated is as important as a text is.
    if (e.matches('button, select') && !e.disabled && e.getClientRects().length && parseFloat(style.borderTopWidth) > 0 && rgb(style.borderTopColor)[3] !== 0)
      judge(e, rgb(style.borderTopColor), ground(e.parentElement), 3, 'edge');
  }
  return [...new Set(pale)].slice(0, 8);
})()""".replace("LEAST", str(LEAST_CONTRAST))
# Controls that nobody can name who cannot see them.
NAMELESS = """[...document.querySelectorAll('button, select, input, canvas')].filter(e => e.getClientRects().length)
  .filter(e => !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length))
  .map(e => e.outerHTML.slice(0, 60))"""


def operable(page):
    """With the Tab key alone one comes to every control and sees where one is; whoever wants no motion gets none."""
    page.ask("(scrollTo(0, 0), document.activeElement.blur())")
    controls = """[...document.querySelectorAll('button, select, input, canvas[tabindex]')].filter(e =>
      e.getClientRects().length && !e.disabled && e.tabIndex >= 0)"""
    page.ask("window.reached = new Set(), window.unseen = []")
    for _ in range(page.ask(f"{controls}.length") + 3):
        page.key("Tab")
        page.ask("""(e => { reached.add(e); const s = getComputedStyle(e);
          if (e !== document.body && (s.outlineStyle === 'none' || parseFloat(s.outlineWidth) < 2)) unseen.push(e.id || e.textContent); })
          (document.activeElement)""")
    missed = page.ask(f"{controls}.filter(e => !reached.has(e)).map(e => e.id || e.textContent || e.outerHTML.slice(0, 60))")
    expect(not missed, f"the Tab key does not come to {missed}")
    expect(not page.ask("unseen"), f"focus cannot be seen on {page.ask('unseen')}")
    page.ask("document.activeElement.blur()")
    page.scheme("light", "reduce")
    before = page.ask("[studio.stats.frames, studio.where(0)]")
    page.key(".")
    page.until(f"studio.stats.frames > {before[0]}", "a step without motion")
    jumped = page.ask("studio.where(0)")
    expect(jumped != before[1] and jumped == page.ask("new Promise(done => setTimeout(() => done(studio.where(0)), 120))"),
           "the car is at once where it goes")
    page.scheme("light")


def look_closely(page, scheme):
    """Contrast, names, width: the page is for everybody."""
    page.scheme(scheme)
    for tab in ("curves", "stage"):
        page.click(f"#tab-{tab}")
        pale, nameless = page.ask(PALE), page.ask(NAMELESS)
        expect(not pale, f"{scheme} {tab}: too pale: {pale}")
        expect(not nameless, f"{scheme} {tab}: without a name: {nameless}")
    for width in (1440, 1024, 768):
        page.size(width, 900)
        wide = page.ask("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        expect(wide <= 0, f"at {width} pixels the page is {wide} too wide")
    page.size(1440, 900)
