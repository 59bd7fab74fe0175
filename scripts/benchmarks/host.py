# SPDX-License-Identifier: MIT
"""What a figure was measured on: added to every JSON file of a benchmark run."""
import datetime
import json
import os
import re
import subprocess
import sys


def output_of(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor():
    with open("/proc/cpuinfo") as file:
        text = file.read()
    name = re.search(r"model name\s*: (.*)", text)
    flags = re.search(r"flags\s*: (.*)", text)
    words = set(flags.group(1).split()) if flags else set()
    best = "avx512" if {"avx512f", "avx512vl", "avx512dq", "avx512bw"} <= words else (
        "avx2" if {"avx2", "fma"} <= words else "generic")
    return name.group(1) if name else os.uname().machine, best


def available_mib():
    with open("/proc/meminfo") as file:
        return int(re.search(r"MemAvailable:\s+(\d+)", file.read()).group(1)) // 1024


def context(build):
    """Processor, memory, compiler and version of the sources."""
    with open("/proc/meminfo") as file:
        memory = int(re.search(r"MemTotal:\s+(\d+)", file.read()).group(1)) / 2**20
    with open(os.path.join(build, "CMakeCache.txt")) as file:
        compiler = re.search(r"CMAKE_CXX_COMPILER:\w+=(.*)", file.read()).group(1)
    version = output_of(compiler, "--version").splitlines()
    commit = output_of("git", "rev-parse", "--short", "HEAD")
    if output_of("git", "status", "--porcelain", "--untracked-files=no"):
        commit += " with changes"
    name, best = processor()
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "processor": name,
        "instruction_set": os.environ.get("MSCOMP_INSTRUCTION_SET", best),
        "cores": len(os.sched_getaffinity(0)),
        "memory_gib": round(memory, 1),
        "load_before": [round(load, 2) for load in os.getloadavg()],
        "system": f"{os.uname().sysname} {os.uname().release}",
        "compiler": version[0] if version else compiler,
        "commit": commit,
    }


def write(path, value):
    """The whole file or none."""
    with open(path + ".new", "w") as file:
        json.dump(value, file, indent=1)
        file.write("\n")
    os.replace(path + ".new", path)


def main(build, paths):
    """Adds the context to files of Google Benchmark and takes out what names this machine."""
    for path in paths:
        with open(path) as file:
            value = json.load(file)
        found = value["context"]
        found.pop("host_name", None)
        found["executable"] = os.path.basename(found.get("executable", ""))
        found.update(context(build))
        write(path, value)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
