# SPDX-License-Identifier: Apache-2.0
# What every target of the project shares.

add_library(fransac_flags INTERFACE)
target_compile_options(fransac_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion
                                               -Wnon-virtual-dtor -Woverloaded-virtual)
# GCC 12 warns of overlapping copies inside std::string's operator+ (GCC bug 105651).
target_compile_options(fransac_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(FRANSAC_WARNINGS_AS_ERRORS)
  target_compile_options(fransac_flags INTERFACE -Werror)
endif()

if(PROJECT_IS_TOP_LEVEL)
  add_compile_definitions($<$<CONFIG:Debug>:_GLIBCXX_ASSERTIONS>)
  if(NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
    find_program(FRANSAC_CCACHE ccache)
    mark_as_advanced(FRANSAC_CCACHE)
    if(FRANSAC_CCACHE)
      # Checkouts in different folders share what was compiled.
      set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${FRANSAC_CCACHE})
    endif()
  endif()
endif()

if(FRANSAC_SANITIZE)
  add_compile_options(-fsanitize=${FRANSAC_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${FRANSAC_SANITIZE})
  # Else Eigen allocates otherwise under the address sanitizer than in PCL's libraries, and one frees what the other allocated.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# fransac_library(NAME COMPONENT): a library that is exported as fransac::COMPONENT, in an export set of its own.
function(fransac_library name component)
  add_library(${name})
  add_library(fransac::${component} ALIAS ${name})
  # Before 1.0 a new minor version may break binary compatibility.
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${component} VERSION ${PROJECT_VERSION}
                                           SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} INSTALL_RPATH $ORIGIN)
  target_compile_features(${name} PUBLIC cxx_std_20)
  # Without a build type, as a project's subdirectory may be, nothing would be optimised.
  target_compile_options(${name} PRIVATE $<$<CONFIG:>:-O3>)
  target_compile_definitions(${name} PRIVATE $<$<CONFIG:>:NDEBUG>)
  target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:fransac_flags>)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                            $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                                    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  if(FRANSAC_INSTALL)
    install(TARGETS ${name} EXPORT ${name} RUNTIME COMPONENT lib LIBRARY COMPONENT lib NAMELINK_COMPONENT dev ARCHIVE COMPONENT dev)
  endif()
endfunction()
