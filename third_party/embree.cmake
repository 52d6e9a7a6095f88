# Ray casting for previews. Debian 12 has Embree 3, Ubuntu 24.04 has Embree 4; the sources tell them
# apart by WEFT_EMBREE_MAJOR.
find_package(embree 4 CONFIG QUIET)
if(NOT TARGET embree)
  find_package(embree 3 CONFIG QUIET)
endif()
if(NOT TARGET embree)
  message(FATAL_ERROR "Embree 3 or 4 was not found. Install it (apt-get install libembree-dev), or "
                      "let './dev setup' install everything that the build needs.")
endif()
string(REGEX MATCH "^[0-9]+" WEFT_EMBREE_MAJOR "${embree_VERSION}")
message(STATUS "Embree: ${embree_VERSION}")
