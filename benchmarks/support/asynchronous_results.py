"""What committed results of weft_bench_asynchronous say of the scenes of Ainsley et al. 2012.

A case is called SCENE_HOW. Durations of runs that were sampled are extrapolated.
"""

from fnmatch import fnmatchcase

# Scene as files name it, and what Ainsley et al. 2012 have for it on one thread: no slabs, all of
# it [min], and all of it on 12 threads. Their eta(1) is not published: thin_two_cloths is two_cloths
# with that of the knots.
PAPER = (
    ("reef_knot", 74, 50.5, 5.8),
    ("bowline", 294, 121, 15.2),
    ("trash_compactor", 53.5, 13.3, 2.4),
    ("two_cloths", 402, 282, 40.1),
    ("thin_two_cloths", 402, 282, 40.1),
)
# A run that is extrapolated from fewer windows says nothing.
LEAST_WINDOWS = 200


def results(cases, pattern):
    """The cases whose names match, without parts of one."""
    return {name: cases[name] for name in sorted(cases)
            if fnmatchcase(name, pattern) and "_part_" not in name}


def samples(found):
    """Samples that say something, each with the result that it is of."""
    return [(result, sample) for result in found.values() for sample in result["samples"]
            if not sample["extrapolated"] or sample["windows"] >= LEAST_WINDOWS]


def minutes(sample):
    """What the run takes, and how that is known."""
    how = f" (extrapolated from {sample['windows']} windows)" if sample["extrapolated"] else ""
    cut = f", first {sample['simulated_s']:.3g} s" if sample["stopped_by_limit"] else ""
    return f"{sample['wall_s'] / 60:.3g} min{how}{cut}"


def pick(found, narrow, threads):
    """The whole run of that kind, else what was sampled of one; of runs that were cut the longest.
    None if there is none."""
    fitting = [(r, s) for r, s in samples(found)
               if s["narrow"] == narrow and s["threads"] == threads and s["failure"] == "none"
               and abs(s["window_s"] - 0.003) < 1e-9 and s["timed_steps"] > 0]
    return min(fitting, key=lambda rs: (rs[1]["stopped_by_limit"], rs[1]["extrapolated"],
                                        -rs[1]["simulated_s"]), default=None)
