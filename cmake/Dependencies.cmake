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
# draws the plots of a study's page, which contains a copy of it
find_file(PSIVOX_CHART_JS NAMES chart.min.js Chart.min.js chart.umd.js
  PATHS /usr/share/javascript /usr/share/nodejs /usr/lib/node_modules
  PATH_SUFFIXES chart.js chart.js/dist chartjs REQUIRED)
# the text of colour bars: the library contains the font
find_file(PSIVOX_FONT DejaVuSans.ttf PATHS /usr/share/fonts
  PATH_SUFFIXES truetype/dejavu dejavu TTF dejavu-sans-fonts truetype REQUIRED)
find_path(STB_INCLUDE_DIR stb/stb_truetype.h REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl)
pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)
# MPI: several processes draw one picture. Optional.
pkg_check_modules(PSIVOX_MPI_openmpi QUIET IMPORTED_TARGET ompi-c)
pkg_check_modules(PSIVOX_MPI_mpich QUIET IMPORTED_TARGET mpich)
set(PSIVOX_MPIS "")
foreach(mpi openmpi mpich)
  if(PSIVOX_MPI_${mpi}_FOUND)
    set(PSIVOX_MPI_${mpi} TRUE)
    list(APPEND PSIVOX_MPIS ${mpi})
  endif()
endforeach()
if(NOT PSIVOX_MPIS)
  message(STATUS "psivox without MPI: a picture is drawn by one process "
    "(Debian: libopenmpi-dev, libmpich-dev)")
endif()

# Debian's OpenVDB has no package configuration file, and its find module requires too much.
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
find_path(NANOVDB_INCLUDE_DIR nanovdb/NanoVDB.h REQUIRED)  # headers alone
find_package(Imath REQUIRED)
add_library(psivox_openvdb INTERFACE)
target_include_directories(psivox_openvdb SYSTEM INTERFACE
  "${OPENVDB_INCLUDE_DIR}" "${NANOVDB_INCLUDE_DIR}")
target_link_libraries(psivox_openvdb INTERFACE "${OPENVDB_LIBRARY}" Imath::Imath TBB::tbb)
