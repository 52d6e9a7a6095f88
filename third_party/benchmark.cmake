# Google Benchmark, for the kernels' benchmarks.
weft_require(benchmark::benchmark libbenchmark-dev benchmark CONFIG)
