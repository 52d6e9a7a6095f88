# Headers only, and never in a public header: small dense solves and the tests' oracles.
weft_require(Eigen3::Eigen libeigen3-dev Eigen3 3.3 NO_MODULE)
