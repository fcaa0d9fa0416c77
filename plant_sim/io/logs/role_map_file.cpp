// SPDX-License-Identifier: Apache-2.0
// A role map as its file has it, checked whole: every key known, of its type, in its range, fit for its role.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/errors.hpp"
#include "core/toml_text.hpp"
#include "io/logs/recorded_frame.hpp"
#include "io/logs/role_map.hpp"

namespace voltlap::plant {
namespace {

constexpr std::int64_t kLastStandard = 0x7FF, kLastExtended = 0x1FFFFFFF;

constexpr std::array<std::string_view, 11> kEither{"unit", "scale",   "offset", "discharge", "index",  "first",
                                                   "file", "shift_s", "min",    "max",       "invalid"};
constexpr std::array<std::string_view, 3> kOfColumn{"column", "time", "optional"};
constexpr std::array<std::string_view, 9> kOfFrame{"frame", "last_frame", "extended", "signal",  "dbc",
                                                   "bus",   "checksum",   "counter",  "period_s"};

std::string place_of(const std::string& path, const toml::node& node, std::string_view what) {
  return fmt::format("{}:{}: {}", path, node.source().begin.line, what);
}

/// What is wrong with a file, all of it at once.
class Complaints {
 public:
  template <class Step>
  void collect(const Step& step) {
    try {
      step();
    } catch (const InputError& error) {
      texts_.emplace_back(error.what());
    }
  }
  void throw_any() const {
    if (!texts_.empty()) throw InputError(fmt::format("{}", fmt::join(texts_, "\n")));
  }

 private:
  std::vector<std::string> texts_;
};

/// One role's entry; each getter is an InputError with the line when the value is not of its type.
class Entry {
 public:
  Entry(const std::string& path, std::string role, const toml::table& table)
      : path_(path), role_(std::move(role)), table_(table) {}

  [[nodiscard]] const std::string& role() const { return role_; }
  [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }
  [[nodiscard]] std::string place(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return place_of(path_, node != nullptr ? *node : static_cast<const toml::node&>(table_),
                    fmt::format("roles.{}{}{}", role_, key.empty() ? "" : ".", key));
  }

  [[nodiscard]] std::optional<std::string> text(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<std::string>();
    if (!value || value->empty()) refuse(key, *node, "a text that is not empty, in quotation marks");
    return value;
  }
  [[nodiscard]] std::string text_or_none(std::string_view key) const { return text(key).value_or(std::string()); }
  [[nodiscard]] std::string needed_text(std::string_view key, const char* example) const {
    if (const auto value = text(key)) return *value;
    throw InputError(place(""), fmt::format("no {}", key), example, "Add it");
  }
  [[nodiscard]] std::optional<double> number(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = number_of(*node);
    if (!value || !std::isfinite(*value)) refuse(key, *node, "a number, without quotation marks");
    return value;
  }
  [[nodiscard]] std::optional<std::int64_t> whole(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<std::int64_t>();
    if (!value) refuse(key, *node, "a whole number");
    return value;
  }
  [[nodiscard]] bool flag(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return false;
    const auto value = node->value_exact<bool>();
    if (!value) refuse(key, *node, "true or false");
    return *value;
  }
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return {};
    constexpr const char* kList = "a list of numbers such as [255, 65535]";
    const toml::array* list = node->as_array();
    if (list == nullptr) refuse(key, *node, kList);
    std::vector<double> out;
    for (const toml::node& item : *list) {
      const auto value = number_of(item);
      if (!value || !std::isfinite(*value)) refuse(key, item, kList);
      out.push_back(*value);
    }
    return out;
  }

  void check_keys(bool frame) const {
    for (const auto& [key, value] : table_) {
      const std::string_view name = key.str();
      const auto in = [&](const auto& keys) { return std::find(keys.begin(), keys.end(), name) != keys.end(); };
      if (in(kEither) || (frame ? in(kOfFrame) : in(kOfColumn))) continue;
      std::vector<std::string_view> known;
      if (frame) known.insert(known.end(), kOfFrame.begin(), kOfFrame.end());
      if (!frame) known.insert(known.end(), kOfColumn.begin(), kOfColumn.end());
      known.insert(known.end(), kEither.begin(), kEither.end());
      throw InputError(place(key.str()), fmt::format("key \"{}\"", key.str()),
                       fmt::format("{}", fmt::join(known, ", ")), "Remove or correct the key");
    }
  }

  [[noreturn]] void refuse(std::string_view key, const toml::node& found, const char* expected) const {
    throw InputError(place_of(path_, found, fmt::format("roles.{}.{}", role_, key)),
                     fmt::format("{} = {}", key, found_text(found)), expected, "Correct it");
  }
  [[noreturn]] void refuse(std::string_view key, const char* expected) const {
    refuse(key, *table_.get(key), expected);
  }

 private:
  const std::string& path_;
  std::string role_;
  const toml::table& table_;
};

DischargeSign sign_of(const Entry& entry) {
  const auto text = entry.text("discharge");
  if (!text) return DischargeSign::kAuto;
  if (entry.role() != "current") entry.refuse("discharge", "it beside the role current only");
  if (*text == "+") return DischargeSign::kPositive;
  if (*text == "-") return DischargeSign::kNegative;
  if (*text != "auto") entry.refuse("discharge", "\"+\", \"-\" or \"auto\"");
  return DischargeSign::kAuto;
}

FrameChecksum checksum_of(const Entry& entry) {
  const std::string text = entry.text_or_none("checksum");
  if (text.empty()) return FrameChecksum::kNone;
  if (text == "orion") return FrameChecksum::kOrion;
  if (text == "crc8") return FrameChecksum::kCrc8;
  if (text != "sum") {
    entry.refuse("checksum", "\"orion\" (identifier + 8 + sum of bytes 0 to 6), \"sum\" (of bytes 0 to 6) or \"crc8\" "
                             "(SAE J1850 over the identifier and bytes 0 to 6)");
  }
  return FrameChecksum::kSum;
}

/// Numbers that go on in the frames behind the first.
void take_last_frame(const Entry& entry, RoleSource& out) {
  constexpr std::uint32_t kMostFrames = 1000;
  const auto last = entry.whole("last_frame");
  if (!last || !out.frame) return;
  const std::uint32_t flag = *out.frame & RecordedFrame::kExtendedFlag, first = *out.frame & ~flag;
  const std::int64_t end = flag != 0 ? kLastExtended : kLastStandard;
  if (*last <= first || *last > std::min<std::int64_t>(end, first + kMostFrames)) {
    entry.refuse("last_frame", "an identifier above that of frame, of as many bits, at most 1000 further");
  }
  if (!is_numbered(entry.role())) {
    entry.refuse("last_frame", "it only for a role with <n>, by numbers in the signals' names or by an index");
  }
  out.last_frame = static_cast<std::uint32_t>(*last) | flag;
}

void take_frame(const Entry& entry, RoleSource& out, Complaints& complaints) {
  complaints.collect([&] {
    const std::int64_t id = entry.whole("frame").value_or(-1);
    if (id < 0 || id > kLastExtended) entry.refuse("frame", "an identifier of 11 or 29 bits such as 0x6B0");
    const bool extended = entry.flag("extended") || id > kLastStandard;
    out.frame = static_cast<std::uint32_t>(id) | (extended ? RecordedFrame::kExtendedFlag : 0U);
  });
  complaints.collect([&] { take_last_frame(entry, out); });
  complaints.collect([&] { out.signal = entry.needed_text("signal", "signal = \"name in the DBC\""); });
  complaints.collect([&] { out.dbc = entry.needed_text("dbc", "dbc = \"file.dbc\""); });
  complaints.collect([&] { out.bus = entry.text_or_none("bus"); });
  complaints.collect([&] { out.checksum = checksum_of(entry); });
  complaints.collect([&] { out.counter = entry.text_or_none("counter"); });
  complaints.collect([&] {
    out.period_s = entry.number("period_s");
    if (out.period_s && !(*out.period_s > 0.0 && *out.period_s <= 3600.0)) {
      entry.refuse("period_s", "seconds between two frames, above 0 and at most 3600");
    }
  });
}

void take_unit(const Entry& entry, RoleSource& out, Complaints& complaints) {
  Unit unit = unit_of("", "1");
  complaints.collect([&] {
    const std::string name = entry.text("unit").value_or("1");
    if (name != "1") out.unit = name;
    unit = unit_of(entry.place("unit"), name);
    if (unit_fits(unit, entry.role())) return;
    throw InputError(entry.place("unit"), fmt::format("unit = \"{}\"", name),
                     fmt::format("a unit that {} can have: {}", entry.role(), fmt::join(units_of(entry.role()), ", ")),
                     "Correct the unit or the role");
  });
  complaints.collect([&] {
    const double scale = entry.number("scale").value_or(1.0);
    if (scale == 0.0) entry.refuse("scale", "a number that is not 0");
    out.scale = scale * unit.scale;
  });
  complaints.collect([&] { out.offset = entry.number("offset").value_or(0.0) * unit.scale + unit.offset; });
}

void take_number(const Entry& entry, RoleSource& out) {
  out.index = entry.text_or_none("index");
  if (const auto first = entry.whole("first")) {
    if (std::abs(*first) > 100000) entry.refuse("first", "the index of the first, such as 0 or 1");
    out.first = static_cast<long>(*first);
  }
  const bool numbered = is_numbered(entry.role());
  if (!out.index.empty() && !numbered) {
    entry.refuse("index", "it only for a role with <n>, such as \"cell_voltage_<n>\"");
  }
  const std::string& pattern = out.frame ? out.signal : out.column;
  if (pattern.empty() || !out.index.empty()) return;
  const char* key = out.frame ? "signal" : "column";
  if (is_numbered(pattern) && !numbered) entry.refuse(key, "one name; <n> for all numbers needs a role with <n>");
  if (numbered && !is_numbered(pattern)) entry.refuse(key, "<n> in the name, or an index, for a role with <n>");
}

void take_limits(const Entry& entry, RoleSource& out, Complaints& complaints) {
  complaints.collect([&] { out.shift_s = entry.number("shift_s").value_or(0.0); });
  complaints.collect([&] {
    out.min = entry.number("min");
    out.max = entry.number("max");
    if (out.min && out.max && !(*out.min < *out.max)) entry.refuse("max", "more than min");
  });
  complaints.collect([&] { out.invalid = entry.numbers("invalid"); });
}

RoleSource source_of(const std::string& path, const std::string& role, const toml::node& node,
                     Complaints& complaints) {
  const toml::table* table = node.as_table();
  if (table == nullptr) {
    throw InputError(place_of(path, node, "roles." + role), found_text(node),
                     "{column = \"...\", unit = \"...\"} or {frame = 0x..., signal = \"...\", dbc = \"...\"}",
                     "Name the column or the signal");
  }
  const Entry entry(path, role, *table);
  const bool frame = entry.has("frame");
  entry.check_keys(frame);
  if (frame && role == "time") entry.refuse("frame", "a column: frames carry the recorder's own time");
  RoleSource out;
  if (frame) {
    take_frame(entry, out, complaints);
  } else {
    complaints.collect([&] {
      out.column = entry.needed_text("column", "column = \"name in the table\", or frame, signal and dbc");
    });
    complaints.collect([&] { out.optional = entry.flag("optional"); });
  }
  take_unit(entry, out, complaints);
  complaints.collect([&] { out.discharge = sign_of(entry); });
  complaints.collect([&] { take_number(entry, out); });
  complaints.collect([&] { out.file = entry.text_or_none("file"); });
  complaints.collect([&] { out.time = entry.text_or_none("time"); });
  take_limits(entry, out, complaints);
  return out;
}

std::vector<std::string> texts_of(const std::string& path, const toml::table& file, const char* key,
                                  const char* expected) {
  const toml::node* match = file.get(key);
  if (match == nullptr) return {};
  const toml::array* list = match->as_array();
  const bool texts = list != nullptr && std::all_of(list->begin(), list->end(),
                                                    [](const toml::node& text) { return text.is_string(); });
  if (!texts) throw InputError(place_of(path, *match, key), found_text(*match), expected, "Correct it");
  std::vector<std::string> out;
  for (const toml::node& text : *list) out.push_back(text.value_or(std::string()));
  return out;
}

void take_match(const std::string& path, const toml::table& file, RoleMap& map) {
  map.match = texts_of(path, file, "match", "a list of header lines, [\"t,I,U\"]");
  map.match_columns = texts_of(path, file, "match_columns", "a list of names of columns, [\"t\", \"I\", \"U\"]");
  if (const toml::node* match = file.get("match_frames")) {
    const toml::array* list = match->as_array();
    const bool whole = list != nullptr && std::all_of(list->begin(), list->end(), [](const toml::node& id) {
      const auto value = id.value_exact<std::int64_t>();
      return value && *value >= 0 && *value <= kLastExtended;
    });
    if (!whole) {
      throw InputError(place_of(path, *match, "match_frames"), found_text(*match),
                       "a list of identifiers, [0x6B0, 0x6B1]", "Correct it");
    }
    for (const toml::node& id : *list) {
      map.match_frames.push_back(static_cast<std::uint32_t>(id.value_or(std::int64_t{0})));
    }
  }
}

void take_place_of_temperatures(const std::string& path, const toml::table& file, RoleMap& map) {
  const toml::node* given = file.get("temperatures_of_core");
  if (given == nullptr) return;
  if (!given->is_boolean()) {
    throw InputError(place_of(path, *given, "temperatures_of_core"), found_text(*given), "true or false", "Correct it");
  }
  map.temperatures_of_core = given->value_or(false);
}

}  // namespace

RoleMap load_role_map(const std::string& path) {
  const toml::table file = parse_toml_file(path);
  constexpr std::array<std::string_view, 5> kKnown{"match", "match_columns", "match_frames", "temperatures_of_core",
                                                   "roles"};
  for (const auto& [key, node] : file) {
    if (std::find(kKnown.begin(), kKnown.end(), key.str()) != kKnown.end()) continue;
    throw InputError(place_of(path, node, key.str()), fmt::format("key \"{}\"", key.str()),
                     fmt::format("{}", fmt::join(kKnown, ", ")),
                     is_role(key.str()) ? "Write [roles] before it" : "Remove or correct the key");
  }
  const toml::table* roles = file["roles"].as_table();
  if (roles == nullptr || roles->empty()) {
    throw InputError(path, "no [roles]", "[roles] with time, current and voltage",
                     "Give a role map; plant_sim/data/maps has examples");
  }
  RoleMap map;
  map.source = path;
  take_match(path, file, map);
  take_place_of_temperatures(path, file, map);
  Complaints complaints;
  for (const auto& [key, node] : *roles) {
    const std::string role(key.str());
    complaints.collect([&, &node = node] {
      if (!is_role(role)) {
        throw InputError(place_of(path, node, "roles." + role), "an unknown role",
                         fmt::format("one of {}", fmt::join(role_names(), ", ")), "Correct its name");
      }
      map.roles[role] = source_of(path, role, node, complaints);
    });
  }
  complaints.throw_any();
  return map;
}

}  // namespace voltlap::plant
