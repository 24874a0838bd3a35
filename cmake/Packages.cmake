# Debian packages: cmake --preset package && cmake --build --preset package && cpack --preset package
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL psivox dev)
if(TARGET psivox_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
list(APPEND CPACK_COMPONENTS_ALL ${PSIVOX_MPIS})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_CONTACT "The psivox developers <psivox@psivox.org>")
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/src")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# without them the packages would depend on almost nothing
set(CPACK_PROJECT_CONFIG_FILE "${PROJECT_SOURCE_DIR}/cmake/PackageTools.cmake")

set(name_psivox psivox)
set(CPACK_DEBIAN_PSIVOX_PACKAGE_SECTION graphics)
# which libepoxy loads when it is called
set(CPACK_DEBIAN_PSIVOX_PACKAGE_DEPENDS "libegl1, libopengl0 | libgl1")
set(CPACK_DEBIAN_PSIVOX_PACKAGE_RECOMMENDS libgl1-mesa-dri)
set(CPACK_DEBIAN_PSIVOX_PACKAGE_SUGGESTS ffmpeg)
set(CPACK_DEBIAN_PSIVOX_DESCRIPTION
  "psivox draws .vdb files: smoke, clouds, fire, scans, level sets. It chooses a
look that suits the file, and how to march it so that the RMS error of the
picture stays below a tolerance.")
set(CPACK_DEBIAN_PSIVOX_PACKAGE_CONTROL_EXTRA "${PROJECT_SOURCE_DIR}/cmake/triggers")

set(name_dev libpsivox-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "psivox (= ${PROJECT_VERSION}-1), libglm-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION "Headers of libpsivox, for programs that draw volumes with it.")

set(name_python python3-psivox)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
# a module is for one version of Python
math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "psivox (= ${PROJECT_VERSION}-1), python3-numpy, "
  "python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}), "
  "python3 (<< ${Python3_VERSION_MAJOR}.${next_minor})")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "The Python module: it draws .vdb files and numpy arrays, and measures the
error of its pictures.")

foreach(mpi IN LISTS PSIVOX_MPIS)
  string(TOUPPER ${mpi} MPI)
  set(name_${mpi} psivox-${mpi})
  set(CPACK_DEBIAN_${MPI}_PACKAGE_SECTION graphics)
  set(CPACK_DEBIAN_${MPI}_PACKAGE_DEPENDS "psivox (= ${PROJECT_VERSION}-1)")
  set(CPACK_DEBIAN_${MPI}_DESCRIPTION
    "What psivox needs to draw one picture by several processes of this MPI.")
endforeach()

# each with the licence and the changes, as Debian wants them
set(doc_dir "${PROJECT_BINARY_DIR}/package_docs")
configure_file(cmake/changelog.in "${doc_dir}/changelog.Debian" @ONLY)
find_program(PSIVOX_GZIP gzip REQUIRED)
add_custom_command(OUTPUT "${doc_dir}/changelog.Debian.gz"
  COMMAND "${PSIVOX_GZIP}" -9nkf "${doc_dir}/changelog.Debian"
  DEPENDS "${doc_dir}/changelog.Debian" VERBATIM)
add_custom_target(psivox_changelog ALL DEPENDS "${doc_dir}/changelog.Debian.gz")
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${name_${component}})
  install(FILES "${doc_dir}/changelog.Debian.gz"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${name_${component}}" COMPONENT ${component})
  install(FILES cmake/copyright
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${name_${component}}" COMPONENT ${component})
endforeach()
include(CPack)
