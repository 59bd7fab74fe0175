# SPDX-License-Identifier: MIT
"""Writes the generated part of docs/benchmarks.md and the plots from the JSON files of a run."""
import argparse
import json
import os
import statistics

import plot

BEGIN, END = "<!-- generated: begin -->", "<!-- generated: end -->"
SETS = ("generic", "avx2", "avx512")
BASES = ("PyTorch", "PyTorch, linear codes")


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows] + [""]


def number(value):
    if value >= 100:
        return f"{value:,.0f}"
    return f"{value:.1f}" if value >= 1 else f"{value:.2g}"


def measured_on(context):
    if "processor" not in context:
        return f"{context['num_cpus']} processors, {context['date'][:10]}"  # an earlier file
    text = (f"{context['processor']}, {context['cores']} cores, {context['memory_gib']:.0f} GiB, "
            f"{context['instruction_set']} kernels, {context['compiler']}, {context['date'][:10]}, "
            f"commit {context['commit']}, load before {context['load_before'][0]}")
    return text + (f", PyTorch {context['pytorch']}" if context.get("pytorch") else "")


class Steps:
    """The runs of step.json by kind, size, threads and program."""

    def __init__(self, value):
        self.value = value
        self.good = [r for r in value["runs"] if "failed" not in r]
        self.failed = [r for r in value["runs"] if "failed" in r]

    def compared(self):
        keys = []
        for run in self.value["runs"]:
            key = (run["kind"], run["vertices"], run["shapes"], run["threads"])
            if run["purpose"] == "compare" and key not in keys:
                keys.append(key)
        return keys

    def of(self, key, program):
        """{round: run} of one program."""
        return {r["round"]: r for r in self.good if r["purpose"] == "compare" and
                (r["kind"], r["vertices"], r["shapes"], r["threads"]) == key and
                r["program"] == program}

    def programs(self, kind):
        return list(dict.fromkeys(r["program"] for r in self.good
                                  if r["kind"] == kind and r["purpose"] == "compare"))

    def ratio(self, key, ours, theirs):
        """theirs / ours, round by round: median and range; None without common rounds."""
        a, b = self.of(key, ours), self.of(key, theirs)
        ratios = [b[i]["median_ms"] / a[i]["median_ms"] for i in a if i in b]
        return (statistics.median(ratios), min(ratios), max(ratios)) if ratios else None

    def fastest_of_each_size(self):
        """{(kind, V, N, threads): run} of the scaling runs."""
        return {(r["kind"], r["vertices"], r["shapes"], r["threads"]): r
                for r in self.good if r["purpose"] == "scale"}


def ratio_text(ratio):
    return "–" if ratio is None else f"**{ratio[0]:.1f}×** ({ratio[1]:.1f}–{ratio[2]:.1f})"


def comparison(steps):
    rows = []
    bases = [b for b in BASES if any(r["program"] == b for r in steps.good)]
    for key in steps.compared():
        kind, vertices, shapes, threads = key
        for program in steps.programs(kind):
            runs = steps.of(key, program).values()
            if not runs:
                continue
            ours = program not in BASES
            rows.append([kind, f"{vertices:,} × {shapes}", str(threads), program,
                         number(statistics.median(r["median_ms"] for r in runs)),
                         *[ratio_text(steps.ratio(key, program, base)) if ours else ""
                           for base in bases],
                         number(max(r["peak_mib"] for r in runs))])
    return [] if not rows else ["### A step beside PyTorch's", ""] + table(
        ["model", "V × N", "threads", "program", "ms",
         *[f"faster than {base}" for base in bases], "peak MiB"], rows)


def scaling(steps):
    runs = steps.fastest_of_each_size()
    rows = []
    for (kind, vertices, shapes, threads), one in sorted(runs.items()):
        if threads != 1:
            continue
        two = runs.get((kind, vertices, shapes, 2))
        base = runs.get((kind, 5023, shapes, 1))
        per = one["median_ms"] / vertices
        rows.append([kind, f"{vertices:,}", str(shapes), number(one["median_ms"]),
                     number(two["median_ms"]) if two else "–",
                     f"{one['median_ms'] / two['median_ms']:.2f}×" if two else "–",
                     f"{1e6 * per / shapes:.0f}",
                     f"{per / (base['median_ms'] / 5023):.2f}" if base else "–",
                     f"{100 * one['touched']:.0f} %" if "touched" in one else "–",
                     number(one["adapt_ms"]) if "adapt_ms" in one else "–",
                     number(one["start_ms"]) if "start_ms" in one else "–",
                     number(max(one["peak_mib"], two["peak_mib"] if two else 0))])
    return [] if not rows else ["### A step against the size", ""] + table(
        ["model", "V", "N", "ms, 1 thread", "2 threads", "second thread gives",
         "ns per vertex and shape", "cost per vertex, V = 5,023 is 1", "touched",
         "adapting, ms", "start, ms", "peak MiB"],
        rows)


def disturbed(steps):
    """A process that computes all the time and gets less than a whole processor was not alone."""
    count = sum(r.get("processors_used", 1) < 0.9 for r in steps.good)
    return [f"**{count} of {len(steps.good)} runs got less than 0.9 of a processor: something else "
            "was running, and their figures are worth little.**", ""] if count else []


def failures(steps):
    if not steps.failed:
        return []
    return ["Not measured:", ""] + [
        f"* {r['kind']}, V {r['vertices']:,}, N {r['shapes']}, {r['threads']} thread(s), "
        f"{r['program']}: {r['failed']}" for r in steps.failed] + [""]


def plots(steps, folder):
    """Writes the plots that there are at least two points for; returns their names and titles."""
    runs = steps.fastest_of_each_size()
    made = []

    def add(name, title, x_label, y_label, key, value, fixed):
        series = {}
        for (kind, vertices, shapes, threads), run in runs.items():
            sizes = {"V": vertices, "N": shapes}
            other = "N" if key == "V" else "V"
            if fixed is not None and sizes[other] != fixed:
                continue
            label = f"{kind}, " + (f"{other} = {sizes[other]:,}, " if fixed is None else "")
            series.setdefault(f"{label}{threads} thread{'s' * (threads > 1)}",
                              []).append((sizes[key], run[value]))
        series = {label: line for label, line in series.items() if len(line) > 1}
        if series:
            with open(os.path.join(folder, name), "w") as file:
                file.write(plot.line_plot(title, x_label, y_label, series))
            made.append((name, title))

    add("step-vertices.svg", "A step against the number of vertices, 36 shapes", "vertices V",
        "ms per step", "V", "median_ms", 36)
    add("step-shapes.svg", "A step against the number of shapes, 12,500 vertices", "shapes N",
        "ms per step", "N", "median_ms", 12500)
    add("memory-vertices.svg", "Peak memory against the number of vertices, 36 shapes",
        "vertices V", "MiB", "V", "peak_mib", 36)
    return made


def kernels(value):
    """One row per kernel: its plain loop, and each instruction set beside it."""
    runs = {}
    for run in of_repetitions(value["benchmarks"]):
        _, kernel, which = run["run_name"].split("/")[:3]
        runs.setdefault(kernel, {})[which] = run
    present = [s for s in SETS if any(s in r for r in runs.values())]
    rows = []
    for kernel, by_set in runs.items():
        plain = by_set["plain"]["cpu_time"]
        best = by_set[present[-1]] if present[-1] in by_set else by_set["plain"]
        rows.append([f"`{kernel}`", number(plain),
                     *[f"{plain / by_set[s]['cpu_time']:.1f}×" if s in by_set and
                       "cpu_time" in by_set[s] else "–" for s in present],
                     number(best.get("flops", 0) / 1e9), number(best.get("bytes", 0) / 1e9)])
    return ["### Kernels beside their plain loops, one thread", ""] + table(
        ["kernel", "plain loop, µs", *present, f"GFLOP/s, {present[-1]}",
         f"GB/s, {present[-1]}"], rows)


# What Google Benchmark itself writes; all else are counters of the case.
OWN_KEYS = ("cpu_time", "family_index", "iterations", "per_family_instance_index", "real_time",
            "repetition_index", "repetitions", "threads", "items_per_second", "bytes_per_second")


def of_repetitions(runs):
    """One entry per case: the median where a case was repeated."""
    medians = {run["run_name"] for run in runs if run.get("aggregate_name") == "median"}
    return [run for run in runs if not run.get("error_occurred") and
            run.get("aggregate_name") == ("median" if run["run_name"] in medians else None)]


def duration(value, unit):
    value *= {"ns": 1e-6, "us": 1e-3, "ms": 1, "s": 1e3}[unit]
    if value >= 1e4:
        return f"{number(value / 1e3)} s"
    return f"{number(value)} ms" if value >= 0.1 else f"{number(value * 1e3)} µs"


def listing(name, value):
    rows = []
    for run in of_repetitions(value["benchmarks"]):
        counters = [f"{key} {number(found)}" for key, found in run.items()
                    if isinstance(found, (int, float)) and key not in OWN_KEYS]
        rows.append([run["run_name"], duration(run["real_time"], run["time_unit"]),
                     duration(run["cpu_time"], run["time_unit"]), ", ".join(counters)])
    title = f"### `docs/benchmarks/{name}.json`"
    return [title, "", f"Measured on: {measured_on(value['context'])}.", ""] + table(
        ["case", "time", "processor time of the caller", "its own figures"], rows)


def read(folder, name):
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return None
    with open(path) as file:
        return json.load(file)


def generated(folder, others, images):
    lines = []
    value = read(folder, "step.json")
    if value and "runs" in value:
        steps = Steps(value)
        lines += [f"Measured on: {measured_on(value['context'])}.", ""]
        lines += disturbed(steps) + comparison(steps) + scaling(steps) + failures(steps)
        lines += [f"![{title}]({images}{name})\n" for name, title in plots(steps, folder)]
    value = read(folder, "kernels.json")
    if value:
        lines += kernels(value)
    for name in others:
        value = read(folder, name + ".json")
        if value and value.get("benchmarks"):
            lines += listing(name, value)
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--page", required=True, help="the page to begin with")
    parser.add_argument("--to", required=True, help="where it is written")
    parser.add_argument("--out", required=True, help="folder of the JSON files")
    parser.add_argument("others", nargs="*", help="further JSON files, listed as they are")
    options = parser.parse_args()
    with open(options.page) as file:
        text = file.read()
    head, rest = text.split(BEGIN, 1)
    tail = rest.split(END, 1)[1]
    images = os.path.relpath(options.out, os.path.dirname(os.path.abspath(options.to))) + "/"
    lines = generated(options.out, options.others, images)
    with open(options.to, "w") as file:
        file.write("\n".join([head + BEGIN, ""] + lines + [END]) + tail)


if __name__ == "__main__":
    main()
