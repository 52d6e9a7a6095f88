# The installed package: the engine, files for find_package, scenes. Included at the top, after all
# targets are complete.
include(CMakePackageConfigHelpers)
set(weft_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/weft")
set(weft_data_dir "${CMAKE_INSTALL_DATADIR}/weft")

install(TARGETS weft EXPORT weftTargets)
install(EXPORT weftTargets NAMESPACE weft:: DESTINATION "${weft_package_dir}")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/include/weft" "${CMAKE_BINARY_DIR}/include/weft"
        DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY "${CMAKE_SOURCE_DIR}/scenes/" DESTINATION "${weft_data_dir}/scenes")
if(TARGET weft_io)
  install(TARGETS weft_io EXPORT weft-ioTargets)
  install(EXPORT weft-ioTargets NAMESPACE weft:: DESTINATION "${weft_package_dir}")
endif()
if(TARGET weft_app)
  install(TARGETS weft_app)
endif()
configure_package_config_file(
  host/weftConfig.cmake.in "${CMAKE_BINARY_DIR}/weftConfig.cmake"
  INSTALL_DESTINATION "${weft_package_dir}" PATH_VARS weft_data_dir)
write_basic_package_version_file("${CMAKE_BINARY_DIR}/weftConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/weftConfig.cmake"
              "${CMAKE_BINARY_DIR}/weftConfigVersion.cmake"
        DESTINATION "${weft_package_dir}")
