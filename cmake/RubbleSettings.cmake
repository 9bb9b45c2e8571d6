# Compiler settings that every target of the project shares.

option(RUBBLE_BUILD_TESTS "Build the tests" ON)
option(RUBBLE_BUILD_BENCHMARKS "Build the benchmarks" ON)
option(RUBBLE_FUZZ "Build the fuzz targets (clang only, see tests/fuzz/run)" OFF)
set(RUBBLE_SANITIZE "" CACHE STRING "Sanitizers to compile in, e.g. address,undefined or thread")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(RUBBLE_CCACHE ccache)
if(RUBBLE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${RUBBLE_CCACHE})
endif()

# Warnings as errors for our own code; generated code is compiled without them.
add_library(rubble_warnings INTERFACE)
target_compile_options(rubble_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Werror -Wshadow -Wnon-virtual-dtor -Wold-style-cast
  -Wcast-align -Woverloaded-virtual -Wconversion -Wno-sign-conversion
  -Wdouble-promotion -Wformat=2 -Wimplicit-fallthrough)

if(RUBBLE_SANITIZE)
  # -g1 (functions and lines) is all that a sanitizer's report needs, and -O1 what its authors advise: with -O2 -g a file
  # takes half as long again to compile.
  add_compile_options(-O1 -g1 -fsanitize=${RUBBLE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${RUBBLE_SANITIZE})
endif()
