# Slices of time on MPI ranks (mpirun -n P weft run --method time_parallel); never required.
set(MPI_CXX_SKIP_MPICXX ON)
find_package(MPI QUIET COMPONENTS CXX)
set(weft_mpi_usual OFF)
if(MPI_CXX_FOUND)
  set(weft_mpi_usual ON)
endif()
option(WEFT_MPI "Let MPI ranks simulate slices of time" ${weft_mpi_usual})
if(WEFT_MPI AND NOT MPI_CXX_FOUND)
  message(FATAL_ERROR "WEFT_MPI is on and no MPI was found. Install one (apt-get install "
                      "libopenmpi-dev openmpi-bin), or leave WEFT_MPI off.")
endif()
