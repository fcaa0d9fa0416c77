// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/table/number_field.hpp"
#include "io/table/table_dialect.hpp"
#include "io/table/table_lines.hpp"
#include "io/table/time_stamp.hpp"
#include "io/table_file.hpp"

namespace voltlap::plant {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kExpected = "a table, plain or gzipped";
constexpr const char* kRowsExpected = "a header line with column names and at least one row below it";
// Lines from which separator, decimal sign, names and units are found.
constexpr std::size_t kLinesLookedAt = 2000, kBytesLookedAt = std::size_t{1} << 19;

/// A row that is too long or too short.
struct OddRow {
  std::size_t line = 0, fields = 0;
};

/// Rows of text into the columns of a table, in the dialect that its first lines told.
class TableBuilder {
 public:
  TableBuilder(MeasuredTable& table, TableDialect dialect) : table_(table), dialect_(std::move(dialect)) {
    table_.columns = dialect_.columns;
    table_.values.resize(table_.columns.size());
    table_.about.resize(table_.columns.size());
    stamps_.resize(table_.columns.size());
    row_.resize(table_.columns.size());
    for (std::size_t k = 0; k < table_.columns.size(); ++k) {
      table_.about[k].unit = dialect_.units[k];
      plain_ = plain_ && !dialect_.is_stamp[k];
    }
    plain_ = plain_ && dialect_.separator != ' ' && dialect_.leading_empty == 0;
  }

  void add(std::string_view text, std::size_t line) {
    if (is_passed_over(text)) return;
    if (cut_.line > 0) refuse(cut_);
    if (plain_ && dialect_.decimal == '.' && add_plain_row(text, line)) return;
    add_row(text, line);
  }

  void finish();

 private:
  [[noreturn]] void refuse(const OddRow& row) const;
  bool add_plain_row(std::string_view text, std::size_t line);
  void add_row(std::string_view text, std::size_t line);
  bool is_outer_level() const;
  void add_field(std::size_t column, std::string_view field);
  void add_word(std::size_t column, std::string_view field);
  void check_decimal(std::size_t column, std::string_view field);
  void settle_stamps();

  MeasuredTable& table_;
  TableDialect dialect_;
  std::vector<double> row_;
  std::vector<std::vector<TimeStamp>> stamps_;  ///< [column][row]
  std::vector<TableField> fields_;
  std::vector<std::string> unescaped_;
  bool plain_ = true;  ///< columns of numbers, which need no look at each field's form
  OddRow cut_;         ///< a line that is too short: only the last one may be
  std::size_t outer_rows_ = 0;
  std::size_t line_ = 0;
};

void TableBuilder::refuse(const OddRow& row) const {
  const bool twice = dialect_.separator == ',' && row.fields > table_.columns.size();
  throw InputError(
      fmt::format("{}:{}", table_.path, row.line), fmt::format("{} fields", row.fields),
      fmt::format("{} ({})", table_.columns.size(), fmt::join(table_.columns, ",")),
      twice ? "Complete the row or remove it; with decimal commas separate the fields by semicolons or tabs"
            : "Complete the row or remove it");
}

/// A row of plain numbers and empty fields in one go; false for any other, of which nothing is kept.
bool TableBuilder::add_plain_row(std::string_view text, std::size_t line) {
  const char *at = text.data(), *const end = at + text.size();
  const std::size_t n = row_.size();
  const char separator = dialect_.separator;
  const auto skip_blanks = [&] {
    while (at != end && *at == ' ') ++at;
  };
  std::size_t column = 0;
  for (; column < n; ++column) {
    skip_blanks();
    const auto [after, error] = std::from_chars(at, end, row_[column]);
    if (error != std::errc{} || row_[column] - row_[column] != 0.0) return false;
    at = after;
    skip_blanks();
    if (at == end) break;
    if (*at != separator) return false;
    ++at;
  }
  if (at != end || column + 1 != n) return false;
  for (std::size_t k = 0; k < n; ++k) table_.values[k].push_back(row_[k]);
  table_.lines.push_back(line);
  return true;
}

/// Of a nested table: a row that begins before the innermost level's fields.
bool TableBuilder::is_outer_level() const {
  const std::size_t before = std::min(dialect_.leading_empty, fields_.size());
  return std::any_of(fields_.begin(), fields_.begin() + static_cast<std::ptrdiff_t>(before),
                     [](const TableField& field) { return !field.text.empty(); });
}

void TableBuilder::add_row(std::string_view text, std::size_t line) {
  split_row(text, dialect_.separator, fields_, unescaped_);
  if (is_outer_level()) {
    ++outer_rows_;
    return;
  }
  const std::size_t n = table_.columns.size();
  while (fields_.size() > n && fields_.back().text.empty() && !fields_.back().quoted) fields_.pop_back();
  if (fields_.size() > n) refuse({line, fields_.size()});
  if (fields_.size() < n) {
    cut_ = {line, fields_.size()};
    return;
  }
  line_ = line;
  for (std::size_t k = 0; k < n; ++k) add_field(k, fields_[k].text);
  table_.lines.push_back(line);
}

void TableBuilder::check_decimal(std::size_t column, std::string_view field) {
  const DecimalEvidence evidence = decimal_evidence(field);
  if (dialect_.decimal_open && evidence != DecimalEvidence::kNone) {
    const bool comma = evidence == DecimalEvidence::kComma || evidence == DecimalEvidence::kCommaOrGroups;
    dialect_.decimal = comma ? ',' : '.';
    dialect_.decimal_open = false;
    if (comma) table_.notes.push_back(fmt::format("decimal comma, first in line {}", line_));
    if (evidence == DecimalEvidence::kCommaOrGroups) {
      table_.about[column].unreadable =
          fmt::format("\"{}\" in line {}, which may have a decimal comma or a mark between thousands", field, line_);
    }
  }
  const bool other = dialect_.decimal == '.' ? evidence == DecimalEvidence::kComma
                                             : evidence == DecimalEvidence::kPoint;
  if (other && table_.about[column].unreadable.empty()) {
    table_.about[column].unreadable = fmt::format("\"{}\" in line {} among numbers with a decimal {}", field, line_,
                                                  dialect_.decimal == '.' ? "point" : "comma");
  }
}

void TableBuilder::add_field(std::size_t column, std::string_view field) {
  std::vector<double>& values = table_.values[column];
  MeasuredColumn& about = table_.about[column];
  if (dialect_.is_stamp[column]) {
    stamps_[column].resize(values.size());
    stamps_[column].push_back(time_stamp(field));
    values.push_back(kNothing);
    if (stamps_[column].back().is_stamp()) return;
    about.holes.empty += field.empty() ? 1 : 0;
    about.holes.words += field.empty() ? 0 : 1;
    return;
  }
  double value = 0.0;
  if (!dialect_.decimal_open && plain_number(field, dialect_.decimal, value)) return values.push_back(value);
  if (field.find_first_of(".,") != std::string_view::npos) check_decimal(column, field);
  const NumberField read = number_field(field, dialect_.decimal);
  values.push_back(read.kind == FieldKind::kNumber ? read.value : kNothing);
  if (read.kind == FieldKind::kNumber) return;
  if (read.kind == FieldKind::kEmpty) ++about.holes.empty;
  if (read.kind == FieldKind::kMissing) ++about.holes.missing;
  if (read.kind == FieldKind::kNotFinite) ++about.holes.not_finite;
  if (read.kind == FieldKind::kWord) add_word(column, field);
  if (about.holes.example.empty()) about.holes.example = utf8_of(field.substr(0, 40));
}

void TableBuilder::add_word(std::size_t column, std::string_view field) {
  MeasuredColumn& about = table_.about[column];
  ++about.holes.words;
  auto at = std::find(about.words.begin(), about.words.end(), field);
  if (at == about.words.end()) {
    if (about.words.size() >= MeasuredColumn::kMostWords) return;
    at = about.words.emplace(about.words.end(), field);
  }
  about.word_of_row.resize(table_.values[column].size());
  about.word_of_row.back() = static_cast<unsigned char>(at - about.words.begin() + 1);
}

void TableBuilder::settle_stamps() {
  for (std::size_t k = 0; k < table_.columns.size(); ++k) {
    if (!dialect_.is_stamp[k]) continue;
    stamps_[k].resize(table_.rows());
    StampSeconds read = seconds_of(stamps_[k], table_.columns[k]);
    table_.about[k].is_stamp = true;
    table_.about[k].unit.assign(1, 's');
    table_.about[k].unreadable = read.why_not.value_or("");
    if (!read.why_not) table_.values[k] = std::move(read.seconds);
    table_.about[k].notes = std::move(read.notes);
  }
}

void TableBuilder::finish() {
  if (cut_.line > 0) table_.repairs.push_back(fmt::format("last line {} is cut off: left out", cut_.line));
  if (outer_rows_ > 0)
    table_.notes.push_back(fmt::format("{} rows of outer levels (cycles, steps) passed over", outer_rows_));
  settle_stamps();
  for (MeasuredColumn& about : table_.about) {
    for (std::string& word : about.words) word = utf8_of(word);
  }
}

std::vector<TableLine> first_lines(TableLines& lines) {
  std::vector<TableLine> out;
  std::string_view text;
  std::size_t bytes = 0;
  while (out.size() < kLinesLookedAt && bytes < kBytesLookedAt && lines.next(text)) {
    out.push_back({std::string(text), lines.line()});
    bytes += text.size();
  }
  return out;
}

}  // namespace

std::string MeasuredColumn::Holes::text() const {
  std::vector<std::string> parts;
  const auto add = [&](std::size_t count, const char* what) {
    if (count > 0) parts.push_back(fmt::format("{} {}", count, what));
  };
  add(empty, "empty");
  add(missing, "marked as none");
  add(not_finite, "not finite");
  add(words, "words");
  return fmt::format("{}{}", fmt::join(parts, ", "), example.empty() ? "" : fmt::format(", such as \"{}\"", example));
}

int MeasuredTable::find(std::string_view column) const {
  const auto at = std::find(columns.begin(), columns.end(), column);
  return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
}

std::size_t MeasuredTable::index_for(const std::string& column, const std::string& role,
                                     const std::string& map) const {
  const int found = find(column);
  if (found < 0) {
    throw InputError(path, fmt::format("no column \"{}\" among {}", column, fmt::join(columns, ", ")),
                     fmt::format("that column for the role {} ({})", role, map), "Correct the map or the file");
  }
  const auto index = static_cast<std::size_t>(found);
  for (std::size_t other = index + 1; other < columns.size(); ++other) {
    if (columns[other] != column) continue;
    const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    if (std::equal(values[index].begin(), values[index].end(), values[other].begin(), values[other].end(), same))
      continue;
    throw InputError(path, fmt::format("the name \"{}\" for column {} and for column {}", column, index + 1, other + 1),
                     fmt::format("one column for the role {}", role),
                     "Rename one of them in the file, and name the other in a map");
  }
  if (!about.empty() && !about[index].unreadable.empty()) {
    throw InputError(fmt::format("{}, column \"{}\"", path, column), about[index].unreadable,
                     "numbers, or time stamps, that can be read in one way only", "Write it in one form");
  }
  return index;
}

MeasuredTable read_measured_table(const std::string& path) {
  TableLines lines(path, kExpected);
  const std::vector<TableLine> first = first_lines(lines);
  TableDialect dialect = dialect_of(path, first);
  MeasuredTable table;
  table.path = path;
  table.notes = dialect.notes;
  if (lines.was_utf16()) table.notes.emplace_back("UTF-16 brought to UTF-8");
  const std::size_t first_row = dialect.header_line > 0 ? dialect.first_row : first.size();
  TableBuilder builder(table, std::move(dialect));
  for (std::size_t k = first_row; k < first.size(); ++k) builder.add(first[k].text, first[k].number);
  std::string_view text;
  while (lines.next(text)) builder.add(text, lines.line());
  builder.finish();
  if (table.lines.empty() || table.columns.empty()) {
    throw InputError(path,
                     table.lines.empty() && table.columns.empty() ? "an empty file"
                     : table.lines.empty()                        ? "a header line without rows"
                                                                  : "rows below a header line without a name",
                     kRowsExpected,
                     "Check that this is the recording you meant");
  }
  VOLTLAP_DEMAND(table.values.size() == table.columns.size());
  VOLTLAP_DEMAND(table.values.back().size() == table.lines.size());
  return table;
}

}  // namespace voltlap::plant
