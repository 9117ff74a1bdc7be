# SPDX-License-Identifier: Apache-2.0
# The manual page and the completions, written by the program itself and installed beside it.
find_program(GZIP gzip)
mark_as_advanced(GZIP)

set(folder ${PROJECT_BINARY_DIR}/definition)
set(write sh -c "\"$1\" $2 > \"$3\"" sh $<TARGET_FILE:fransac_app>)
set(man ${folder}/fransac.1)
file(MAKE_DIRECTORY ${folder})
add_custom_command(TARGET fransac_app POST_BUILD COMMAND ${write} man ${man}
                   COMMAND ${write} "completion bash" ${folder}/fransac COMMAND ${write} "completion zsh" ${folder}/_fransac
                   COMMAND ${write} "completion fish" ${folder}/fransac.fish VERBATIM)
if(GZIP)  # as Debian wants it: small, and without the time
  add_custom_command(TARGET fransac_app POST_BUILD COMMAND ${GZIP} -9nf ${man} VERBATIM)
  string(APPEND man .gz)
endif()

set(zsh_folder zsh/site-functions)
if(CMAKE_INSTALL_PREFIX STREQUAL /usr AND EXISTS /etc/debian_version)
  set(zsh_folder zsh/vendor-completions)  # where Debian's zsh looks
endif()
install(FILES ${man} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tool)
install(FILES ${folder}/fransac DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT tool)
install(FILES ${folder}/_fransac DESTINATION ${CMAKE_INSTALL_DATADIR}/${zsh_folder} COMPONENT tool)
install(FILES ${folder}/fransac.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT tool)
