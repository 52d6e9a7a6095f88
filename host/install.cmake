# The installed package: the engine, its public headers, files for find_package and pkg-config,
# scenes. Included at the top, after all targets are complete.
include(CMakePackageConfigHelpers)
set(weft_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/weft")
set(weft_data_dir "${CMAKE_INSTALL_DATADIR}/weft")

install(TARGETS weft EXPORT weftTargets)
install(EXPORT weftTargets NAMESPACE weft:: DESTINATION "${weft_package_dir}")
# What a program includes, and what that needs. Kernels and elements are the engine's own.
file(GLOB weft_public_headers CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/include/weft/*.hpp")
install(FILES ${weft_public_headers} "${CMAKE_BINARY_DIR}/include/weft/version.hpp"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/weft")
foreach(header IN ITEMS core/assert core/hd core/ids core/span core/vec exec/device exec/memory_book)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES "${CMAKE_SOURCE_DIR}/include/weft/${header}.hpp"
          DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/weft/${folder}")
endforeach()
# Licences of what is compiled in or linked, as Debian and its relatives have them.
foreach(package IN ITEMS libeigen3-dev nlohmann-json3-dev libassimp-dev libembree-dev libtbb-dev
                         libpng-dev libexpat1-dev libcli11-dev libfmt-dev libcgal-dev libgmp-dev libjs-three libcpp-httplib-dev pybind11-dev)
  if(EXISTS "/usr/share/doc/${package}/copyright")
    install(FILES "/usr/share/doc/${package}/copyright" RENAME "${package}.txt"
            DESTINATION "${CMAKE_INSTALL_DOCDIR}/third_party")
  endif()
endforeach()
install(FILES LICENSE docs/third_party.md DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/scenes/" DESTINATION "${weft_data_dir}/scenes")
install(FILES "${CMAKE_SOURCE_DIR}/python/blender/weft_blender.py"
        DESTINATION "${weft_data_dir}/blender")
if(TARGET weft_io)
  install(TARGETS weft_io EXPORT weft-ioTargets)
  install(EXPORT weft-ioTargets NAMESPACE weft:: DESTINATION "${weft_package_dir}")
endif()
if(TARGET weft_app)
  install(TARGETS weft_app)
  if(NOT CMAKE_CROSSCOMPILING)
    set(weft_manual "${CMAKE_BINARY_DIR}/manual")
    install(FILES "${weft_manual}/weft"
            DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions")
    install(FILES "${weft_manual}/_weft" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/site-functions")
    install(FILES "${weft_manual}/weft.fish"
            DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d")
    install(FILES "${weft_manual}/weft.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
  endif()
endif()
configure_package_config_file(
  host/weftConfig.cmake.in "${CMAKE_BINARY_DIR}/weftConfig.cmake"
  INSTALL_DESTINATION "${weft_package_dir}" PATH_VARS weft_data_dir)
write_basic_package_version_file("${CMAKE_BINARY_DIR}/weftConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH weft_pc_up "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
if(weft_has_cuda)
  set(weft_pc_cuda " -L${CUDAToolkit_LIBRARY_DIR} -lcudart_static -ldl -lrt")
endif()
configure_file(host/weft.pc.in "${CMAKE_BINARY_DIR}/weft.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/weft.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
install(FILES "${CMAKE_BINARY_DIR}/weftConfig.cmake"
              "${CMAKE_BINARY_DIR}/weftConfigVersion.cmake"
        DESTINATION "${weft_package_dir}")
