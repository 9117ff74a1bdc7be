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
if(FRANSAC_SANITIZE)
  add_compile_options(-fsanitize=${FRANSAC_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${FRANSAC_SANITIZE})
endif()

# fransac_library(NAME [ALIAS part]): a library that is installed as fransac::ALIAS.
function(fransac_library name alias)
  add_library(${name})
  add_library(fransac::${alias} ALIAS ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${alias} VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:fransac_flags>)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                            $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
                                    PRIVATE ${PROJECT_SOURCE_DIR}/src)
endfunction()
