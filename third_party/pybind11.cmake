# The Python package: pybind11, and the distribution's Python, which has NumPy and pytest.
set(Python_FIND_STRATEGY LOCATION)
if(NOT DEFINED Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 COMPONENTS Interpreter Development.Module)
if(NOT Python_FOUND)
  message(FATAL_ERROR "Python's headers were not found. Install them (apt-get install python3-dev), "
                      "or configure with -DWEFT_PYTHON_PACKAGE=OFF.")
endif()
weft_require(pybind11::module pybind11-dev pybind11 CONFIG)
