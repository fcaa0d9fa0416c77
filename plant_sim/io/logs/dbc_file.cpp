// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/dbc_json.hpp"
#include "io/logs/half_float.hpp"

namespace voltlap::plant {
namespace {

using Json = nlohmann::json;

/// What dbc_json gives is checked as a file is: an entry of its cache may be another version's.
constexpr std::uint64_t kMost32 = 0xFFFFFFFF, kMostLines = 1'000'000'000;

[[noreturn]] void refuse(const std::string& expected) { throw std::invalid_argument(expected); }

std::uint64_t whole(const Json& entry, const char* key, std::uint64_t most) {
  const Json& value = entry.at(key);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > most) {
    refuse(fmt::format("{} a whole number up to {}", key, most));
  }
  return value.get<std::uint64_t>();
}

std::uint32_t id_of(const Json& entry) {
  return static_cast<std::uint32_t>(whole(entry, "id", kMost32)) |
         (entry.at("extended").get<bool>() ? RecordedFrame::kExtendedFlag : std::uint32_t{0});
}

std::vector<RawRange> ranges_of(const Json& pairs) {
  std::vector<RawRange> out;
  for (const Json& pair : pairs) {
    if (!pair.at(0).is_number_unsigned() || !pair.at(1).is_number_unsigned()) refuse("ranges of raw values");
    out.push_back({pair.at(0).get<std::uint64_t>(), pair.at(1).get<std::uint64_t>()});
  }
  return out;
}

std::optional<double> number_of(const Json& value) {
  return value.is_null() ? std::nullopt : std::optional<double>(value.get<double>());
}

DbcSignal::Kind kind_of(const Json& entry, unsigned length) {
  if (!entry.at("float").get<bool>()) {
    return entry.at("signed").get<bool>() ? DbcSignal::Kind::kSigned : DbcSignal::Kind::kUnsigned;
  }
  return length == 16   ? DbcSignal::Kind::kHalf
         : length == 32 ? DbcSignal::Kind::kFloat
                        : DbcSignal::Kind::kDouble;
}

DbcSignal signal_of(const Json& entry, unsigned frame_bytes) {
  constexpr std::uint64_t kLongest = 64, kLastBit = 8 * RecordedFrame::kMostBytes - 1;
  DbcSignal out;
  out.name = entry.at("name");
  out.unit = entry.at("unit");
  out.length = static_cast<unsigned>(whole(entry, "length", kLongest));
  out.kind = kind_of(entry, out.length);
  out.scale = entry.at("scale");
  out.offset = entry.at("offset");
  out.min = number_of(entry.at("min"));
  out.max = number_of(entry.at("max"));
  out.cases = ranges_of(entry.at("cases"));
  out.invalid_codes = ranges_of(entry.at("invalid"));
  for (const Json& choice : entry.at("choices")) {
    if (choice.at(0).is_number_integer()) out.value_names[choice.at(0)] = choice.at(1);
  }
  out.line = whole(entry, "line", kMostLines);
  const auto start = static_cast<unsigned>(whole(entry, "start", kLastBit));
  if (out.length == 0) refuse("signals of a bit or more");
  out.bits = BitField(start, out.length, entry.at("big_endian"));
  if (out.bytes() > frame_bytes) refuse("signals within their frame");
  return out;
}

/// Each multiplexer, that of a multiplexer too, ends at a signal that is always there.
void link_multiplexers(const Json& signals, DbcMessage& message) {
  std::map<std::string, std::size_t> places;
  for (std::size_t k = 0; k < message.signals.size(); ++k) places[message.signals[k].name] = k;
  for (std::size_t k = 0; k < message.signals.size(); ++k) {
    const Json& multiplexer = signals[k].at("multiplexer");
    if (multiplexer.is_null()) continue;
    const auto place = places.find(multiplexer.get<std::string>());
    if (place == places.end()) refuse("multiplexers of the same frame");
    message.signals[k].multiplexer = place->second;
  }
  for (const DbcSignal& signal : message.signals) {
    std::size_t depth = 0;
    for (const DbcSignal* at = &signal; at->multiplexer; at = &message.signals[*at->multiplexer]) {
      if (++depth > message.signals.size()) refuse("no multiplexer under itself");
    }
  }
}

DbcMessage message_of(const Json& entry) {
  DbcMessage out;
  out.id = id_of(entry);
  out.name = entry.at("name");
  out.length = static_cast<unsigned>(whole(entry, "length", RecordedFrame::kMostBytes));
  out.flexible = entry.at("fd");
  out.j1939 = entry.value("j1939", false);
  const auto cycle = entry.find("cycle_time_ms");
  if (cycle != entry.end() && cycle->is_number() && *cycle > 0.0) out.cycle_time_s = 1e-3 * cycle->get<double>();
  out.line = whole(entry, "line", kMostLines);
  for (const Json& signal : entry.at("signals")) out.signals.push_back(signal_of(signal, out.length));
  link_multiplexers(entry.at("signals"), out);
  return out;
}

DbcRefusal refusal_of(const Json& entry) {
  return {id_of(entry),      entry.at("name"),     whole(entry, "line", kMostLines),
          entry.at("found"), entry.at("expected"), entry.at("action")};
}

[[noreturn]] void refuse_json(const std::string& path, const std::string& found) {
  throw InputError(path, fmt::format("frames that this version does not understand ({})", found),
                   "those that its own reader of DBC files gives",
                   "Remove the folder voltlap/dbc in $XDG_CACHE_HOME or ~/.cache, where they are kept");
}

double signed_number(std::uint64_t raw, unsigned length) {
  const std::uint64_t sign = std::uint64_t{1} << (length - 1);
  return static_cast<double>(static_cast<std::int64_t>((raw ^ sign) - sign));
}

}  // namespace

double DbcSignal::value_as(Kind other, std::uint64_t raw) const {
  double number = 0.0;
  switch (other) {
    case Kind::kUnsigned:
      number = static_cast<double>(raw);
      break;
    case Kind::kSigned:
      number = signed_number(raw, length);
      break;
    case Kind::kHalf:
      number = half_float(static_cast<std::uint16_t>(raw));
      break;
    case Kind::kFloat:
      number = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
      break;
    case Kind::kDouble:
      number = std::bit_cast<double>(raw);
      break;
  }
  return number * scale + offset;
}

bool DbcSignal::is_invalid_code(std::uint64_t raw) const {
  return std::any_of(invalid_codes.begin(), invalid_codes.end(), [&](const RawRange& r) { return r.holds(raw); });
}

bool DbcSignal::is_end_beyond_range(Kind as, std::uint64_t raw) const {
  constexpr unsigned kShortest = 8;
  if (length < kShortest || !is_integer() || !min || !max || !(*min < *max)) return false;
  const std::uint64_t ones = bits.mask(), lowest = std::uint64_t{1} << (length - 1);
  const bool is_end = as == Kind::kUnsigned ? raw == ones : raw == lowest || raw == lowest - 1;
  if (!is_end) return false;
  // Scales are rounded: 255 x 0.392157 % is still 100 %.
  const double value = value_as(as, raw), tolerance = 0.5 * std::abs(scale);
  return value < *min - tolerance || value > *max + tolerance;
}

const DbcSignal* DbcMessage::find(std::string_view signal) const {
  const auto at =
      std::find_if(signals.begin(), signals.end(), [&](const DbcSignal& s) { return s.name == signal; });
  return at == signals.end() ? nullptr : &*at;
}

DbcFile::DbcFile(const std::string& path) : path_(path) {
  const std::string text = dbc_json(path);
  try {
    take(text);
  } catch (const Json::exception& error) {
    refuse_json(path, error.what());
  } catch (const std::invalid_argument& error) {
    refuse_json(path, fmt::format("not {}", error.what()));
  }
  VOLTLAP_DEMAND(!messages_.empty() || !refused_.empty());
}

void DbcFile::take(const std::string& json) {
  const Json file = Json::parse(json);
  for (const Json& entry : file.at("messages")) {
    messages_.push_back(message_of(entry));
    messages_.back().file = path_;
  }
  for (const Json& entry : file.at("refused")) refused_.push_back(refusal_of(entry));
  if (const auto notes = file.find("notes"); notes != file.end()) {
    for (const Json& entry : *notes) {
      notes_.push_back({entry.at("line").get<std::size_t>(), entry.at("text").get<std::string>()});
    }
  }
  if (messages_.empty() && refused_.empty()) refuse("a frame");
}

const DbcMessage* DbcFile::find(std::uint32_t id) const {
  const auto at = std::find_if(messages_.begin(), messages_.end(), [&](const DbcMessage& m) { return m.id == id; });
  if (at != messages_.end()) return &*at;
  if ((id & RecordedFrame::kExtendedFlag) == 0) return nullptr;
  const auto group = std::find_if(messages_.begin(), messages_.end(), [&](const DbcMessage& m) {
    return m.j1939 && parameter_group(m.id) == parameter_group(id);
  });
  return group == messages_.end() ? nullptr : &*group;
}

void DbcFile::check_usable(std::uint32_t id) const {
  constexpr std::uint32_t kLastStandard = 0x7FF;
  for (const DbcRefusal& refusal : refused_) {
    // A long identifier without its flag is one of the reasons.
    const bool is_long = (refusal.id & ~RecordedFrame::kExtendedFlag) > kLastStandard;
    if ((refusal.id | (is_long ? RecordedFrame::kExtendedFlag : 0U)) != id) continue;
    throw InputError(refusal.line > 0 ? fmt::format("{}:{}", path_, refusal.line) : path_, refusal.found,
                     refusal.expected, refusal.action);
  }
}

std::optional<std::uint64_t> raw_value(const DbcMessage& message, const DbcSignal& signal,
                                       const RecordedFrame& frame) {
  for (const DbcSignal* below = &signal; below->multiplexer;) {
    const DbcSignal& above = message.signals[*below->multiplexer];
    if (above.bytes() > frame.length) return std::nullopt;
    const std::uint64_t now = above.raw(frame.data);
    if (std::none_of(below->cases.begin(), below->cases.end(), [&](const RawRange& r) { return r.holds(now); })) {
      return std::nullopt;
    }
    below = &above;
  }
  if (signal.bytes() > frame.length) return std::nullopt;
  return signal.raw(frame.data);
}

}  // namespace voltlap::plant
