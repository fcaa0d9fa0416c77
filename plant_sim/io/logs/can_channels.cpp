// SPDX-License-Identifier: Apache-2.0
// Roles from the signals of CAN frames.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <unordered_map>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/channel_builder.hpp"
#include "io/logs/dbc_file.hpp"
#include "io/logs/frame_checksum.hpp"
#include "io/logs/signal_tap.hpp"

namespace voltlap::plant {
namespace {

/// Rolling counter of one sender's frames.
struct CounterWatch {
  const DbcSignal* signal;
  bool known = false;
  std::uint64_t last = 0;
  double last_s = 0.0;
};

/// Everything that is taken from the frames of one identifier on one bus.
struct FrameTap {
  std::string bus;             ///< as the map names it; empty: the only one that it is on
  std::uint8_t heard_on = 0;   ///< where it is not named: the first one
  FrameChecksum checksum = FrameChecksum::kNone;
  std::vector<CounterWatch> counters;
  std::vector<SignalTap> signals;
  std::vector<double> time_s;  ///< of every frame that its checksum lets through
  std::size_t frames = 0, rejected = 0;
  double first_rejected_s = 0.0;
};

const DbcSignal& signal_in(const DbcFile& dbc, const DbcMessage& message, const std::string& name,
                           const std::string& place) {
  if (const DbcSignal* signal = message.find(name)) return *signal;
  std::string known;
  for (const DbcSignal& signal : message.signals) known += (known.empty() ? "" : ", ") + signal.name;
  throw InputError(place,
                   fmt::format("no signal \"{}\" in frame {} of {}", name, identifier_text(message.id), dbc.path()),
                   "one of " + known, "Correct the map");
}

const DbcMessage& message_in(const DbcFile& dbc, std::uint32_t id, const std::string& place) {
  dbc.check_usable(id);
  if (const DbcMessage* message = dbc.find(id)) return *message;
  throw InputError(place, fmt::format("no frame {} in {}", identifier_text(id), dbc.path()), "a frame of that file",
                   "Correct the identifier (extended = true for a small one of 29 bits) or the file");
}

/// Signals VoltageCell01, VoltageCell02, ... for VoltageCell<n>.
std::map<long, const DbcSignal*> numbered_signals(const DbcMessage& message, const RoleSource& source) {
  std::map<long, const DbcSignal*> out;
  for (const DbcSignal& signal : message.signals) {
    if (const auto n = number_in(source.signal, signal.name)) out[*n] = &signal;
  }
  return out;
}

class CanTaps {
 public:
  CanTaps(DriveLog& log, const RoleMap& map) : log_(log), map_(map) {}

  void add(const std::string& role, const RoleSource& source) {
    VOLTLAP_DEMAND(source.frame.has_value());
    const std::string place = fmt::format("{}: roles.{}", map_.source, role);
    const DbcFile& dbc = dbc_of(source.dbc);
    const std::uint32_t last = source.last_frame.value_or(*source.frame);
    long before = 0;  // numbers in the frames before
    for (std::uint32_t id = *source.frame; id <= last; ++id) {
      const DbcMessage& message = message_in(dbc, id, place);
      add(id, role, source, dbc, message, before);
      before += static_cast<long>(numbered_signals(message, source).size());
    }
    if (source.last_frame) ranges_.emplace_back(*source.frame, last);
  }

  /// Intervals between the frames of an identifier, by the map or else by the DBC.
  [[nodiscard]] const std::map<std::uint32_t, double>& periods_s() const { return periods_s_; }

  void take(double time_s, const RecordedFrame& recorded, const std::vector<std::string>& buses) {
    const auto at = taps_.find(recorded.id);
    bool taken = false;
    if (at != taps_.end()) {
      for (FrameTap& tap : at->second) {
        if (!is_on_bus(tap, recorded, buses)) continue;
        take(tap, time_s, recorded);
        taken = true;
      }
    }
    if (!taken) ++log_.frames.ignored;
  }

  /// Throws InputError for a bus that the map names and the recording does not have.
  void check_buses(const std::vector<std::string>& buses) const {
    for (const auto& [id, taps] : taps_) {
      for (const FrameTap& tap : taps) {
        if (tap.bus.empty() || std::find(buses.begin(), buses.end(), tap.bus) != buses.end()) continue;
        throw InputError(map_.source, fmt::format("bus = \"{}\" for frame {}", tap.bus, identifier_text(id)),
                         fmt::format("one of the buses of {}: {}", log_.path, fmt::join(buses, ", ")),
                         "Correct the bus in the map");
      }
    }
  }

  void finish() {
    for (auto& [id, taps] : taps_) {
      for (FrameTap& tap : taps) finish(id, tap);
    }
  }

 private:
  void add(std::uint32_t id, const std::string& role, const RoleSource& source, const DbcFile& dbc,
           const DbcMessage& message, long before) {
    const std::string place = fmt::format("{}: roles.{}", map_.source, role);
    FrameTap& tap = tap_of(id, source.bus);
    if (message.cycle_time_s) periods_s_.try_emplace(id, *message.cycle_time_s);
    if (source.period_s) periods_s_[id] = *source.period_s;
    if (source.checksum != FrameChecksum::kNone) tap.checksum = source.checksum;
    if (!source.counter.empty()) watch(tap, signal_in(dbc, message, source.counter, place));
    if (!source.index.empty()) {
      tap.signals.emplace_back(log_, role, source, message, signal_in(dbc, message, source.signal, place),
                               &signal_in(dbc, message, source.index, place));
      return;
    }
    const auto numbered = numbered_signals(message, source);
    for (const auto& [n, signal] : numbered) {
      const long number = before + n - source.first.value_or(1) + 1;
      tap.signals.emplace_back(log_, with_number(role, number), source, message, *signal, nullptr);
    }
    if (numbered.empty()) {
      tap.signals.emplace_back(log_, role, source, message, signal_in(dbc, message, source.signal, place), nullptr);
    }
  }

  const DbcFile& dbc_of(const std::string& text) {
    const std::string path = path_in_map(map_, text);
    auto& dbc = files_[path];
    if (!dbc) dbc = std::make_unique<DbcFile>(path);
    return *dbc;
  }
  FrameTap& tap_of(std::uint32_t id, const std::string& bus) {
    std::vector<FrameTap>& taps = taps_[id];
    for (FrameTap& tap : taps) {
      if (tap.bus == bus) return tap;
    }
    taps.emplace_back().bus = bus;
    return taps.back();
  }

  /// Two senders behind one identifier are two signals: the map must say which is meant.
  bool is_on_bus(FrameTap& tap, const RecordedFrame& recorded, const std::vector<std::string>& buses) const {
    VOLTLAP_DEMAND(recorded.bus < buses.size());
    const std::string& bus = buses[recorded.bus];
    if (!tap.bus.empty()) return tap.bus == bus;
    if (tap.frames == 0) tap.heard_on = recorded.bus;
    if (tap.heard_on == recorded.bus) return true;
    throw InputError(
        fmt::format("{}:{}", log_.path, recorded.line),
        fmt::format("frame {} on {} and on {}", identifier_text(recorded.id), buses[tap.heard_on], bus),
        "one sender of a frame that " + map_.source + " reads",
        fmt::format("Say there which bus is meant: bus = \"{}\" beside frame", buses[tap.heard_on]));
  }

  void take(FrameTap& tap, double time_s, const RecordedFrame& frame) {
    ++tap.frames;
    if (!checksum_holds(tap.checksum, frame)) {
      if (tap.rejected++ == 0) tap.first_rejected_s = time_s;
      for (SignalTap& signal : tap.signals) signal.mask(time_s, frame, "checksum does not hold");
      return;
    }
    tap.time_s.push_back(time_s);
    for (CounterWatch& counter : tap.counters) count(tap, counter, time_s, frame);
    for (SignalTap& signal : tap.signals) signal.take(time_s, frame);
  }

  void finish(std::uint32_t id, FrameTap& tap) {
    const std::string name = tap.bus.empty() ? identifier_text(id) : tap.bus + " " + identifier_text(id);
    if (tap.frames == 0) {
      if (is_beyond_last(id)) return;
      log_.defects.push_back(
          {"frame never seen", "", 0, 0.0, fmt::format("frame {} is not in the recording", name)});
      return;
    }
    if (tap.rejected > 0) {
      log_.defects.push_back({"checksum does not hold", "", tap.rejected, tap.first_rejected_s,
                              fmt::format("{}: {} of {} frames discarded by their checksum, first at {:.3f} s", name,
                                          tap.rejected, tap.frames, tap.first_rejected_s)});
    }
    for (SignalTap& signal : tap.signals) signal.finish();
    account_for(tap);
  }

  /// A frame is used when some channel has a value at its time; else nothing in it could be believed.
  void account_for(const FrameTap& tap) {
    std::vector<bool> used(tap.time_s.size(), false);
    for (const SignalTap& signal : tap.signals) {
      for (const std::string& name : signal.channels()) {
        const Channel* channel = log_.find(name);
        if (channel != nullptr) mark_used(*channel, tap.time_s, used);
      }
    }
    const auto count = static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
    VOLTLAP_DEMAND(tap.frames == tap.rejected + used.size());
    log_.frames.used += count;
    log_.frames.corrupt += tap.frames - count;
  }

  static void mark_used(const Channel& channel, const std::vector<double>& time_s, std::vector<bool>& used) {
    std::size_t at = 0;
    for (std::size_t first = 0, end = 0; first < time_s.size(); first = end) {
      while (end < time_s.size() && time_s[end] == time_s[first]) ++end;  // frames may share a time
      while (at < channel.size() && channel.time_s[at] < time_s[first]) ++at;
      bool any = false;
      for (; at < channel.size() && channel.time_s[at] == time_s[first]; ++at)
        any = any || std::isfinite(channel.value[at]);
      if (any) std::fill(used.begin() + static_cast<long>(first), used.begin() + static_cast<long>(end), true);
    }
  }

  /// Frames of a range behind the last one that was heard are those of a larger battery.
  [[nodiscard]] bool is_beyond_last(std::uint32_t id) const {
    for (const auto& [first, last] : ranges_) {
      if (id <= first || id > last) continue;
      for (std::uint32_t later = id; later <= last; ++later) {
        const auto at = taps_.find(later);
        if (at == taps_.end()) continue;
        const auto is_heard = [](const FrameTap& tap) { return tap.frames > 0; };
        if (std::any_of(at->second.begin(), at->second.end(), is_heard)) return false;
      }
      return true;
    }
    return false;
  }

  static void watch(FrameTap& tap, const DbcSignal& signal) {
    const bool known = std::any_of(tap.counters.begin(), tap.counters.end(),
                                   [&](const CounterWatch& counter) { return counter.signal == &signal; });
    if (!known) tap.counters.push_back({&signal});
  }
  static void count(FrameTap& tap, CounterWatch& counter, double time_s, const RecordedFrame& frame) {
    if (counter.signal->bytes() > frame.length) return;
    const std::uint64_t now = counter.signal->raw(frame.data), turn = counter.signal->bits.mask();
    if (counter.known && now != counter.last) {
      const std::uint64_t missing = (now - counter.last - 1) & turn;
      for (SignalTap& signal : tap.signals) {
        if (missing > 0) signal.add_lost_frames(counter.last_s, time_s, missing);
      }
    }
    counter.known = true;
    counter.last = now;
    counter.last_s = time_s;
  }

  DriveLog& log_;
  const RoleMap& map_;
  std::map<std::string, std::unique_ptr<DbcFile>> files_;
  std::map<std::uint32_t, double> periods_s_;
  std::unordered_map<std::uint32_t, std::vector<FrameTap>> taps_;  ///< of an identifier, by bus
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges_;    ///< first and last frame of numbers that go on
};

}  // namespace

/// What is wrong with the recording as a whole, and how its clock was read.
static void note_summary(DriveLog& log, const std::string& path, const CanSummary& summary, double origin_s) {
  for (const CanDefect& defect : summary.defects) {
    log.defects.push_back({defect.kind, "", defect.count, defect.first_s - origin_s,
                           fmt::format("{}: {} x {}, first in line {}", path, defect.count, defect.kind,
                                       defect.first_line)});
  }
  for (const std::string& note : summary.notes) log.notes.push_back(path + ": " + note);
  for (const ClockPart& part : summary.parts) {
    if (part.begin == ClockPart::Begin::kAnew) {
      log.restarts_s.push_back(part.recorded_begin_s + part.shift_s - origin_s);
    }
  }
}

void add_can_channels(DriveLog& log, const RoleMap& map, const std::string& path,
                      const std::map<std::string, RoleSource>& roles, bool main) {
  VOLTLAP_DEMAND(!roles.empty());
  if (main) log.notes.insert(log.notes.end(), map.notes.begin(), map.notes.end());
  CanTaps taps(log, map);
  for (const auto& [role, source] : roles) taps.add(role, source);
  const double shift_s = roles.begin()->second.shift_s;
  CanReading reading;
  reading.period_s = taps.periods_s();
  CanRecording recording(path, reading);
  RecordedFrame frame;
  bool first = true, absolute = false;
  while (recording.next(frame)) {
    if (first) {
      absolute = is_absolute(frame.time_s);
      if (main && absolute) log.origin_s = frame.time_s;
      first = false;
    }
    taps.take(frame.time_s - (absolute ? log.origin_s : 0.0) + shift_s, frame, recording.buses());
  }
  taps.check_buses(recording.buses());
  note_summary(log, path, recording.summary(), absolute ? log.origin_s : 0.0);
  log.frames.in_file += recording.summary().frames_in_file;
  log.frames.add_left_out(recording.summary());
  taps.finish();
}

}  // namespace voltlap::plant
