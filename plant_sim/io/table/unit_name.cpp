// SPDX-License-Identifier: Apache-2.0
#include "io/table/unit_name.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "io/table/number_field.hpp"

namespace voltlap::plant {
namespace {

struct Spelling {
  std::string_view text;
  NamedUnit unit;
  bool any_case = true;
};

constexpr Quantity kT = Quantity::kTime, kI = Quantity::kCurrent, kU = Quantity::kVoltage,
                   kK = Quantity::kTemperature, kQ = Quantity::kCharge, kP = Quantity::kShare;
constexpr NamedUnit kSecond{"s", kT}, kMilliSecond{"ms", kT, 1e-3}, kMicroSecond{"us", kT, 1e-6},
    kMinute{"min", kT, 60}, kHour{"h", kT, 3600}, kDay{"d", kT, 86400}, kAmpere{"A", kI}, kMilliAmpere{"mA", kI, 1e-3},
    kMicroAmpere{"uA", kI, 1e-6}, kKiloAmpere{"kA", kI, 1e3}, kKiloVolt{"kV", kU, 1e3}, kVolt{"V", kU},
    kMilliVolt{"mV", kU, 1e-3}, kMicroVolt{"uV", kU, 1e-6},
    kCelsius{"degC", kK}, kKelvin{"K", kK, 1, -273.15}, kFahrenheit{"degF", kK, 5.0 / 9.0, -160.0 / 9.0},
    kAmpereHour{"Ah", kQ}, kMilliAmpereHour{"mAh", kQ, 1e-3}, kAmpereSecond{"As", kQ, 1.0 / 3600},
    kPercent{"%", kP, 0.01}, kMetrePerSecond{"m/s", Quantity::kSpeed},
    kKilometrePerHour{"km/h", Quantity::kSpeed, 1 / 3.6},
    kMilePerHour{"mph", Quantity::kSpeed, 0.44704}, kPerMinute{"rpm", Quantity::kRotation},
    kRadianPerSecond{"rad/s", Quantity::kRotation, 60.0 / 6.283185307179586},
    kNewtonMetre{"Nm", Quantity::kTorque}, kMetrePerSecondSquared{"m/s2", Quantity::kAcceleration},
    kGravity{"g", Quantity::kAcceleration, 9.80665};

constexpr std::array kSpellings{
    Spelling{"s", kSecond}, Spelling{"sec", kSecond}, Spelling{"secs", kSecond}, Spelling{"second", kSecond},
    Spelling{"seconds", kSecond}, Spelling{"sek", kSecond}, Spelling{"sekunden", kSecond}, Spelling{"ms", kMilliSecond},
    Spelling{"msec", kMilliSecond}, Spelling{"millis", kMilliSecond}, Spelling{"milliseconds", kMilliSecond},
    Spelling{"us", kMicroSecond}, Spelling{"\xC2\xB5s", kMicroSecond}, Spelling{"\xCE\xBCs", kMicroSecond},
    Spelling{"min", kMinute}, Spelling{"mins", kMinute}, Spelling{"minute", kMinute}, Spelling{"minutes", kMinute},
    Spelling{"minuten", kMinute}, Spelling{"h", kHour}, Spelling{"hr", kHour}, Spelling{"hrs", kHour},
    Spelling{"hour", kHour}, Spelling{"hours", kHour}, Spelling{"std", kHour}, Spelling{"stunden", kHour},
    Spelling{"d", kDay, false}, Spelling{"day", kDay}, Spelling{"days", kDay}, Spelling{"tage", kDay},
    Spelling{"a", kAmpere}, Spelling{"amp", kAmpere}, Spelling{"amps", kAmpere}, Spelling{"ampere", kAmpere},
    Spelling{"amperes", kAmpere}, Spelling{"ma", kMilliAmpere}, Spelling{"milliamps", kMilliAmpere},
    Spelling{"ua", kMicroAmpere}, Spelling{"ka", kKiloAmpere}, Spelling{"kv", kKiloVolt},
    Spelling{"\xC2\xB5" "a", kMicroAmpere}, Spelling{"\xCE\xBC" "a", kMicroAmpere},
    Spelling{"v", kVolt}, Spelling{"volt", kVolt}, Spelling{"volts", kVolt}, Spelling{"vdc", kVolt},
    Spelling{"mv", kMilliVolt}, Spelling{"millivolts", kMilliVolt}, Spelling{"uv", kMicroVolt},
    Spelling{"\xC2\xB5v", kMicroVolt}, Spelling{"degc", kCelsius}, Spelling{"deg c", kCelsius}, Spelling{"c", kCelsius},
    Spelling{"celsius", kCelsius}, Spelling{"\xC2\xB0" "c", kCelsius}, Spelling{"\xC2\xBA" "c", kCelsius},
    Spelling{"\xC2\xB0 c", kCelsius}, Spelling{"\xE2\x84\x83", kCelsius}, Spelling{"grad c", kCelsius},
    Spelling{"k", kKelvin}, Spelling{"kelvin", kKelvin}, Spelling{"f", kFahrenheit}, Spelling{"degf", kFahrenheit},
    Spelling{"deg f", kFahrenheit}, Spelling{"\xC2\xB0" "f", kFahrenheit}, Spelling{"fahrenheit", kFahrenheit},
    Spelling{"ah", kAmpereHour}, Spelling{"a.h", kAmpereHour}, Spelling{"a\xC2\xB7h", kAmpereHour},
    Spelling{"amp-hr", kAmpereHour}, Spelling{"amp-hrs", kAmpereHour}, Spelling{"mah", kMilliAmpereHour},
    Spelling{"ma.h", kMilliAmpereHour}, Spelling{"ma\xC2\xB7h", kMilliAmpereHour}, Spelling{"as", kAmpereSecond},
    Spelling{"a.s", kAmpereSecond}, Spelling{"coulomb", kAmpereSecond}, Spelling{"%", kPercent},
    Spelling{"percent", kPercent}, Spelling{"m/s", kMetrePerSecond}, Spelling{"km/h", kKilometrePerHour},
    Spelling{"kmh", kKilometrePerHour}, Spelling{"kph", kKilometrePerHour}, Spelling{"mph", kMilePerHour},
    Spelling{"rpm", kPerMinute}, Spelling{"1/min", kPerMinute}, Spelling{"u/min", kPerMinute},
    Spelling{"rev/min", kPerMinute}, Spelling{"r/min", kPerMinute}, Spelling{"tr/min", kPerMinute},
    Spelling{"giri/min", kPerMinute}, Spelling{"min-1", kPerMinute}, Spelling{"min^-1", kPerMinute},
    Spelling{"min\xE2\x81\xBB\xC2\xB9", kPerMinute},
    Spelling{"\xD0\xBE\xD0\xB1/\xD0\xBC\xD0\xB8\xD0\xBD", kPerMinute},
    Spelling{"\xE8\xBD\xAC/\xE5\x88\x86", kPerMinute}, Spelling{"rad/s", kRadianPerSecond},
    Spelling{"nm", kNewtonMetre},
    Spelling{"n.m", kNewtonMetre}, Spelling{"m/s2", kMetrePerSecondSquared},
    Spelling{"m/s^2", kMetrePerSecondSquared}, Spelling{"m/s\xC2\xB2", kMetrePerSecondSquared},
    Spelling{"g", kGravity}};

// Of columns that no role has; they say that a row is one of units.
constexpr std::array<std::string_view, 38> kOthers{
    "-",   "1",   "#",   "w",    "kw",   "mw",  "wh",  "mwh",   "w.h", "kwh",  "ohm", "mohm", "\xCE\xA9", "m\xCE\xA9",
    "hz",  "khz", "m",   "mm",   "cm",   "km",  "ft",  "kg",  "deg",  "\xC2\xB0", "rad", "deg/s", "\xC2\xB0/s",
    "bar", "kpa", "mbar", "psi", "pa", "n", "ratio", "cnt", "counts", "v/s", "bool"};

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

std::string_view without_brackets(std::string_view text) {
  text = trimmed(text);
  if (text.size() >= 2 && ((text.front() == '[' && text.back() == ']') || (text.front() == '(' && text.back() == ')')))
    return trimmed(text.substr(1, text.size() - 2));
  return text;
}

/// "ms" of "Time [ms]", "Time(ms)", "time/ms", "I_mA", "Zeit in ms"; where it begins in the header.
std::pair<std::string_view, std::size_t> unit_at_end(std::string_view header) {
  constexpr auto kNone = std::string_view::npos;
  const char last = header.empty() ? '\0' : header.back();
  if (last == ']' || last == ')') {
    const std::size_t open = header.rfind(last == ']' ? '[' : '(');
    if (open != kNone && open > 0) return {trimmed(header.substr(open + 1, header.size() - open - 2)), open};
  }
  for (const std::string_view mark : {"/", " in ", "_", ", ", " "}) {
    for (std::size_t at = header.find(mark); at != kNone; at = header.find(mark, at + 1)) {
      const std::string_view tail = trimmed(header.substr(at + mark.size()));
      if (at > 0 && !tail.empty() && unit_named(tail)) {
        // A plain "a", "c" or "h" after a blank is a word or a number of it, not a unit.
        if (mark != " " || tail.size() > 1) return {tail, at};
      }
    }
  }
  return {{}, header.size()};
}

}  // namespace

std::optional<NamedUnit> unit_named(std::string_view given) {
  const std::string_view text = without_brackets(given);
  const std::string low = lower(text);
  for (const Spelling& spelling : kSpellings) {
    if (spelling.text == (spelling.any_case ? std::string_view(low) : text)) return spelling.unit;
  }
  return std::nullopt;
}

bool is_unit_text(std::string_view text) {
  if (unit_named(text)) return true;
  const std::string low = lower(without_brackets(text));
  if (std::find(kOthers.begin(), kOthers.end(), low) != kOthers.end()) return true;
  return text.size() > 2 && text.front() == '[' && text.back() == ']';
}

namespace {

/// Arbin numbers a channel behind its unit: "Temperature (C)_1" is "Temperature_1 (C)".
void put_number_before_unit(std::string& name) {
  const std::size_t number = name.rfind('_');
  if (number == std::string::npos || number == 0 || name[number - 1] != ')' || number + 1 == name.size()) return;
  const bool digits = std::all_of(name.begin() + static_cast<std::ptrdiff_t>(number) + 1, name.end(),
                                  [](unsigned char c) { return std::isdigit(c) != 0; });
  const std::size_t bracket = name.rfind('(', number);
  if (!digits || bracket == std::string::npos) return;
  name = name.substr(0, bracket) + name.substr(number) + " " + name.substr(bracket, number - bracket);
}

}  // namespace

ColumnName column_name(std::string_view given) {
  std::string plain(trimmed(given));
  for (const auto& [wide, narrow] : {std::pair{"\xEF\xBC\x88", "("}, {"\xEF\xBC\x89", ")"}}) {
    for (std::size_t at = plain.find(wide); at != std::string::npos; at = plain.find(wide))
      plain.replace(at, 3, narrow);
  }
  put_number_before_unit(plain);
  const std::string_view header = plain;
  const auto [unit, at] = unit_at_end(header);
  ColumnName out{"", std::string(unit)};
  for (const char c : header.substr(0, at)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool letter = std::isalnum(byte) != 0 || byte >= 0x80;
    if (letter) out.name += static_cast<char>(std::tolower(byte));
    if (!letter && !out.name.empty() && out.name.back() != ' ') out.name += ' ';
  }
  while (out.name.ends_with(' ')) out.name.pop_back();
  return out;
}

}  // namespace voltlap::plant
