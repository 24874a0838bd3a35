# Flags and components. A component is a folder of src/, compiled separately with the packages it
# may use: OpenVDB in reader, OpenImageIO in oiio, GL in gl. tests/check_includes.sh enforces the rules
# that include paths cannot.
add_library(psivox_flags INTERFACE)
target_compile_features(psivox_flags INTERFACE cxx_std_20)
target_include_directories(psivox_flags INTERFACE "${PROJECT_SOURCE_DIR}/include"
  "${PROJECT_SOURCE_DIR}/src" "${PROJECT_BINARY_DIR}/generated")
target_compile_options(psivox_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow
  # gcc 12 reports overlaps in std::string's operator+ that do not exist (bug 105651)
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # gcc collects its garbage from 1 GiB on, in place of 128 MiB: a tenth of the time to compile
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>
  # a study measures rounding: no contraction into fused multiply-adds, and no -ffast-math
  -ffp-contract=off)
target_compile_definitions(psivox_flags INTERFACE
  PSIVOX_VERSION="${PROJECT_VERSION}")
if(PSIVOX_SANITIZE)
  # AddressSanitizer finds what `null` and `object-size` would, and x86 reads from any address: to
  # compile these checks takes a quarter to a third of all time.
  target_compile_options(psivox_flags INTERFACE
    -fsanitize=address,undefined,float-cast-overflow -fno-sanitize=null,object-size,alignment
    -fno-sanitize-recover=undefined,float-cast-overflow -fno-omit-frame-pointer)
  target_link_options(psivox_flags INTERFACE -fsanitize=address,undefined)
endif()

set(PSIVOX_COMPONENTS "" CACHE STRING
  "Components of libpsivox, for tests that need no others; empty: all of them")
mark_as_advanced(PSIVOX_COMPONENTS)

# psivox_sources(VARIABLE FOLDER): the C++ files of a component's folder.
function(psivox_sources variable folder)
  file(GLOB sources RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" CONFIGURE_DEPENDS
    "${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp")
  set(${variable} ${sources} PARENT_SCOPE)
endfunction()

# psivox_component(NAME SOURCES generated files... USES targets...): the folder of that name.
function(psivox_component name)
  cmake_parse_arguments(arg "" "" "SOURCES;USES" ${ARGN})
  psivox_sources(sources ${name})
  add_library(psivox_${name} OBJECT ${sources} ${arg_SOURCES})
  set_target_properties(psivox_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(psivox_${name} PRIVATE psivox_flags glm::glm ${arg_USES})
  if(NOT PSIVOX_COMPONENTS OR name IN_LIST PSIVOX_COMPONENTS)
    target_sources(psivox PRIVATE $<TARGET_OBJECTS:psivox_${name}>)
    target_link_libraries(psivox PRIVATE ${arg_USES})
  endif()
endfunction()

# What was built finds other files of the build by its own place, so that the folder can be moved.
set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)

# psivox_finds_library(TARGET BUILT INSTALLED): where a target that is installed finds libpsivox. CMake
# would exchange the two paths by itself, and end the first with an empty entry, which is the folder in
# which somebody works: libraries of that folder would run. psivox_set_runpath exchanges them instead.
function(psivox_finds_library target built installed)
  if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
    set(installed "")  # where the system looks by itself
  endif()
  string(LENGTH "${installed}" wanted)
  string(LENGTH "${built}" length)
  while(length LESS wanted)  # the room for the other path
    string(APPEND built "/.")
    string(LENGTH "${built}" length)
  endwhile()
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${built}" BUILD_WITH_INSTALL_RPATH ON
    INSTALL_RPATH_USE_LINK_PATH ON PSIVOX_INSTALLED_RPATH "${installed}")
endfunction()

# psivox_set_runpath(FOLDER COMPONENT targets...): after install(TARGETS) to that folder.
function(psivox_set_runpath folder component)
  foreach(target IN LISTS ARGN)
    get_target_property(path ${target} PSIVOX_INSTALLED_RPATH)
    install(CODE "file(RPATH_SET NEW_RPATH \"${path}\" FILE
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${folder}/$<TARGET_FILE_NAME:${target}>\")"
      COMPONENT ${component})
  endforeach()
endfunction()

# psivox_module(NAME FOLDER USES targets...): a component that libpsivox loads on demand from the
# folder `psivox` beside itself.
function(psivox_module name folder)
  cmake_parse_arguments(arg "" "" "USES" ${ARGN})
  psivox_sources(sources ${folder})
  add_library(psivox_${name} MODULE ${sources})
  set_target_properties(psivox_${name} PROPERTIES
    LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/src/psivox")
  psivox_finds_library(psivox_${name} "$ORIGIN/.." "$ORIGIN/..")
  target_link_libraries(psivox_${name} PRIVATE psivox psivox_flags ${arg_USES})
endfunction()

# psivox_embed(OUTPUT HEADER header TABLE function NAMES names... PATHS files...): writes OUTPUT to
# the folder `generated`. It defines a function declared in HEADER: a map from NAMES to what the files contain.
function(psivox_embed output)
  cmake_parse_arguments(arg "" "HEADER;TABLE" "NAMES;PATHS" ${ARGN})
  set(file "${PROJECT_BINARY_DIR}/generated/${output}")
  set(script "${PROJECT_SOURCE_DIR}/cmake/EmbedFiles.cmake")
  add_custom_command(OUTPUT "${file}"
    COMMAND "${CMAKE_COMMAND}" "-DOUTPUT=${file}" "-DHEADER=${arg_HEADER}" "-DTABLE=${arg_TABLE}"
            "-DNAMES=${arg_NAMES}" "-DPATHS=${arg_PATHS}" -P "${script}"
    DEPENDS ${arg_PATHS} "${script}" VERBATIM)
endfunction()
