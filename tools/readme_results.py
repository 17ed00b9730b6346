#!/usr/bin/env python3
"""Writes the table and the picture between the README's markers from the folder of a finished run.

Usage: python3 tools/readme_results.py runs/reproduce
"""
import json
import pathlib
import shutil
import sys

ROWS = [
    ("acl", "**Attention control** (default: counterfactual policy iteration)", "acl"),
    ("acl_phase3", "Attention control by the paper's Phase III, over readings", "acl"),
    ("acl_decision", "Phase III in the paper's decision space", None),
    ("acl_paper", "Phase III as printed, Gaussians", None),
    ("foa", "Full observer (all of vision)", "foa"),
    ("fusion", "Fusion of everybody, Eq. (7)", "fusion"),
    ("best_fixed", "Best fixed choice of sensors, same recipe", None),
    ("blind", "Best constant action, no look", None),
    ("oracle", "Scripted expert with ground truth", None),
]
SCENARIOS = ["free_road", "approaching", "from_behind"]
PICTURE = "look_map-1.svg"


def minus(text):
    return text.replace("-", "\u2212")


def cell(estimate):
    text = f"{estimate['mean']:.1f}"
    if estimate["lo"] is not None:
        text += f" [{estimate['lo']:.1f}, {estimate['hi']:.1f}]"
    return minus(text)


def printed(paper, policy):
    if policy is None:
        return "\u2013"
    return minus(" / ".join(f"{paper['table2'][policy][s]['total']:.1f}" for s in SCENARIOS))


def table(results):
    lines = [
        "| total cost per motor step | free road | car approaching | nearing a car | looks | accidents | paper |",
        "|---|---|---|---|---|---|---|",
    ]
    for policy, name, paper in ROWS:
        cells = results["policies"][policy]
        if policy == "best_fixed":
            name += f" ({results['best_fixed'].removeprefix('fixed:')})"
        row = [name] + [cell(cells[s]["total"]) for s in SCENARIOS]
        accidents = "{:.0f} %".format(100 * sum(cells[s]["accident_rate"]["mean"] for s in SCENARIOS) / 3)
        row += [f"{cells['mix']['looks']['mean']:.1f}", accidents, printed(results["paper"], paper)]
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines)


def ratio(results, key):
    r = results["ratios"][key]
    return f"{r['mean']:.2f} [{r['lo']:.2f}, {r['hi']:.2f}]"


def text(results):
    return f"""{table(results)}

Mean of {results['seeds']} trainings with the 95 % interval over trainings; paper: its Table 2, free road / approaching / nearing.
Attention control costs {ratio(results, 'acl/foa')} times the full observer (paper 0.72) and {ratio(results, 'acl/fusion')} times
fusion (paper 0.60), on test roads {ratio(results, 'acl/foa@test')} and {ratio(results, 'acl/fusion@test')}. What the paper did not
ask: against the best fixed choice of sensors (by the same recipe; "/2" is looked at at every second step only) it costs
{ratio(results, 'acl/best_fixed')} times as much, on test roads {ratio(results, 'acl/best_fixed@test')}: whether looking where it
matters pays against always looking at the same place is [the next question](docs/results/attention.md). The paper's own
Phase III with the same sensors costs {ratio(results, 'acl_phase3/foa')} times the full observer.

![Where the trained mind looks on the training road, by the number of looks](docs/images/{PICTURE})"""


def main():
    run = pathlib.Path(sys.argv[1])
    root = pathlib.Path(__file__).resolve().parent.parent
    results = json.loads((run / "results.json").read_text())
    readme = root / "README.md"
    before, rest = readme.read_text().split("<!-- results:begin -->\n")
    after = rest.split("<!-- results:end -->")[1]
    body = f"<!-- results:begin -->\n{text(results)}\n<!-- results:end -->"
    readme.write_text(before + body + after)
    shutil.copy(run / "figures" / PICTURE, root / "docs" / "images" / PICTURE)


if __name__ == "__main__":
    main()
