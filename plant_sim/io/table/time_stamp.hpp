// SPDX-License-Identifier: Apache-2.0
// Time stamps of a table's column: h:min:s, min:s, "2d 03:04:05", dates with and without a time of day.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voltlap::plant {

/// A stamp as it is written; what its parts mean is for the whole column to say.
struct TimeStamp {
  enum class Date : std::uint8_t { kNone, kYearFirst, kDayFirst, kDayOrMonthFirst, kAbsent };
  Date date = Date::kAbsent;  ///< kAbsent: the field is no stamp
  std::uint8_t clock_parts = 0;  ///< 0, 2 or 3
  bool fraction = false;
  std::int16_t year = 0;
  std::uint8_t first = 0, second = 0;  ///< month and day of kYearFirst; of the others as written
  double clock = 0.0;                  ///< 3 parts: s; 2 parts: first x 60 + second

  [[nodiscard]] bool is_stamp() const { return date != Date::kAbsent; }
};

/// A stamp that is none for other text. A plain number is no stamp.
[[nodiscard]] TimeStamp time_stamp(std::string_view text);

struct StampSeconds {
  std::vector<double> seconds;      ///< NaN where there is no stamp; since 1970 for dates, without a time zone
  std::vector<std::string> notes;   ///< how they were read
  std::optional<std::string> why_not;  ///< what leaves the meaning open; `seconds` is empty then
};
/// Seconds of a column. Whether 03/04 is a day of April or of March, and whether 12:34 are minutes or hours, follows
/// from the other rows and from the column's name, or is left open and said in `why_not`.
[[nodiscard]] StampSeconds seconds_of(const std::vector<TimeStamp>& stamps, std::string_view column);

}  // namespace voltlap::plant
