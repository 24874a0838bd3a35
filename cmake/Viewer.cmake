# The window is optional. It needs GLFW and Dear ImGui; Debian packages ImGui as a static library
# that includes its OpenGL backend, without a CMake package.
find_package(glfw3 3.3 QUIET)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)  # Debian's imgui rasterises its fonts with it
if(glfw3_FOUND AND IMGUI_INCLUDE_DIR AND IMGUI_LIBRARY AND STB_LIBRARY)
  set(PSIVOX_VIEWER_FOUND ON)
else()
  set(PSIVOX_VIEWER_FOUND OFF)
  message(STATUS "GLFW or Dear ImGui not found: psivox view will not be built "
    "(Debian: libglfw3-dev libimgui-dev)")
endif()
option(PSIVOX_BUILD_VIEWER "Build the window of psivox view" ${PSIVOX_VIEWER_FOUND})
if(PSIVOX_BUILD_VIEWER)
  if(NOT PSIVOX_VIEWER_FOUND)
    message(FATAL_ERROR "PSIVOX_BUILD_VIEWER needs GLFW and Dear ImGui "
      "(Debian: libglfw3-dev libimgui-dev)")
  endif()
  add_library(psivox_imgui INTERFACE)
  target_include_directories(psivox_imgui SYSTEM INTERFACE "${IMGUI_INCLUDE_DIR}")
  target_link_libraries(psivox_imgui INTERFACE "${IMGUI_LIBRARY}" "${STB_LIBRARY}" ${CMAKE_DL_LIBS})
endif()
