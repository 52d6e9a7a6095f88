# Exact intersection tests, for the independent check only (host/lab/check). Headers only, with GMP
# and MPFR behind them.
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)
weft_require(CGAL::CGAL libcgal-dev CGAL CONFIG)
