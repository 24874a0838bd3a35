find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(glm REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenImageIO REQUIRED)
# Debian's target lists OpenCV's headers, which its package does not depend on and psivox does not
# use.
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}")
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(pugixml REQUIRED)
# the text of colour bars: the library contains the font
find_file(PSIVOX_FONT DejaVuSans.ttf
  PATHS /usr/share/fonts /usr/local/share/fonts /Library/Fonts
  PATH_SUFFIXES truetype/dejavu dejavu TTF dejavu-sans-fonts truetype fonts share/fonts)
if(NOT PSIVOX_FONT)
  message(FATAL_ERROR "No DejaVuSans.ttf found (Debian: fonts-dejavu-core); -DPSIVOX_FONT=FILE "
    "names it or another TrueType font")
endif()
find_path(STB_INCLUDE_DIR stb/stb_truetype.h REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(NETTLE REQUIRED IMPORTED_TARGET nettle)
pkg_check_modules(BLOSC REQUIRED IMPORTED_TARGET blosc)  # with OpenVDB
if(PSIVOX_GUARD)
  pkg_check_modules(SECCOMP IMPORTED_TARGET libseccomp)
  if(NOT SECCOMP_FOUND)
    message(FATAL_ERROR "PSIVOX_GUARD needs libseccomp (Debian: libseccomp-dev); with "
      "-DPSIVOX_GUARD=OFF psivox reads files in its own process, where a hostile one can do harm")
  endif()
endif()
# MPI: several processes draw one picture. Optional.
if(PSIVOX_MPI)
  pkg_check_modules(PSIVOX_MPI_openmpi QUIET IMPORTED_TARGET ompi-c)
  pkg_check_modules(PSIVOX_MPI_mpich QUIET IMPORTED_TARGET mpich)
endif()
set(PSIVOX_MPIS "")
foreach(mpi openmpi mpich)
  if(PSIVOX_MPI AND PSIVOX_MPI_${mpi}_FOUND)
    set(PSIVOX_MPI_${mpi} TRUE)
    list(APPEND PSIVOX_MPIS ${mpi})
  endif()
endforeach()
if(PSIVOX_MPI AND NOT PSIVOX_MPIS)
  message(STATUS "psivox without MPI: a picture is drawn by one process "
    "(Debian: libopenmpi-dev, libmpich-dev)")
endif()

# vcpkg has a package configuration for OpenVDB. Debian, Fedora, Arch and conda-forge have headers,
# a library and FindOpenVDB.cmake, which demands packages that only OpenVDB's own build needs; so
# psivox looks for the first two itself. It needs no definitions: OpenVDB's version.h has them.
find_package(OpenVDB CONFIG QUIET)
find_package(Imath REQUIRED)
set(openvdb_roots "${OpenVDB_ROOT}" ENV OpenVDB_ROOT ENV CONDA_PREFIX)
find_path(NANOVDB_INCLUDE_DIR nanovdb/NanoVDB.h  # headers alone
  HINTS ${openvdb_roots} PATH_SUFFIXES include)
if(NOT NANOVDB_INCLUDE_DIR)
  message(FATAL_ERROR "NanoVDB not found, a part of OpenVDB (Debian: libnanovdb-dev); "
    "-DNANOVDB_INCLUDE_DIR=DIR names the folder above nanovdb/NanoVDB.h")
endif()
add_library(psivox_openvdb INTERFACE)
target_include_directories(psivox_openvdb SYSTEM INTERFACE "${NANOVDB_INCLUDE_DIR}")
if(TARGET OpenVDB::openvdb)
  target_link_libraries(psivox_openvdb INTERFACE OpenVDB::openvdb)
else()
  find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h HINTS ${openvdb_roots} PATH_SUFFIXES include)
  find_library(OPENVDB_LIBRARY NAMES openvdb libopenvdb HINTS ${openvdb_roots} PATH_SUFFIXES lib)
  if(NOT OPENVDB_INCLUDE_DIR OR NOT OPENVDB_LIBRARY)
    message(FATAL_ERROR "OpenVDB not found (Debian: libopenvdb-dev, Fedora: openvdb-devel, Arch "
      "and conda-forge: openvdb); -DOpenVDB_ROOT=DIR names the folder above its include and lib")
  endif()
  target_include_directories(psivox_openvdb SYSTEM INTERFACE "${OPENVDB_INCLUDE_DIR}")
  target_link_libraries(psivox_openvdb INTERFACE "${OPENVDB_LIBRARY}")
endif()
target_link_libraries(psivox_openvdb INTERFACE Imath::Imath TBB::tbb)
