// SPDX-License-Identifier: Apache-2.0
#include "io/table/time_stamp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerDay = 86400.0;
using Date = TimeStamp::Date;

/// Reads a text from left to right.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] char peek() const { return rest_.empty() ? '\0' : rest_[0]; }
  bool take(char c) {
    if (peek() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool take_blanks() {
    bool any = false;
    while (take(' ')) any = true;
    return any;
  }
  /// Up to `most` digits; -1 for none.
  long digits(std::size_t most, std::size_t& count) {
    long value = -1;
    for (count = 0; count < most && std::isdigit(static_cast<unsigned char>(peek())) != 0; ++count) {
      value = 10 * std::max(value, 0L) + (peek() - '0');
      rest_.remove_prefix(1);
    }
    return value;
  }
  /// Letters, in lower case.
  std::string word() {
    std::string out;
    while (std::isalpha(static_cast<unsigned char>(peek())) != 0) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(peek())));
      rest_.remove_prefix(1);
    }
    return out;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

long month_named(const std::string& word) {
  constexpr std::array<std::string_view, 12> kMonths{"jan", "feb", "mar", "apr", "may", "jun",
                                                     "jul", "aug", "sep", "oct", "nov", "dec"};
  if (word.size() < 3) return 0;
  const auto at = std::find(kMonths.begin(), kMonths.end(), std::string_view(word).substr(0, 3));
  return at == kMonths.end() ? 0 : at - kMonths.begin() + 1;
}

bool is_year(std::size_t digits) { return digits == 2 || digits == 4; }

/// year-month-day, day.month.year, either of day and month first with / or -, day-Jan-year.
bool scan_date(Scanner& in, TimeStamp& out) {
  std::size_t n1 = 0, n2 = 0, n3 = 0;
  const long d1 = in.digits(4, n1);
  const char mark = in.peek();
  if (d1 < 0 || (mark != '-' && mark != '/' && mark != '.')) return false;
  in.take(mark);
  const bool named = std::isalpha(static_cast<unsigned char>(in.peek())) != 0;
  const long d2 = named ? month_named(in.word()) : in.digits(2, n2);
  if (d2 <= 0 || !in.take(mark)) return false;
  const long d3 = in.digits(4, n3);
  if (d3 < 0 || d1 < 0 || d2 > 31) return false;
  long year = d3, first = d1, second = d2;
  if (n1 == 4) {
    if (n3 > 2) return false;
    out.date = Date::kYearFirst;
    year = d1, first = d2, second = d3;
  } else {
    if (n1 > 2 || !is_year(n3)) return false;
    out.date = named || mark == '.' ? Date::kDayFirst : Date::kDayOrMonthFirst;
  }
  if (first < 1 || first > 31 || second < 1 || second > 31) return false;
  if (out.date == Date::kYearFirst && first > 12) return false;
  if (out.date == Date::kDayFirst && second > 12) return false;
  out.year = static_cast<std::int16_t>(year < 100 ? 2000 + year : year);
  out.first = static_cast<std::uint8_t>(first);
  out.second = static_cast<std::uint8_t>(second);
  return true;
}

/// h:min, h:min:s or min:s, with a fraction, AM or PM, and a time zone that is taken off.
bool scan_clock(Scanner& in, TimeStamp& out) {
  std::size_t n = 0, n2 = 0;
  const long first = in.digits(6, n), colon = in.take(':') ? 1 : 0, second = in.digits(2, n2);
  if (first < 0 || colon == 0 || n2 == 0 || second >= 60) return false;
  out.clock_parts = 2;
  out.clock = static_cast<double>(60 * first + second);
  if (in.take(':')) {
    const long third = in.digits(2, n);
    if (n == 0 || third > 60) return false;
    out.clock_parts = 3;
    out.clock = out.clock * 60.0 + static_cast<double>(third);
  }
  if (in.peek() == '.' || in.peek() == ',' || (out.clock_parts == 3 && in.peek() == ':')) {
    in.take(in.peek());
    const long fraction = in.digits(9, n);
    if (n == 0) return false;
    out.fraction = true;
    out.clock += static_cast<double>(fraction) / std::pow(10.0, static_cast<double>(n));
  }
  in.take_blanks();
  const std::string half = in.word();
  if (half == "pm" || half == "am") {
    if (first < 1 || first > 12) return false;
    const double hour = out.clock_parts == 3 ? 3600.0 : 60.0;
    out.clock += hour * ((half == "pm" ? 12.0 : 0.0) - (first == 12 ? 12.0 : 0.0));
    return true;
  }
  if (half == "z") return true;
  if (!half.empty()) return false;
  if (out.date != Date::kNone && (in.peek() == '+' || in.peek() == '-')) {
    const double sign = in.peek() == '+' ? 1.0 : -1.0;
    in.take(in.peek());
    const long hours = in.digits(2, n);
    in.take(':');
    const long minutes = in.digits(2, n2);
    if (hours < 0) return false;
    const double zone = sign * static_cast<double>(60 * hours + std::max(minutes, 0L));
    out.clock -= out.clock_parts == 3 ? 60.0 * zone : zone;
  }
  return true;
}

double days_since_1970(long year, unsigned month, unsigned day) {
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(year)), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
}

double days_of(const TimeStamp& s, bool day_first) {
  if (s.date == Date::kNone) return 0.0;
  if (s.date == Date::kYearFirst) return days_since_1970(s.year, s.first, s.second);
  const bool swapped = s.date == Date::kDayOrMonthFirst && !day_first;
  return days_since_1970(s.year, swapped ? s.first : s.second, swapped ? s.second : s.first);
}

/// Longest step of time that an order of day and month would mean; none when a row has no such date.
std::optional<double> longest_step(const std::vector<TimeStamp>& stamps, bool day_first) {
  double longest = 0.0, before = 0.0;
  bool any = false;
  for (const TimeStamp& s : stamps) {
    if (!s.is_stamp()) continue;
    const double days = days_of(s, day_first);
    if (!std::isfinite(days)) return std::nullopt;
    const double now = days * kSecondsPerDay + (s.clock_parts == 2 ? 60.0 : 1.0) * s.clock;
    if (any) longest = std::max(longest, std::abs(now - before));
    before = now;
    any = true;
  }
  return longest;
}

/// Whether the day stands before the month; nothing when the rows do not tell.
std::optional<bool> is_day_first(const std::vector<TimeStamp>& stamps) {
  constexpr double kClearly = 5.0, kDays = 5.0;
  const auto day = longest_step(stamps, true), month = longest_step(stamps, false);
  if (!day || !month) return day.has_value() == month.has_value() ? std::nullopt : std::optional(day.has_value());
  if (std::max(*day, *month) < kSecondsPerDay) return true;  // one day: either way the same seconds
  if (std::min(*day, *month) > kDays * kSecondsPerDay) return std::nullopt;
  if (*day * kClearly < *month) return true;
  if (*month * kClearly < *day) return false;
  return std::nullopt;
}

/// Seconds that one of a two-part clock's second part is; nothing when the rows do not tell.
std::optional<double> two_part_scale(const std::vector<TimeStamp>& stamps, std::string_view column) {
  std::string name(column);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto named = [&](std::initializer_list<const char*> forms) {
    return std::any_of(forms.begin(), forms.end(), [&](const char* f) { return name.find(f) != std::string::npos; });
  };
  if (named({"min:s", "mm:ss", "m:s"})) return 1.0;
  if (named({"h:m", "hh:mm"})) return 60.0;
  for (const TimeStamp& s : stamps) {
    if (!s.is_stamp() || s.clock_parts != 2) continue;
    if (s.date != Date::kNone) return 60.0;
    if (s.fraction || s.clock >= 24.0 * 60.0) return 1.0;
  }
  return std::nullopt;
}

/// A clock of the day that passes midnight goes on.
std::size_t pass_midnights(std::vector<double>& seconds) {
  constexpr double kNear = 0.02 * kSecondsPerDay;
  double before = std::nan(""), shift = 0.0;
  std::size_t midnights = 0;
  for (double& t : seconds) {
    if (!std::isfinite(t)) continue;
    const double own = t;
    if (before > kSecondsPerDay - kNear && before < kSecondsPerDay && own < kNear) {
      shift += kSecondsPerDay;
      ++midnights;
    }
    before = own;
    t += shift;
  }
  return midnights;
}

}  // namespace

TimeStamp time_stamp(std::string_view text) {
  TimeStamp out;
  if (text.size() < 3 || text.find_first_of(":-./") == std::string_view::npos) return out;
  out.date = Date::kNone;
  Scanner clock_only(text);
  if (scan_clock(clock_only, out) && clock_only.at_end()) return out;
  out = TimeStamp{Date::kNone};
  Scanner in(text);
  std::size_t n = 0;
  Scanner days(text);
  const long count = days.digits(6, n);
  if (count >= 0 && (days.take('d') || days.take('D')) && days.take_blanks() && scan_clock(days, out) &&
      days.at_end() && out.clock_parts == 3) {
    out.clock += static_cast<double>(count) * kSecondsPerDay;
    return out;
  }
  out = TimeStamp{Date::kNone};
  if (!scan_date(in, out)) return {};
  if (in.at_end()) return out;
  if (!in.take('T') && !in.take_blanks()) return {};
  if (!scan_clock(in, out) || !in.at_end()) return {};
  return out;
}

StampSeconds seconds_of(const std::vector<TimeStamp>& stamps, std::string_view column) {
  StampSeconds out;
  const auto has = [&](auto&& what) {
    return std::any_of(stamps.begin(), stamps.end(), [&](const TimeStamp& s) { return s.is_stamp() && what(s); });
  };
  bool day_first = true;
  if (has([](const TimeStamp& s) { return s.date == Date::kDayOrMonthFirst; })) {
    const auto order = is_day_first(stamps);
    if (!order) {
      out.why_not = fmt::format("dates in \"{}\" whose day and month cannot be told apart", column);
      return out;
    }
    day_first = *order;
    out.notes.push_back(fmt::format("\"{}\": dates read as {}", column, day_first ? "day/month" : "month/day"));
  }
  double two_parts = 60.0;
  if (has([](const TimeStamp& s) { return s.clock_parts == 2; })) {
    const auto scale = two_part_scale(stamps, column);
    if (!scale) {
      out.why_not = fmt::format(
          "times in \"{}\" that may be minutes:seconds or hours:minutes (name it \"{} (min:s)\" or \"{} (h:min)\")",
          column, column, column);
      return out;
    }
    two_parts = *scale;
    out.notes.push_back(fmt::format("\"{}\": read as {}", column, two_parts == 1.0 ? "min:s" : "h:min"));
  }
  for (const TimeStamp& s : stamps) {
    out.seconds.push_back(s.is_stamp() ? days_of(s, day_first) * kSecondsPerDay +
                                             (s.clock_parts == 2 ? two_parts : 1.0) * s.clock
                                       : std::nan(""));
  }
  if (!has([](const TimeStamp& s) { return s.date != Date::kNone; })) {
    const std::size_t midnights = pass_midnights(out.seconds);
    if (midnights > 0)
      out.notes.push_back(fmt::format("\"{}\": a clock of the day that passes midnight {} times", column, midnights));
  }
  VOLTLAP_DEMAND(out.seconds.size() == stamps.size());
  return out;
}

}  // namespace voltlap::plant
