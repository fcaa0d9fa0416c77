// SPDX-License-Identifier: Apache-2.0
// Small parts that reports are put together from; look: html/page.css.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

/// A sentence that was written for a terminal, with the signs that a page has: °C, ±.
[[nodiscard]] std::string page_words(std::string text);

/// A key number with its unit and a remark, for a list of class "tiles". All plain text.
[[nodiscard]] std::string html_tile(const std::string& label, const std::string& value, const std::string& unit,
                                    const std::string& note = {});

/// A name and its value, for a list of class "facts-list". Plain text.
[[nodiscard]] std::string html_fact(const std::string& name, const std::string& value);

/// A row of a table: the first cell is its head. Plain text.
[[nodiscard]] std::string html_row(const std::vector<std::string>& cells);

}  // namespace voltlap::plant
