include(CMakePackageConfigHelpers)

install(TARGETS psivox EXPORT psivoxTargets
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
  INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(TARGETS psivox_oiio LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(TARGETS psivox_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
install(DIRECTORY include/psivox DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(EXPORT psivoxTargets NAMESPACE psivox:: DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/psivox")
configure_package_config_file(cmake/psivoxConfig.cmake.in psivoxConfig.cmake
  INSTALL_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/psivox")
write_basic_package_version_file(psivoxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/psivoxConfig.cmake"
  "${PROJECT_BINARY_DIR}/psivoxConfigVersion.cmake"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/psivox")
