# What is installed: the program, its manual pages and completions (psivox), what other programs
# build with (dev), and the Python module (python). cmake/Packages.cmake makes a Debian package of
# each.
include(CMakePackageConfigHelpers)

# pip installs the library within the Python package, and nothing else (pyproject.toml)
set(library_component psivox)
if(SKBUILD)
  set(library_component python)
endif()
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/psivox")
install(TARGETS psivox EXPORT psivoxTargets
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
    COMPONENT ${library_component} NAMELINK_COMPONENT dev
  INCLUDES DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
psivox_set_runpath("${CMAKE_INSTALL_LIBDIR}" ${library_component} psivox)
set(module_dir "${CMAKE_INSTALL_LIBDIR}/psivox")
foreach(module IN ITEMS psivox_reader psivox_oiio)
  if(TARGET ${module})
    install(TARGETS ${module}
      LIBRARY DESTINATION "${module_dir}" COMPONENT ${library_component})
    psivox_set_runpath("${module_dir}" ${library_component} ${module})
  endif()
endforeach()
foreach(mpi IN LISTS PSIVOX_MPIS)
  install(TARGETS psivox_${mpi} LIBRARY DESTINATION "${module_dir}" COMPONENT ${mpi})
  psivox_set_runpath("${module_dir}" ${mpi} psivox_${mpi})
endforeach()
install(TARGETS psivox_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT psivox)
psivox_set_runpath("${CMAKE_INSTALL_BINDIR}" psivox psivox_program)
install(DIRECTORY include/psivox DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT dev)
install(EXPORT psivoxTargets NAMESPACE psivox:: DESTINATION "${package_dir}" COMPONENT dev)
configure_package_config_file(cmake/psivoxConfig.cmake.in psivoxConfig.cmake
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file(psivoxConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/psivoxConfig.cmake"
  "${PROJECT_BINARY_DIR}/psivoxConfigVersion.cmake"
  DESTINATION "${package_dir}" COMPONENT dev)
file(RELATIVE_PATH PSIVOX_PREFIX_FROM_PC "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig"
  "${CMAKE_INSTALL_PREFIX}")
configure_file(cmake/psivox.pc.in psivox.pc @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/psivox.pc"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT dev)

# --- manual pages and completions, which the program prints ---------------------------------------
# A program for another machine prints nothing here, unless an emulator runs it.
if(NOT CMAKE_CROSSCOMPILING OR CMAKE_CROSSCOMPILING_EMULATOR)
  set(help_dir "${PROJECT_BINARY_DIR}/help")
  set(help_files)
  # psivox_help_file(NAME arguments...): what psivox prints with these arguments
  function(psivox_help_file name)
    set(compress)
    if(name MATCHES "gz$")
      set(compress | gzip -9n)
    endif()
    add_custom_command(OUTPUT "${help_dir}/${name}"
      COMMAND psivox_program ${ARGN} ${compress} > "${help_dir}/${name}"
      DEPENDS psivox_program VERBATIM)
    set(help_files ${help_files} "${help_dir}/${name}" PARENT_SCOPE)
  endfunction()
  file(MAKE_DIRECTORY "${help_dir}")
  psivox_help_file(psivox.1.gz --help=man)
  foreach(command compare examples info render study verify view)
    psivox_help_file(psivox-${command}.1.gz ${command} --help=man)
  endforeach()
  set(manual_pages ${help_files})
  foreach(shell bash zsh fish)
    psivox_help_file(psivox.${shell} --help=${shell})
  endforeach()
  add_custom_target(psivox_help_files ALL DEPENDS ${help_files})

  install(FILES ${manual_pages} DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT psivox)
  install(FILES "${help_dir}/psivox.bash" RENAME psivox
    DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" COMPONENT psivox)
  set(zsh_functions site-functions)
  if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    set(zsh_functions vendor-completions)  # Debian's place for packages
  endif()
  install(FILES "${help_dir}/psivox.zsh" RENAME _psivox
    DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/${zsh_functions}" COMPONENT psivox)
  install(FILES "${help_dir}/psivox.fish"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d" COMPONENT psivox)
endif()

# --- the desktop: its file type, the window, thumbnails -------------------------------------------
set(desktop "${PROJECT_SOURCE_DIR}/assets/desktop")
set(id org.psivox.psivox)
install(FILES "${desktop}/psivox.xml"
  DESTINATION "${CMAKE_INSTALL_DATADIR}/mime/packages" COMPONENT psivox)
install(FILES "${desktop}/psivox.thumbnailer"
  DESTINATION "${CMAKE_INSTALL_DATADIR}/thumbnailers" COMPONENT psivox)
if(PSIVOX_BUILD_VIEWER)
  configure_file("${desktop}/${id}.metainfo.xml" "${PROJECT_BINARY_DIR}/${id}.metainfo.xml" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/${id}.metainfo.xml"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/metainfo" COMPONENT psivox)
  install(FILES "${desktop}/${id}.desktop"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/applications" COMPONENT psivox)
  install(FILES "${desktop}/${id}.png"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/icons/hicolor/256x256/apps" COMPONENT psivox)
endif()
