# Text output of the program and of the benchmarks.
weft_require(fmt::fmt libfmt-dev fmt CONFIG)
