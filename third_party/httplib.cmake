# cpp-httplib serves the page of `weft run --live`. Without it, the program says that --live is
# missing.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(WEFT_HTTPLIB QUIET IMPORTED_TARGET cpp-httplib)
endif()
if(NOT TARGET PkgConfig::WEFT_HTTPLIB)
  message(STATUS "*** cpp-httplib was not found (apt-get install libcpp-httplib-dev): THE PROGRAM "
                 "IS BUILT WITHOUT `weft run --live` ***")
endif()
