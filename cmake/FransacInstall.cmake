# SPDX-License-Identifier: Apache-2.0
# Headers and the CMake package: find_package(fransac CONFIG [COMPONENTS io cloud_io pcl]).
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/fransac)
set(headers ${PROJECT_SOURCE_DIR}/include/fransac)

install(DIRECTORY ${headers} ${PROJECT_BINARY_DIR}/include/fransac DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.hpp" PATTERN io EXCLUDE PATTERN tuning.hpp EXCLUDE)
if(FRANSAC_BUILD_IO)
  install(DIRECTORY ${headers}/io DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fransac
          FILES_MATCHING PATTERN "*.hpp" PATTERN cloud_file.hpp EXCLUDE)
endif()
if(FRANSAC_BUILD_CLOUD_IO)
  install(FILES ${headers}/io/cloud_file.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fransac/io)
endif()

if(FRANSAC_BUILD_PCL)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/adapters/pcl/include/fransac/pcl DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/fransac)
endif()

foreach(component fransac fransac_io fransac_cloud_io fransac_pcl)
  if(TARGET ${component})
    install(EXPORT ${component} FILE ${component}-targets.cmake NAMESPACE fransac:: DESTINATION ${package_dir})
  endif()
endforeach()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/fransacConfig.cmake.in fransacConfig.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(fransacConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/fransacConfig.cmake ${PROJECT_BINARY_DIR}/fransacConfigVersion.cmake
        DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
