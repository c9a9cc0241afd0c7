# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
#
# cmake --install build --prefix P: the program, the shared library with its headers, and what
# pkg-config and find_package(ryusa) need.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS ryusa_program RUNTIME)
install(TARGETS ryusa EXPORT ryusaTargets LIBRARY)
install(DIRECTORY include/ryusa TYPE INCLUDE)
install(FILES README.md LICENSE CHANGELOG.md TYPE DOC OPTIONAL)

set(RY_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/ryusa)
install(EXPORT ryusaTargets NAMESPACE ryusa:: DESTINATION ${RY_CMAKE_DIR})
configure_package_config_file(cmake/ryusaConfig.cmake.in ryusaConfig.cmake INSTALL_DESTINATION ${RY_CMAKE_DIR})
write_basic_package_version_file(ryusaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/ryusaConfig.cmake ${PROJECT_BINARY_DIR}/ryusaConfigVersion.cmake
        DESTINATION ${RY_CMAKE_DIR})

# The prefix follows the place of the .pc file, so that an installed tree can be moved.
file(RELATIVE_PATH RY_PC_TO_PREFIX "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
string(REGEX REPLACE "/$" "" RY_PC_TO_PREFIX "${RY_PC_TO_PREFIX}")
configure_file(cmake/ryusa.pc.in ryusa.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/ryusa.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
