# The window is optional. It needs GLFW, and Dear ImGui with its OpenGL backend and imgui_stdlib: a
# library that has all three, as Debian's and Arch's, or Dear ImGui's own sources.
set(PSIVOX_IMGUI "" CACHE PATH "Folder of Dear ImGui's sources; empty: the system's library")
find_package(glfw3 3.3 QUIET)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
if(glfw3_FOUND AND (PSIVOX_IMGUI OR (IMGUI_INCLUDE_DIR AND IMGUI_LIBRARY)))
  set(PSIVOX_VIEWER_FOUND ON)
else()
  set(PSIVOX_VIEWER_FOUND OFF)
  message(STATUS "GLFW or Dear ImGui not found: psivox view will not be built "
    "(Debian: libglfw3-dev libimgui-dev; -DPSIVOX_IMGUI=DIR names Dear ImGui's sources)")
endif()
option(PSIVOX_BUILD_VIEWER "Build the window of psivox view" ${PSIVOX_VIEWER_FOUND})
if(PSIVOX_BUILD_VIEWER)
  if(NOT PSIVOX_VIEWER_FOUND)
    message(FATAL_ERROR "PSIVOX_BUILD_VIEWER needs GLFW and Dear ImGui (Debian: libglfw3-dev "
      "libimgui-dev; -DPSIVOX_IMGUI=DIR names Dear ImGui's sources)")
  endif()
  if(PSIVOX_IMGUI)
    set(sources imgui.cpp imgui_draw.cpp imgui_tables.cpp imgui_widgets.cpp
      misc/cpp/imgui_stdlib.cpp backends/imgui_impl_opengl3.cpp)
    list(TRANSFORM sources PREPEND "${PSIVOX_IMGUI}/")
    add_library(psivox_imgui STATIC ${sources})
    target_include_directories(psivox_imgui SYSTEM PUBLIC
      "${PSIVOX_IMGUI}" "${PSIVOX_IMGUI}/misc/cpp")
    target_link_libraries(psivox_imgui PUBLIC ${CMAKE_DL_LIBS})
  else()
    find_library(STB_LIBRARY stb)  # Debian's imgui rasterises its fonts with it
    add_library(psivox_imgui INTERFACE)
    target_include_directories(psivox_imgui SYSTEM INTERFACE "${IMGUI_INCLUDE_DIR}")
    target_link_libraries(psivox_imgui INTERFACE "${IMGUI_LIBRARY}" ${CMAKE_DL_LIBS})
    if(STB_LIBRARY)
      target_link_libraries(psivox_imgui INTERFACE "${STB_LIBRARY}")
    endif()
  endif()
endif()
