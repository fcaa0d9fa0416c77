// SPDX-License-Identifier: Apache-2.0
#include "replay/own_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "codec/seal.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/bus/candump_file.hpp"
#include "io/logs/can/can_recording.hpp"
#include "replay/cell_limits.hpp"
#include "replay/firmware_watch.hpp"
#include "replay/frame_verdicts.hpp"

namespace voltlap::plant {
namespace {

constexpr double kTick_s = 1e-3 * can::kTickMs;

template <std::size_t N>
bool in_table(const can::MessageRow (&table)[N], std::uint32_t id) {
  return codec::find_row(table, N, id) != codec::kNoRow;
}

/// A frame of car.dbc or orion.dbc as the nodes know it; false: of another bus.
bool of_our_bus(const RecordedFrame& recorded, Frame& out) {
  if (recorded.flexible || recorded.length > Frame::kMaxBytes) return false;
  if (!in_table(can::kMessages, recorded.id)) return false;
  out = Frame{};
  out.id = recorded.id;
  out.dlc = recorded.length;
  std::memcpy(out.data, recorded.data, recorded.length);
  return true;
}

std::string written(double time_s, const Frame& frame) {
  return candump_line(std::chrono::microseconds(std::llround(1e6 * time_s)), frame, "");
}

bool same(const Frame& a, const Frame& b) {
  return a.id == b.id && a.dlc == b.dlc && std::memcmp(a.data, b.data, Frame::kMaxBytes) == 0;
}

/// The frames of one node in one tick, recorded and answered.
void compare(const char* name, double time_s, const std::vector<Frame>& recorded, const TxQueue& answered,
             FrameComparison::Node& node, std::optional<FrameComparison::Difference>& first) {
  node.recorded += recorded.size();
  const std::size_t count = std::max(recorded.size(), answered.size());
  for (std::size_t k = 0; k < count; ++k) {
    const Frame* was = k < recorded.size() ? &recorded[k] : nullptr;
    const Frame* is = k < answered.size() ? &answered[k] : nullptr;
    if (was != nullptr && is != nullptr && same(*was, *is)) {
      ++node.same;
      continue;
    }
    ++(was == nullptr ? node.extra : is == nullptr ? node.missing : node.different);
    if (first) continue;
    const std::uint32_t id = was != nullptr ? was->id : is->id;
    first = FrameComparison::Difference{
        time_s, name, can::kMessageNames[codec::find_row(can::kMessages, codec::kMessageCount, id)],
        was != nullptr ? written(time_s, *was) : "", is != nullptr ? written(time_s, *is) : ""};
  }
}

/// What the recording says, by the frames of its plant and of the control units that it was recorded with.
class OwnLog {
 public:
  OwnLog(double min_v, double max_v, ReplayResult& result) : limits_(min_v, max_v, result.violations) {}

  void take(double time_s, const Frame& frame) {
    can::PackSensor pack;
    can::CellVoltages cells;
    can::Temperatures temperatures;
    if (decode(frame, pack)) {
      if (pack.pack_current_ok) current_a_ = 1e-3 * pack.pack_current_ma;
    } else if (decode(frame, cells)) {
      take_cells(time_s, cells);
    } else if (decode(frame, temperatures)) {
      take_temperatures(temperatures);
    }
  }
  void take_answer(const Frame& frame) { said_.take(frame); }

  [[nodiscard]] LoggedMoment moment() const {
    LoggedMoment out;
    out.current_a = current_a_;
    std::tie(out.cell_min_v, out.cell_max_v) = ends(cells_v_);
    out.temperature_max_c = ends(temperatures_c_).second;
    if (said_.bms.soc_ok) out.soc = 1e-6 * said_.bms.soc_ppm;
    if (said_.limits.discharge_limit_ok) out.discharge_limit_a = 1e-3 * said_.limits.discharge_limit_ma;
    if (said_.limits.charge_limit_ok) out.charge_limit_a = 1e-3 * said_.limits.charge_limit_ma;
    return out;
  }
  [[nodiscard]] std::size_t cells() const { return cells_v_.size(); }
  [[nodiscard]] std::size_t thermistors() const { return temperatures_c_.size(); }
  void finish() { limits_.finish(); }

 private:
  static std::pair<double, double> ends(const std::vector<double>& values) {
    double low = kUnknown, high = kUnknown;
    for (const double value : values) {
      low = std::fmin(low, value);  // fmin and fmax pass NaN over
      high = std::fmax(high, value);
    }
    return {low, high};
  }
  static double& at(std::vector<double>& values, std::size_t index) {
    if (index >= values.size()) values.resize(index + 1, kUnknown);
    return values[index];
  }
  void take_cells(double time_s, const can::CellVoltages& m) {
    for (std::size_t i = 0; i < can::CellVoltages::kPerFrame; ++i) {
      if (!m.cell_ok[i]) continue;
      const std::size_t cell = m.group * can::CellVoltages::kPerFrame + i;
      at(cells_v_, cell) = 1e-4 * m.cell_100uv[i];
      limits_.sample(time_s, cell, 1e-4 * m.cell_100uv[i]);
    }
  }
  void take_temperatures(const can::Temperatures& m) {
    for (std::size_t i = 0; i < can::Temperatures::kPerFrame; ++i) {
      if (m.temperature_ok[i]) {
        at(temperatures_c_, m.group * can::Temperatures::kPerFrame + i) = 0.1 * m.temperature_dc[i];
      }
    }
  }

  double current_a_ = kUnknown;
  std::vector<double> cells_v_, temperatures_c_;
  Said said_{};
  CellLimits limits_;
};

/// One tick after the other: the plant's frames in, both nodes' answers out.
class OwnReplay {
 public:
  OwnReplay(Ecus& ecus, double min_v, double max_v, ReplayResult& result)
      : ecus_(ecus), result_(result), log_(min_v, max_v, result), watch_(result, true) {}

  void tick(std::uint32_t tick, double time_s, const OwnFrame* begin, const OwnFrame* end) {
    recorded_bms_.clear();
    recorded_master_.clear();
    for (const OwnFrame* at = begin; at != end; ++at) {
      if (in_table(can::kBmsTx, at->frame.id)) {
        recorded_bms_.push_back(at->frame);
        log_.take_answer(at->frame);
      } else if (in_table(can::kMasterTx, at->frame.id)) {
        recorded_master_.push_back(at->frame);
      } else {
        for_bms_.push_back(at->frame);
        for_master_.push_back(at->frame);
        log_.take(time_s, at->frame);
      }
    }
    answer(tick, time_s);
  }
  void finish() {
    log_.finish();
    watch_.finish();
    result_.cells = log_.cells();
    result_.thermistors = log_.thermistors();
  }

 private:
  /// In the order of the bus: the BMS hears the plant, the master hears both, the BMS hears the master a tick later.
  void answer(std::uint32_t tick, double time_s) {
    const Instant now = Instant::from_ms(tick * can::kTickMs);
    TxQueue bms, master;
    ecus_.bms(now, FrameView{for_bms_.data(), for_bms_.size()}, bms);
    for_master_.insert(for_master_.end(), bms.begin(), bms.end());
    ecus_.master(now, FrameView{for_master_.data(), for_master_.size()}, master);
    for_bms_.assign(master.begin(), master.end());
    for_master_.clear();
    FrameComparison& comparison = *result_.comparison;
    compare("BMS", time_s, recorded_bms_, bms, comparison.bms, comparison.first);
    compare("master", time_s, recorded_master_, master, comparison.master, comparison.first);
    for (const Frame& frame : bms) said_.take(frame);
    for (const Frame& frame : master) said_.take(frame);
    watch_.tick(time_s, said_, log_.moment());
  }

  Ecus& ecus_;
  ReplayResult& result_;
  OwnLog log_;
  FirmwareWatch watch_;
  Said said_{};
  std::vector<Frame> for_bms_, for_master_, recorded_bms_, recorded_master_;
};

}  // namespace

bool is_own_recording(const std::string& path) {
  constexpr std::size_t kEnough = 2'000;  // frames: a second of our bus
  constexpr double kMost = 0.9;
  if (!is_can_recording(path)) return false;
  CanRecording recording(path);
  RecordedFrame recorded;
  Frame frame;
  std::size_t plant = 0, nodes = 0, sealed = 0;
  for (std::size_t k = 0; k < kEnough && recording.next(recorded); ++k) {
    if (!of_our_bus(recorded, frame) || in_table(can::kBmsTx, frame.id)) continue;  // an Orion may send some of them
    const bool ours = codec::sealed_ok(frame);
    sealed += ours ? 1U : 0U;
    ++(in_table(can::kMasterTx, frame.id) ? nodes : plant);
  }
  return plant > 0 && nodes > 0 && static_cast<double>(sealed) > kMost * static_cast<double>(plant + nodes);
}

OwnRecording read_own_recording(const std::string& path) {
  OwnRecording out;
  out.path = path;
  CanReading reading;
  reading.broken = BrokenStream::kKeep;
  CanRecording recording(path, reading);
  RecordedFrame recorded;
  OwnFrame own;
  bool begun = false;
  while (recording.next(recorded)) {
    if (!of_our_bus(recorded, own.frame)) {
      ++out.account.ignored;
      continue;
    }
    if (!begun) out.origin_s = kTick_s * std::floor(recorded.time_s / kTick_s + 1e-6);
    begun = true;
    own.tick = static_cast<std::uint32_t>(std::floor((recorded.time_s - out.origin_s) / kTick_s + 1e-3));
    out.frames.push_back(own);
  }
  if (!begun) {
    throw InputError(path, "no frame of can_dbc/car.dbc", "a recording of our own bus", "Give a role map with --map");
  }
  const CanSummary& summary = recording.summary();
  out.account.in_file = summary.frames_in_file;
  add_left_out(summary, out.account, out.defects);
  out.notes = summary.notes;
  if (!summary.broken.empty()) out.notes.push_back(summary.broken + "; what stands before it was replayed");
  return out;
}

void replay_own(const OwnRecording& recording, Ecus& ecus, double cell_min_v, double cell_max_v,
                ReplayResult& result) {
  VOLTLAP_DEMAND(!recording.frames.empty());
  const auto begin = std::chrono::steady_clock::now();
  result.frames = recording.account;
  result.defects = recording.defects;
  result.notes = recording.notes;
  result.comparison.emplace();
  result.begin_s = recording.origin_s;
  OwnReplay replay(ecus, cell_min_v, cell_max_v, result);
  const OwnFrame* at = recording.frames.data();
  const OwnFrame* const end = at + recording.frames.size();
  const std::uint32_t last = recording.frames.back().tick;
  for (std::uint32_t tick = 0; tick <= last; ++tick) {
    const OwnFrame* const from = at;
    while (at != end && at->tick == tick) ++at;
    replay.tick(tick, recording.origin_s + kTick_s * tick, from, at);
  }
  replay.finish();
  result.duration_s = result.firmware_s = kTick_s * (last + 1.0);
  result.computed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  judge_frames(recording.frames, result.cells, result.frames);
}

}  // namespace voltlap::plant
