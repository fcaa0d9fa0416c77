// SPDX-License-Identifier: Apache-2.0
// A table of drawn numbers, written in a drawn dialect, gives the same numbers back.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "io/table_file.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

struct Drawn {
  std::mt19937 engine;
  [[nodiscard]] bool maybe(double share = 0.5) { return std::bernoulli_distribution(share)(engine); }
  [[nodiscard]] int number(int low, int high) { return std::uniform_int_distribution(low, high)(engine); }
  [[nodiscard]] double real(double low, double high) { return std::uniform_real_distribution(low, high)(engine); }
  template <class T>
  [[nodiscard]] const T& of(const std::vector<T>& all) {
    return all[static_cast<std::size_t>(number(0, static_cast<int>(all.size()) - 1))];
  }
};

struct Style {
  char separator = ',', decimal = '.';
  std::string end = "\n";
  bool mark = false, unit_row = false, quoted = false, trailing = false, groups = false, utf16 = false;
  int preamble = 0;

  static Style drawn(Drawn& draw) {
    Style out;
    out.separator = draw.of(std::vector{',', ';', '\t', '|', ' '});
    out.quoted = out.separator != ' ' && draw.maybe(0.3);
    out.decimal = (out.separator != ',' || out.quoted) && draw.maybe() ? ',' : '.';
    out.end = draw.maybe() ? "\n" : "\r\n";
    out.mark = draw.maybe(0.3);
    out.utf16 = draw.maybe(0.2);
    out.unit_row = draw.maybe(0.3);
    out.trailing = out.separator != ' ' && draw.maybe(0.3);
    out.groups = draw.maybe(0.2) && (out.separator != ',' || out.quoted);
    out.preamble = draw.maybe(0.4) ? draw.number(1, 12) : 0;
    return out;
  }
  [[nodiscard]] std::string text() const {
    return fmt::format("separator '{}', decimal '{}', {} line ends, mark {}, unit row {}, quoted {}, trailing {}, "
                       "groups {}, utf16 {}, preamble {}",
                       separator, decimal, end.size() == 2 ? "Windows" : "plain", mark, unit_row, quoted, trailing,
                       groups, utf16, preamble);
  }
};

/// With as many digits as a double has, in a drawn form.
std::string written(double value, const Style& style, Drawn& draw) {
  std::string out = draw.maybe(0.2) ? fmt::format("{:.17E}", value) : fmt::format("{:.17g}", value);
  if (out.find('e') == std::string::npos && out.find('E') == std::string::npos) {
    const std::size_t from = out[0] == '-' ? 1 : 0;
    if (value >= 0.0 && draw.maybe(0.2)) out.insert(0, 1, '+');
    else if (out.compare(from, 2, "0.") == 0 && draw.maybe(0.2)) out.erase(from, 1);
    else if (style.groups) {
      std::size_t whole = std::min(out.find('.'), out.size());
      while (whole > from + 3) out.insert(whole -= 3, 1, '\'');
    }
  }
  if (style.decimal == ',') std::replace(out.begin(), out.end(), '.', ',');
  return out;
}

std::string joined(const std::vector<std::string>& fields, const Style& style, Drawn& draw) {
  std::string out;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (k > 0) out += style.separator == ' ' ? std::string(static_cast<std::size_t>(draw.number(1, 4)), ' ')
                                             : std::string(1, style.separator);
    out += style.quoted ? "\"" + fields[k] + "\"" : fields[k];
  }
  if (style.trailing) out += style.separator;
  return out + style.end;
}

struct Table {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;  // [column][row]
  std::string text;
};

Table drawn_table(const Style& style, Drawn& draw) {
  Table out;
  out.names = {"time", "current", "voltage", "temp"};
  if (draw.maybe()) out.names.emplace_back("charge");
  std::shuffle(out.names.begin(), out.names.end(), draw.engine);
  const int rows = draw.number(2, 60);
  for (int k = 0; k < style.preamble; ++k)
    out.text += draw.maybe(0.2) ? style.end : fmt::format("Key {}: some words{}", k, style.end);
  out.text += joined(out.names, style, draw);
  if (style.unit_row) {
    const std::map<std::string, std::string> unit_of{
        {"time", "s"}, {"current", "A"}, {"voltage", "V"}, {"temp", "degC"}, {"charge", "Ah"}};
    std::vector<std::string> units;
    for (const std::string& name : out.names) units.push_back(unit_of.at(name));
    out.text += joined(units, style, draw);
  }
  out.values.resize(out.names.size());
  for (int row = 0; row < rows; ++row) {
    std::vector<std::string> fields;
    for (std::size_t column = 0; column < out.names.size(); ++column) {
      const double value = draw.real(-1.0, 1.0) * std::pow(10.0, draw.number(-4, 5));
      out.values[column].push_back(value);
      fields.push_back(written(value, style, draw));
    }
    if (draw.maybe(0.05)) out.text += style.end;
    out.text += joined(fields, style, draw);
  }
  return out;
}

std::string encoded(const std::string& text, const Style& style) {
  if (!style.utf16) return (style.mark ? "\xEF\xBB\xBF" : "") + text;
  std::string out = style.mark ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : text) {
    const char pair[2] = {style.mark ? '\0' : c, style.mark ? c : '\0'};
    out.append(pair, 2);
  }
  return out;
}

}  // namespace

TEST_GROUP(DrawnTable) { Scratch scratch; };

TEST(DrawnTable, NumbersComeBackInWhateverDialectTheyAreWritten) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
  Drawn draw{std::mt19937(seed)};
  for (int k = 0; k < 300; ++k) {
    const Style style = Style::drawn(draw);
    const Table table = drawn_table(style, draw);
    const std::string about = fmt::format("VOLTLAP_TEST_SEED={}, draw {}: {}\n{}", seed, k, style.text(),
                                          table.text.substr(0, 1500));
    const std::string path = scratch.write("drawn.csv", encoded(table.text, style));
    MeasuredTable read;
    const std::string refused = complaint([&] { read = read_measured_table(path); });
    STRCMP_EQUAL_TEXT("no error", refused.c_str(), about.c_str());
    CHECK_TEXT(read.columns == table.names, about.c_str());
    CHECK_TEXT(read.values == table.values, about.c_str());
    for (std::size_t column = 0; column < table.names.size(); ++column)
      CHECK_TEXT(read.about[column].unit.empty() != style.unit_row, about.c_str());
  }
}
