// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/plot_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/plot/signal_unit.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMost = 24;         // without being asked
constexpr std::size_t kMostOfQuantity = 6, kMostOfOther = 1;
constexpr std::size_t kMostNamed = 96;    // a page that can still be read
constexpr std::size_t kSuggested = 8;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

bool fits(const std::string& pattern, const std::string& name) {
  if (pattern == name) return true;  // a name may hold brackets
  return fnmatch(pattern.c_str(), name.c_str(), FNM_CASEFOLD) == 0;
}

/// The name as a whole, without its bus, and the signal alone.
bool fits_any(const std::string& pattern, const std::string& name) {
  if (fits(pattern, name)) return true;
  const std::size_t bus = name.find(':'), message = name.find('.');
  if (bus != std::string::npos && fits(pattern, name.substr(bus + 1))) return true;
  return message != std::string::npos && fits(pattern, name.substr(message + 1));
}

std::string without_case_and_marks(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

/// Names that share the longest part with what was asked for.
std::vector<std::string> nearest(const std::string& pattern, const std::vector<SignalHead>& heads) {
  const std::string wanted = without_case_and_marks(pattern);
  std::vector<std::pair<std::size_t, std::string>> found;
  for (const SignalHead& head : heads) {
    const std::string name = without_case_and_marks(head.name);
    std::size_t longest = 0;
    for (std::size_t from = 0; from < wanted.size(); ++from) {
      for (std::size_t length = longest + 1; from + length <= wanted.size(); ++length) {
        if (!contains(name, wanted.substr(from, length))) break;
        longest = length;
      }
    }
    found.emplace_back(longest, head.name);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> out;
  for (std::size_t k = 0; k < std::min(found.size(), kSuggested); ++k) out.push_back(found[k].second);
  return out;
}

[[noreturn]] void refuse(const std::string& pattern, const PlottedSignals& recorded) {
  for (const std::string& name : recorded.silent()) {
    if (!fits_any(pattern, name)) continue;
    throw InputError("--signals " + pattern, name + ", which is described and was never heard in the recording",
                     "a signal that it has", "Choose another one, or check that the frame was recorded");
  }
  throw InputError("--signals " + pattern, "no signal of that name",
                   fmt::format("names or patterns such as {}", fmt::join(nearest(pattern, recorded.heads()), ", ")),
                   "Correct the name; the report without --signals lists all of them");
}

/// Counts, checks and choices of multiplexers say nothing about the car.
bool is_housekeeping(const SignalHead& head, const SignalCourse& course) {
  static constexpr std::array<std::string_view, 12> kWords = {"counter", "crc",  "checksum", "rolling",   "chksum",
                                                              "csum",    "prun", "_cnt",     "_mux",      "alive",
                                                              "clock",   "multiplex"};
  const std::string name = without_case_and_marks(head.name);
  const bool named = std::any_of(kWords.begin(), kWords.end(), [&](std::string_view word) {
    return contains(name, word[0] == '_' ? word.substr(1) : word) && (word[0] != '_' || contains(head.name, word));
  });
  return named || course.is_counter() || course.is_noise();
}

/// How many steps of its last decimal it covers, as a power of two; it counts no more than ten.
double levels_of(const SignalCourse& course) {
  constexpr double kMostLevels = 10.0;
  return std::min(std::log2(1.0 + course.range() * std::pow(10.0, course.decimals())), kMostLevels);
}

/// A signal of many levels that changes often says most.
double score_of(const SignalCourse& course) {
  const double changes = static_cast<double>(course.changes());
  return levels_of(course) + std::min(std::log2(1.0 + changes), 10.0);
}

/// What is measured in units that everybody knows comes first, then what has no unit, then the rest.
enum class Kind { kKnown, kUnitless, kOther };
using Quantity = std::pair<Kind, std::string>;

Quantity quantity_of(const SignalHead& head) {
  const SignalUnit unit = signal_unit(head.unit);
  if (unit.quantity.empty()) return {Kind::kOther, unit.text};
  return {unit.text.empty() ? Kind::kUnitless : Kind::kKnown, unit.quantity};
}

/// Signals that say something, the best first, by what they measure; and how many do not.
struct Moving {
  std::map<Quantity, std::vector<std::size_t>> by_quantity;
  std::size_t heard = 0, constant = 0, housekeeping = 0;

  [[nodiscard]] std::string reason(std::size_t chosen) const {
    if (chosen == heard) return fmt::format("all {} signals", heard);
    const std::size_t moving = heard - constant - housekeeping;
    const std::string which =
        moving == chosen ? fmt::format("the {} of {} signals that move", moving, heard)
                         : fmt::format("{} of the {} signals that move, those that move most of each quantity", chosen,
                                       moving);
    return which + fmt::format("; {} never change, {} are counters or checksums; --signals chooses others", constant,
                               housekeeping);
  }
};

Moving signals_by_quantity(const std::vector<SignalHead>& heads, const std::vector<SignalCourse>& courses) {
  Moving out;
  for (std::size_t k = 0; k < heads.size(); ++k) {
    if (courses[k].samples() == 0) continue;
    ++out.heard;
    if (courses[k].is_constant())
      ++out.constant;
    else if (is_housekeeping(heads[k], courses[k]))
      ++out.housekeeping;
    else
      out.by_quantity[quantity_of(heads[k])].push_back(k);
  }
  for (auto& [quantity, signals] : out.by_quantity) {
    std::stable_sort(signals.begin(), signals.end(),
                     [&](std::size_t a, std::size_t b) { return score_of(courses[a]) > score_of(courses[b]); });
  }
  return out;
}

/// The best of each quantity, then the second of each, and so on, while there is room.
void take_by_rank(const Moving& moving, bool other, std::size_t most_of_each, std::vector<std::size_t>& chosen) {
  for (std::size_t rank = 0; rank < most_of_each; ++rank) {
    for (const auto& [quantity, signals] : moving.by_quantity) {
      const bool is_wanted = (quantity.first == Kind::kOther) == other && rank < signals.size();
      if (is_wanted && chosen.size() < kMost) chosen.push_back(signals[rank]);
    }
  }
}

}  // namespace

PlotChoice signals_named(const std::vector<std::string>& patterns, const PlottedSignals& recorded,
                           const std::vector<SignalCourse>& courses) {
  PlotChoice out;
  const std::vector<SignalHead>& heads = recorded.heads();
  VOLTLAP_DEMAND(courses.size() == heads.size());
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (std::size_t k = 0; k < heads.size(); ++k) {
      if (!fits_any(pattern, heads[k].name) || courses[k].samples() == 0) continue;
      found = true;
      if (std::find(out.signals.begin(), out.signals.end(), k) == out.signals.end()) out.signals.push_back(k);
    }
    if (!found) refuse(pattern, recorded);
  }
  if (out.signals.size() > kMostNamed) {
    throw InputError("--signals", fmt::format("{} signals that fit", out.signals.size()),
                     fmt::format("at most {}", kMostNamed), "Name fewer, or make a page for each part");
  }
  out.reason = fmt::format("{} signals that fit {}", out.signals.size(), fmt::join(patterns, ", "));
  return out;
}

PlotChoice signals_that_move(const std::vector<SignalHead>& heads, const std::vector<SignalCourse>& courses) {
  VOLTLAP_DEMAND(courses.size() == heads.size());
  const Moving moving = signals_by_quantity(heads, courses);
  PlotChoice out;
  take_by_rank(moving, false, kMostOfQuantity, out.signals);
  take_by_rank(moving, true, kMostOfOther, out.signals);
  for (std::size_t k = 0; out.signals.empty() && k < heads.size() && k < kMost; ++k) {
    if (courses[k].samples() > 0) out.signals.push_back(k);
  }
  std::sort(out.signals.begin(), out.signals.end());
  out.reason = moving.reason(out.signals.size());
  return out;
}

}  // namespace voltlap::plant
