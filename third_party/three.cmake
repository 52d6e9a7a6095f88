# three.js draws the page of `weft view`. The build puts it into the program; without it, the
# program says that the page is missing.
find_file(WEFT_THREE three.min.js PATHS /usr/share/javascript/three NO_CMAKE_FIND_ROOT_PATH)
find_file(WEFT_THREE_ORBIT OrbitControls.js PATHS /usr/share/javascript/three/examples/js/controls
          NO_CMAKE_FIND_ROOT_PATH)
find_file(WEFT_THREE_NOTICE copyright PATHS /usr/share/doc/libjs-three NO_CMAKE_FIND_ROOT_PATH)
mark_as_advanced(WEFT_THREE WEFT_THREE_ORBIT WEFT_THREE_NOTICE)
set(weft_has_three FALSE)
if(WEFT_THREE AND WEFT_THREE_ORBIT AND WEFT_THREE_NOTICE)
  set(weft_has_three TRUE)
else()
  message(STATUS "*** three.js was not found (apt-get install libjs-three): THE PROGRAM IS BUILT "
                 "WITHOUT `weft view` ***")
endif()
