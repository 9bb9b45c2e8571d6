# rubble_library(NAME [SOURCES ...] [PUBLIC ...] [PRIVATE ...])
#   A static library `rubble_NAME` (alias rubble::NAME) with the project's warnings.
#   include/ is public where it exists, src/ is private.
function(rubble_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(rubble_${name} STATIC ${arg_SOURCES})
  add_library(rubble::${name} ALIAS rubble_${name})
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/include)
    target_include_directories(rubble_${name} PUBLIC include)
  endif()
  target_include_directories(rubble_${name} PRIVATE src)
  target_link_libraries(rubble_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} rubble_warnings)
endfunction()

# rubble_program(NAME SOURCE ... LINK ...)
#   An executable bin/NAME with the project's warnings.
function(rubble_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINK} rubble_warnings)
endfunction()

# rubble_tests(NAME LABEL SOURCES ... LINK ... [DEFINE ...])
#   One GoogleTest executable; every test in it gets the ctest label unit, integration or system. The target
#   tests_<label> builds all of a label.
function(rubble_tests name label)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK;DEFINE" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINK} rubble_warnings GTest::gmock_main)
  target_compile_definitions(${name} PRIVATE ${arg_DEFINE})
  if(NOT TARGET tests_${label})
    add_custom_target(tests_${label})
  endif()
  add_dependencies(tests_${label} ${name})
  gtest_discover_tests(${name} PROPERTIES LABELS ${label} DISCOVERY_TIMEOUT 60)
endfunction()
