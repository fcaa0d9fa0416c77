// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "fuzz/target.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/can/dbc_set.hpp"
#include "io/logs/can/frame_survey.hpp"
#include "io/logs/cell_log.hpp"
#include "io/logs/dbc_decoder.hpp"
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {
namespace {

const DataFolder kData{VOLTLAP_SOURCE_DIR "/plant_sim/data"};

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Both ways of decoding a frame give the same.
void compare_decoders(const CompiledMessage& compiled, const RecordedFrame& frame) {
  const DbcMessage& message = compiled.message();
  std::vector<double> values(message.signals.size());
  std::vector<std::uint64_t> present(presence_words(message.signals.size()));
  compiled.decode_all(frame, values, present);
  for (std::size_t k = 0; k < message.signals.size(); ++k) {
    const DbcSignal& signal = message.signals[k];
    const std::optional<std::uint64_t> raw = raw_value(message, signal, frame);
    VOLTLAP_DEMAND(raw.has_value() == ((present[k / 64] >> k % 64 & 1) != 0));
    if (!raw) continue;
    VOLTLAP_DEMAND(same(signal.value(*raw), values[k]));
    static_cast<void>(signal.is_invalid_code(*raw) || signal.is_end_beyond_range(*raw));
  }
}

/// An input of several parts, each behind a line of its own: "%%".
std::array<std::string, 2> parts_of(const std::string& path) {
  const std::string text = content_of(path), mark = "\n%%\n";
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) return {"", text};
  return {text.substr(0, at + 1), text.substr(at + mark.size())};
}

std::string sibling(const std::string& path, const std::string& name, const std::string& content) {
  const std::string out = (std::filesystem::path(path).parent_path() / name).string();
  std::ofstream(out, std::ios::binary | std::ios::trunc) << content;
  return out;
}

/// The recording beside its map; without a map of its own, the program finds one.
struct MappedRecording {
  explicit MappedRecording(const std::string& path) {
    const auto [map_text, recording] = parts_of(path);
    static const std::string dbc = content_of(VOLTLAP_FUZZ_SEEDS "/dbc/pack.json");
    sibling(path, "pack.dbc", dbc);
    file = sibling(path, "recording.csv", recording);
    if (!map_text.empty()) map = load_role_map(sibling(path, "map.toml", map_text));
  }
  [[nodiscard]] const RoleMap* its_map() const { return map ? &*map : nullptr; }

  std::string file;
  std::optional<RoleMap> map;
};

}  // namespace

void read_can(const std::string& path) {
  CanReading reading{.broken = BrokenStream::kKeep, .keep_remote = true, .period_s = {{0x100, 0.01}}};
  const DbcSet no_dbc({});
  CanRecording recording(path, reading);
  const RecordingSurvey found = survey(recording, no_dbc, [](std::size_t) {});
  const CanSummary& summary = found.summary;
  VOLTLAP_DEMAND(std::isfinite(summary.begin_s) && std::isfinite(summary.end_s));
  VOLTLAP_DEMAND(summary.begin_s <= summary.end_s);
  std::size_t lost = 0, counted = 0;
  for (const CanDefect& defect : summary.defects) lost += defect.used ? 0 : defect.count;
  for (const auto& [key, frame] : found.frames) counted += frame.count;
  VOLTLAP_DEMAND(counted == summary.frames && summary.frames + lost == summary.frames_in_file);
  for (const std::string& bus : summary.buses) VOLTLAP_DEMAND(!std::isnan(found.load_pct(bus, 5e5)));
}

void read_dbc(const std::string& path) {
  const DbcSet dbc({path});
  std::mt19937_64 draw(std::hash<std::string>{}(content_of(path)));
  for (const DbcMessage& message : dbc.files().front()->messages()) {
    const CompiledMessage* compiled = dbc.find(message.id);
    VOLTLAP_DEMAND(compiled != nullptr);
    for (int k = 0; k < 8; ++k) {
      RecordedFrame frame;
      frame.id = message.id;
      frame.length = static_cast<std::uint8_t>(draw() % (RecordedFrame::kMostBytes + 1));
      for (std::size_t b = 0; b < frame.length; ++b) {
        frame.data[b] = static_cast<std::uint8_t>(k == 0 ? 0 : k == 1 ? 0xFF : draw() >> (draw() % 56));
      }
      compare_decoders(*compiled, frame);
    }
  }
  for (const DbcRefusal& refusal : dbc.files().front()->refused()) VOLTLAP_DEMAND(dbc.refusal(refusal.id) != nullptr);
}

void read_role_map(const std::string& path) {
  const RoleMap map = load_role_map(path);
  VOLTLAP_DEMAND(!map.roles.empty());
  for (const auto& [role, source] : map.roles) {
    VOLTLAP_DEMAND(is_role(role) && map.find(role) == &source);
    VOLTLAP_DEMAND(std::isfinite(source.scale) && std::isfinite(source.offset) && std::isfinite(source.shift_s));
  }
}

void read_drive_recording(const std::string& path) {
  const MappedRecording input(path);
  const DriveLog log = read_drive_log(input.file, input.its_map(), kData);
  VOLTLAP_DEMAND(!log.channels.empty());
  for (const auto& [role, channel] : log.channels) {
    VOLTLAP_DEMAND(channel.time_s.size() == channel.value.size());
    VOLTLAP_DEMAND(all_finite(channel.time_s) && std::is_sorted(channel.time_s.begin(), channel.time_s.end()));
    for (const double value : channel.value) VOLTLAP_DEMAND(!std::isinf(value));
  }
  for (const MaskedStretch& stretch : log.masked) VOLTLAP_DEMAND(stretch.start_s <= stretch.end_s);
}

void read_cell_recording(const std::string& path) {
  const MappedRecording input(path);
  const CellLog log = read_cell_log(input.file, input.its_map(), kData, {});
  VOLTLAP_DEMAND(log.rows() > 0 && all_finite(log.time_s) && increasing(log.time_s) && all_finite(log.current_a));
  for (const std::size_t size : {log.current_a.size(), log.voltage_v.size(), log.gap.size()}) {
    VOLTLAP_DEMAND(size == log.rows());
  }
  for (const auto* optional : {&log.temperature_c, &log.ambient_c, &log.charge_ah}) {
    VOLTLAP_DEMAND(optional->empty() || optional->size() == log.rows());
  }
  VOLTLAP_DEMAND(charge_drawn_ah(log, CurrentHold::kLinear).size() == log.rows());
  static_cast<void>(hold_from_counter(log));
}

}  // namespace voltlap::plant
