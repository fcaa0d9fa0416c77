// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_dialect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/table/number_field.hpp"
#include "io/table/table_lines.hpp"
#include "io/table/time_stamp.hpp"
#include "io/table/unit_name.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array kSeparators{';', '\t', '|', ',', ' '};
constexpr std::string_view kCommentMarks = "#%~/ \t";

enum class Content { kEmpty, kNumber, kStamp, kWord };

Content content_of(std::string_view field) {
  if (field.empty()) return Content::kEmpty;
  for (const char decimal : {'.', ','}) {
    const FieldKind kind = number_field(field, decimal).kind;
    if (kind == FieldKind::kMissing) return Content::kEmpty;
    if (kind != FieldKind::kWord) return Content::kNumber;
  }
  return time_stamp(field).is_stamp() ? Content::kStamp : Content::kWord;
}

/// A line split by one of the separators.
struct SplitLine {
  std::size_t index = 0;  ///< among the lines
  bool comment = false;
  std::vector<std::string> fields;
  std::vector<Content> contents;
  std::size_t numbers = 0, words = 0;

  [[nodiscard]] std::size_t size() const { return fields.size(); }
  /// Without empty fields at the end.
  [[nodiscard]] std::size_t filled() const {
    std::size_t n = contents.size();
    while (n > 0 && fields[n - 1].empty()) --n;
    return n;
  }
  [[nodiscard]] bool is_data() const {
    const auto is_value = [](Content c) { return c == Content::kNumber || c == Content::kStamp; };
    if (comment || numbers == 0) return false;
    const auto first = std::find_if(contents.begin(), contents.end(), [](Content c) { return c != Content::kEmpty; });
    const bool begins = is_value(*first);
    return numbers > words || (begins && (numbers >= 2 || numbers >= words));
  }
  [[nodiscard]] bool is_names() const {
    return words > numbers || (words > 0 && !contents.empty() && contents.front() == Content::kWord);
  }
};

SplitLine split_line(std::string_view text, char separator, bool comment) {
  SplitLine out;
  out.comment = comment;
  if (comment) text.remove_prefix(std::min(text.find_first_not_of(kCommentMarks), text.size()));
  std::vector<TableField> fields;
  std::vector<std::string> unescaped;
  split_row(text, separator, fields, unescaped);
  for (const TableField& field : fields) {
    out.fields.emplace_back(field.text);
    const Content content = content_of(field.text);
    out.contents.push_back(content);
    if (content == Content::kWord) ++out.words;
    if (content == Content::kNumber || content == Content::kStamp) ++out.numbers;
  }
  return out;
}

/// What the lines are with one separator.
struct Reading {
  char separator = ',';
  std::vector<SplitLine> lines;             ///< without blank ones
  std::size_t fields = 0;                   ///< of most rows
  std::size_t first_data = 0;               ///< index into `lines`
  std::optional<std::size_t> names, units;  ///< indices into `lines`
  double score = 0.0;                       ///< numbers in rows of that size, words count against it

  [[nodiscard]] bool is_row(const SplitLine& line) const { return line.is_data() && line.size() == fields; }
};

std::size_t usual_size(const std::vector<SplitLine>& lines) {
  std::map<std::size_t, std::size_t> numbers;  // by size of the row
  for (const SplitLine& line : lines) {
    if (line.is_data()) numbers[line.size()] += line.numbers;
  }
  const auto most = std::max_element(numbers.begin(), numbers.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == numbers.end() ? 0 : most->first;
}

/// Fields that say units: "[V]", "(V)", "V"; empty ones do not count.
bool is_unit_row(const SplitLine& line) {
  std::size_t units = 0, others = 0;
  for (const std::string& field : line.fields) {
    if (field.empty()) continue;
    (is_unit_text(field) ? units : others) += 1;
  }
  return units > 0 && units >= others && line.numbers * 2 <= units;
}

/// Names fit rows whose separator at the end, if any, makes one more field.
bool fits(const SplitLine& line, std::size_t fields) {
  return line.size() == fields || line.filled() == fields || line.size() + 1 == fields;
}

/// The line of names is the last above the rows that is no unit row; a comment where there is no other.
void find_names(Reading& reading) {
  std::vector<std::size_t> units;
  for (std::size_t k = reading.first_data; k-- > 0;) {
    const SplitLine& line = reading.lines[k];
    if (line.comment) continue;
    const bool unit_row = is_unit_row(line);
    if (!fits(line, reading.fields) || !(line.is_names() || unit_row)) break;
    if (unit_row) {
      units.push_back(k);
      if (units.size() > 2) break;
      continue;
    }
    const bool describes = k > 0 && fits(reading.lines[k - 1], reading.fields) && reading.lines[k - 1].is_names() &&
                           !reading.lines[k - 1].comment && 2 * line.filled() < reading.lines[k - 1].filled();
    if (describes) continue;
    reading.names = k;
    break;
  }
  if (!reading.names && !units.empty()) {
    reading.names = units.back();
    units.pop_back();
  }
  if (reading.names && !units.empty()) reading.units = units.back();
  for (std::size_t k = reading.first_data; k-- > 0 && !reading.names;) {
    const SplitLine& line = reading.lines[k];
    if (line.comment && line.size() == reading.fields && line.is_names()) reading.names = k;
  }
}

Reading reading_with(char separator, const std::vector<TableLine>& lines) {
  Reading out;
  out.separator = separator;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::string_view text = lines[k].text;
    if (trimmed(text).empty()) continue;
    out.lines.push_back(split_line(text, separator, is_passed_over(text)));
    out.lines.back().index = k;
  }
  out.fields = usual_size(out.lines);
  const auto is_row = [&](const SplitLine& line) { return out.is_row(line); };
  out.first_data =
      static_cast<std::size_t>(std::find_if(out.lines.begin(), out.lines.end(), is_row) - out.lines.begin());
  // Rows of other sizes directly above belong to the table too: a short one is named later, by its line.
  while (out.first_data > 0 && out.first_data < out.lines.size() && out.lines[out.first_data - 1].is_data())
    --out.first_data;
  for (const SplitLine& line : out.lines) {
    if (is_row(line)) out.score += static_cast<double>(line.numbers) - static_cast<double>(line.words);
  }
  if (out.first_data < out.lines.size()) find_names(out);
  return out;
}

/// The separator with which the most numbers stand in rows of one size below names of that size.
Reading best_reading(const std::vector<TableLine>& lines) {
  std::optional<Reading> best;
  bool tabs = false;
  for (const char separator : kSeparators) {
    if (separator == ' ' && tabs) continue;  // the blank between date and time of day separates nothing
    Reading reading = reading_with(separator, lines);
    tabs = tabs || (separator == '\t' && reading.fields >= 2 && reading.names && reading.score > 0.0);
    if (reading.fields < 2) continue;
    const auto rank = [](const Reading& r) { return std::pair(r.names.has_value(), r.score); };
    if (!best || rank(reading) > rank(*best)) best = std::move(reading);
  }
  if (best) return std::move(*best);
  const bool semicolons = std::any_of(lines.begin(), lines.end(), [](const TableLine& line) {
    return !is_passed_over(line.text) && line.text.find(';') != std::string::npos;
  });
  return reading_with(semicolons ? ';' : ',', lines);  // one column, or no numbers at all
}

void set_decimal(const std::string& path, const Reading& reading, const std::vector<TableLine>& lines,
                 TableDialect& out) {
  std::map<DecimalEvidence, std::pair<std::size_t, std::string>> seen;  // count and the first
  for (std::size_t k = reading.first_data; k < reading.lines.size(); ++k) {
    const SplitLine& line = reading.lines[k];
    for (std::size_t f = 0; f < line.size(); ++f) {
      if (line.contents[f] != Content::kNumber) continue;
      auto& [count, first] = seen[decimal_evidence(line.fields[f])];
      if (count++ == 0) first = fmt::format("{}:{}: \"{}\"", path, lines[line.index].number, line.fields[f]);
    }
  }
  const std::size_t commas = seen[DecimalEvidence::kComma].first, points = seen[DecimalEvidence::kPoint].first;
  const bool maybe = seen[DecimalEvidence::kCommaOrGroups].first > 0;
  out.decimal = commas > points || (commas == 0 && points == 0 && maybe) ? ',' : '.';
  out.decimal_open = commas == 0 && points == 0 && !maybe && seen[DecimalEvidence::kPointOrGroups].first == 0;
  if (commas == 0 && points == 0 && maybe) {
    throw InputError(path, "numbers such as " + seen[DecimalEvidence::kCommaOrGroups].second,
                     "a decimal sign that can be told from marks between thousands",
                     "1,234 may be 1.234 or 1234: write a decimal point, and nothing between thousands");
  }
}

std::vector<std::string> names_of(const Reading& reading, TableDialect& out) {
  const SplitLine& names = reading.lines[*reading.names];
  std::vector<std::string> columns(names.fields.begin(),
                                   names.fields.begin() + static_cast<std::ptrdiff_t>(names.filled()));
  // A row that is one field longer than its names ends with a separator.
  for (std::size_t k = 0; k < columns.size(); ++k) {
    columns[k] = utf8_of(columns[k]);
    std::replace(columns[k].begin(), columns[k].end(), '\n', ' ');
    if (columns[k].size() > 2 && columns[k].starts_with('\'') && columns[k].ends_with('\''))
      columns[k] = columns[k].substr(1, columns[k].size() - 2);
    if (columns[k].empty()) columns[k] = fmt::format("column {}", k + 1);
  }
  while (out.leading_empty < names.size() && names.fields[out.leading_empty].empty()) ++out.leading_empty;
  const bool any_row = reading.first_data < reading.lines.size() && reading.lines[reading.first_data].is_data();
  if (out.leading_empty < 2 || !any_row) out.leading_empty = 0;
  return columns;
}

void find_stamps(const Reading& reading, TableDialect& out) {
  std::vector<std::size_t> stamps(out.columns.size()), others(out.columns.size());
  for (std::size_t k = reading.first_data; k < reading.lines.size(); ++k) {
    const SplitLine& line = reading.lines[k];
    if (!reading.is_row(line)) continue;
    for (std::size_t f = 0; f < std::min(line.size(), out.columns.size()); ++f) {
      if (line.contents[f] == Content::kStamp) ++stamps[f];
      if (line.contents[f] == Content::kNumber || line.contents[f] == Content::kWord) ++others[f];
    }
  }
  for (std::size_t f = 0; f < out.columns.size(); ++f) out.is_stamp.push_back(stamps[f] > others[f]);
}

std::string name_of_separator(char separator) {
  if (separator == '\t') return "tabs";
  return separator == ' ' ? "blanks" : fmt::format("\"{}\"", separator);
}

void note_what_is_unusual(const Reading& reading, const std::vector<TableLine>& lines, TableDialect& out) {
  std::vector<std::string> parts;
  if (out.separator != ',') parts.push_back("fields separated by " + name_of_separator(out.separator));
  if (out.decimal == ',') parts.emplace_back("decimal comma");
  std::size_t before = 0;
  for (std::size_t k = 0; k < *reading.names; ++k) before += reading.lines[k].comment ? 0 : 1;
  if (before > 0) parts.push_back(fmt::format("{} lines above the names passed over", before));
  if (before > 0 || reading.lines[*reading.names].comment)
    parts.push_back(fmt::format("names in line {}", out.header_line));
  if (reading.units)
    parts.push_back(fmt::format("units in line {}", lines[reading.lines[*reading.units].index].number));
  if (out.leading_empty > 0) parts.emplace_back("rows of the innermost of nested levels only");
  if (parts.empty()) return;
  std::string text = "table read with " + parts.front();
  for (std::size_t k = 1; k < parts.size(); ++k) text += ", " + parts[k];
  out.notes.push_back(text);
}

/// Recordings have hundreds of columns; what has a separator at every other byte is none.
void refuse_endless_rows(const std::string& path, const std::vector<TableLine>& lines) {
  constexpr std::ptrdiff_t kMostFields = 20'000;
  for (const TableLine& line : lines) {
    for (const char separator : kSeparators) {
      const auto fields = std::count(line.text.begin(), line.text.end(), separator) + 1;
      if (separator == ' ' || fields <= kMostFields) continue;
      throw InputError(fmt::format("{}:{}", path, line.number),
                       fmt::format("a row of {} fields", fields),
                       fmt::format("at most {} columns", kMostFields), "Check that this is the recording you meant");
    }
  }
}

/// Without a row of numbers below names: the first line of content is the header, whatever follows.
void take_first_line_as_names(Reading& reading) {
  const auto content = std::find_if(reading.lines.begin(), reading.lines.end(),
                                    [](const SplitLine& line) { return !line.comment; });
  if (content == reading.lines.end()) return;
  reading.names = static_cast<std::size_t>(content - reading.lines.begin());
  reading.first_data = *reading.names + 1;
}

}  // namespace

bool is_passed_over(std::string_view text) {
  text = trimmed(text);
  return text.empty() || text[0] == '#' || text[0] == '%' || text[0] == '~' || text.starts_with("//");
}

TableDialect dialect_of(const std::string& path, const std::vector<TableLine>& lines) {
  refuse_endless_rows(path, lines);
  Reading reading = best_reading(lines);
  if (!reading.names) {
    const bool numbers = reading.first_data < reading.lines.size() && reading.fields >= 2;
    if (numbers) {
      const TableLine& first = lines[reading.lines[reading.first_data].index];
      throw InputError(fmt::format("{}:{}", path, first.number),
                       fmt::format("rows of {} numbers without a line of {} names above them", reading.fields,
                                   reading.fields),
                       "a header line such as time_s,current_a,voltage_v, with a name for each field",
                       "Add it, or give the rows the fields that the header has; with decimal commas separate them by "
                       "semicolons");
    }
    take_first_line_as_names(reading);
  }
  TableDialect out;
  out.separator = reading.separator;
  if (!reading.names) return out;
  out.columns = names_of(reading, out);
  out.header_line = lines[reading.lines[*reading.names].index].number;
  const bool any = reading.first_data < reading.lines.size();
  out.first_row = any ? reading.lines[reading.first_data].index : lines.size();
  if (reading.units) {
    for (const std::string& unit : reading.lines[*reading.units].fields) out.units.push_back(utf8_of(unit));
  }
  out.units.resize(out.columns.size());
  set_decimal(path, reading, lines, out);
  find_stamps(reading, out);
  note_what_is_unusual(reading, lines, out);
  VOLTLAP_DEMAND(out.is_stamp.size() == out.columns.size() && out.units.size() == out.columns.size());
  VOLTLAP_DEMAND(out.decimal == '.' || out.decimal == ',');
  return out;
}

}  // namespace voltlap::plant
