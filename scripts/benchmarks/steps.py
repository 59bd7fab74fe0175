# SPDX-License-Identifier: MIT
"""Times training steps, one configuration per process, in turn with PyTorch where there is a script
for it: ours, PyTorch, ours, PyTorch ... so that a machine that gets slower does so for both.
Writes step.json; scripts/bench.sh calls this."""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import host

LEVELS = "act_z='tanh', act_f='tanh'"  # what the PyTorch step puts around codes and decoded features
# The environment in which PyTorch is fastest; the first two where the processor has AVX-512.
WIDE = {"ATEN_CPU_CAPABILITY": "avx512", "OPENBLAS_CORETYPE": "SkylakeX"}
KEEP_MEMORY = {"MALLOC_MMAP_THRESHOLD_": "17179869184", "MALLOC_TRIM_THRESHOLD_": "17179869184",
               "MALLOC_TOP_PAD_": "1073741824"}
SECONDS = 1800  # of one configuration


def last_to_be_spared():
    """If memory runs out, this process is the one to end."""
    with open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, environment):
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS,
                              env={**os.environ, **environment}, preexec_fn=last_to_be_spared)
    except subprocess.TimeoutExpired:
        return None, f"not done after {SECONDS} s"
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return None, f"ended with {done.returncode}: {reason}"
    return done.stdout, ""


class Ours:
    """A benchmark whose names have the parts of `model`, vertices:V, shapes:N and threads:T."""

    def __init__(self, program, model, label):
        self.program, self.model, self.label = program, set(model.split("/")), label
        names = host.output_of(program, "--large", "--benchmark_list_tests").splitlines()
        self.names = {name: set(name.split("/")) for name in names}

    def time(self, vertices, shapes, threads):
        parts = self.model | {f"vertices:{vertices}", f"shapes:{shapes}", f"threads:{threads}"}
        names = [name for name, has in self.names.items() if parts <= has]
        if len(names) != 1:
            return None, f"{len(names)} benchmarks have {'/'.join(sorted(parts))}"
        text, why = run([self.program, "--large", f"--benchmark_filter=^{names[0]}$",
                         "--benchmark_format=json"], {"GOMP_SPINCOUNT": "20000"})
        if text is None:
            return None, why
        found = json.loads(text).get("benchmarks", []) if text.strip() else []
        if len(found) != 1:
            return None, f"{len(found)} results of {names[0]}"
        result = found[0]
        if result.get("error_occurred"):
            return None, result["error_message"]
        keys = ("median_ms", "min_ms", "passes_ms", "update_ms", "start_ms",
                "adapt_ms", "touched", "peak_mib")
        return {key: round(result[key], 3) for key in keys if key in result}, ""


class PyTorch:
    def __init__(self, python, script, model, folder, label):
        self.python, self.script, self.model = python, script, model
        self.folder, self.label = folder, label

    def time(self, vertices, shapes, threads):
        need = 1000 + 6e-3 * vertices * shapes  # MiB
        if host.available_mib() < need:
            return None, f"left out: needs about {need:.0f} MiB"
        wide = WIDE if host.processor()[1] == "avx512" else {}
        text, why = run([self.python, self.script, "--model", self.model, "--V", str(vertices),
                         "--B", str(shapes), "--threads", str(threads), "--steps", "5"],
                        {**wide, **KEEP_MEMORY, "PYTHONPATH": self.folder,
                         "PYTHONDONTWRITEBYTECODE": "1"})
        if text is None:
            return None, why
        result = json.loads(text.strip().splitlines()[-1])
        return {"median_ms": result["step_ms"], "min_ms": result["min_ms"],
                "passes_ms": round(result["fwd_ms"] + result["bwd_ms"], 3),
                "update_ms": result["adam_ms"], "peak_mib": result["peak_rss_MiB"]}, ""


def pytorch_programs(options, scratch):
    """The step as it is, and that without tanh of codes and decoded features, as ours is."""
    if not options.torch:
        return []
    folder = os.path.dirname(os.path.abspath(options.torch))
    make = lambda script, model, label: PyTorch(options.python, script, model, folder, label)
    programs = [("stacked", make(options.torch, "A", "PyTorch"))]
    with open(options.torch) as file:
        text = file.read()
    if LEVELS in text:
        plain = os.path.join(scratch, "linear_codes.py")
        with open(plain, "w") as file:
            file.write(text.replace(LEVELS, LEVELS.replace("tanh", "none")))
        programs.append(("stacked", make(plain, "A", "PyTorch, linear codes")))
    programs.append(("vae", make(options.torch, "B", "PyTorch")))
    return programs


def our_programs(bin_folder):
    stacked = os.path.join(bin_folder, "step_bench")
    programs = [
        ("stacked", Ours(stacked, "model:default/start:deflation", "mscomp")),
        ("stacked", Ours(stacked, "model:default/start:random",
                         "mscomp, random start")),
        ("stacked", Ours(stacked, "model:pytorch/start:random",
                         "mscomp, PyTorch's model")),
    ]
    spectral = os.path.join(bin_folder, "spectral_step_bench")
    if os.path.exists(spectral):
        programs += [("vae", Ours(spectral, "model:default", "mscomp")),
                     ("vae", Ours(spectral, "model:pytorch",
                                  "mscomp, PyTorch's model"))]
    return programs


def sizes_to_compare(options):
    if options.quick:
        return {"stacked": [(2000, 36)], "vae": [(2000, 36)]}
    return {"stacked": [(12500, 36), (5023, 256)], "vae": [(12500, 36)]}


def sizes_to_scale(options):
    """(V, N) of ours alone: step time and memory against either."""
    if options.quick:
        return {"stacked": [(2000, 36), (5023, 36)]}
    vertices = (2000, 5023, 12500, 50000) + ((200000, 1000000) if options.large else ())
    sizes = [(v, n) for n in (20, 36) for v in vertices]
    more = [(12500, n) for n in (72, 144, 256)] + [(50000, 256)]
    return {"stacked": sizes + more, "vae": [(v, 36) for v in vertices[:4]]}


class Record:
    def __init__(self, path, options):
        self.path = path
        self.value = {"context": host.context(options.build), "rounds": options.rounds, "runs": []}
        if options.torch:
            self.value["context"]["pytorch"] = host.output_of(
                options.python, "-c", "import torch; print(torch.__version__)")

    def time(self, kind, program, size, threads, number, purpose):
        begin, used = time.monotonic(), processor_seconds()
        result, why = program.time(*size, threads)
        share = (processor_seconds() - used) / (time.monotonic() - begin)
        run = {"purpose": purpose, "kind": kind, "program": program.label, "vertices": size[0],
               "shapes": size[1], "threads": threads, "round": number,
               "processors_used": round(share, 2)}
        run.update(result if result is not None else {"failed": why})
        self.value["runs"].append(run)
        host.write(self.path, self.value)  # what is measured stays, whatever comes
        said = f"{result['median_ms']:.1f} ms, {result['peak_mib']:.0f} MiB" if result else why
        print(f"bench: {kind}, V {size[0]}, N {size[1]}, {threads} thread(s), {program.label}: "
              f"{said}", file=sys.stderr, flush=True)
        return result is not None


def compare(options, record, ours, theirs):
    for kind, sizes in sizes_to_compare(options).items():
        programs = [p for k, p in ours + theirs if k == kind]
        for size in sizes:
            for threads in (1, 2):
                broken = set()
                for number in range(options.rounds):
                    for program in programs:
                        if program not in broken and not record.time(kind, program, size, threads,
                                                                     number, "compare"):
                            broken.add(program)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("--torch")
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--large", action="store_true")
    options = parser.parse_args()
    record = Record(os.path.join(options.out, "step.json"), options)
    ours = our_programs(os.path.join(options.build, "bin"))
    with tempfile.TemporaryDirectory() as scratch:
        compare(options, record, ours, pytorch_programs(options, scratch))
    for kind, sizes in sizes_to_scale(options).items():
        for program in [p for k, p in ours if k == kind][:1]:
            for size in sizes:
                for threads in (1, 2):
                    record.time(kind, program, size, threads, 0, "scale")


if __name__ == "__main__":
    main()
