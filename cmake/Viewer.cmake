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
endif()
psivox_option(PSIVOX_BUILD_VIEWER ${PSIVOX_VIEWER_FOUND}
  "libglfw3-dev, and libimgui-dev or -DPSIVOX_IMGUI=DIR" "the window of psivox view")
if(PSIVOX_BUILD_VIEWER)
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
