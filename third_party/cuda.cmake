# Option WEFT_CUDA: on where a CUDA toolkit works, also one in /usr/local/cuda that is not on PATH.
# Included before any target exists, at the top, because it enables the language.
if(NOT DEFINED CMAKE_CUDA_COMPILER AND NOT DEFINED ENV{CUDACXX})
  find_program(WEFT_NVCC nvcc HINTS ENV CUDA_PATH ENV CUDA_HOME PATHS /usr/local/cuda
               PATH_SUFFIXES bin)
  mark_as_advanced(WEFT_NVCC)
  if(WEFT_NVCC)
    set(ENV{CUDACXX} "${WEFT_NVCC}")
  endif()
endif()

if(NOT DEFINED WEFT_CUDA)
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    set(weft_cuda_default ON)
  else()
    set(weft_cuda_default OFF)
    message(STATUS "CUDA: no toolkit found, left out (WEFT_CUDA=OFF)")
  endif()
endif()
option(WEFT_CUDA "Build the CUDA kernels" ${weft_cuda_default})

if(WEFT_CUDA)
  # Unless the user says otherwise, a release runs on A100, RTX 30, RTX 40, H100 and RTX 50. PTX of
  # 9.0 is there for 10.x, and that of 12.0 for what comes after. Other builds are for one GPU.
  set(weft_choose_architectures OFF)
  if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES AND NOT DEFINED ENV{CUDAARCHS})
    set(weft_choose_architectures ON)
    set(CMAKE_CUDA_ARCHITECTURES 90)  # to try the compiler, whose version is not known yet
  endif()
  enable_language(CUDA)
  if(weft_choose_architectures)
    unset(CMAKE_CUDA_ARCHITECTURES)
    set(weft_architectures 90)
    if(CMAKE_BUILD_TYPE STREQUAL "Release" OR weft_multi_config)
      set(weft_architectures 80-real 86-real 89-real 90)
      if(CMAKE_CUDA_COMPILER_VERSION VERSION_GREATER_EQUAL 12.8)
        list(APPEND weft_architectures 120)
      endif()
    endif()
    set(CMAKE_CUDA_ARCHITECTURES "${weft_architectures}" CACHE STRING "GPU architectures to compile for"
        FORCE)
  endif()
  # CMake 3.25 does not know yet that nvcc 12 takes C++20.
  if(CMAKE_CUDA_COMPILER_ID STREQUAL "NVIDIA" AND NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
    set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
  endif()
  find_package(CUDAToolkit REQUIRED)
  message(STATUS "CUDA: ${CMAKE_CUDA_COMPILER_VERSION}, architectures ${CMAKE_CUDA_ARCHITECTURES}")
endif()
