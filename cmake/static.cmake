# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# What the program (not the installed library) carries within itself, where the compiler and the packages have it:
#
#   HDF5     Debian's shared one brings forty libraries for reading from the web. Loading them takes three times as
#            long as reading a scene; the static one leaves out what nobody calls.
#   OpenMP   GCC's reads its settings before main. Of a static one they can be set before (src/cli/main.c).
#
# After this file: ryusa_dep_hdf5_program and ryusa_openmp_program, to be linked, and RY_STATIC_OPENMP.
include(CheckCSourceCompiles)
option(RY_STATIC "the program carries HDF5 and OpenMP within itself, where they are found: it starts in a fifth of the time" ON)

add_library(ryusa_dep_hdf5_program INTERFACE)
add_library(ryusa_openmp_program INTERFACE)
set(RY_STATIC_OPENMP OFF)

# The static library beside the shared one (another may be of another version than the headers), with what it needs in
# turn, if a program can be made of them.
function(find_static_hdf5 result)
    set(from ryusa_dep_hdf5)
    if(TARGET PkgConfig::RY_hdf5)
        set(from PkgConfig::RY_hdf5)
    endif()
    get_target_property(shared ${from} INTERFACE_LINK_LIBRARIES)
    get_target_property(CMAKE_REQUIRED_INCLUDES ${from} INTERFACE_INCLUDE_DIRECTORIES)
    list(GET shared 0 shared)
    get_filename_component(folder ${shared} DIRECTORY)
    find_library(RY_HDF5_STATIC NAMES libhdf5_serial.a libhdf5.a PATHS ${folder} NO_DEFAULT_PATH)
    find_library(RY_SZIP_LIBRARY NAMES sz)
    find_library(RY_ZLIB_LIBRARY NAMES z)
    set(libraries ${RY_HDF5_STATIC} ${RY_SZIP_LIBRARY} ${RY_ZLIB_LIBRARY} ${CMAKE_DL_LIBS} m)
    list(FILTER libraries EXCLUDE REGEX NOTFOUND)
    set(CMAKE_REQUIRED_LIBRARIES ${libraries} Threads::Threads)
    if(RY_HDF5_STATIC)
        check_c_source_compiles("#include <hdf5.h>\nint main(void) { return H5open(); }" RY_STATIC_HDF5_WORKS)
    endif()
    set(${result} "" PARENT_SCOPE)
    if(RY_STATIC_HDF5_WORKS)
        set(${result} ${libraries} PARENT_SCOPE)
    endif()
endfunction()

function(find_static_openmp result)
    execute_process(COMMAND ${CMAKE_C_COMPILER} -print-file-name=libgomp.a OUTPUT_VARIABLE file OUTPUT_STRIP_TRAILING_WHITESPACE)
    set(${result} "" PARENT_SCOPE)
    if(CMAKE_C_COMPILER_ID STREQUAL "GNU" AND IS_ABSOLUTE "${file}")
        set(${result} ${file} ${CMAKE_DL_LIBS} PARENT_SCOPE)
    endif()
endfunction()

set(hdf5 "")
set(openmp "")
if(RY_STATIC AND NOT RY_SANITIZE)
    find_static_hdf5(hdf5)
    if(OpenMP_C_FOUND)
        find_static_openmp(openmp)
    endif()
endif()
if(hdf5)
    target_link_libraries(ryusa_dep_hdf5_program INTERFACE ${hdf5})
else()
    target_link_libraries(ryusa_dep_hdf5_program INTERFACE ryusa_dep_hdf5)
endif()
if(openmp)
    set(RY_STATIC_OPENMP ON)
    target_link_libraries(ryusa_openmp_program INTERFACE ${openmp})
elseif(OpenMP_C_FOUND)
    target_link_libraries(ryusa_openmp_program INTERFACE OpenMP::OpenMP_C)
endif()
