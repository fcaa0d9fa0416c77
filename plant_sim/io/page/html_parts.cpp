// SPDX-License-Identifier: Apache-2.0
#include "io/page/html_parts.hpp"

#include <fmt/format.h>

#include <string_view>

#include "io/page/html_page.hpp"

namespace voltlap::plant {

std::string page_words(std::string text) {
  const auto replace = [&](std::string_view word, std::string_view by) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size()))
      text.replace(at, word.size(), by);
  };
  replace("degC", "°C");
  replace("+-", "±");
  return text;
}

std::string html_tile(const std::string& label, const std::string& value, const std::string& unit,
                 const std::string& note) {
  return fmt::format("<div class=\"tile\"><dt>{}</dt><dd><b>{}</b>{}{}</dd></div>\n", html_text(label),
                     html_text(value),
                     unit.empty() ? "" : fmt::format(" <span class=\"unit\">{}</span>", html_text(unit)),
                     note.empty() ? "" : fmt::format("<small>{}</small>", html_text(note)));
}

std::string html_fact(const std::string& name, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", html_text(name), html_text(value));
}

std::string html_row(const std::vector<std::string>& cells) {
  std::string out = fmt::format("<tr><th scope=\"row\">{}</th>", html_text(cells.front()));
  for (std::size_t k = 1; k < cells.size(); ++k) out += "<td>" + html_text(cells[k]) + "</td>";
  return out + "</tr>\n";
}

}  // namespace voltlap::plant
