// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/can_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <utility>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "io/logs/can/foreign_format.hpp"

namespace voltlap::plant {
namespace {

constexpr std::array kFormats{CanFormat::kCandump, CanFormat::kScreen, CanFormat::kAsc,
                              CanFormat::kRawHex,  CanFormat::kSlcan,  CanFormat::kTable};
constexpr std::size_t kFirstLines = 1000;
constexpr double kSlcanTurn = 60.0;  // s; the stamp starts again each minute, of some adapters after 65.536 s

/// What the first lines say of a file.
struct FirstLook {
  CanFormat format = CanFormat::kCandump;
  std::size_t frames = 0, untimed = 0;
  std::vector<double> stamps_s{};
  std::vector<std::uint32_t> ids{};
};

/// The next line; false at the end, and in a file without lines.
bool next_line(LineReader& reader, std::string_view& line) {
  try {
    return reader.next(line);
  } catch (const InputError&) {
    return false;
  }
}

/// A file may begin with anything; the format in which most of its first lines are frames is its own.
std::optional<FirstLook> look_at(const std::string& path) {
  std::array<FirstLook, kFormats.size()> looks{};
  std::array<CanLineState, kFormats.size()> states{};
  LineReader reader(path, "a recording", BrokenStream::kKeep);
  std::string_view line;
  RecordedFrame frame;
  while (reader.number() < kFirstLines && next_line(reader, line)) {
    for (std::size_t k = 0; k < kFormats.size(); ++k) {
      const CanLine kind = parse_can_line(kFormats[k], line, states[k], frame);
      looks[k].untimed += kind == CanLine::kUntimed ? 1U : 0U;
      looks[k].frames += kind == CanLine::kFrame || kind == CanLine::kUntimed ? 1U : 0U;
      if (kind != CanLine::kFrame) continue;
      looks[k].stamps_s.push_back(frame.time_s);
      looks[k].ids.push_back(frame.id);
    }
  }
  if (reader.number() == 0 && !reader.broken().empty()) {
    throw InputError(path, reader.broken() + " before its first line", "a whole file", "Copy the recording again");
  }
  for (std::size_t k = 0; k < kFormats.size(); ++k) looks[k].format = kFormats[k];
  auto& best = *std::max_element(looks.begin(), looks.end(),
                                 [](const FirstLook& a, const FirstLook& b) { return a.frames < b.frames; });
  if (best.frames == 0) return std::nullopt;
  return std::move(best);
}

/// Stamps that do not grow are times since the line before (candump -td): half a file later they are as small.
bool are_differences(const std::vector<double>& stamps_s) {
  constexpr std::size_t kFewest = 8;
  if (stamps_s.size() < kFewest) return false;
  const std::size_t half = stamps_s.size() / 2;
  std::size_t grown = 0;
  for (std::size_t k = 0; k < half; ++k) grown += stamps_s[k + half] > stamps_s[k] ? 1U : 0U;
  return 4 * grown < 3 * half;
}

/// Size of a tick whose unit is nowhere said: the sender that speaks most often does so every 1 to 1000 ms.
double tick_of(const FirstLook& look) {
  std::map<std::uint32_t, std::vector<double>> by_id;
  for (std::size_t k = 0; k < look.ids.size(); ++k) by_id[look.ids[k]].push_back(look.stamps_s[k]);
  const auto& most = std::max_element(by_id.begin(), by_id.end(), [](const auto& a, const auto& b) {
                       return a.second.size() < b.second.size();
                     })->second;
  const double usual = median(differences(most));
  for (const double tick_s : {1.0, 1e-3, 1e-6, 1e-9}) {
    if (usual * tick_s <= 1.0) return tick_s;
  }
  return 1e-9;
}

FirstLook known_format(const std::string& path, const std::string& file, const ForeignRecording& foreign) {
  if (auto look = look_at(file)) return *look;
  if (!foreign.format.empty()) {
    throw InputError(path, fmt::format("a recording in the format {} without a frame{}", foreign.format,
                                       foreign.broken.empty() ? "" : "; " + foreign.broken),
                     "one with frames", "Check that this is the recording you meant, and that it is whole");
  }
  throw InputError(path, "no frame in the first 1000 lines",
                   "a CAN recording: candump, Vector ASC, SLCAN, lines such as 0000026Bx000005220108160000000000 (ms x "
                   "identifier data), BLF, TRC, MF4, GVRET CSV, BUSMASTER, PCAP, plain or compressed",
                   "Convert the recording to one of these; a table is read by identify, validate and explain, and "
                   "shown by voltlap log plot");
}

const char* kind_of(CanLine line) {
  switch (line) {
    case CanLine::kUntimed:
      return "frame without a stamp";
    case CanLine::kRemote:
      return "remote frame, without data";
    case CanLine::kError:
      return "error frame";
    case CanLine::kBeyondBus:
      return "identifier beyond 29 bits";
    case CanLine::kNamed:
      return "frame by name, without identifier";
    case CanLine::kEmptySlot:
      return "empty slot";
    default:
      return "line that is no frame";
  }
}

/// A recording is looked at before it is read.
void refuse_pipe(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_fifo(path, ignored) && !std::filesystem::is_character_file(path, ignored)) return;
  throw InputError(path, "a pipe, which can be read once only", "a file", "Save what comes out of the pipe to a file");
}

}  // namespace

CanRecording::CanRecording(const std::string& path, CanReading reading) : CanRecording(source_of(path), reading) {}

CanRecording::CanRecording(const Source& source, const CanReading& reading)
    : path_(source.path),
      reader_(source.file, "a CAN recording", reading.broken),
      format_(CanFormat::kCandump),
      reading_(reading) {
  const std::string& path = path_;
  if (source.foreign != nullptr) take_foreign(*source.foreign);
  static const ForeignRecording kNative;
  const FirstLook look = known_format(path, source.file, source.foreign != nullptr ? *source.foreign : kNative);
  format_ = look.format;
  untimed_ = 2 * look.untimed > look.frames;
  clock_.emplace(defects_, format_ == CanFormat::kSlcan && !untimed_ ? kSlcanTurn : 0.0);
  if (format_ == CanFormat::kScreen && are_differences(look.stamps_s)) {
    state_.differences = true;
    summary_.notes.emplace_back("the stamps do not grow: read as times since the line before (candump -td)");
  }
  if (format_ == CanFormat::kTable) {
    state_.table.tick_s = tick_of(look);
    if (state_.table.tick_s != 1.0) {
      summary_.notes.push_back(fmt::format("a table of frames: its time is taken in {:g} s", state_.table.tick_s));
    }
  }
  if (!untimed_) return;
  if (reading_.period_s.empty()) {
    throw InputError(path, fmt::format("{} frames without stamps", name_of(format_)),
                     "the interval between the frames of one identifier",
                     "Give period_s = 0.01 beside its frame in the role map, or GenMsgCycleTime in the DBC; or record "
                     "with stamps");
  }
}

CanRecording::Source CanRecording::source_of(const std::string& path) {
  refuse_pipe(path);
  if (look_at(path) || !may_be_foreign(path)) return {path, path, nullptr};
  const ForeignRecording& foreign = read_foreign(path);
  return {path, foreign.candump, &foreign};
}

/// What of the recording did not come to be a line of candump.
void CanRecording::take_foreign(const ForeignRecording& foreign) {
  format_name_ = foreign.format;
  if (!foreign.broken.empty() && reading_.broken == BrokenStream::kRefuse) {
    throw InputError(path_, foreign.broken, "a whole file",
                     "Copy the recording again; `voltlap log convert` keeps what can be read of it");
  }
  summary_.broken = foreign.broken;
  for (const CanDefect& skipped : foreign.skipped) {
    for (std::size_t k = 0; k < skipped.count; ++k) defects_.add(skipped.kind.c_str(), 0, 0.0);
    summary_.frames_in_file += skipped.count;
  }
}

void CanRecording::judge_lines() const {
  if (reader_.number() > kFirstLines || 2 * unreadable_ <= kFirstLines) return;
  throw InputError(place(), fmt::format("{} lines that are no frames", unreadable_),
                   fmt::format("a recording in the format {}, as its other lines are", format_name()),
                   "Check that the file is whole and of one format");
}

/// The identifier of the shortest period is the clock; what lies between has the time of its last frame.
bool CanRecording::time_by_period(RecordedFrame& frame) {
  const auto clock = std::min_element(reading_.period_s.begin(), reading_.period_s.end(),
                                      [](const auto& a, const auto& b) { return a.second < b.second; });
  // On one bus: the same identifier on another is another sender.
  if (frame.id == clock->first && (!period_began_ || frame.bus == period_bus_)) {
    period_clock_s_ += period_began_ ? clock->second : 0.0;
    if (!period_began_) {
      period_bus_ = frame.bus;
      summary_.notes.push_back(fmt::format("frames without stamps: {} {} every {:g} ms is the clock",
                                           state_.buses.at(frame.bus), identifier_text(clock->first),
                                           1e3 * clock->second));
    }
    period_began_ = true;
  }
  frame.time_s = period_clock_s_;
  return true;
}

/// Buses one after the other, of the same time: nobody can tell how far the second lies behind.
void CanRecording::refuse_bus_behind(const RecordedFrame& first) const {
  throw InputError(fmt::format("{}:{}", path_, first.line),
                   fmt::format("the frames of {} behind those of the other bus, though of the same time",
                               state_.buses.at(first.bus)),
                   "frames in the order of their time",
                   "Sort the file by its stamps (of candump: sort -s -k1,1), or read each bus from a file of its own");
}

/// One line of the file into the clock; false at its end.
bool CanRecording::read() {
  std::string_view line;
  if (!reader_.next(line)) return false;
  ++summary_.lines;
  RecordedFrame& frame = clock_->slot();
  const CanLine kind = parse_can_line(format_, line, state_, frame);
  if (kind == CanLine::kHeader) return true;
  ++summary_.frames_in_file;
  frame.line = reader_.number();
  frame.remote = kind == CanLine::kRemote && reading_.keep_remote;
  const bool waits_for_time = (kind == CanLine::kUntimed || frame.remote) && untimed_;
  if (kind == CanLine::kFrame || (frame.remote && !untimed_) || (waits_for_time && time_by_period(frame))) {
    clock_->push();
    return true;
  }
  if (kind == CanLine::kUnreadable) ++unreadable_;
  defects_.add(kind_of(kind), reader_.number(), summary_.end_s);
  judge_lines();
  return true;
}

void CanRecording::end() {
  if (ended_) return;
  ended_ = true;
  if (!reader_.broken().empty()) summary_.broken = reader_.broken();
  summary_.buses = state_.buses;
  summary_.parts = clock_->parts();
  summary_.defects = defects_.all();
  for (std::string& note : clock_notes(summary_.parts, "line")) summary_.notes.push_back(std::move(note));
}

bool CanRecording::next(RecordedFrame& out) {
  while (!clock_->pop(out)) {
    if (const auto& behind = clock_->bus_behind()) refuse_bus_behind(*behind);
    if (clock_->finished()) {
      end();
      return false;
    }
    if (!read()) clock_->finish();
  }
  VOLTLAP_DEMAND(summary_.frames == 0 || !(out.time_s < summary_.end_s));
  VOLTLAP_DEMAND(out.length <= RecordedFrame::kMostBytes);
  if (summary_.frames++ == 0) summary_.begin_s = out.time_s;
  summary_.end_s = out.time_s;
  return true;
}

std::string CanRecording::place() const {
  return fmt::format("{}:{}", path_, reader_.number());
}

bool is_can_recording(const std::string& path) {
  refuse_pipe(path);
  return look_at(path).has_value() || may_be_foreign(path);
}

std::string identifier_text(std::uint32_t id) {
  return fmt::format("0x{:0{}X}", id & ~RecordedFrame::kExtendedFlag, (id & RecordedFrame::kExtendedFlag) != 0 ? 8 : 3);
}

}  // namespace voltlap::plant
