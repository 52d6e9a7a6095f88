# Headers only: the command line of the program and of the benchmarks.
weft_require(CLI11::CLI11 libcli11-dev CLI11 CONFIG)
