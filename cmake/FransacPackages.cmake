# SPDX-License-Identifier: Apache-2.0
# Debian packages out of a shared build that is configured for /usr (preset `shared`): scripts/package, or cpack in its folder.
if(NOT BUILD_SHARED_LIBS OR NOT CMAKE_INSTALL_PREFIX STREQUAL /usr OR NOT FRANSAC_BUILD_APP)
  return()
endif()
find_program(GZIP gzip)
find_program(FRANSAC_DPKG_SHLIBDEPS dpkg-shlibdeps)
mark_as_advanced(GZIP FRANSAC_DPKG_SHLIBDEPS)
if(NOT GZIP OR NOT FRANSAC_DPKG_SHLIBDEPS)
  message(STATUS "No Debian packages: gzip or dpkg-shlibdeps is missing")
  return()
endif()

set(FRANSAC_MAINTAINER "fransac maintainers <fransac@example.org>" CACHE STRING "Who answers for the packages: NAME <ADDRESS>")
set(debian_version ${PROJECT_VERSION}-1)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH, if that is set
set(changelog ${PROJECT_BINARY_DIR}/changelog.Debian)
file(WRITE ${changelog} "fransac (${debian_version}) unstable; urgency=medium

  * Version ${PROJECT_VERSION}. What changed stands in CHANGELOG.md of the sources.

 -- ${FRANSAC_MAINTAINER}  ${date}
")
file(REMOVE ${changelog}.gz)
execute_process(COMMAND ${GZIP} -9nk ${changelog} COMMAND_ERROR_IS_FATAL ANY)

# fransac_package(COMPONENT NAME SECTION SUMMARY TEXT [DEPENDS COMPONENT…] [NEEDS PACKAGE…]): what is installed with COMPONENT.
# DEPENDS are the project's own, in the same version; libraries of others are found in the binaries, NEEDS is what can't be.
macro(fransac_package component name section summary text)
  cmake_parse_arguments(ARG "" "" "DEPENDS;NEEDS" ${ARGN})
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_COMPONENT_${upper}_DEPENDS ${ARG_DEPENDS})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}")
  list(JOIN ARG_NEEDS ", " CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS)
  install(FILES ${changelog}.gz ${PROJECT_SOURCE_DIR}/cmake/debian/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endmacro()

set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(about "fransac finds every plane of a depth frame or point cloud, and what stands on\nthe floor or falls away from it: fast, and the same on every run.")
fransac_package(lib libfransac${abi} libs "planes and obstacles in depth frames and point clouds"
                "${about}\n\nThis package holds the shared libraries: algorithms, and files of\nimages, cameras and point clouds.")
fransac_package(dev libfransac-dev libdevel "planes and obstacles in depth frames and point clouds: headers"
                "${about}\n\nThis package holds what is needed to build programs with it." DEPENDS lib NEEDS "libeigen3-dev (>= 3.4)")
if(FRANSAC_BUILD_PCL)
  fransac_package(pcl_dev libfransac-pcl-dev libdevel "planes and obstacles in depth frames and point clouds: in PCL's place"
                  "${about}\n\nThis package holds headers that stand where PCL's own stood." DEPENDS dev NEEDS libpcl-dev)
endif()
fransac_package(tool fransac science "planes and obstacles in depth frames and point clouds: command line"
                "${about}\n\nThis package holds the command line, its manual page and completions for bash,\nzsh and fish."
                DEPENDS lib)
if(FRANSAC_BUILD_PYTHON)
  fransac_package(python python3-fransac python "planes and obstacles in depth frames and point clouds: Python"
                  "${about}\n\nThis package holds the Python module."
                  DEPENDS lib NEEDS ${FRANSAC_PYTHON_NEEDS} "python3-numpy (>= 1:1.23)")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGE_NAME fransac)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each has its own
set(CPACK_PACKAGE_CONTACT ${FRANSAC_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/debian/remove_rpath.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIB_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/triggers)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/python/postinst
                                              ${PROJECT_SOURCE_DIR}/cmake/debian/python/prerm)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src ${PROJECT_BINARY_DIR}/src/io)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
