# SPDX-License-Identifier: Apache-2.0
# Headers and what finds them: the CMake package, find_package(fransac CONFIG [COMPONENTS io pcl]), and files for pkg-config.
# What goes into which Debian package is said by install components; FransacPackages.cmake lists these.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/fransac)
set(headers ${PROJECT_SOURCE_DIR}/include/fransac)

install(DIRECTORY ${headers} ${PROJECT_BINARY_DIR}/include/fransac DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
        FILES_MATCHING PATTERN "*.hpp" PATTERN io EXCLUDE PATTERN tuning.hpp EXCLUDE)
if(FRANSAC_BUILD_IO)
  install(DIRECTORY ${headers}/io DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fransac COMPONENT dev
          FILES_MATCHING PATTERN "*.hpp")
endif()

if(FRANSAC_BUILD_PCL)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/adapters/pcl/include/fransac/pcl DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fransac COMPONENT pcl_dev)
  install(EXPORT fransac_pcl FILE fransac_pcl-targets.cmake NAMESPACE fransac:: DESTINATION ${package_dir} COMPONENT pcl_dev)
endif()

# install_pc(NAME DESCRIPTION REQUIRES COMPONENT LIBS): NAME.pc.
function(install_pc pc_name pc_description pc_requires component pc_libs)
  set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH to_prefix /${pc_dir} /)
  string(REGEX REPLACE "/$" "" to_prefix ${to_prefix})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/fransac.pc.in ${PROJECT_BINARY_DIR}/${pc_name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${pc_name}.pc DESTINATION ${pc_dir} COMPONENT ${component})
endfunction()

# install_library(COMPONENT DESCRIPTION REQUIRES [STATIC_REQUIRES]): how COMPONENT's library is found. Who links a static library
# links what it is made with, too; a shared one keeps that to itself.
function(install_library component description requires static_requires)
  set(library fransac_${component})
  set(pc_name fransac-${component})
  if(component STREQUAL "fransac")
    set(library fransac)
    set(pc_name fransac)
  endif()
  if(NOT TARGET ${library})
    return()
  endif()
  install(EXPORT ${library} FILE ${library}-targets.cmake NAMESPACE fransac:: DESTINATION ${package_dir} COMPONENT dev)

  string(REPLACE _ - pc_name ${pc_name})
  set(pc_requires ${requires})
  if(NOT BUILD_SHARED_LIBS)
    string(APPEND pc_requires ", ${static_requires}")
  endif()
  install_pc(${pc_name} "${description}" "${pc_requires}" dev "Libs: -L\${libdir} -l${library}\n")
endfunction()

set(same "= ${PROJECT_VERSION}")
install_library(fransac "${PROJECT_DESCRIPTION}" "eigen3 >= 3.4" "libhwy, tbb")
install_library(io "Images, cameras, folders of frames and clouds for fransac" "fransac ${same}" "libdeflate, spng, libtiff-4, libturbojpeg, yaml-cpp")
if(FRANSAC_BUILD_PCL)  # headers only
  install_pc(fransac-pcl "fransac in the place of PCL's classes" "fransac ${same}, pcl_common >= 1.12" pcl_dev "")
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/fransacConfig.cmake.in fransacConfig.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(fransacConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/fransacConfig.cmake ${PROJECT_BINARY_DIR}/fransacConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence)
