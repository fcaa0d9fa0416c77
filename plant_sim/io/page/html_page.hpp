// SPDX-License-Identifier: Apache-2.0
// The frame that every HTML report shares: one file with style, scripts, the charting library and data inside,
// which asks the network for nothing. html/page.html is the frame. The files of html/ and vendor/ are built into the
// program, and so are those that a report has of its own, beside its sources (page_files.cmake).
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

/// The files that a report has of its own, by name; empty for one that it does not have.
using PageFiles = std::string_view (*)(std::string_view name);

struct HtmlPage {
  std::string title;                      ///< plain text
  std::string description;                ///< plain text, a sentence
  std::string body;                       ///< HTML
  std::vector<std::string_view> scripts;  ///< names of files, run in this order after page.js
  std::string data;                       ///< JSON that the scripts read
  PageFiles own = nullptr;                ///< where scripts are looked for before the shared files
};

/// Text as it stands in HTML, between tags or in a quoted attribute.
[[nodiscard]] std::string html_text(std::string_view text);

/// The whole file.
[[nodiscard]] std::string html_page(const HtmlPage& page);

/// `pattern` with each {{name}} replaced by its value. Throws std::out_of_range for a name without one.
[[nodiscard]] std::string fill_template(std::string_view pattern,
                                        const std::map<std::string_view, std::string_view>& values);

/// A file by its name: of `own`, else of html/ or vendor/. Throws std::out_of_range for one that was not built in.
[[nodiscard]] std::string_view html_asset(std::string_view name, PageFiles own = nullptr);

}  // namespace voltlap::plant
