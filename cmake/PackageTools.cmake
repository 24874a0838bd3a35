# Read by cpack: it finds out with these programs what a package depends on.
foreach(program file dpkg-shlibdeps)
  find_program(found_${program} ${program})
  if(NOT found_${program})
    message(FATAL_ERROR "cpack needs the program ${program} (Debian: file, dpkg-dev)")
  endif()
endforeach()
