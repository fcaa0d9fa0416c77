// SPDX-License-Identifier: Apache-2.0
// Tables of frames, as bus analysers export them: a header names the columns; a line is a frame.
//   ParserFlags	Ch	Counter	T/R	Time	Flags	CAN ID	Len	Data
//   1	0	1	RX	48659511		0x000001db	8	0xee c0 c3 ea 00 f7 61 9b
#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "io/logs/can/line_words.hpp"

namespace voltlap::plant {
namespace {

/// The fields of a line, without blanks and quotation marks around them.
std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find(separator, from), line.size());
    std::string_view field = line.substr(from, end - from);
    const auto is_margin = [](char c) { return c == ' ' || c == '"' || c == '\t'; };
    while (!field.empty() && is_margin(field.front())) field.remove_prefix(1);
    while (!field.empty() && is_margin(field.back())) field.remove_suffix(1);
    out.push_back(field);
    from = end + 1;
  }
  return out;
}

std::string plain(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return out;
}

bool is_one_of(const std::string& name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Columns by their names; whether time, identifier and data are there.
bool take_header(std::string_view line, char separator, FrameTableHeader& out) {
  FrameTableHeader header;
  const std::vector<std::string_view> names = fields_of(line, separator);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::string name = plain(names[k]);
    const int column = static_cast<int>(k);
    if (header.time < 0 && is_one_of(name, {"time", "timestamp", "times", "timems", "abstime", "reltime", "t"})) {
      header.time = column;
    } else if (header.id < 0 && is_one_of(name, {"canid", "id", "identifier", "idhex", "arbid", "msgid"})) {
      header.id = column;
    } else if (header.length < 0 && is_one_of(name, {"len", "dlc", "length", "datalength"})) {
      header.length = column;
    } else if (header.data < 0 &&
               is_one_of(name, {"data", "datahex", "databytes", "data0", "b0", "b1", "byte0", "d0", "d1"})) {
      header.data = column;
    } else if (header.bus < 0 && is_one_of(name, {"ch", "bus", "channel", "chn"})) {
      header.bus = column;
    } else if (header.extended < 0 && is_one_of(name, {"ext", "extended", "ide", "isextended"})) {
      header.extended = column;
    }
  }
  if (header.time < 0 || header.id < 0 || header.data < 0) return false;
  const std::string time = plain(names[static_cast<std::size_t>(header.time)]);
  const bool gvret = time == "timestamp" && header.extended >= 0 && plain(names[0]) == time;
  header.tick_s = gvret ? 1e-6 : time == "timems" ? 1e-3 : out.tick_s;
  header.separator = separator;
  out = header;
  return true;
}

std::string_view without_prefix(std::string_view text) {
  return text.starts_with("0x") || text.starts_with("0X") ? text.substr(2) : text;
}

/// Bytes in one field with blanks or none between them, or one in each field from the first on.
bool take_data(const std::vector<std::string_view>& fields, std::size_t first, std::size_t most, RecordedFrame& out) {
  std::string digits;
  for (std::size_t k = first; k < fields.size() && digits.size() < 2 * most; ++k) {
    std::string_view rest = fields[k];
    while (!rest.empty()) {
      const std::string_view byte = without_prefix(next_word(rest));
      if (byte.size() == 1) digits += '0';
      digits += byte;
    }
    if (digits.size() > 2) break;  // all bytes stood in one field
  }
  if (digits.size() > 2 * most) digits.resize(2 * most);
  return hex_bytes(digits, RecordedFrame::kMostBytes, out);
}

}  // namespace

CanLine parse_frame_table(std::string_view line, CanLineState& state, RecordedFrame& out) {
  FrameTableHeader& header = state.table;
  if (!header.known()) {
    // What stands before the header is a preamble.
    for (const char separator : {'\t', ',', ';'}) {
      if (take_header(line, separator, header)) break;
    }
    return CanLine::kHeader;
  }
  const std::vector<std::string_view> fields = fields_of(line, header.separator);
  if (fields.size() == 1 && fields[0].empty()) return CanLine::kHeader;
  const int last = std::max({header.time, header.id, header.data, header.length, header.extended});
  if (std::ssize(fields) <= last) return CanLine::kUnreadable;
  const auto field = [&](int column) { return fields[static_cast<std::size_t>(column)]; };
  double time = 0.0;
  std::uint32_t id = 0;
  const std::string_view digits = without_prefix(field(header.id));
  if (!seconds(field(header.time), time) || !hex(digits, id)) return CanLine::kUnreadable;
  std::size_t length = RecordedFrame::kMostBytes;
  if (header.length >= 0 && (!whole(field(header.length), length) || length > RecordedFrame::kMostBytes)) {
    return CanLine::kUnreadable;
  }
  if (!take_data(fields, static_cast<std::size_t>(header.data), length, out)) return CanLine::kUnreadable;
  if (header.length >= 0 && out.length != length) return CanLine::kUnreadable;
  if (id > kLastExtended) return CanLine::kBeyondBus;
  const bool said = header.extended >= 0 && is_one_of(plain(field(header.extended)), {"1", "true", "yes", "ext", "x"});
  out.id = id > kLastStandard || said ? id | RecordedFrame::kExtendedFlag : id;
  out.flexible = out.length > 8;
  out.time_s = advance(state, time * header.tick_s);
  const std::string_view bus = header.bus >= 0 && header.bus < std::ssize(fields) ? field(header.bus) : "bus";
  return channel_of(bus, state, out.bus) ? CanLine::kFrame : CanLine::kUnreadable;
}

}  // namespace voltlap::plant
