"""How long `import neurbs` takes beside `import numpy`: python benches/import_time.py."""

import subprocess
import sys
import time

RUNS = 25
PROGRAMS = {
    "python alone": "pass",
    "numpy": "import numpy",
    "neurbs": "import neurbs",
    "neurbs, used": "import neurbs; neurbs.reconstruct, neurbs.NurbsSurface, neurbs.read_points",
}


def main() -> None:
    """Print the best of some runs, each program in turn."""
    best = dict.fromkeys(PROGRAMS, float("inf"))
    for _ in range(RUNS):
        for name, program in PROGRAMS.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", program], check=True)
            best[name] = min(best[name], time.perf_counter() - start)
    numpy = best["numpy"] - best["python alone"]
    for name, seconds in best.items():
        own = seconds - best["python alone"]
        print(f"{name:<14}{1e3 * seconds:7.1f} ms{own / numpy:8.2f} × numpy's own")


if __name__ == "__main__":
    main()
