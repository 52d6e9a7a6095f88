# Exact arithmetic with C++ operators, for tests only. GMP comes without CMake files.
find_path(WEFT_GMPXX_INCLUDE_DIR gmpxx.h)
find_library(WEFT_GMP_LIBRARY gmp)
find_library(WEFT_GMPXX_LIBRARY gmpxx)
mark_as_advanced(WEFT_GMPXX_INCLUDE_DIR WEFT_GMP_LIBRARY WEFT_GMPXX_LIBRARY)
if(NOT WEFT_GMPXX_INCLUDE_DIR OR NOT WEFT_GMP_LIBRARY OR NOT WEFT_GMPXX_LIBRARY)
  message(FATAL_ERROR "GMP was not found. Install it (apt-get install libgmp-dev), or let "
                      "'./dev setup' install everything that the build needs.")
endif()
add_library(weft_gmp INTERFACE)
target_include_directories(weft_gmp SYSTEM INTERFACE "${WEFT_GMPXX_INCLUDE_DIR}")
target_link_libraries(weft_gmp INTERFACE "${WEFT_GMPXX_LIBRARY}" "${WEFT_GMP_LIBRARY}")
