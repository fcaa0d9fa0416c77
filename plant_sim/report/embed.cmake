# SPDX-License-Identifier: Apache-2.0
# cmake -DOUTPUT=FILE.cpp -DFILES=a;b -P embed.cmake: the files as string constants, looked up by html_asset(name).
set(entries)
foreach(path IN LISTS FILES)
  get_filename_component(name ${path} NAME)
  file(READ ${path} content)
  if(content MATCHES "\\)voltlap\"")
    message(FATAL_ERROR "${path} holds the mark that ends a string constant")
  endif()
  string(APPEND entries "    {\"${name}\", R\"voltlap(${content})voltlap\"sv},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by embed.cmake.
#include <stdexcept>
#include <string>

#include \"report/html_page.hpp\"

namespace voltlap::plant {
namespace {

using namespace std::string_view_literals;

struct Asset {
  std::string_view name, content;
};
const Asset kAssets[] = {
${entries}};

}  // namespace

std::string_view html_asset(std::string_view name) {
  for (const Asset& asset : kAssets) {
    if (asset.name == name) return asset.content;
  }
  throw std::out_of_range(\"no file of this name is built in: \" + std::string(name));
}

}  // namespace voltlap::plant
")
