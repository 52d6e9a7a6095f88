# Only for Embree, which names it as a dependency.
weft_require(TBB::tbb libtbb-dev TBB COMPONENTS tbb)
