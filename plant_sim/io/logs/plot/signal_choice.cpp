// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMost = 24;         // without being asked
constexpr std::size_t kMostOfUnit = 6;
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

[[noreturn]] void refuse(const std::string& pattern, const RecordedSignals& recorded) {
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
bool is_housekeeping(const SignalHead& head, const SignalSurvey& survey) {
  static constexpr std::array<std::string_view, 9> kWords = {"counter", "crc",  "checksum", "rolling", "chksum",
                                                             "_cnt",    "_mux", "alive",    "multiplex"};
  const std::string name = without_case_and_marks(head.name);
  const bool named = std::any_of(kWords.begin(), kWords.end(), [&](std::string_view word) {
    return contains(name, word[0] == '_' ? word.substr(1) : word) && (word[0] != '_' || contains(head.name, word));
  });
  return named || survey.is_counter() || survey.is_noise();
}

/// How many steps of its last decimal it covers, as a power of two; it counts no more than ten.
double levels_of(const SignalSurvey& survey) {
  constexpr double kMostLevels = 10.0;
  return std::min(std::log2(1.0 + survey.range() * std::pow(10.0, survey.decimals())), kMostLevels);
}

/// A signal of many levels that changes often says most.
double score_of(const SignalSurvey& survey) {
  const double changes = static_cast<double>(survey.changes());
  return levels_of(survey) + std::min(std::log2(1.0 + changes), 10.0);
}

}  // namespace

std::string unit_text(const std::string& unit) {
  static const std::map<std::string, std::string> kSame = {
      {"degC", "°C"},    {"C", "°C"},       {"deg C", "°C"}, {"Deg C", "°C"}, {"DegC", "°C"},  {"Celsius", "°C"},
      {"celsius", "°C"}, {"degrees C", "°C"}, {"degc", "°C"},  {"ºC", "°C"}, {"deg", "°"},    {"Deg", "°"},
      {"Volts", "V"},    {"volts", "V"},    {"Volt", "V"},   {"v", "V"},      {"Amps", "A"},   {"amps", "A"},
      {"Amp", "A"},      {"a", "A"},        {"RPM", "rpm"},  {"Rpm", "rpm"},  {"1/min", "rpm"}, {"N.m", "Nm"},
      {"N·m", "Nm"},     {"N-m", "Nm"},     {"nm", "Nm"},    {"kph", "km/h"}, {"kmh", "km/h"}, {"KPH", "km/h"},
      {"Percent", "%"},  {"percent", "%"},  {"pct", "%"},    {"kw", "kW"},    {"KW", "kW"},    {"1", ""},
      {"-", ""},         {"bool", ""},      {"Boolean", ""}, {"none", ""},    {"None", ""},    {"enum", ""},
      {"watts", "W"},    {"ohm", "Ω"},      {"Ohm", "Ω"},    {"sec", "s"},    {"bit", ""},     {"flag", ""}};
  const auto at = kSame.find(unit);
  return at == kSame.end() ? unit : at->second;
}

SignalChoice signals_named(const std::vector<std::string>& patterns, const RecordedSignals& recorded,
                           const std::vector<SignalSurvey>& surveys) {
  SignalChoice out;
  const std::vector<SignalHead>& heads = recorded.heads();
  VOLTLAP_DEMAND(surveys.size() == heads.size());
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (std::size_t k = 0; k < heads.size(); ++k) {
      if (!fits_any(pattern, heads[k].name) || surveys[k].samples() == 0) continue;
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

SignalChoice signals_that_move(const std::vector<SignalHead>& heads, const std::vector<SignalSurvey>& surveys) {
  VOLTLAP_DEMAND(surveys.size() == heads.size());
  std::map<std::string, std::vector<std::size_t>> by_unit;
  std::size_t heard = 0, constant = 0, housekeeping = 0;
  for (std::size_t k = 0; k < heads.size(); ++k) {
    if (surveys[k].samples() == 0) continue;
    ++heard;
    if (surveys[k].is_constant())
      ++constant;
    else if (is_housekeeping(heads[k], surveys[k]))
      ++housekeeping;
    else
      by_unit[unit_text(heads[k].unit)].push_back(k);
  }
  for (auto& [unit, signals] : by_unit) {
    std::stable_sort(signals.begin(), signals.end(),
                     [&](std::size_t a, std::size_t b) { return score_of(surveys[a]) > score_of(surveys[b]); });
  }
  SignalChoice out;
  for (std::size_t rank = 0; rank < kMostOfUnit; ++rank) {
    for (const auto& [unit, signals] : by_unit) {
      if (rank < signals.size() && out.signals.size() < kMost) out.signals.push_back(signals[rank]);
    }
  }
  for (std::size_t k = 0; out.signals.empty() && k < heads.size() && k < kMost; ++k) {
    if (surveys[k].samples() > 0) out.signals.push_back(k);
  }
  std::sort(out.signals.begin(), out.signals.end());
  out.reason = out.signals.size() == heard
                   ? fmt::format("all {} signals", heard)
                   : fmt::format("the {} of {} signals that move most, some of each unit; {} never change, {} are "
                                 "counters or checksums; --signals chooses others",
                                 out.signals.size(), heard, constant, housekeeping);
  return out;
}

}  // namespace voltlap::plant
