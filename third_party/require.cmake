# weft_require(<target> <Debian package> <find_package arguments>...)
#
# Finds a dependency and stops with the name of the package to install if it is missing.
macro(weft_require target package name)
  find_package(${name} ${ARGN} QUIET)
  if(NOT TARGET ${target})
    message(FATAL_ERROR "${name} was not found. Install it (apt-get install ${package}), or let "
                        "'./dev setup' install everything that the build needs.")
  endif()
endmacro()
