# SPDX-License-Identifier: Apache-2.0
# voltlap_page_files(<target> <function> <file>...): the files are built into the target as string constants, which
#   std::string_view voltlap::plant::<function>(std::string_view name)
# looks up by file name; empty for a name that is not among them.
# As a script: cmake -DOUTPUT=FILE.cpp -DFUNCTION=NAME -DFILES=a;b -P page_files.cmake
if(NOT CMAKE_SCRIPT_MODE_FILE)
  set(VOLTLAP_PAGE_FILES_SCRIPT ${CMAKE_CURRENT_LIST_FILE})
  function(voltlap_page_files target function)
    set(output ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DFUNCTION=${function} "-DFILES=${ARGN}" -P ${VOLTLAP_PAGE_FILES_SCRIPT}
      DEPENDS ${ARGN} ${VOLTLAP_PAGE_FILES_SCRIPT}
      COMMENT "Building the files of a page into the program"
      VERBATIM)
    target_sources(${target} PRIVATE ${output})
  endfunction()
  return()
endif()

set(entries)
foreach(path IN LISTS FILES)
  get_filename_component(name ${path} NAME)
  file(READ ${path} content)
  if(content MATCHES "\\)voltlap\"")
    message(FATAL_ERROR "${path} holds the mark that ends a string constant")
  endif()
  string(APPEND entries "  if (name == \"${name}\") return R\"voltlap(${content})voltlap\"sv;\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by page_files.cmake.
#include <string_view>

namespace voltlap::plant {

using namespace std::string_view_literals;

std::string_view ${FUNCTION}(std::string_view name) {
${entries}  return {};
}

}  // namespace voltlap::plant
")
