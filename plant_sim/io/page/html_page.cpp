// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_page.hpp"

#include <stdexcept>

namespace voltlap::plant {

std::string_view shared_page_files(std::string_view name);  // made by page_files.cmake

namespace {

/// A "<" only stands inside strings of JSON text; escaped, no string can end the script element around it.
std::string json_in_html(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string_view html_asset(std::string_view name, PageFiles own) {
  std::string_view content = own != nullptr ? own(name) : std::string_view();
  if (content.empty()) content = shared_page_files(name);
  if (content.empty()) throw std::out_of_range("no file of this name is built in: " + std::string(name));
  return content;
}

std::string fill_template(std::string_view pattern, const std::map<std::string_view, std::string_view>& values) {
  std::string out;
  while (true) {
    const std::size_t open = pattern.find("{{");
    out += pattern.substr(0, open);
    if (open == std::string_view::npos) return out;
    const std::size_t close = pattern.find("}}", open);
    out += values.at(pattern.substr(open + 2, close - open - 2));
    pattern.remove_prefix(close + 2);
  }
}

std::string html_page(const HtmlPage& page) {
  std::string scripts;
  for (const std::string_view name : page.scripts) scripts += html_asset(name, page.own);
  return fill_template(html_asset("page.html"), {{"title", html_text(page.title)},
                                                 {"description", html_text(page.description)},
                                                 {"style", html_asset("page.css")},
                                                 {"body", page.body},
                                                 {"data", json_in_html(page.data)},
                                                 {"library", html_asset("echarts.min.js")},
                                                 {"shared", html_asset("page.js")},
                                                 {"scripts", scripts}});
}

}  // namespace voltlap::plant
