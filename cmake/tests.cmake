# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# Every tests/test_*.c, .py and .sh is one test of ctest. A test says how it wants to be run in a comment
# of its own that holds the word `ctest:` and what applies of
#     slow          label slow instead of fast (ctest -L fast leaves it out); the language is a label, too
#     serial        nothing else runs meanwhile: it measures time
#     timeout N     seconds until it is taken for hanging, 900 otherwise: on a busy machine all take several times longer
# Exit code 77: skipped; the reason is in the output.
enable_testing()

find_program(RY_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(NOT RY_PYTHON)
    find_program(RY_PYTHON NAMES python3 REQUIRED)
endif()
find_program(RY_BASH NAMES bash REQUIRED)
find_path(RY_CMOCKA_HEADER cmocka.h)
find_library(RY_CMOCKA_LIBRARY cmocka)
if(NOT RY_CMOCKA_HEADER OR NOT RY_CMOCKA_LIBRARY)
    message(STATUS "ryusa: no cmocka (Debian: libcmocka-dev), the tests in C are left out")
endif()

function(describe_test name file)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(STRINGS ${file} wish REGEX "ctest:" LIMIT_COUNT 1)
    string(REGEX REPLACE ".*ctest:" "" wish "${wish}")
    string(REGEX REPLACE ".*[.]" "" language ${file})
    set(label fast)
    if(wish MATCHES "slow")
        set(label slow)
    endif()
    set(timeout 900)
    if(wish MATCHES "timeout ([0-9]+)")
        set(timeout ${CMAKE_MATCH_1})
    endif()
    set(serial OFF)
    if(wish MATCHES "serial")
        set(serial ON)
    endif()
    # Spinning threads slow each other down on a machine that also does something else.
    set_tests_properties(${name} PROPERTIES
        LABELS "${label};${language}" TIMEOUT ${timeout} RUN_SERIAL ${serial} SKIP_RETURN_CODE 77
        ENVIRONMENT "OMP_WAIT_POLICY=passive;RYUSA=$<TARGET_FILE:ryusa_program>;SOURCE_DIR=${PROJECT_SOURCE_DIR};BUILD_DIR=${PROJECT_BINARY_DIR};RY_LIBRARY=$<TARGET_FILE:ryusa>;MPLBACKEND=Agg")
endfunction()

if(RY_CMOCKA_HEADER AND RY_CMOCKA_LIBRARY)
    file(GLOB RY_C_TESTS CONFIGURE_DEPENDS tests/test_*.c)
endif()
foreach(file ${RY_C_TESTS})
    get_filename_component(name ${file} NAME_WE)
    add_executable(${name} ${file})
    target_include_directories(${name} PRIVATE src tests)
    target_include_directories(${name} SYSTEM PRIVATE ${RY_CMOCKA_HEADER})
    target_compile_definitions(${name} PRIVATE
        RY_SOURCE_DIR="${PROJECT_SOURCE_DIR}" RY_PROGRAM="$<TARGET_FILE:ryusa_program>")
    target_link_libraries(${name} PRIVATE ryusa_static ${RY_CMOCKA_LIBRARY})
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
    add_dependencies(${name} ryusa_program)
    add_test(NAME ${name} COMMAND ${name})
    describe_test(${name} ${file})
endforeach()

file(GLOB RY_SCRIPT_TESTS CONFIGURE_DEPENDS tests/test_*.py tests/test_*.sh)
foreach(file ${RY_SCRIPT_TESTS})
    get_filename_component(name ${file} NAME_WE)
    if(file MATCHES "py$")
        add_test(NAME ${name} COMMAND ${RY_PYTHON} -B ${file})
    else()
        add_test(NAME ${name} COMMAND ${RY_BASH} ${file})
    endif()
    describe_test(${name} ${file})
endforeach()
