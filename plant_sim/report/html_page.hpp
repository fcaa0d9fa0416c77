// SPDX-License-Identifier: Apache-2.0
// The frame that every HTML report shares: one file with style, scripts, the charting library and data inside,
// which asks the network for nothing. html/page.html is the frame; the files of html/ and vendor/ are built into
// the program.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

struct HtmlPage {
  std::string title;                      ///< plain text
  std::string description;                ///< plain text, a sentence
  std::string body;                       ///< HTML
  std::vector<std::string_view> scripts;  ///< names in html/, run in this order after the shared ones
  std::string data;                       ///< JSON that the scripts read
};

/// Text as it stands in HTML, between tags or in a quoted attribute.
[[nodiscard]] std::string html_text(std::string_view text);

/// The whole file.
[[nodiscard]] std::string html_page(const HtmlPage& page);

/// `pattern` with each {{name}} replaced by its value. Throws std::out_of_range for a name without one.
[[nodiscard]] std::string fill_template(std::string_view pattern,
                                        const std::map<std::string_view, std::string_view>& values);

/// A file of html/ or vendor/ by its name. Throws std::out_of_range for one that was not built in.
[[nodiscard]] std::string_view html_asset(std::string_view name);

}  // namespace voltlap::plant
