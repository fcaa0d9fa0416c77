// SPDX-License-Identifier: Apache-2.0
#include "io/table/number_field.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array<std::string_view, 22> kMissing{
    "nan",   "-nan",  "null",   "none",   "n/a",   "#n/a", "na",      "n.a.",    "-",       "--",      "---",
    "#div/0!", "#value!", "#ref!", "#name?", "#num!", "#null!", "#wert!", "1.#ind", "-1.#ind", "1.#qnan", "-nan(ind)"};
constexpr std::array<std::string_view, 8> kInfinite{"inf", "-inf", "+inf", "infinity", "-infinity", "1.#inf", "-1.#inf",
                                                    "\xE2\x88\x9E"};
// Between thousands, beside comma and point: apostrophe, no-break blank (UTF-8, Latin-1) and narrow blank.
constexpr std::array<std::string_view, 5> kGroupMarks{"'", "\xE2\x80\x99", "\xC2\xA0", "\xE2\x80\xAF", "\xA0"};
constexpr std::string_view kMinus = "\xE2\x88\x92";  // as word processors write it

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

/// "1,234,567" with mark ",": groups of three after one to three digits that do not begin with 0.
bool is_grouped(std::string_view digits, char mark) {
  const std::size_t first = digits.find(mark);
  if (first == 0 || first == std::string_view::npos || first > 3 || digits[0] == '0') return false;
  for (std::size_t at = 0; at < digits.size(); ++at) {
    const bool mark_expected = at >= first && (at - first) % 4 == 0;
    if (mark_expected ? digits[at] != mark : !is_digit(digits[at])) return false;
  }
  return (digits.size() - first) % 4 == 0;
}

std::string without(std::string_view text, char mark) {
  std::string out(text);
  out.erase(std::remove(out.begin(), out.end(), mark), out.end());
  return out;
}

NumberField value_of(const std::string& plain) {
  double value = 0.0;
  const char* from = plain.data() + (plain.starts_with('+') ? 1 : 0);
  const char* to = plain.data() + plain.size();
  if (from == to || (!is_digit(*from) && *from != '-' && *from != '.')) return {FieldKind::kWord, 0.0};
  const auto [end, error] = std::from_chars(from, to, value);
  if (end != to) return {FieldKind::kWord, 0.0};
  if (error == std::errc::result_out_of_range) {
    const bool tiny = plain.find("e-") != std::string::npos || plain.find("E-") != std::string::npos;
    return tiny ? NumberField{FieldKind::kNumber, 0.0} : NumberField{FieldKind::kNotFinite, 0.0};
  }
  if (error != std::errc{}) return {FieldKind::kWord, 0.0};
  return {std::isfinite(value) ? FieldKind::kNumber : FieldKind::kNotFinite, value};
}

struct Parts {
  std::string_view sign, whole, exponent;  ///< `whole` with point, comma and groups
};

/// Sign, digits and exponent of what could be a number; an empty `whole` when it is none.
Parts parts_of(std::string_view field) {
  Parts out;
  const std::size_t from = field.empty() || (field[0] != '-' && field[0] != '+') ? 0 : 1;
  const std::size_t to = std::min(field.find_first_of("eE", from), field.size());
  out.sign = field.substr(0, from);
  out.whole = field.substr(from, to - from);
  out.exponent = field.substr(to);
  const bool numeric = std::all_of(out.whole.begin(), out.whole.end(),
                                   [](char c) { return is_digit(c) || c == '.' || c == ','; });
  if (!numeric || std::none_of(out.whole.begin(), out.whole.end(), is_digit)) out.whole = {};
  return out;
}

/// A number whose marks between thousands are not the plain ones, with these taken out; groups must have three digits.
std::string without_group_marks(std::string_view field) {
  std::string out(field);
  for (const std::string_view mark : kGroupMarks) {
    for (std::size_t at = out.find(mark); at != std::string::npos; at = out.find(mark, at)) {
      const auto digits_before = at > 0 && is_digit(out[at - 1]);
      const std::size_t after = at + mark.size();
      std::size_t digits = 0;
      while (after + digits < out.size() && is_digit(out[after + digits])) ++digits;
      if (!digits_before || digits != 3) return std::string(field);
      out.erase(at, mark.size());
    }
  }
  return out;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

NumberField number_field(std::string_view given, char decimal) {
  VOLTLAP_DEMAND(decimal == '.' || decimal == ',');
  if (given.empty()) return {FieldKind::kEmpty, 0.0};
  std::string field(given);
  if (given.starts_with(kMinus)) field.replace(0, kMinus.size(), 1, '-');
  if (std::any_of(field.begin(), field.end(), [](char c) { return c == '\'' || (c & 0x80) != 0; }))
    field = without_group_marks(field);
  const Parts parts = parts_of(field);
  if (!parts.whole.empty()) {
    const char group = decimal == '.' ? ',' : '.';
    const std::size_t sign = parts.whole.find(decimal);
    const std::string_view before = parts.whole.substr(0, sign);
    std::string whole(before);
    if (before.find(group) != std::string_view::npos) {
      if (!is_grouped(before, group)) return {FieldKind::kWord, 0.0};
      whole = without(before, group);
    }
    if (sign != std::string_view::npos) whole.append(1, '.').append(parts.whole.substr(sign + 1));
    return value_of(std::string(parts.sign).append(whole).append(parts.exponent));
  }
  const std::string word = lower(field);
  if (std::find(kMissing.begin(), kMissing.end(), word) != kMissing.end()) return {FieldKind::kMissing, 0.0};
  if (std::find(kInfinite.begin(), kInfinite.end(), word) != kInfinite.end()) return {FieldKind::kNotFinite, 0.0};
  return {FieldKind::kWord, 0.0};
}

DecimalEvidence decimal_evidence(std::string_view field) {
  const Parts parts = parts_of(field);
  if (parts.whole.empty()) return DecimalEvidence::kNone;
  const std::size_t comma = parts.whole.rfind(','), point = parts.whole.rfind('.');
  constexpr auto kNo = std::string_view::npos;
  if (comma == kNo && point == kNo) return DecimalEvidence::kNone;
  if (comma != kNo && point != kNo) {
    const bool comma_last = comma > point;
    const std::string_view before = parts.whole.substr(0, comma_last ? comma : point);
    if (!is_grouped(before, comma_last ? '.' : ',')) return DecimalEvidence::kNone;
    return comma_last ? DecimalEvidence::kComma : DecimalEvidence::kPoint;
  }
  const char mark = comma != kNo ? ',' : '.';
  const bool several = std::count(parts.whole.begin(), parts.whole.end(), mark) > 1;
  const bool grouped = is_grouped(parts.whole, mark);
  if (several && !grouped) return DecimalEvidence::kNone;
  if (several) return mark == ',' ? DecimalEvidence::kPoint : DecimalEvidence::kComma;
  if (grouped && parts.exponent.empty())
    return mark == ',' ? DecimalEvidence::kCommaOrGroups : DecimalEvidence::kPointOrGroups;
  return mark == ',' ? DecimalEvidence::kComma : DecimalEvidence::kPoint;
}

}  // namespace voltlap::plant
