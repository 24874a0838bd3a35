# The Python package is optional. It needs Python's headers and pybind11; numpy when it runs.
find_path(PYBIND11_INCLUDE_DIR pybind11/pybind11.h)
# The first Python in PATH that has headers, and numpy if any has.
function(psivox_check_python result program)
  execute_process(COMMAND "${program}" -c "import os, sysconfig${PSIVOX_PYTHON_NEEDS}
assert os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h'))"
    RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
  if(failed)
    set(${result} FALSE PARENT_SCOPE)
  endif()
endfunction()
foreach(PSIVOX_PYTHON_NEEDS ", numpy" "")
  find_program(PSIVOX_PYTHON_PROGRAM NAMES python3 VALIDATOR psivox_check_python)
endforeach()
if(PSIVOX_PYTHON_PROGRAM AND NOT Python3_EXECUTABLE)
  set(Python3_EXECUTABLE "${PSIVOX_PYTHON_PROGRAM}")
endif()
find_package(Python3 COMPONENTS Interpreter OPTIONAL_COMPONENTS Development.Module)
if(Python3_Development.Module_FOUND AND PYBIND11_INCLUDE_DIR AND NOT PSIVOX_SANITIZE)
  set(PSIVOX_PYTHON_FOUND ON)
else()
  set(PSIVOX_PYTHON_FOUND OFF)
endif()
psivox_option(PSIVOX_PYTHON ${PSIVOX_PYTHON_FOUND} "pybind11-dev python3-dev, and no sanitizer"
  "the Python package")
set(PSIVOX_PYTHON_DIR "lib/python3/dist-packages" CACHE STRING
  "Folder of Python packages below the prefix")
